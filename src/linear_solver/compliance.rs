//! X = L⁻¹ E for unit loads E at a few dofs, and the compliances
//!
//! ```text
//! Aᵢⱼ = Eᵢᵀ K⁻¹ Eⱼ = Xᵢᵀ Xⱼ
//! ```
//!
//! from K = L Lᵀ, without solving for other dofs. A unit load enters X at the column of its dof and in
//! those above it in the elimination tree; dofs close together share most of this path to the root, some
//! tenth of L.

mod block;

use super::cholesky::Factor;
use super::columns::{slice, slice_mut, symmetric};
use super::policy::{FEW_UNIT_LOADS, UNIT_LOADS};
use block::Block;
use faer::Mat;
use rayon::prelude::*;

/// L⁻¹ E of a list of dofs.
#[derive(Default)]
pub struct UnitLoads {
    len: usize,
    blocks: Vec<Block>,
    /// Multiplications and additions that it took.
    pub flops: f64,
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

impl<const B: usize> Factor<B> {
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
}

/// An even number of equal blocks, if there are enough columns for them.
fn block_size(columns: usize) -> usize {
    let blocks = match columns < 2 * FEW_UNIT_LOADS {
        true => 1,
        false => 2 * columns.div_ceil(2 * UNIT_LOADS),
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
    fn factor() -> Factor<2> {
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
        let symbolic = Symbolic::<2>::new(pattern.symbolic(), &pattern.graph, Ordering::Metis);
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
