//! Columns of X = L⁻¹ E whose dofs share their path to the root of the elimination tree, and their products.

use crate::linear_solver::cholesky::Factor;
use crate::linear_solver::columns::symmetric;
use crate::linear_solver::path::Path;
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, Mat, Par};
use std::ops::Range;

/// Columns of X that share a path.
pub struct Block {
    /// The dofs that the columns belong to, in the order of their columns of L.
    pub members: Vec<usize>,
    /// The rows of X, ascending.
    stretches: Vec<Stretch>,
    /// X: rows of the path × members.
    pub x: Mat<f64>,
    /// Multiplications and additions that X took.
    pub flops: f64,
}

/// Neighbouring columns of L, and the members that have entries there.
#[derive(Clone)]
struct Stretch {
    begin: usize,
    len: usize,
    /// The place of the first one among the rows of X.
    row: usize,
    members: Range<usize>,
}

/// Columns of L that two blocks have in common.
struct Common {
    /// Their first rows in either block, and their number.
    rows: [usize; 2],
    len: usize,
    members: [Range<usize>; 2],
}

impl Block {
    /// The columns at these places in the block, and what they are called in the new one.
    pub fn select(&self, kept: &[(usize, usize)]) -> Block {
        let before = |limit: usize| kept.partition_point(|&(place, _)| place < limit);
        let stretches = self.stretches.iter().map(|stretch| Stretch {
            members: before(stretch.members.start)..before(stretch.members.end),
            ..stretch.clone()
        });
        let mut x = Mat::zeros(self.x.nrows(), kept.len());
        for (mut to, &(place, _)) in x.col_iter_mut().zip(kept) {
            to.copy_from(self.x.col(place));
        }
        Block {
            members: kept.iter().map(|&(_, target)| target).collect(),
            stretches: stretches.collect(),
            x,
            flops: 0.0,
        }
    }

    /// Xᵢᵀ Xⱼ.
    pub fn product(&self, other: &Block) -> Mat<f64> {
        let mut product = Mat::zeros(self.members.len(), other.members.len());
        for common in common(&self.stretches, &other.stretches) {
            let [left, right] = [(self, 0), (other, 1)].map(|(block, k)| {
                let members = common.members[k].clone();
                let rows = block.x.subrows(common.rows[k], common.len);
                rows.subcols(members.start, members.len())
            });
            let [rows, columns] = common.members;
            let to = product.as_mut().submatrix_mut(
                rows.start,
                columns.start,
                rows.len(),
                columns.len(),
            );
            matmul(to, Accum::Add, left.transpose(), right, 1.0, Par::Seq);
        }
        product
    }

    /// Xᵀ X.
    pub fn square(&self) -> Mat<f64> {
        let size = self.members.len();
        let mut square = Mat::zeros(size, size);
        for stretch in &self.stretches {
            let (first, count) = (stretch.members.start, stretch.members.len());
            let x = self.x.submatrix(stretch.row, first, stretch.len, count);
            triangular::matmul(
                square.as_mut().submatrix_mut(first, first, count, count),
                BlockStructure::TriangularUpper,
                Accum::Add,
                x.transpose(),
                BlockStructure::Rectangular,
                x,
                BlockStructure::Rectangular,
                1.0,
                Par::Seq,
            );
        }
        symmetric(&square)
    }
}

fn common(a: &[Stretch], b: &[Stretch]) -> Vec<Common> {
    let mut found: Vec<Common> = Vec::new();
    let (mut i, mut j) = (0, 0);
    while i < a.len() && j < b.len() {
        let (one, other) = (&a[i], &b[j]);
        let begin = one.begin.max(other.begin);
        let [one_end, other_end] = [one, other].map(|s| s.begin + s.len);
        let end = one_end.min(other_end);
        if begin < end {
            found.push(Common {
                rows: [one, other].map(|s| s.row + begin - s.begin),
                len: end - begin,
                members: [one, other].map(|s| s.members.clone()),
            });
        }
        if one_end <= other_end {
            i += 1;
        } else {
            j += 1;
        }
    }
    found
}

impl<const B: usize> Factor<B> {
    /// Goes up the tree with unit loads at some columns of L, ascending.
    pub(super) fn block(&self, columns: &[usize], members: Vec<usize>) -> Block {
        let path = Path::new(self.supernodes(), columns);
        let mut x = Mat::zeros(path.rows, columns.len());
        for (j, &column) in columns.iter().enumerate() {
            x[(path.row(column), j)] = 1.0;
        }
        let most = path.steps.iter().map(|s| s.below.len()).max();
        let mut beside = Mat::zeros(most.unwrap_or(0), columns.len());
        let mut flops = 0;
        let mut stretches: Vec<Stretch> = Vec::new();
        for step in &path.steps {
            let (width, below) = (step.width, step.below.len());
            let (first, count) = (step.members.start, step.members.len());
            let own = x.as_mut().subcols_mut(first, count);
            let beside = beside.as_mut().submatrix_mut(0, first, below, count);
            self.step_up(step, own, beside);
            flops += count * width * (width + 2 * below);
            match stretches.last_mut() {
                Some(last)
                    if last.begin + last.len == step.begin && last.members == step.members =>
                {
                    last.len += width;
                }
                _ => stretches.push(Stretch {
                    begin: step.begin,
                    len: width,
                    row: step.first_row,
                    members: step.members.clone(),
                }),
            }
        }
        Block {
            flops: flops as f64,
            members,
            stretches,
            x,
        }
    }
}
