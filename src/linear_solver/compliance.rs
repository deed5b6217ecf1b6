//! X = L⁻¹ E for unit loads E at a few dofs, and the compliances
//!
//! ```text
//! Aᵢⱼ = Eᵢᵀ K⁻¹ Eⱼ = Xᵢᵀ Xⱼ
//! ```
//!
//! from K = L Lᵀ, without solving for other dofs. A unit load enters X at the column of its dof and in
//! those above it in the elimination tree; dofs close together share most of this path to the root, some
//! tenth of L.

use super::cholesky::Factor;
use super::columns::{slice, slice_mut, symmetric};
use super::path::Path;
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, Mat, Par};
use rayon::prelude::*;
use std::ops::Range;

/// Most columns of X that one thread computes at a time: as many keep products of dense blocks at their full
/// rate.
const BLOCK: usize = 480;

/// Fewer are not shared out.
const FEWEST: usize = 24;

/// L⁻¹ E of a list of dofs.
#[derive(Default)]
pub struct UnitLoads {
    len: usize,
    blocks: Vec<Block>,
    /// Multiplications and additions that it took.
    pub flops: f64,
}

/// Columns of X that share a path.
struct Block {
    /// Which of the dofs, in the order of their columns of L.
    members: Vec<usize>,
    /// Ascending.
    stretches: Vec<Stretch>,
    /// X: rows of the path × members.
    x: Mat<f64>,
    flops: f64,
}

/// Neighbouring columns of L, and the members that have entries there.
#[derive(Clone)]
struct Stretch {
    begin: usize,
    len: usize,
    /// Where the first one stands among the rows of X.
    row: usize,
    members: Range<usize>,
}

/// Where two blocks have the same columns of L.
struct Common {
    /// Rows in either, and how many.
    rows: [usize; 2],
    len: usize,
    members: [Range<usize>; 2],
}

impl UnitLoads {
    pub fn len(&self) -> usize {
        self.len
    }

    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Parts of X that go up the tree together.
    pub fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// Rows of X, at most.
    pub fn rows(&self) -> usize {
        let rows = self.blocks.iter().map(|block| block.x.nrows());
        rows.max().unwrap_or(0)
    }

    /// Xᵢᵀ Xⱼ, on all threads with the same bits on any number of them.
    pub fn product(&self, other: &UnitLoads) -> Mat<f64> {
        let pairs: Vec<(&Block, &Block)> = (self.blocks.iter())
            .flat_map(|a| other.blocks.iter().map(move |b| (a, b)))
            .collect();
        let each = pairs.par_iter().map(|(a, b)| a.product(b));
        let products: Vec<Mat<f64>> = each.collect();
        let mut all = Mat::zeros(self.len, other.len);
        for ((a, b), product) in pairs.iter().zip(&products) {
            for (product, &column) in product.col_iter().zip(&b.members) {
                let to = slice_mut(all.col_mut(column));
                let rows = a.members.iter().zip(slice(product));
                rows.for_each(|(&row, value)| to[row] = *value);
            }
        }
        all
    }

    /// Xᵀ X.
    pub fn square(&self) -> Mat<f64> {
        let blocks = self.blocks.iter().enumerate();
        let pairs: Vec<(&Block, &Block)> = blocks
            .flat_map(|(i, a)| self.blocks[i..].iter().map(move |b| (a, b)))
            .collect();
        let each = pairs.par_iter().map(|(a, b)| match std::ptr::eq(*a, *b) {
            true => a.square(),
            false => a.product(b),
        });
        let products: Vec<Mat<f64>> = each.collect();
        let mut upper = Mat::zeros(self.len, self.len);
        for ((a, b), product) in pairs.iter().zip(&products) {
            for (product, &column) in product.col_iter().zip(&b.members) {
                for (&row, value) in a.members.iter().zip(slice(product)) {
                    upper[(row.min(column), row.max(column))] = *value;
                }
            }
        }
        symmetric(&upper)
    }

    /// Takes the loads at some places, in this order, to its own, at the end.
    pub fn append(&mut self, other: &UnitLoads, places: &[usize]) {
        let mut target = vec![None; other.len];
        for (k, &place) in (self.len..).zip(places) {
            target[place] = Some(k);
        }
        self.take(other, &target);
    }

    /// Takes loads of others, each to the place that is told for it.
    pub fn take(&mut self, other: &UnitLoads, target: &[Option<usize>]) {
        self.len += target.iter().flatten().count();
        for block in &other.blocks {
            let members = block.members.iter().enumerate();
            let kept: Vec<(usize, usize)> = members
                .filter_map(|(k, &place)| Some((k, target[place]?)))
                .collect();
            if !kept.is_empty() {
                self.blocks.push(block.select(&kept));
            }
        }
    }

    /// Takes all loads of others, at the end.
    pub fn extend(&mut self, other: UnitLoads) {
        for mut block in other.blocks {
            block
                .members
                .iter_mut()
                .for_each(|place| *place += self.len);
            self.blocks.push(block);
        }
        self.len += other.len;
        self.flops += other.flops;
    }
}

impl Block {
    /// The columns at these places in the block, and what they are called in the new one.
    fn select(&self, kept: &[(usize, usize)]) -> Block {
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
    fn product(&self, other: &Block) -> Mat<f64> {
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
    fn square(&self) -> Mat<f64> {
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

impl Factor {
    /// L⁻¹ E of the dofs of which `is_loaded` is true; nothing for the others. On all threads, with the
    /// same bits on any number of them.
    pub fn unit_loads(&self, dofs: &[usize], is_loaded: impl Fn(usize) -> bool) -> UnitLoads {
        let columns: Vec<usize> = dofs.iter().map(|&dof| self.column(dof)).collect();
        // Neighbours in the elimination tree share a block.
        let mut order: Vec<usize> = (0..dofs.len()).filter(|&k| is_loaded(dofs[k])).collect();
        order.sort_by_key(|&k| columns[k]);
        let blocks: Vec<Block> = (order.par_chunks(block_size(order.len())))
            .map(|block| {
                let columns: Vec<usize> = block.iter().map(|&k| columns[k]).collect();
                self.block(&columns, block.to_vec())
            })
            .collect();
        UnitLoads {
            len: dofs.len(),
            flops: blocks.iter().map(|block| block.flops).sum(),
            blocks,
        }
    }

    /// Goes up the tree with unit loads at some columns of L, ascending.
    fn block(&self, columns: &[usize], members: Vec<usize>) -> Block {
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

/// An even number of equal blocks, if there are enough columns for them.
fn block_size(columns: usize) -> usize {
    let blocks = match columns < 2 * FEWEST {
        true => 1,
        false => 2 * columns.div_ceil(2 * BLOCK),
    };
    columns.div_ceil(blocks).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly::{ElementStiffness, Pattern};
    use crate::interactions::Interactions;
    use crate::linear_solver::cholesky::Symbolic;
    use crate::linear_solver::ordering::Ordering;
    use nalgebra::DMatrix;

    const SIDE: usize = 60;

    /// A lattice of interactions to the eight nearest neighbours, on soft ground.
    fn factor() -> Factor {
        let node = |i: usize, j: usize| (i * SIDE + j) as u32;
        let mut pairs = Vec::new();
        for i in 0..SIDE {
            for j in 0..SIDE {
                let inside = |&(a, b): &(usize, usize)| a < SIDE && b < SIDE;
                let near = [
                    (i + 1, j),
                    (i, j + 1),
                    (i + 1, j + 1),
                    (i + 1, j.wrapping_sub(1)),
                ];
                let near = near.into_iter().filter(inside);
                pairs.extend(near.map(|(a, b)| [node(i, j), node(a, b)]));
            }
        }
        let positions: Vec<[f64; 2]> = (0..SIDE * SIDE)
            .map(|k| [(k % SIDE) as f64, (k / SIDE) as f64])
            .collect();
        let stiffness = vec![1.0; pairs.len()];
        let interactions = Interactions::of_bonds(pairs, stiffness);
        let ground = |k: usize| ElementStiffness {
            nodes: vec![k as u32],
            matrix: DMatrix::from_diagonal_element(2, 2, 1e-3),
        };
        let elements: Vec<ElementStiffness> = (0..SIDE * SIDE).map(ground).collect();
        let pattern = Pattern::new(SIDE * SIDE, &interactions, &elements);
        let symbolic = Symbolic::new(pattern.symbolic(), &pattern.graph, Ordering::Metis);
        let matrix = pattern.assemble(&positions, &interactions, &elements);
        symbolic
            .and_then(|s| s.factorise(&matrix))
            .expect("a factor")
    }

    /// Dofs of a rectangle of points.
    fn rectangle(x: std::ops::Range<usize>, y: std::ops::Range<usize>) -> Vec<usize> {
        let nodes = y.flat_map(|i| x.clone().map(move |j| i * SIDE + j));
        nodes.flat_map(|node| [2 * node, 2 * node + 1]).collect()
    }

    #[test]
    fn products_of_unit_loads_are_compliances() {
        let factor = factor();
        let [zone, other] = [rectangle(20..40, 10..30), rectangle(35..50, 25..32)];
        let held = zone[7];
        let of_zone = factor.unit_loads(&zone, |dof| dof != held);
        let of_other = factor.unit_loads(&other, |_| true);
        assert!(of_zone.blocks.len() > 1);
        let (square, product) = (of_zone.square(), of_zone.product(&of_other));
        let places = [3, 100, 4];
        let mut some = UnitLoads::default();
        some.append(&of_other, &places[..1]);
        some.append(&of_other, &places[1..]);
        let selected = some.product(&of_zone);
        let scale = square[(8, 8)];
        let mut differ = 0.0f64;
        for (j, &dof) in zone.iter().enumerate() {
            let mut u = vec![0.0; 2 * SIDE * SIDE];
            u[dof] = if dof == held { 0.0 } else { 1.0 };
            factor.solve_in_place(&mut u);
            u[held] = 0.0;
            for (i, &dof) in zone.iter().enumerate() {
                differ = differ.max((square[(i, j)] - u[dof]).abs());
            }
            for (i, &dof) in other.iter().enumerate() {
                differ = differ.max((product[(j, i)] - u[dof]).abs());
            }
            for (i, &place) in places.iter().enumerate() {
                differ = differ.max((selected[(i, j)] - u[other[place]]).abs());
            }
        }
        // Rounding of both.
        assert!(differ < 1e-13 * scale, "{:e}", differ / scale);
    }
}
