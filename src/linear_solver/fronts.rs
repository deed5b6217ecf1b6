//! The fronts of the Cholesky factorisation:
//!
//! ```text
//! L11 L11ᵀ = A11,   L21 = A21 L11⁻ᵀ,   passed up: U = A22 − L21 L21ᵀ
//! ```

use super::extend_add::Part;
use super::held::HeldColumns;
use super::multifrontal::{self, Child, Front, NotPositive};
use super::node_blocks::NodeBlocks;
use super::policy::{LEAST_PIVOT, PANEL};
use super::supernodes::Supernodes;
use super::tiles;
use faer::dyn_stack::{MemStack, StackReq};
use faer::{Accum, MatMut};
use rayon::prelude::*;
use std::ops::Range;

/// K, as the fronts take it.
pub struct Fronts<'a, const B: usize> {
    pub structure: &'a Supernodes,
    pub nodes: &'a NodeBlocks<B>,
    /// Entries of K.
    pub matrix: &'a [f64],
    pub held: HeldColumns,
}

impl<const B: usize> Front for Fronts<'_, B> {
    fn start(&self, s: usize) -> usize {
        self.structure.block_start(s)
    }

    fn scratch(&self, columns: usize) -> StackReq {
        tiles::cholesky_scratch(columns)
    }

    fn eliminate(
        &self,
        s: usize,
        block: &mut [f64],
        children: &[Child],
        update: &mut [f64],
        memory: &mut MemStack,
    ) -> Result<(), NotPositive> {
        let structure = self.structure;
        let (width, rows) = (structure.width(s), structure.rows(s).len());
        let height = width + rows;
        let mut diagonal = vec![0.0; width];
        for (column, diagonal) in diagonal.iter_mut().enumerate() {
            *diagonal = self.diagonal(s, column);
        }
        self.gather(s, block, children);
        let first = structure.columns(s).start;
        let mut l = MatMut::from_column_major_slice_mut(block, height, width);
        tiles::cholesky(l.as_mut(), memory).map_err(|column| NotPositive(first + column))?;
        for (j, &diagonal) in diagonal.iter().enumerate() {
            // False for a pivot that is not a number.
            let sound = l[(j, j)].powi(2) > LEAST_PIVOT * diagonal;
            if !sound {
                return Err(NotPositive(first + j));
            }
        }
        let l21 = l.as_ref().subrows(width, rows);
        let product = |passed: MatMut<f64>, first: usize| {
            tiles::subtract_square(passed, first, l21, Accum::Replace);
        };
        multifrontal::pass_up(children, width, rows, update, product);
        Ok(())
    }
}

impl<const B: usize> Fronts<'_, B> {
    /// Fills a front's columns by K's entries and what children pass up.
    fn gather(&self, s: usize, block: &mut [f64], children: &[Child]) {
        let width = self.structure.width(s);
        let height = width + self.structure.rows(s).len();
        let panel = PANEL.next_multiple_of(B);
        let columns = block.par_chunks_mut(panel * height).enumerate();
        columns.for_each(|(k, values)| {
            let columns = k * panel..width.min((k + 1) * panel);
            self.fill(s, columns.clone(), values);
            let part = Part {
                values,
                columns,
                first_row: 0,
                height,
            };
            multifrontal::add_children(children, part);
        });
    }

    /// K's entry on the diagonal of a supernode's column.
    fn diagonal(&self, s: usize, column: usize) -> f64 {
        let (place, axis) = (column - column % B, column % B);
        let first = self.structure.columns(s).start + place;
        let mut blocks = self.nodes.of_columns(first).iter();
        let own = blocks.find(|block| block.row as usize == place);
        match own {
            _ if self.held.holds(first + axis) => self.held.diagonal,
            Some(own) => self.matrix[own.columns[axis] as usize],
            None => 0.0,
        }
    }

    /// Writes K's entries in some columns of a supernode.
    fn fill(&self, s: usize, part: Range<usize>, block: &mut [f64]) {
        block.fill(0.0);
        let columns = self.structure.columns(s);
        let height = columns.len() + self.structure.rows(s).len();
        let nodes = part.clone().step_by(B);
        for (place, values) in nodes.zip(block.chunks_exact_mut(B * height)) {
            for block in self.nodes.of_columns(columns.start + place) {
                let row = block.row as usize;
                for (axis, &at) in block.columns.iter().enumerate() {
                    let at = at as usize;
                    if row == place {
                        let rows = axis * height + row + axis..axis * height + row + B;
                        let count = rows.len();
                        values[rows].copy_from_slice(&self.matrix[at..at + count]);
                    } else if block.transposed {
                        for (j, &value) in self.matrix[at..at + B].iter().enumerate() {
                            values[j * height + row + axis] = value;
                        }
                    } else {
                        let rows = axis * height + row..axis * height + row + B;
                        values[rows].copy_from_slice(&self.matrix[at..at + B]);
                    }
                }
            }
        }
        for row in self.held.among(self.structure, s) {
            let own = part.start..part.end.min(row.max(part.start));
            own.for_each(|column| block[(column - part.start) * height + row] = 0.0);
            if part.contains(&row) {
                let column = &mut block[(row - part.start) * height..][..height];
                column[row..].fill(0.0);
                column[row] = self.held.diagonal;
            }
        }
    }
}
