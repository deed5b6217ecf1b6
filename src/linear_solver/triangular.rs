//! L Lᵀ x = b over supernodes, up the elimination tree and down again.
//!
//! ```text
//! up:    y = L11⁻¹ (b + Σ children),   passed up: Σ children − L21 y
//! down:  x = L11⁻ᵀ (y − L21ᵀ x_rows)
//! ```
//!
//! The time is that of reading L twice. Subtrees are shared out to the threads; their updates are added
//! in the order of the tree, so that the bits do not depend on the number of threads.

use super::kernels::Block;
use super::policy::{SUBTREE_ENTRIES, TOGETHER};
use super::supernodes::Supernodes;
use rayon::prelude::*;
use std::ops::Range;

/// The unknowns that are needed.
#[derive(Clone, Copy)]
pub enum Wanted<'a> {
    All,
    /// The unknowns of supernodes for which it is true, which hold with each of them all above it; the others
    /// become zero.
    Some(&'a [bool]),
}

impl Wanted<'_> {
    fn has(self, s: usize) -> bool {
        match self {
            Wanted::All => true,
            Wanted::Some(supernodes) => supernodes[s],
        }
    }
}

/// Overwrites `x`, vectors one after the other, by (L Lᵀ)⁻¹ x. `values`: the blocks of L; `dof`: the unknown that a
/// column eliminates.
pub fn solve(
    structure: &Supernodes,
    values: &[f64],
    x: &mut [f64],
    wanted: Wanted,
    dof: impl Fn(usize) -> usize + Copy,
) {
    let n = structure.dofs();
    let sweep = Sweep {
        structure,
        values,
        wanted,
    };
    for x in x.chunks_mut(TOGETHER * n) {
        // [`TOGETHER`] right-hand sides, or half of them, or one.
        match x.len() / n {
            1 => sweep.solve::<1>(x, dof),
            2..=4 => sweep.solve::<4>(x, dof),
            _ => sweep.solve::<TOGETHER>(x, dof),
        }
    }
}

struct Sweep<'a> {
    structure: &'a Supernodes,
    /// The blocks of L.
    values: &'a [f64],
    wanted: Wanted<'a>,
}

/// Neighbouring supernodes with their part of the unknowns and of the updates that go to their parents: one number
/// for each right-hand side.
struct Subtrees<'a, const K: usize> {
    supernodes: Range<usize>,
    x: &'a mut [[f64; K]],
    work: &'a mut [[f64; K]],
}

impl Sweep<'_> {
    /// Solves for `K` vectors one after the other, or fewer.
    fn solve<const K: usize>(&self, vectors: &mut [f64], dof: impl Fn(usize) -> usize) {
        let n = self.structure.dofs();
        let mut x = vec![[0.0; K]; n];
        let mut work = vec![[0.0; K]; self.rows(0..self.structure.len()).len()];
        for (column, x) in x.iter_mut().enumerate() {
            let own = vectors[dof(column)..].iter().step_by(n);
            x.iter_mut().zip(own).for_each(|(x, &own)| *x = own);
        }
        let roots = self.structure.roots();
        for run in [Sweep::up, Sweep::down] {
            let all = Subtrees {
                supernodes: 0..self.structure.len(),
                x: &mut x,
                work: &mut work,
            };
            self.share_out(&roots, all, run);
        }
        for (column, x) in x.iter().enumerate() {
            let own = vectors[dof(column)..].iter_mut().step_by(n);
            x.iter().zip(own).for_each(|(x, own)| *own = *x);
        }
    }

    fn rows(&self, supernodes: Range<usize>) -> Range<usize> {
        match supernodes.clone().next_back() {
            None => 0..0,
            Some(last) => {
                self.structure.row_range(supernodes.start).start..self.structure.row_range(last).end
            }
        }
    }

    fn columns(&self, supernodes: Range<usize>) -> Range<usize> {
        match supernodes.clone().next_back() {
            None => 0..0,
            Some(last) => {
                self.structure.columns(supernodes.start).start..self.structure.columns(last).end
            }
        }
    }

    fn block(&self, s: usize) -> Block<'_> {
        let (width, rows) = (self.structure.width(s), self.structure.rows(s).len());
        Block {
            values: &self.values[self.structure.block(s)],
            width,
            height: width + rows,
        }
    }

    fn entries(&self, root: usize) -> usize {
        let first = self.structure.subtree(root).start;
        self.structure.block(root).end - self.structure.block(first).start
    }

    /// Runs all subtrees of `roots`, which `all` consists of.
    fn share_out<const K: usize>(
        &self,
        roots: &[usize],
        all: Subtrees<K>,
        run: fn(&Self, usize, Subtrees<K>),
    ) {
        let (mut x, mut work) = (all.x, all.work);
        let share = |&root: &usize| {
            let supernodes = self.structure.subtree(root);
            let columns = self.columns(supernodes.clone()).len();
            let rows = self.rows(supernodes.clone()).len();
            let (own_x, rest) = std::mem::take(&mut x).split_at_mut(columns);
            x = rest;
            let (own_work, rest) = std::mem::take(&mut work).split_at_mut(rows);
            work = rest;
            let own = Subtrees {
                supernodes,
                x: own_x,
                work: own_work,
            };
            (root, own)
        };
        let shares: Vec<(usize, Subtrees<K>)> = roots.iter().map(share).collect();
        shares
            .into_par_iter()
            .for_each(|(root, own)| run(self, root, own));
    }

    /// The first supernode, from `root` down, whose subtree forks into several large ones or none;
    /// `None` if the whole subtree is for one thread.
    fn fork(&self, root: usize) -> Option<usize> {
        let mut top = root;
        if self.entries(root) < SUBTREE_ENTRIES {
            return None;
        }
        loop {
            let mut large = (self.structure.children_from_last(top))
                .filter(|&c| self.entries(c) >= SUBTREE_ENTRIES);
            match (large.next(), large.next()) {
                (Some(only), None) => top = only,
                (None, _) => return None,
                _ => return Some(top),
            }
        }
    }

    fn up<const K: usize>(&self, root: usize, own: Subtrees<K>) {
        let Subtrees {
            supernodes,
            x,
            work,
        } = own;
        let mut front = Vec::new();
        let Some(top) = self.fork(root) else {
            for s in supernodes.clone() {
                self.up_one(s, supernodes.start, x, work, &mut front);
            }
            return;
        };
        let below = self.structure.subtree(top);
        for s in supernodes.start..below.start {
            self.up_one(s, supernodes.start, x, work, &mut front);
        }
        self.fork_of(top, supernodes.start, x, work, Sweep::up);
        for s in top..=root {
            self.up_one(s, supernodes.start, x, work, &mut front);
        }
    }

    fn down<const K: usize>(&self, root: usize, own: Subtrees<K>) {
        let Subtrees {
            supernodes,
            x,
            work,
        } = own;
        let mut front = Vec::new();
        let Some(top) = self.fork(root) else {
            for s in supernodes.clone().rev() {
                self.down_one(s, supernodes.start, x, work, &mut front);
            }
            return;
        };
        let below = self.structure.subtree(top);
        for s in (top..=root).rev() {
            self.down_one(s, supernodes.start, x, work, &mut front);
        }
        self.fork_of(top, supernodes.start, x, work, Sweep::down);
        for s in (supernodes.start..below.start).rev() {
            self.down_one(s, supernodes.start, x, work, &mut front);
        }
    }

    /// The subtrees of the children of `top`; `first` is the first supernode of `x` and `work`.
    fn fork_of<const K: usize>(
        &self,
        top: usize,
        first: usize,
        x: &mut [[f64; K]],
        work: &mut [[f64; K]],
        run: fn(&Self, usize, Subtrees<K>),
    ) {
        let mut children: Vec<usize> = self.structure.children_from_last(top).collect();
        children.reverse();
        let supernodes = self.structure.subtree(top).start..top;
        let columns = self.local_columns(supernodes.clone(), first);
        let rows = self.local_rows(supernodes.clone(), first);
        let below = Subtrees {
            supernodes,
            x: &mut x[columns],
            work: &mut work[rows],
        };
        self.share_out(&children, below, run);
    }

    fn local_columns(&self, supernodes: Range<usize>, first: usize) -> Range<usize> {
        let shift = self.structure.columns(first).start;
        let columns = self.columns(supernodes);
        columns.start - shift..columns.end - shift
    }

    fn local_rows(&self, supernodes: Range<usize>, first: usize) -> Range<usize> {
        let shift = self.structure.row_range(first).start;
        let rows = self.rows(supernodes);
        rows.start - shift..rows.end - shift
    }

    fn up_one<const K: usize>(
        &self,
        s: usize,
        first: usize,
        x: &mut [[f64; K]],
        work: &mut [[f64; K]],
        front: &mut Vec<[f64; K]>,
    ) {
        let width = self.structure.width(s);
        let own = self.local_columns(s..s + 1, first);
        let passed = self.local_rows(s..s + 1, first);
        front.clear();
        front.extend_from_slice(&x[own.clone()]);
        front.resize(width + passed.len(), [0.0; K]);
        for child in self.structure.children_from_last(s) {
            let places = self.structure.places(child);
            let from = &work[self.local_rows(child..child + 1, first)];
            for (&place, from) in places.iter().zip(from) {
                let to = &mut front[place as usize];
                (0..K).for_each(|k| to[k] += from[k]);
            }
        }
        // Far from few forces all is zero: most of L need not be read on the way up.
        if front.iter().all(|f| f.iter().all(|&f| f == 0.0)) {
            return;
        }
        let block = self.block(s);
        block.forward(front);
        x[own].copy_from_slice(&front[..width]);
        work[passed].copy_from_slice(&front[width..]);
    }

    fn down_one<const K: usize>(
        &self,
        s: usize,
        first: usize,
        x: &mut [[f64; K]],
        work: &mut [[f64; K]],
        front: &mut Vec<[f64; K]>,
    ) {
        let width = self.structure.width(s);
        let own = self.local_columns(s..s + 1, first);
        if !self.wanted.has(s) {
            x[own].fill([0.0; K]);
            return;
        }
        let passed = self.local_rows(s..s + 1, first);
        front.clear();
        front.extend_from_slice(&x[own.clone()]);
        front.extend_from_slice(&work[passed]);
        let block = self.block(s);
        block.backward(front);
        x[own].copy_from_slice(&front[..width]);
        for child in self.structure.children_from_last(s) {
            let places = self.structure.places(child);
            let to = &mut work[self.local_rows(child..child + 1, first)];
            for (&place, to) in places.iter().zip(to) {
                *to = front[place as usize];
            }
        }
    }
}
