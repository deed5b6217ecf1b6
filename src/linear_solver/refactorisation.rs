//! Factors that follow a change of K: the fronts where it changes, and those above them up to the root, are
//! factorised anew from the updates of their other children, which are kept ([`Kept`]): the same sums as of a
//! whole factorisation, and so the same bits.

use super::multifrontal::{Child, Front, NotPositive, Numeric, Updates};
use super::supernodes::Supernodes;
use super::update_memory::Pool;
use faer::dyn_stack::{MemBuffer, MemStack};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// The updates from which supernodes are factorised anew.
#[derive(Clone, Debug, Default)]
pub struct Kept {
    /// Updates, by supernode, for parents that were factorised anew and may be again.
    updates: Updates,
    /// Supernodes that are not done because a pivot failed, ascending.
    undone: Vec<usize>,
    /// Room for the updates of two levels: one is read while the next is written, in turn.
    stacks: [Vec<f64>; 2],
}

/// Fills the numbers of the supernodes of a path anew: ascending, with each of them all above it. The updates of
/// other children are those that are kept; where none is, it is computed, and kept from now on.
///
/// # Errors
/// [`NotPositive`]: the rest of the path is done by the next call.
pub fn refactorise<F: Front>(
    structure: &Supernodes,
    front: &F,
    values: &mut [f64],
    pool: &Pool,
    kept: &mut Kept,
    path: &[usize],
) -> Result<(), NotPositive> {
    let undone = std::mem::take(&mut kept.undone);
    let (path, missing) = kept.complete(structure, path.iter().copied().chain(undone).collect());
    let numeric = Numeric::new(structure, front, pool, &[]);
    let updates = numeric.stored_subtrees(&missing, values);
    kept.updates
        .extend(updates.inspect_err(|_| kept.undone.clone_from(&path))?);
    numeric.along(&path, values, kept)
}

/// The numbers of each supernode of a path.
fn blocks<'v, F: Front>(
    front: &F,
    mut values: &'v mut [f64],
    path: &[usize],
) -> BTreeMap<usize, &'v mut [f64]> {
    let mut offset = 0;
    let block = |&s: &usize| {
        let [begin, end] = [s, s + 1].map(|s| front.start(s));
        let rest = &mut std::mem::take(&mut values)[begin - offset..];
        let (own, rest) = rest.split_at_mut(end - begin);
        (values, offset) = (rest, end);
        (s, own)
    };
    path.iter().map(block).collect()
}

/// A path by distance from the root, the farthest first: supernodes of one level do not need each other.
fn levels(structure: &Supernodes, path: &[usize]) -> Vec<Vec<usize>> {
    let mut depths: BTreeMap<usize, usize> = BTreeMap::new();
    let mut levels: Vec<Vec<usize>> = Vec::new();
    for &s in path.iter().rev() {
        let depth = structure.parent(s).map_or(0, |parent| depths[&parent] + 1);
        depths.insert(s, depth);
        levels.resize_with(levels.len().max(depth + 1), Vec::new);
        levels[depth].push(s);
    }
    levels.reverse();
    levels
}

impl Kept {
    pub fn new(updates: Updates) -> Kept {
        Kept {
            updates,
            ..Kept::default()
        }
    }

    /// The path with those children besides it whose updates are not kept although some below them are; and the
    /// roots of subtrees of which no update is kept. Both ascending.
    fn complete(
        &self,
        structure: &Supernodes,
        mut path: BTreeSet<usize>,
    ) -> (Vec<usize>, Vec<usize>) {
        let mut missing = BTreeSet::new();
        let mut looked_at: Vec<usize> = path.iter().copied().collect();
        while let Some(s) = looked_at.pop() {
            for child in structure.children_from_last(s) {
                if self.updates.contains_key(&child) || path.contains(&child) {
                    continue;
                }
                if self
                    .updates
                    .range(structure.subtree(child))
                    .next()
                    .is_some()
                {
                    path.insert(child);
                    looked_at.push(child);
                } else {
                    missing.insert(child);
                }
            }
        }
        (path.into_iter().collect(), missing.into_iter().collect())
    }
}

/// The part of a path that is not done.
struct Undone {
    supernodes: BTreeSet<usize>,
    /// The first pivot that failed in the order of elimination, and its supernode.
    failed: Option<(usize, NotPositive)>,
}

impl Undone {
    /// Supernodes before the one whose pivot failed are done all the same, so that the first failure is reported.
    fn has_turn(&self, s: usize) -> bool {
        self.failed.is_none_or(|(failed, _)| s < failed)
    }

    fn note(&mut self, s: usize, done: Result<(), NotPositive>) {
        match done {
            Ok(()) => {
                self.supernodes.remove(&s);
            }
            Err(pivot) => {
                let other = self.failed.unwrap_or((s, pivot));
                self.failed = Some(other.min((s, pivot)));
            }
        }
    }
}

/// A supernode that is eliminated once more: its numbers, and its update.
struct Again<'v> {
    supernode: usize,
    own: &'v mut [f64],
    update: &'v mut [f64],
}

impl<F: Front> Numeric<'_, F> {
    /// Fills the numbers of a path, ascending, those far from the root first; the updates of other children are
    /// kept.
    ///
    /// # Errors
    /// [`NotPositive`]: the rest is noted as undone.
    fn along(
        &self,
        path: &[usize],
        values: &mut [f64],
        kept: &mut Kept,
    ) -> Result<(), NotPositive> {
        path.iter().for_each(|s| drop(kept.updates.remove(s)));
        let mut blocks = blocks(self.front, values, path);
        let levels = levels(self.structure, path);
        let mut stacks = std::mem::take(&mut kept.stacks);
        self.make_room(&mut stacks, &levels);
        let mut undone = Undone {
            supernodes: path.iter().copied().collect(),
            failed: None,
        };
        // The places of the updates of the level below in the stack that it wrote.
        let mut below: BTreeMap<usize, Range<usize>> = BTreeMap::new();
        for (k, level) in levels.iter().enumerate() {
            let [even, odd] = &mut stacks;
            let (write, read) = if k % 2 == 0 { (even, odd) } else { (odd, even) };
            let passed = |(&s, at): (&usize, &Range<usize>)| (s, &read[at.clone()]);
            let fresh: BTreeMap<usize, &[f64]> = below.iter().map(passed).collect();
            let level = level.iter().copied().filter(|&s| undone.has_turn(s));
            let (tasks, mut here) = self.tasks(level, &mut blocks, write);
            let done: Vec<_> = (tasks.into_par_iter())
                .map(|task| (task.supernode, self.again(task, &fresh, &kept.updates)))
                .collect();
            done.into_iter().for_each(|(s, done)| undone.note(s, done));
            here.retain(|s, _| !undone.supernodes.contains(s));
            for (s, update) in fresh {
                let parent = self.structure.parent(s).expect("on the level above");
                if !here.contains_key(&parent) {
                    kept.updates.insert(s, update.to_vec());
                }
            }
            below = here;
        }
        kept.stacks = stacks;
        let Some((_, pivot)) = undone.failed else {
            return Ok(());
        };
        kept.undone = undone.supernodes.into_iter().collect();
        Err(pivot)
    }

    /// Some supernodes with their numbers and room in a stack for their updates; and the places of that room.
    fn tasks<'v, 'b: 'v>(
        &self,
        supernodes: impl Iterator<Item = usize>,
        blocks: &mut BTreeMap<usize, &'b mut [f64]>,
        mut stack: &'v mut [f64],
    ) -> (Vec<Again<'v>>, BTreeMap<usize, Range<usize>>) {
        let (mut places, mut top) = (BTreeMap::new(), 0);
        let again = |s: usize| {
            let count = self.passed(s);
            let (update, rest) = std::mem::take(&mut stack).split_at_mut(count);
            places.insert(s, top..top + count);
            (stack, top) = (rest, top + count);
            Again {
                supernode: s,
                own: blocks.remove(&s).expect("done once"),
                update,
            }
        };
        (supernodes.map(again).collect(), places)
    }

    fn make_room(&self, stacks: &mut [Vec<f64>; 2], levels: &[Vec<usize>]) {
        let size = |level: &Vec<usize>| level.iter().map(|&s| self.passed(s)).sum::<usize>();
        for (first, stack) in stacks.iter_mut().enumerate() {
            let sizes = levels.iter().skip(first).step_by(2).map(size);
            let most = sizes.max().unwrap_or(0);
            if stack.len() < most {
                *stack = Vec::new();
                *stack = vec![0.0; most];
            }
        }
    }

    /// Eliminates a supernode of a path once more, from the fresh updates of children on the path and the kept ones
    /// of others.
    fn again(
        &self,
        task: Again,
        fresh: &BTreeMap<usize, &[f64]>,
        kept: &Updates,
    ) -> Result<(), NotPositive> {
        let s = task.supernode;
        let children = self.structure.children(s);
        let child = |&child: &usize| {
            let update = fresh.get(&child).copied();
            self.child(child, s, update.unwrap_or_else(|| &kept[&child]))
        };
        let updates: Vec<Child> = children.iter().map(child).collect();
        let mut memory = MemBuffer::new(self.front.scratch(self.structure.width(s)));
        let memory = MemStack::new(&mut memory);
        (self.front).eliminate(s, task.own, &updates, task.update, memory)
    }
}
