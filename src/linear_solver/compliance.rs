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
use super::path::Path;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use rayon::prelude::*;

/// Columns of X that one thread computes at a time.
const BLOCK: usize = 256;

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
    /// Which of the dofs.
    members: Vec<usize>,
    /// Columns of L in ascending order: the first one of each stretch, its place among the rows, its length.
    stretches: Vec<[usize; 3]>,
    /// Xᵀ: members × rows.
    x: Mat<f64>,
    flops: f64,
}

impl UnitLoads {
    pub fn len(&self) -> usize {
        self.len
    }

    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Xᵢᵀ Xⱼ, on all threads with the same bits on any number of them.
    pub fn product(&self, other: &UnitLoads) -> Mat<f64> {
        let pairs: Vec<(&Block, &Block)> = (self.blocks.iter())
            .flat_map(|a| other.blocks.iter().map(move |b| (a, b)))
            .collect();
        let each = pairs.par_iter().map(|(a, b)| a.product(b));
        let products: Vec<Mat<f64>> = each.collect();
        self.collect(other, &pairs, &products, false)
    }

    /// Xᵀ X.
    pub fn square(&self) -> Mat<f64> {
        let blocks = self.blocks.iter().enumerate();
        let pairs: Vec<(&Block, &Block)> = blocks
            .flat_map(|(i, a)| self.blocks[..=i].iter().map(move |b| (a, b)))
            .collect();
        let each = pairs.par_iter().map(|(a, b)| a.product(b));
        let products: Vec<Mat<f64>> = each.collect();
        self.collect(self, &pairs, &products, true)
    }

    fn collect(
        &self,
        other: &UnitLoads,
        pairs: &[(&Block, &Block)],
        products: &[Mat<f64>],
        is_symmetric: bool,
    ) -> Mat<f64> {
        let mut all = Mat::zeros(self.len, other.len);
        for ((a, b), product) in pairs.iter().zip(products) {
            for (j, &column) in b.members.iter().enumerate() {
                for (i, &row) in a.members.iter().enumerate() {
                    all[(row, column)] = product[(i, j)];
                    if is_symmetric {
                        all[(column, row)] = product[(i, j)];
                    }
                }
            }
        }
        all
    }

    /// Takes the loads at some places, in this order, to its own, at the end.
    pub fn append(&mut self, other: &UnitLoads, places: &[usize]) {
        let mut target = vec![usize::MAX; other.len];
        for (k, &place) in places.iter().enumerate() {
            target[place] = self.len + k;
        }
        self.len += places.len();
        for block in &other.blocks {
            let members = block.members.iter().enumerate();
            let kept: Vec<(usize, usize)> = members
                .map(|(k, &place)| (k, target[place]))
                .filter(|&(_, target)| target != usize::MAX)
                .collect();
            if !kept.is_empty() {
                self.blocks.push(block.select(&kept));
            }
        }
    }
}

impl UnitLoads {
    /// Drops all but the first ones, of which whole lists have been appended.
    pub fn truncate(&mut self, len: usize) {
        self.blocks
            .retain(|block| block.members.iter().all(|&place| place < len));
        self.len = len;
    }
}

impl Block {
    /// The columns at these places in the block, and what they are called in the new one.
    fn select(&self, kept: &[(usize, usize)]) -> Block {
        let of = |i: usize, j: usize| self.x[(kept[i].0, j)];
        Block {
            members: kept.iter().map(|&(_, target)| target).collect(),
            stretches: self.stretches.clone(),
            x: Mat::from_fn(kept.len(), self.x.ncols(), of),
            flops: 0.0,
        }
    }

    /// Xᵢᵀ Xⱼ.
    fn product(&self, other: &Block) -> Mat<f64> {
        let mut product = Mat::zeros(self.members.len(), other.members.len());
        for [a, b, count] in common(&self.stretches, &other.stretches) {
            let left = self.x.subcols(a, count);
            let right = other.x.subcols(b, count).transpose();
            matmul(product.as_mut(), Accum::Add, left, right, 1.0, Par::Seq);
        }
        product
    }
}

/// Where both have the same columns of L: the places in either, and how many.
fn common(a: &[[usize; 3]], b: &[[usize; 3]]) -> Vec<[usize; 3]> {
    let mut found: Vec<[usize; 3]> = Vec::new();
    let (mut i, mut j) = (0, 0);
    while i < a.len() && j < b.len() {
        let ([first, at, len], [other, other_at, other_len]) = (a[i], b[j]);
        let begin = first.max(other);
        let end = (first + len).min(other + other_len);
        if begin < end {
            found.push([at + begin - first, other_at + begin - other, end - begin]);
        }
        if first + len <= other + other_len {
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
        let count = order.len().div_ceil(BLOCK).max(1);
        let blocks: Vec<Block> = (order.par_chunks(order.len().div_ceil(count).max(1)))
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

    /// Goes up the tree with unit loads at some columns of L.
    fn block(&self, columns: &[usize], members: Vec<usize>) -> Block {
        let path = Path::new(self.supernodes(), columns);
        let mut x = Mat::zeros(columns.len(), path.rows);
        for (j, &column) in columns.iter().enumerate() {
            x[(j, path.row(column))] = 1.0;
        }
        let most = path.steps.iter().map(|s| s.below.len()).max();
        let mut beside = Mat::zeros(columns.len(), most.unwrap_or(0));
        let mut entries = 0;
        let mut stretches: Vec<[usize; 3]> = Vec::new();
        for step in &path.steps {
            let below = step.below.len();
            self.step_up(step, x.as_mut(), beside.as_mut().subcols_mut(0, below));
            entries += step.width * (step.width + below);
            match stretches.last_mut() {
                Some([begin, _, len]) if *begin + *len == step.begin => *len += step.width,
                _ => stretches.push([step.begin, step.first_row, step.width]),
            }
        }
        Block {
            flops: 2.0 * (columns.len() * entries) as f64,
            members,
            stretches,
            x,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly::{ElementStiffness, Pattern};
    use crate::linear_solver::cholesky::Symbolic;
    use crate::linear_solver::ordering::Ordering;
    use crate::springs::Springs;
    use nalgebra::DMatrix;

    const SIDE: usize = 60;

    /// A lattice of springs to the eight nearest neighbours, on soft ground.
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
        let springs = Springs::of_pairs(pairs, stiffness);
        let ground = |k: usize| ElementStiffness {
            nodes: vec![k as u32],
            matrix: DMatrix::from_diagonal_element(2, 2, 1e-3),
        };
        let elements: Vec<ElementStiffness> = (0..SIDE * SIDE).map(ground).collect();
        let pattern = Pattern::new(SIDE * SIDE, &springs, &elements);
        let symbolic = Symbolic::new(pattern.symbolic(), &pattern.graph, Ordering::Metis);
        let matrix = pattern.assemble(&positions, &springs, &elements);
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
