//! A = Eᵀ K⁻¹ E, the compliance of a few dofs, from K = L Lᵀ without solving for the others.
//!
//! A unit load e enters L⁻¹ e at the column of its dof and in those above it in the elimination tree.
//! Dofs close together share most of this path to the root, some tenth of L, and
//!
//! ```text
//! A = Xᵀ X,   X = L⁻¹ E
//! ```
//!
//! needs no more of L than that, in products of dense blocks.

use super::cholesky::Factor;
use super::supernodes::Supernodes;
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Accum, Mat, MatRef, Par};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Columns of X that one thread computes at a time.
const BLOCK: usize = 64;

/// Supernodes of L that unit loads enter, ascending, and their rows of X.
struct Path<'a> {
    structure: &'a Supernodes,
    /// By supernode: where its columns' rows of X begin.
    first_row: BTreeMap<usize, usize>,
    rows: usize,
}

impl<'a> Path<'a> {
    /// The supernodes of `columns` and all above them.
    fn new(structure: &'a Supernodes, columns: &[usize]) -> Path<'a> {
        let mut path = Path {
            structure,
            first_row: BTreeMap::new(),
            rows: 0,
        };
        for s in path.above(columns) {
            path.first_row.insert(s, path.rows);
            path.rows += path.width(s);
        }
        path
    }

    fn above(&self, columns: &[usize]) -> Vec<usize> {
        let mut found = std::collections::BTreeSet::new();
        for &column in columns {
            let mut next = Some(self.supernode_of(column));
            while let Some(s) = next.filter(|&s| found.insert(s)) {
                let below = self.structure.rows(s);
                next = below.first().map(|&row| self.supernode_of(row as usize));
            }
        }
        found.into_iter().collect()
    }

    fn supernode_of(&self, column: usize) -> usize {
        self.structure.supernode_of(column)
    }

    fn width(&self, s: usize) -> usize {
        self.structure.width(s)
    }

    fn row(&self, column: usize) -> usize {
        let s = self.supernode_of(column);
        self.first_row[&s] + column - self.structure.columns(s).start
    }

    /// The rows of X below a supernode's own.
    fn rows_below(&self, s: usize) -> Vec<usize> {
        let below = self.structure.rows(s);
        below.iter().map(|&row| self.row(row as usize)).collect()
    }
}

impl Factor {
    /// A of the dofs; the lower triangle alone is meant. On all threads, with the same bits on any
    /// number of them.
    pub fn compliance(&self, dofs: &[usize]) -> Mat<f64> {
        let structure = self.supernodes();
        let columns: Vec<usize> = dofs.iter().map(|&dof| self.column(dof)).collect();
        let path = Path::new(structure, &columns);
        // Neighbours in the elimination tree share a block of columns.
        let mut order: Vec<usize> = (0..dofs.len()).collect();
        order.sort_by_key(|&k| columns[k]);
        let below: BTreeMap<usize, Vec<usize>> = (path.first_row.keys())
            .map(|&s| (s, path.rows_below(s)))
            .collect();
        let blocks: Vec<Mat<f64>> = (order.par_chunks(BLOCK))
            .map(|block| {
                let columns: Vec<usize> = block.iter().map(|&k| columns[k]).collect();
                self.unit_loads(&path, &below, &columns)
            })
            .collect();
        let pairs: Vec<[usize; 2]> = (0..blocks.len())
            .flat_map(|i| (0..=i).map(move |j| [i, j]))
            .collect();
        let products: Vec<Mat<f64>> = (pairs.par_iter())
            .map(|&[i, j]| {
                let mut product = Mat::zeros(blocks[i].ncols(), blocks[j].ncols());
                let (left, right) = (blocks[i].transpose(), &blocks[j]);
                matmul(&mut product, Accum::Replace, left, right, 1.0, Par::Seq);
                product
            })
            .collect();
        let mut compliance = Mat::zeros(dofs.len(), dofs.len());
        for (&[i, j], product) in pairs.iter().zip(&products) {
            for b in 0..product.ncols() {
                for a in 0..product.nrows() {
                    let (row, column) = (order[BLOCK * i + a], order[BLOCK * j + b]);
                    compliance[(row, column)] = product[(a, b)];
                    compliance[(column, row)] = product[(a, b)];
                }
            }
        }
        compliance
    }

    /// Columns of X.
    fn unit_loads(
        &self,
        path: &Path,
        below: &BTreeMap<usize, Vec<usize>>,
        columns: &[usize],
    ) -> Mat<f64> {
        let mut x = Mat::zeros(path.rows, columns.len());
        for (j, &column) in columns.iter().enumerate() {
            x[(path.row(column), j)] = 1.0;
        }
        for s in path.above(columns) {
            let (width, rows) = (path.width(s), &below[&s]);
            let height = width + rows.len();
            let values = &self.values()[path.structure.block(s)];
            let l = MatRef::from_column_major_slice(values, height, width);
            let (top, bottom) = l.split_at_row(width);
            let mut own = x.as_mut().subrows_mut(path.first_row[&s], width);
            solve_lower_triangular_in_place(top, own.as_mut(), Par::Seq);
            let mut passed_on = Mat::<f64>::zeros(rows.len(), columns.len());
            matmul(
                &mut passed_on,
                Accum::Replace,
                bottom,
                own.as_ref(),
                1.0,
                Par::Seq,
            );
            for j in 0..columns.len() {
                for (i, &row) in rows.iter().enumerate() {
                    x[(row, j)] -= passed_on[(i, j)];
                }
            }
        }
        x
    }
}
