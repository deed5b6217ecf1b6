//! Memory for the updates that supernodes pass up.

use super::supernodes::Supernodes;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// Memory of updates that are no longer needed, for others: fresh pages cost as much as the sums in them.
#[derive(Debug, Default)]
pub struct Pool(Mutex<Vec<Vec<f64>>>);

impl Pool {
    /// Memory for so many numbers, with any numbers in it.
    pub fn take(&self, length: usize) -> Vec<f64> {
        let mut free = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let fitting = free.iter().position(|vector| vector.capacity() >= length);
        let found = fitting.map(|k| free.remove(k));
        drop(free);
        let mut vector = found.unwrap_or_default();
        if vector.capacity() < length {
            return vec![0.0; length];
        }
        vector.resize(length, 0.0);
        vector
    }

    /// Gives all memory back to the system.
    pub fn clear(&self) {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clear();
    }

    /// Takes memory that is no longer needed.
    pub fn give(&self, vector: Vec<f64>) {
        let mut free = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let at = free.partition_point(|other| other.capacity() < vector.capacity());
        free.insert(at, vector);
    }
}

/// Room for the updates of a subtree.
pub struct Stacks {
    /// Levels below the root, by supernode.
    pub level: Vec<usize>,
    /// The most numbers that wait on even and on odd levels.
    pub size: [usize; 2],
}

impl Stacks {
    /// `passed`: how many numbers a supernode passes up.
    pub fn new(
        structure: &Supernodes,
        subtree: Range<usize>,
        passed: impl Fn(usize) -> usize,
    ) -> Stacks {
        let first = subtree.start;
        let mut level = vec![0; subtree.len()];
        for s in subtree.clone().rev().skip(1) {
            let parent = structure.parent(s).expect("only the root has none");
            level[s - first] = level[parent - first] + 1;
        }
        let (mut top, mut size) = ([0, 0], [0, 0]);
        for s in subtree {
            let own = level[s - first] % 2;
            top[own] += passed(s);
            size[own] = size[own].max(top[own]);
            for child in structure.children_from_last(s) {
                top[1 - own] -= passed(child);
            }
        }
        Stacks { level, size }
    }
}
