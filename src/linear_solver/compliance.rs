//! X = L⁻¹ E for unit loads E at a few dofs, and the compliances
//!
//! ```text
//! Aᵢⱼ = Eᵢᵀ K⁻¹ Eⱼ = Xᵢᵀ Xⱼ
//! ```
//!
//! from K = L Lᵀ, without solving for other dofs. A unit load enters X at the column of its dof and in
//! those above it in the elimination tree; dofs close together share most of this path to the root, some
//! tenth of L.
//!
//! Loads near each other look much alike from far away: what a block of n of them passes on to the rows
//! far up the tree has a lower rank r, U = Q R to rounding ([`RANK`]). From there on r columns go on in
//! place of n, X = X_Q R.

use super::cholesky::Factor;
use super::path::Path;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Columns of X that one thread computes at a time.
const BLOCK: usize = 256;

/// A range of U is complete if it leaves no more of U than this share, in the Frobenius norm: rounding of
/// products over some thousand rows.
const RANK: f64 = 1e-14;

/// Columns are not worth a look for a lower rank below this number, nor before the rows that they have
/// reached are this many times as many.
const FEWEST: usize = 96;
const ROWS: usize = 3;

/// Compression pays if what lies ahead, in entries of L, is so many times the rows times the columns.
const WORTH: usize = 6;

/// L⁻¹ E of a list of dofs.
#[derive(Default)]
pub struct UnitLoads {
    len: usize,
    blocks: Vec<Block>,
    /// Multiplications and additions that it took.
    pub flops: f64,
}

struct Block {
    /// Which of the dofs.
    members: Vec<usize>,
    parts: Vec<Part>,
    flops: f64,
}

/// Some rows of X, transposed: `combination`ᵀ · `columns`.
struct Part {
    /// R, r × members; `None`: the identity.
    combination: Option<Mat<f64>>,
    /// Columns of L in ascending order: the first one of each stretch, its place, its length.
    stretches: Vec<[usize; 3]>,
    /// r × rows.
    columns: Mat<f64>,
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
        self.blocks.retain(|block| block.members.iter().all(|&place| place < len));
        self.len = len;
    }
}

impl Block {
    /// The columns at these places in the block.
    fn select(&self, kept: &[(usize, usize)]) -> Block {
        let parts = self.parts.iter().map(|part| {
            let (combination, columns) = match &part.combination {
                Some(r) => {
                    let of = |i: usize, j: usize| r[(i, kept[j].0)];
                    (
                        Some(Mat::from_fn(r.nrows(), kept.len(), of)),
                        part.columns.clone(),
                    )
                }
                None => {
                    let of = |i: usize, j: usize| part.columns[(kept[i].0, j)];
                    (None, Mat::from_fn(kept.len(), part.columns.ncols(), of))
                }
            };
            Part {
                combination,
                stretches: part.stretches.clone(),
                columns,
            }
        });
        Block {
            members: kept.iter().map(|&(_, target)| target).collect(),
            parts: parts.collect(),
            flops: self.flops,
        }
    }

    /// Xᵢᵀ Xⱼ of two blocks.
    fn product(&self, other: &Block) -> Mat<f64> {
        let mut sum = Mat::zeros(self.members.len(), other.members.len());
        for a in &self.parts {
            for b in &other.parts {
                a.add_product(b, &mut sum);
            }
        }
        sum
    }
}

impl Part {
    fn add_product(&self, other: &Part, sum: &mut Mat<f64>) {
        let common = common(&self.stretches, &other.stretches);
        if common.is_empty() {
            return;
        }
        let plain = self.combination.is_none() && other.combination.is_none();
        let mut own = Mat::new();
        let target = if plain {
            &mut *sum
        } else {
            own = Mat::zeros(self.columns.nrows(), other.columns.nrows());
            &mut own
        };
        for [a, b, count] in common {
            let left = self.columns.subcols(a, count);
            let right = other.columns.subcols(b, count).transpose();
            matmul(target.as_mut(), Accum::Add, left, right, 1.0, Par::Seq);
        }
        let add = |sum: &mut Mat<f64>, left: MatRef<f64>, right: MatRef<f64>| {
            matmul(sum, Accum::Add, left, right, 1.0, Par::Seq);
        };
        match (&self.combination, &other.combination) {
            (None, None) => {}
            (Some(r), None) => add(sum, r.transpose(), own.as_ref()),
            (None, Some(r)) => add(sum, own.as_ref(), r.as_ref()),
            (Some(left), Some(right)) => {
                let half = left.transpose() * &own;
                add(sum, half.as_ref(), right.as_ref());
            }
        }
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
        let structure = self.supernodes();
        let path = Path::new(structure, columns);
        let entries = |k: usize| {
            let step = &path.steps[k];
            step.width * (step.width + step.below.len())
        };
        let mut ahead: usize = (0..path.steps.len()).map(entries).sum();
        let mut x = Mat::zeros(columns.len(), path.rows);
        let mut reached = Reached::default();
        for (j, &column) in columns.iter().enumerate() {
            x[(j, path.row(column))] = 1.0;
            reached.rows.insert(path.row(column) as u32);
        }
        let most = path.steps.iter().map(|s| s.below.len()).max();
        let mut beside = Mat::zeros(columns.len(), most.unwrap_or(0));
        let mut parts = Vec::new();
        let mut combination: Option<Mat<f64>> = None;
        let (mut first, mut flops) = (0, 0.0);
        // The number of rows at which a lower rank is looked for next.
        let mut next_look = ROWS * columns.len();
        for k in 0..path.steps.len() {
            let step = &path.steps[k];
            let n = x.nrows();
            let below = step.below.len();
            let beside = beside.as_mut().submatrix_mut(0, 0, n, below);
            self.step_up(step, x.as_mut(), beside);
            flops += 2.0 * (n * entries(k)) as f64;
            ahead -= entries(k);
            reached.rows.extend(&step.below);
            let done = step.first_row + step.width;
            reached.rows = reached.rows.split_off(&(done as u32));
            let b = reached.rows.len();
            if n < FEWEST || b < next_look || ahead < WORTH * b * n {
                continue;
            }
            next_look = b + b / 2;
            let u = reached.gather(&x);
            flops += (8 * b * n * n / 2) as f64;
            let Some((range, basis)) = low_rank(&u) else {
                continue;
            };
            parts.push(part(&path, &x, [first, done], combination.as_ref()));
            first = done;
            combination = Some(match combination {
                Some(before) => &range * &before,
                None => range,
            });
            x = reached.scatter(&basis, path.rows);
            next_look = next_look.max(ROWS * x.nrows());
        }
        parts.push(part(&path, &x, [first, path.rows], combination.as_ref()));
        Block {
            members,
            parts,
            flops,
        }
    }
}

/// Rows of X from the first to the last of the path's.
fn part(
    path: &Path,
    x: &Mat<f64>,
    [first, end]: [usize; 2],
    combination: Option<&Mat<f64>>,
) -> Part {
    let inside = path.steps.iter().filter(|s| (first..end).contains(&s.first_row));
    let mut stretches: Vec<[usize; 3]> = Vec::new();
    for step in inside {
        match stretches.last_mut() {
            Some([begin, _, len]) if *begin + *len == step.begin => *len += step.width,
            _ => stretches.push([step.begin, step.first_row - first, step.width]),
        }
    }
    Part {
        combination: combination.cloned(),
        stretches,
        columns: x.subcols(first, end - first).to_owned(),
    }
}

/// Rows of X that loads have reached and that are still ahead.
#[derive(Default)]
struct Reached {
    rows: BTreeSet<u32>,
}

impl Reached {
    /// Them alone, transposed.
    fn gather(&self, x: &Mat<f64>) -> Mat<f64> {
        let mut u = Mat::zeros(x.nrows(), self.rows.len());
        for (i, &row) in self.rows.iter().enumerate() {
            u.col_mut(i).copy_from(x.col(row as usize));
        }
        u
    }

    fn scatter(&self, u: &Mat<f64>, rows: usize) -> Mat<f64> {
        let mut x = Mat::zeros(u.nrows(), rows);
        for (i, &row) in self.rows.iter().enumerate() {
            x.col_mut(row as usize).copy_from(u.col(i));
        }
        x
    }
}

/// Uᵀ = Rᵀ Qᵀ for Uᵀ with n rows, if half as many will do: R, r × n, and Qᵀ. The range is that of U times
/// as many pseudo-random vectors (Halko, Martinsson & Tropp 2011), and what it leaves of U is measured.
fn low_rank(u: &Mat<f64>) -> Option<(Mat<f64>, Mat<f64>)> {
    let (n, rows) = (u.nrows(), u.ncols());
    let r = n / 2;
    let mut seed = 0x9e37_79b9_7f4a_7c15u64;
    let probe = Mat::from_fn(n, r, |_, _| {
        // xorshift64.
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    });
    let mut sample = Mat::zeros(rows, r);
    matmul(&mut sample, Accum::Replace, u.transpose(), &probe, 1.0, Par::Seq);
    let q = sample.qr().compute_thin_Q();
    let mut range = Mat::zeros(r, n);
    matmul(&mut range, Accum::Replace, q.transpose(), u.transpose(), 1.0, Par::Seq);
    let mut rest = u.clone();
    matmul(&mut rest, Accum::Add, range.transpose(), q.transpose(), -1.0, Par::Seq);
    let is_complete = rest.norm_l2() <= RANK * u.norm_l2();
    is_complete.then(|| (range, q.transpose().to_owned()))
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
                let near = [(i + 1, j), (i, j + 1), (i + 1, j + 1), (i + 1, j.wrapping_sub(1))];
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
        symbolic.and_then(|s| s.factorise(&matrix)).expect("a factor")
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
        let is_compressed = |block: &Block| block.parts.len() > 1;
        assert!(of_zone.blocks.iter().any(is_compressed));
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
        // Rounding of both, and what a lower rank leaves out.
        assert!(differ < 1e-13 * scale, "{:e}", differ / scale);
    }
}
