//! Numeric Cholesky factorisation K = L Lᵀ, multifrontal (Duff & Reid 1983; Liu 1992).
//!
//! A supernode's front is K on its columns and rows, plus what its children pass up:
//!
//! ```text
//! F = [A11  · ]     L11 L11ᵀ = A11,   L21 = A21 L11⁻ᵀ,   passed up: U = A22 − L21 L21ᵀ
//!     [A21 A22]
//! ```
//!
//! Subtrees of the elimination tree do not need each other: those with work enough are shared out to
//! the threads, and large blocks near the root are cut. Both follow from the structure alone, and children
//! are added in their order: the bits do not depend on the number of threads.

use super::kernels::Added;
use super::supernodes::Supernodes;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError, cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Accum, MatMut, Par};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// Subtrees with less than this share of all work, or less work than this, stay with one thread.
const SHARE: f64 = 1.0 / 64.0;
const LEAST_WORK: f64 = 1e7;

/// Blocks with more multiplications and additions are cut for the threads, into this many parts
/// whatever the number of threads: the cuts decide the order of sums, and so the bits.
const LARGE: f64 = 2e8;
const PARTS: usize = 8;

/// The least pivot L_jj² over K_jj. A singular K leaves pivots of rounding size, some 1e-16, of either
/// sign. A body that is held has larger ones: beam theory gives some 1e-10 for a cantilever a thousand
/// times as long as deep, and they fall with the cube of that ratio.
const LEAST_PIVOT: f64 = 1e-13;

/// The column of a pivot that is not positive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotPositive(pub usize);

/// Writes L into `values`; `matrix` are the entries of K that the structure was found from.
pub fn factorise(
    structure: &Supernodes,
    matrix: &[f64],
    values: &mut [f64],
    pool: &Pool,
) -> Result<(), NotPositive> {
    let roots = structure.roots();
    let total: f64 = roots.iter().map(|&s| structure.subtree_flops(s)).sum();
    let numeric = Numeric {
        structure,
        matrix,
        least: LEAST_WORK.max(SHARE * total),
        pool,
    };
    numeric.subtrees(&roots, values).map(|_| ())
}

struct Numeric<'a> {
    structure: &'a Supernodes,
    matrix: &'a [f64],
    /// Work of the smallest subtree that is looked into for more tasks.
    least: f64,
    pool: &'a Pool,
}

/// U of a supernode, column by column; the lower triangle is meant.
struct Update {
    supernode: usize,
    values: Vec<f64>,
}

/// Memory of updates that are no longer needed, for others: fresh pages cost as much as the sums in them.
#[derive(Debug, Default)]
pub struct Pool(Mutex<Vec<Vec<f64>>>);

impl Pool {
    /// So many numbers, whichever they are.
    fn take(&self, length: usize) -> Vec<f64> {
        let mut free = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let fitting = free.iter().position(|vector| vector.capacity() >= length);
        let found = fitting.map(|k| free.swap_remove(k));
        drop(free);
        let mut vector = found.unwrap_or_default();
        if vector.capacity() < length {
            return vec![0.0; length];
        }
        vector.resize(length, 0.0);
        vector
    }

    fn give(&self, vector: Vec<f64>) {
        let mut free = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let at = free.partition_point(|other| other.capacity() < vector.capacity());
        free.insert(at, vector);
    }
}

impl Numeric<'_> {
    /// Neighbouring subtrees, whose entries of L are `values`.
    fn subtrees(&self, roots: &[usize], values: &mut [f64]) -> Result<Vec<Update>, NotPositive> {
        let tasks = self.split(roots, values);
        let done: Vec<Result<Update, NotPositive>> = (tasks.into_par_iter())
            .map(|(root, values)| self.subtree(root, values))
            .collect();
        // The first failure in the order of elimination, on any number of threads.
        done.into_iter().collect()
    }

    fn split<'v>(&self, roots: &[usize], mut values: &'v mut [f64]) -> Vec<(usize, &'v mut [f64])> {
        let share = |&root: &usize| {
            let subtree = self.structure.subtree(root);
            let entries =
                self.structure.block(root).end - self.structure.block(subtree.start).start;
            let (own, rest) = std::mem::take(&mut values).split_at_mut(entries);
            values = rest;
            (root, own)
        };
        roots.iter().map(share).collect()
    }

    fn subtree(&self, root: usize, values: &mut [f64]) -> Result<Update, NotPositive> {
        if self.structure.subtree_flops(root) < self.least {
            return self.sequential(root, values);
        }
        // Down to where the tree forks, so that calls do not nest as deep as the tree.
        let mut chain: Vec<(usize, &mut [f64], Vec<Update>, Vec<Update>)> = Vec::new();
        let (mut top, mut values) = (root, values);
        loop {
            let children = self.structure.children(top);
            let below = values.len() - self.structure.block(top).len();
            let (subtrees, block) = values.split_at_mut(below);
            let large = |&c: &usize| self.structure.subtree_flops(c) >= self.least;
            if children.iter().filter(|c| large(c)).count() != 1 {
                let updates = self.subtrees(&children, subtrees)?;
                let mut update = self.front(top, block, updates)?;
                while let Some((s, block, mut updates, after)) = chain.pop() {
                    updates.push(update);
                    updates.extend(after);
                    update = self.front(s, block, updates)?;
                }
                return Ok(update);
            }
            let at = children
                .iter()
                .position(|c| large(c))
                .expect("there is one");
            let mut parts = self.split(&children, subtrees);
            let after = parts.split_off(at + 1);
            let (next, part) = parts.pop().expect("there is one");
            let side = |parts: Vec<(usize, &mut [f64])>| -> Result<Vec<Update>, NotPositive> {
                let side: Vec<_> = (parts.into_par_iter())
                    .map(|(root, values)| self.sequential(root, values))
                    .collect();
                side.into_iter().collect()
            };
            chain.push((top, block, side(parts)?, side(after)?));
            (top, values) = (next, part);
        }
    }

    fn dense(&self, columns: usize) -> MemBuffer {
        let scratch = cholesky_in_place_scratch::<f64>(columns, Par::Seq, Default::default());
        MemBuffer::new(scratch)
    }

    fn front(
        &self,
        s: usize,
        block: &mut [f64],
        children: Vec<Update>,
    ) -> Result<Update, NotPositive> {
        let rows = self.structure.rows(s).len();
        let mut update = self.pool.take(rows * rows);
        let updates: Vec<(usize, &[f64])> = (children.iter())
            .map(|child| (child.supernode, child.values.as_slice()))
            .collect();
        let mut dense = self.dense(self.structure.width(s));
        self.eliminate(s, block, &updates, &mut update, &mut dense)?;
        children
            .into_iter()
            .for_each(|child| self.pool.give(child.values));
        Ok(Update {
            supernode: s,
            values: update,
        })
    }

    /// A subtree, supernode after supernode.
    fn sequential(&self, root: usize, values: &mut [f64]) -> Result<Update, NotPositive> {
        let structure = self.structure;
        let subtree = structure.subtree(root);
        let first = subtree.start;
        let widest = subtree.clone().map(|s| structure.width(s)).max();
        let mut dense = self.dense(widest.unwrap_or(0));
        let Stacks { level, size } = Stacks::of(structure, subtree.clone());
        // Of supernodes an even, and an odd number of levels below the root: one is read, one is written.
        let mut stacks = size.map(|size| self.pool.take(size));
        let mut top = [0, 0];
        let mut rest = values;
        for s in subtree {
            let (block, after) = std::mem::take(&mut rest).split_at_mut(structure.block(s).len());
            rest = after;
            let rows = structure.rows(s).len();
            let own = level[s - first] % 2;
            let [even, odd] = &mut stacks;
            let (write, read) = if own == 0 { (even, odd) } else { (odd, even) };
            let mut end = top[1 - own];
            let mut children: Vec<(usize, &[f64])> = Vec::new();
            for child in structure.children_from_last(s) {
                let begin = end - structure.rows(child).len().pow(2);
                children.push((child, &read[begin..end]));
                end = begin;
            }
            let update = &mut write[top[own]..][..rows * rows];
            self.eliminate(s, block, &children, update, &mut dense)?;
            top[own] += rows * rows;
            top[1 - own] = end;
        }
        let [mut update, odd] = stacks;
        self.pool.give(odd);
        update.truncate(top[0]);
        Ok(Update {
            supernode: root,
            values: update,
        })
    }

    /// One front: its block of L, and what it passes up.
    fn eliminate(
        &self,
        s: usize,
        block: &mut [f64],
        children: &[(usize, &[f64])],
        update: &mut [f64],
        dense: &mut MemBuffer,
    ) -> Result<(), NotPositive> {
        let structure = self.structure;
        let (width, rows) = (structure.width(s), structure.rows(s).len());
        let height = width + rows;
        block.fill(0.0);
        self.add_matrix(s, block);
        let children: Vec<(Runs, &[f64])> = (children.iter())
            .map(|&(child, update)| (Runs::new(structure.places(child), width), update))
            .collect();
        let mut diagonal = vec![0.0; width];
        for (column, diagonal) in diagonal.iter_mut().enumerate() {
            *diagonal = self.diagonal(s, column);
        }
        for (runs, child) in &children {
            runs.add_columns(child, block, height);
        }
        let par = if structure.flops(s) > LARGE {
            Par::rayon(PARTS)
        } else {
            Par::Seq
        };
        let l = MatMut::from_column_major_slice_mut(block, height, width);
        let (mut l11, mut l21) = l.split_at_row_mut(width);
        let first = structure.columns(s).start;
        cholesky_in_place(
            l11.as_mut(),
            Default::default(),
            par,
            MemStack::new(dense),
            Default::default(),
        )
        .map_err(|LltError::NonPositivePivot { index }| NotPositive(first + index))?;
        for (j, &diagonal) in diagonal.iter().enumerate() {
            // False for a pivot that is not a number.
            let sound = l11[(j, j)].powi(2) > LEAST_PIVOT * diagonal;
            if !sound {
                return Err(NotPositive(first + j));
            }
        }
        if rows == 0 {
            return Ok(());
        }
        solve_lower_triangular_in_place(l11.as_ref(), l21.as_mut().transpose_mut(), par);
        let mut u = MatMut::from_column_major_slice_mut(update, rows, rows);
        triangular::matmul(
            u.as_mut(),
            BlockStructure::TriangularLower,
            Accum::Replace,
            l21.as_ref(),
            BlockStructure::Rectangular,
            l21.as_ref().transpose(),
            BlockStructure::Rectangular,
            -1.0,
            par,
        );
        for (runs, child) in &children {
            runs.add_rest(child, update, rows);
        }
        Ok(())
    }

    fn diagonal(&self, s: usize, column: usize) -> f64 {
        let first = self.structure.columns(s).start + column - column % 2;
        let sources = self.structure.sources(first);
        let own = sources
            .iter()
            .find(|source| source.row as usize == column - column % 2);
        own.map_or(0.0, |own| self.matrix[own.columns[column % 2] as usize])
    }

    /// K's entries in the columns of a supernode.
    fn add_matrix(&self, s: usize, block: &mut [f64]) {
        let columns = self.structure.columns(s);
        let height = columns.len() + self.structure.rows(s).len();
        for (first, pair) in columns.step_by(2).zip((0..).step_by(2)) {
            let (left, right) = block[pair * height..(pair + 2) * height].split_at_mut(height);
            for source in self.structure.sources(first) {
                let row = source.row as usize;
                let [a, b] = source.columns.map(|at| at as usize);
                if row == pair {
                    left[row] = self.matrix[a];
                    left[row + 1] = self.matrix[a + 1];
                    right[row + 1] = self.matrix[b];
                } else if source.transposed {
                    left[row] = self.matrix[a];
                    right[row] = self.matrix[a + 1];
                    left[row + 1] = self.matrix[b];
                    right[row + 1] = self.matrix[b + 1];
                } else {
                    left[row..row + 2].copy_from_slice(&self.matrix[a..a + 2]);
                    right[row..row + 2].copy_from_slice(&self.matrix[b..b + 2]);
                }
            }
        }
    }
}

/// Room for the updates of a subtree.
struct Stacks {
    /// By supernode: levels below the root.
    level: Vec<usize>,
    /// Numbers that wait at most on even and on odd levels.
    size: [usize; 2],
}

impl Stacks {
    fn of(structure: &Supernodes, subtree: Range<usize>) -> Stacks {
        let first = subtree.start;
        let mut level = vec![0; subtree.len()];
        for s in subtree.clone().rev().skip(1) {
            let parent = structure.parent(s).expect("only the root has none");
            level[s - first] = level[parent - first] + 1;
        }
        let (mut top, mut size) = ([0, 0], [0, 0]);
        for s in subtree {
            let own = level[s - first] % 2;
            top[own] += structure.rows(s).len().pow(2);
            size[own] = size[own].max(top[own]);
            for child in structure.children_from_last(s) {
                top[1 - own] -= structure.rows(child).len().pow(2);
            }
        }
        Stacks { level, size }
    }
}

/// Rows of a child that are next to each other in its parent.
struct Runs {
    /// Row of the child, row of the parent's front, length.
    runs: Vec<[usize; 3]>,
    rows: usize,
    /// Columns of the parent.
    width: usize,
}

impl Runs {
    fn new(places: &[u32], width: usize) -> Runs {
        let mut runs: Vec<[usize; 3]> = Vec::new();
        for (row, &place) in places.iter().enumerate() {
            let place = place as usize;
            match runs.last_mut() {
                // Columns and rows of the parent go to different places.
                Some([_, begin, length]) if *begin + *length == place && place != width => {
                    *length += 1;
                }
                _ => runs.push([row, place, 1]),
            }
        }
        Runs {
            runs,
            rows: places.len(),
            width,
        }
    }

    /// Adds what falls into the parent's columns.
    fn add_columns(&self, child: &[f64], block: &mut [f64], height: usize) {
        self.add(child, block, height, 0..self.width);
    }

    /// Adds what the parent passes on.
    fn add_rest(&self, child: &[f64], update: &mut [f64], rows: usize) {
        self.add(child, update, rows, self.width..usize::MAX);
    }

    fn add(&self, update: &[f64], front: &mut [f64], height: usize, columns: Range<usize>) {
        Added {
            runs: &self.runs,
            update,
            rows: self.rows,
            front,
            height,
            first: columns.start,
            end: columns.end,
        }
        .add();
    }
}
