//! Numeric factorisation, multifrontal (Duff & Reid 1983; Liu 1992).
//!
//! A supernode's front is K on its columns and rows, plus the updates of its children:
//!
//! ```text
//! F = [A11 A12]   factors of A11 and of its rows and columns; update: U = A22 − A21 A11⁻¹ A12
//!     [A21 A22]
//! ```
//!
//! Subtrees of the elimination tree do not need each other: those with work enough are shared out to
//! the threads, and blocks are cut in tiles (`tiles.rs`). Both follow from the structure alone, and children
//! are added in their order: the bits do not depend on the number of threads.

use super::extend_add::{Part, Runs, first_row, update_entries};
use super::policy::{PANEL, SUBTREE_SHARE, SUBTREE_WORK};
use super::supernodes::Supernodes;
use super::update_memory::{Pool, Stacks};
use faer::MatMut;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

/// The column of a pivot that is not positive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct NotPositive(pub usize);

/// A factorisation, front by front.
pub trait Front: Sync {
    /// The first number of a supernode among all; at the number of supernodes, the count of all numbers.
    fn start(&self, s: usize) -> usize;

    /// Memory to work in for so many columns.
    fn scratch(&self, columns: usize) -> StackReq;

    /// Fills a supernode's numbers and its update, panel by panel.
    ///
    /// # Errors
    /// [`NotPositive`].
    fn eliminate(
        &self,
        s: usize,
        own: &mut [f64],
        children: &[Child],
        update: &mut [f64],
        memory: &mut MemStack,
    ) -> Result<(), NotPositive>;
}

/// The update of a child.
pub struct Child<'a> {
    pub runs: Runs,
    pub update: &'a [f64],
}

/// Adds the updates of children to a part of their parent's front, in their order.
pub fn add_children(children: &[Child], mut part: Part) {
    for child in children {
        child.runs.add(child.update, &mut part);
    }
}

/// Fills the update of a front of `width` columns: `product` writes −A21 A11⁻¹ A12 to a panel, whose first column is
/// given, and which is still in the cache when the updates of children are added.
pub fn pass_up(
    children: &[Child],
    width: usize,
    rows: usize,
    update: &mut [f64],
    product: impl Fn(MatMut<f64>, usize) + Sync,
) {
    let mut rest = update;
    let panel = |first: usize| {
        let (count, height) = (PANEL.min(rows - first), rows - first_row(first));
        let (values, after) = std::mem::take(&mut rest).split_at_mut(count * height);
        rest = after;
        let part = Part {
            values,
            columns: width + first..width + first + count,
            first_row: width + rows - height,
            height,
        };
        (first, part)
    };
    let panels: Vec<(usize, Part)> = (0..rows).step_by(PANEL).map(panel).collect();
    panels.into_par_iter().for_each(|(first, part)| {
        let (height, count) = (part.height, part.columns.len());
        product(
            MatMut::from_column_major_slice_mut(part.values, height, count),
            first,
        );
        add_children(children, part);
    });
}

/// Updates by supernode, in as little memory as they need.
pub type Updates = BTreeMap<usize, Vec<f64>>;

/// Fills the numbers of all supernodes. `path`: those that are likely to change, ascending and with each of them
/// all above it; the updates of their other children are returned.
///
/// # Errors
/// [`NotPositive`].
pub fn factorise<F: Front>(
    structure: &Supernodes,
    front: &F,
    values: &mut [f64],
    pool: &Pool,
    path: &[usize],
) -> Result<Updates, NotPositive> {
    let numeric = Numeric::new(structure, front, pool, path);
    let roots = numeric.subtrees(&structure.roots(), values, 0)?;
    roots.into_iter().for_each(|root| pool.give(root.values));
    Ok(numeric.kept())
}

pub struct Numeric<'a, F> {
    pub structure: &'a Supernodes,
    pub front: &'a F,
    /// Work of the smallest subtree that is split into more tasks [multiplications and additions].
    least: f64,
    pub pool: &'a Pool,
    /// Supernodes whose other children's updates are kept; ascending.
    path: &'a [usize],
    kept: Mutex<Updates>,
}

/// The update of a supernode.
struct Update {
    supernode: usize,
    values: Vec<f64>,
}

/// A supernode with one large child, which is not done yet.
struct Link<'v> {
    supernode: usize,
    block: &'v mut [f64],
    /// Updates of its small children before and after the large one.
    before: Vec<Update>,
    after: Vec<Update>,
}

impl<'a, F: Front> Numeric<'a, F> {
    pub fn new(
        structure: &'a Supernodes,
        front: &'a F,
        pool: &'a Pool,
        path: &'a [usize],
    ) -> Numeric<'a, F> {
        Numeric {
            structure,
            front,
            least: SUBTREE_WORK.max(SUBTREE_SHARE * structure.total_flops()),
            pool,
            path,
            kept: Mutex::default(),
        }
    }

    fn kept(self) -> Updates {
        let kept = self.kept.into_inner();
        kept.unwrap_or_else(PoisonError::into_inner)
    }

    /// Factorises subtrees in ascending order; `values` begins at number `offset`.
    fn subtrees(
        &self,
        roots: &[usize],
        values: &mut [f64],
        offset: usize,
    ) -> Result<Vec<Update>, NotPositive> {
        let tasks = self.split(roots, values, offset);
        let done: Vec<Result<Update, NotPositive>> = (tasks.into_par_iter())
            .map(|(root, values)| self.subtree(root, values))
            .collect();
        // The first failure in the order of elimination, on any number of threads.
        done.into_iter().collect()
    }

    /// Factorises subtrees and returns the updates of their roots in as little memory as they need; ascending.
    pub fn stored_subtrees(
        &self,
        roots: &[usize],
        values: &mut [f64],
    ) -> Result<Vec<(usize, Vec<f64>)>, NotPositive> {
        let tasks = self.split(roots, values, 0).into_par_iter();
        let done: Vec<Result<(usize, Vec<f64>), NotPositive>> = tasks
            .map(|(root, values)| {
                let update = self.subtree(root, values)?;
                let stored = update.values.to_vec();
                self.pool.give(update.values);
                Ok((root, stored))
            })
            .collect();
        done.into_iter().collect()
    }

    /// The numbers of each of some subtrees in ascending order; `values` begins at number `offset`.
    fn split<'v>(
        &self,
        roots: &[usize],
        mut values: &'v mut [f64],
        mut offset: usize,
    ) -> Vec<(usize, &'v mut [f64])> {
        let share = |&root: &usize| {
            let begin = self.front.start(self.structure.subtree(root).start);
            let end = self.front.start(root + 1);
            let rest = &mut std::mem::take(&mut values)[begin - offset..];
            let (own, rest) = rest.split_at_mut(end - begin);
            (values, offset) = (rest, end);
            (root, own)
        };
        roots.iter().map(share).collect()
    }

    fn subtree(&self, root: usize, values: &mut [f64]) -> Result<Update, NotPositive> {
        if self.structure.subtree_flops(root) < self.least {
            return self.sequential(root, values);
        }
        // Down to where the tree forks, so that calls do not nest as deep as the tree.
        let mut chain: Vec<Link> = Vec::new();
        let (mut top, mut values) = (root, values);
        loop {
            let children = self.structure.children(top);
            let offset = self.front.start(self.structure.subtree(top).start);
            let below = values.len() - self.numbers(top);
            let (subtrees, block) = values.split_at_mut(below);
            let large = |&c: &usize| self.structure.subtree_flops(c) >= self.least;
            if children.iter().filter(|c| large(c)).count() != 1 {
                let updates = self.subtrees(&children, subtrees, offset)?;
                let mut update = self.front(top, block, updates)?;
                while let Some(link) = chain.pop() {
                    let mut updates = link.before;
                    updates.push(update);
                    updates.extend(link.after);
                    update = self.front(link.supernode, link.block, updates)?;
                }
                return Ok(update);
            }
            let at = children.iter().position(large).expect("there is one");
            let mut parts = self.split(&children, subtrees, offset);
            let after = parts.split_off(at + 1);
            let (next, part) = parts.pop().expect("there is one");
            let side = |parts: Vec<(usize, &mut [f64])>| -> Result<Vec<Update>, NotPositive> {
                let side: Vec<_> = (parts.into_par_iter())
                    .map(|(root, values)| self.sequential(root, values))
                    .collect();
                side.into_iter().collect()
            };
            chain.push(Link {
                supernode: top,
                block,
                before: side(parts)?,
                after: side(after)?,
            });
            (top, values) = (next, part);
        }
    }

    /// The count of a supernode's numbers.
    fn numbers(&self, s: usize) -> usize {
        self.front.start(s + 1) - self.front.start(s)
    }

    /// The count of numbers in a supernode's update.
    pub fn passed(&self, s: usize) -> usize {
        update_entries(self.structure.rows(s).len())
    }

    pub fn child<'u>(&self, child: usize, parent: usize, update: &'u [f64]) -> Child<'u> {
        let (places, width) = (self.structure.places(child), self.structure.width(parent));
        Child {
            runs: Runs::new(places, width),
            update,
        }
    }

    fn front(
        &self,
        s: usize,
        block: &mut [f64],
        children: Vec<Update>,
    ) -> Result<Update, NotPositive> {
        let mut update = self.pool.take(self.passed(s));
        let updates: Vec<Child> = (children.iter())
            .map(|child| self.child(child.supernode, s, &child.values))
            .collect();
        let mut memory = MemBuffer::new(self.front.scratch(self.structure.width(s)));
        let memory = MemStack::new(&mut memory);
        (self.front).eliminate(s, block, &updates, &mut update, memory)?;
        for child in children {
            self.keep(child.supernode, &child.values);
            self.pool.give(child.values);
        }
        Ok(Update {
            supernode: s,
            values: update,
        })
    }

    /// Keeps the update of a supernode if it is needed once more.
    fn keep(&self, s: usize, update: &[f64]) {
        let is_on_path = |s: usize| self.path.binary_search(&s).is_ok();
        let parent = self.structure.parent(s);
        if !is_on_path(s) && parent.is_some_and(is_on_path) {
            let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
            kept.insert(s, update.to_vec());
        }
    }

    /// Factorises a subtree, supernode after supernode.
    fn sequential(&self, root: usize, values: &mut [f64]) -> Result<Update, NotPositive> {
        let structure = self.structure;
        let subtree = structure.subtree(root);
        let first = subtree.start;
        let widest = subtree.clone().map(|s| structure.width(s)).max();
        let mut memory = MemBuffer::new(self.front.scratch(widest.unwrap_or(0)));
        let Stacks { level, size } = Stacks::new(structure, subtree.clone(), |s| self.passed(s));
        // One stack for even and one for odd numbers of levels below the root: one is read, one is written.
        let mut stacks = size.map(|size| self.pool.take(size));
        let mut top = [0, 0];
        let mut rest = values;
        for s in subtree {
            let (block, after) = std::mem::take(&mut rest).split_at_mut(self.numbers(s));
            rest = after;
            let own = level[s - first] % 2;
            let [even, odd] = &mut stacks;
            let (write, read) = if own == 0 { (even, odd) } else { (odd, even) };
            let mut end = top[1 - own];
            let mut children: Vec<Child> = Vec::new();
            for child in structure.children_from_last(s) {
                let begin = end - self.passed(child);
                children.push(self.child(child, s, &read[begin..end]));
                end = begin;
            }
            children.reverse();
            let update = &mut write[top[own]..][..self.passed(s)];
            let memory = MemStack::new(&mut memory);
            (self.front).eliminate(s, block, &children, update, memory)?;
            if s != root {
                self.keep(s, update);
            }
            top[own] += self.passed(s);
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
}
