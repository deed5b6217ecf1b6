//! Factors that follow a change of K: the fronts where it changes, and those above them up to the root, are
//! factorised anew, from what their other children pass up, which is kept ([`Kept`]): the same sums as of a
//! whole factorisation, and so the same bits.

use super::multifrontal::{Child, Front, NotPositive, Numeric, Pool, Updates};
use super::supernodes::Supernodes;
use faer::dyn_stack::{MemBuffer, MemStack};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// What it takes to factorise some supernodes anew.
#[derive(Clone, Debug, Default)]
pub struct Kept {
    /// By supernodes: what they pass up to those that were, and may be again.
    updates: Updates,
    /// What a pivot has left undone, ascending.
    undone: Vec<usize>,
}

/// Fills the numbers of the supernodes of a path anew: ascending, with each of them all above it. What
/// others pass up to them is taken from what is kept, or is found anew as well, and kept from now on.
///
/// # Errors
/// [`NotPositive`]: what is left of the path is done by the next call.
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

/// A path by distance from the root, the farthest first: these do not need each other.
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
            undone: Vec::new(),
        }
    }

    /// A path with those supernodes off it of which nothing is kept, but of some below them; and the roots of the
    /// subtrees of which nothing is. Both ascending.
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

impl<F: Front> Numeric<'_, F> {
    /// Fills the numbers of a path, ascending, those far from the root first; what others pass up is kept.
    ///
    /// # Errors
    /// [`NotPositive`]: what is left is noted as undone.
    fn along(
        &self,
        path: &[usize],
        values: &mut [f64],
        kept: &mut Kept,
    ) -> Result<(), NotPositive> {
        path.iter().for_each(|s| drop(kept.updates.remove(s)));
        let mut blocks = blocks(self.front, values, path);
        // Of the path itself, until their parents have taken them.
        let mut fresh = Updates::new();
        let mut undone: BTreeSet<usize> = path.iter().copied().collect();
        let mut failed: Option<(usize, NotPositive)> = None;
        for level in levels(self.structure, path) {
            // What is eliminated before a pivot that failed is done all the same: the first one is told.
            let is_before = |s: &usize| failed.is_none_or(|(failed, _)| *s < failed);
            let level: Vec<(usize, &mut [f64])> = (level.into_iter().filter(is_before))
                .map(|s| (s, blocks.remove(&s).expect("done once")))
                .collect();
            let done: Vec<_> = (level.into_par_iter())
                .map(|(s, own)| (s, self.again(s, own, &fresh, &kept.updates)))
                .collect();
            for (s, update) in done {
                match update {
                    Ok(update) => {
                        let children = self.structure.children_from_last(s);
                        let taken = children.filter_map(|child| fresh.remove(&child));
                        taken.for_each(|update| self.pool.give(update));
                        fresh.insert(s, update);
                        undone.remove(&s);
                    }
                    Err(pivot) => failed = Some(failed.map_or((s, pivot), |f| f.min((s, pivot)))),
                }
            }
        }
        let Some((_, pivot)) = failed else {
            fresh
                .into_values()
                .for_each(|update| self.pool.give(update));
            return Ok(());
        };
        for (s, update) in fresh {
            kept.updates.insert(s, self.stored(s, &update));
        }
        kept.undone = undone.into_iter().collect();
        Err(pivot)
    }

    /// A supernode of a path once more, from what its children pass up: those of the path, and what is kept.
    fn again(
        &self,
        s: usize,
        own: &mut [f64],
        fresh: &Updates,
        kept: &Updates,
    ) -> Result<Vec<f64>, NotPositive> {
        let count = self.structure.rows(s).len().pow(2);
        let mut update = self.pool.take(count);
        let children = self.structure.children(s);
        let child = |&child: &usize| match fresh.get(&child) {
            Some(update) => self.child(child, s, update, false),
            None => self.child(child, s, &kept[&child], F::LOWER),
        };
        let updates: Vec<Child> = children.iter().map(child).collect();
        let mut memory = MemBuffer::new(self.front.scratch(self.structure.width(s)));
        let memory = MemStack::new(&mut memory);
        (self.front).eliminate(s, own, &updates, &mut update[..count], memory)?;
        Ok(update)
    }
}
