//! The columns of each supernode: columns whose patterns nest, and children merged into their parents, zeros and
//! all, where the blocks that result cost less time than before.

use super::elimination_tree::{self, NONE};
use super::node_blocks::inverse;
use super::rates::{ADDED_ENTRY, BLOCK_RATE, HALF_RATE_WIDTH, STREAMED_ENTRY, SUPERNODE};
use super::supernodes::{Supernodes, flops};
use crate::assembly::Lists;
use std::ops::Range;

/// The supernodes of nodes with `B` unknowns each, and the nodes in the order in which these eliminate them.
///
/// `order`: postordered; `below`: by position in it, the neighbours that are eliminated later.
pub fn supernodes<const B: usize>(order: &[u32], below: &Lists) -> (Supernodes, Vec<u32>) {
    let parent = elimination_tree::parents(below);
    let counts = elimination_tree::column_counts(below, &parent);
    let tree = Tree::fundamental(&parent, &counts).amalgamated::<B>();
    tree.supernodes::<B>(order, below)
}

/// Seconds that a supernode of so many nodes is expected to take.
fn cost<const B: usize>(width: u32, below: u32) -> f64 {
    let (w, r) = (B as f64 * f64::from(width), B as f64 * f64::from(below));
    flops(w, r) / BLOCK_RATE * (1.0 + HALF_RATE_WIDTH / w)
        + ADDED_ENTRY * r * r / 2.0
        + STREAMED_ENTRY * w * (w / 2.0 + r)
        + SUPERNODE
}

/// Supernodes while they are merged.
struct Tree {
    parent: Vec<u32>,
    /// The columns, in nodes, as ranges of positions.
    columns: Vec<Vec<Range<u32>>>,
    width: Vec<u32>,
    below: Vec<u32>,
}

impl Tree {
    /// Fundamental supernodes: runs of columns whose patterns nest.
    fn fundamental(parent: &[u32], counts: &[u32]) -> Tree {
        let n = parent.len();
        let mut tree = Tree {
            parent: Vec::new(),
            columns: Vec::new(),
            width: Vec::new(),
            below: Vec::new(),
        };
        let mut supernode_of = vec![0; n];
        let mut begin = 0;
        for j in 0..n {
            supernode_of[j] = tree.width.len() as u32;
            let last = j + 1 == n || parent[j] as usize != j + 1 || counts[j] != counts[j + 1] + 1;
            if last {
                let columns = begin as u32..j as u32 + 1;
                tree.columns.push(std::iter::once(columns).collect());
                tree.width.push((j + 1 - begin) as u32);
                tree.below.push(counts[j] - 1);
                // The parent column, for now.
                tree.parent.push(parent[j]);
                begin = j + 1;
            }
        }
        for parent in &mut tree.parent {
            if *parent != NONE {
                *parent = supernode_of[*parent as usize];
            }
        }
        tree
    }

    fn children(&self) -> Vec<Vec<u32>> {
        let mut children = vec![Vec::new(); self.parent.len()];
        for (s, &parent) in self.parent.iter().enumerate() {
            if parent != NONE {
                children[parent as usize].push(s as u32);
            }
        }
        children
    }

    /// Merges children into parents while that saves time; those with the most rows first, for they
    /// bring the fewest zeros.
    fn amalgamated<const B: usize>(mut self) -> Tree {
        let n = self.parent.len();
        let mut children = self.children();
        let mut gone = vec![false; n];
        for p in 0..n {
            let mut candidates = std::mem::take(&mut children[p]);
            candidates.sort_by_key(|&c| std::cmp::Reverse(self.below[c as usize]));
            let mut kept = Vec::with_capacity(candidates.len());
            for c in candidates {
                let child = c as usize;
                let apart = cost::<B>(self.width[child], self.below[child])
                    + cost::<B>(self.width[p], self.below[p]);
                let width = self.width[child] + self.width[p];
                if cost::<B>(width, self.below[p]) > apart {
                    kept.push(c);
                    continue;
                }
                gone[child] = true;
                self.width[p] = width;
                let columns = std::mem::take(&mut self.columns[child]);
                self.columns[p].extend(columns);
                kept.append(&mut children[child]);
            }
            children[p] = kept;
        }
        for (p, children) in children.iter().enumerate() {
            for &child in children {
                self.parent[child as usize] = p as u32;
            }
        }
        self.without(&gone)
    }

    /// Renumbered, postordered.
    fn without(mut self, gone: &[bool]) -> Tree {
        let kept: Vec<u32> = (0..gone.len() as u32)
            .filter(|&s| !gone[s as usize])
            .collect();
        let mut number = vec![NONE; gone.len()];
        kept.iter()
            .zip(0..)
            .for_each(|(&s, k)| number[s as usize] = k);
        let up = |s: u32| match self.parent[s as usize] {
            NONE => NONE,
            parent => number[parent as usize],
        };
        let parent: Vec<u32> = kept.iter().map(|&s| up(s)).collect();
        let post = elimination_tree::postorder(&parent);
        let place = inverse(&post);
        let up = |k: u32| match parent[k as usize] {
            NONE => NONE,
            parent => place[parent as usize],
        };
        let old = |&k: &u32| kept[k as usize] as usize;
        Tree {
            parent: post.iter().map(|&k| up(k)).collect(),
            width: post.iter().map(|k| self.width[old(k)]).collect(),
            below: post.iter().map(|k| self.below[old(k)]).collect(),
            columns: post
                .iter()
                .map(|k| std::mem::take(&mut self.columns[old(k)]))
                .collect(),
        }
    }

    fn supernodes<const B: usize>(
        mut self,
        order: &[u32],
        below: &Lists,
    ) -> (Supernodes, Vec<u32>) {
        let count = self.parent.len();
        let mut final_order = Vec::with_capacity(order.len());
        let mut old_position = Vec::with_capacity(order.len());
        let mut first_column = vec![0];
        for columns in &mut self.columns {
            columns.sort_unstable_by_key(|range| range.start);
            for k in columns.iter().cloned().flatten() {
                old_position.push(k);
                final_order.push(order[k as usize]);
            }
            first_column.push((B * final_order.len()) as u32);
        }
        let new_position = inverse(&old_position);
        let mut first_descendant: Vec<u32> = (0..count as u32).collect();
        let mut work: Vec<f64> = Vec::with_capacity(count);
        let mut below_work = vec![0.0; count];
        let (mut row_start, mut rows) = (vec![0], Vec::new());
        let mut block_start = vec![0];
        let mut seen = vec![NONE; order.len()];
        let children = self.children();
        for s in 0..count {
            let own = first_column[s] / B as u32..first_column[s + 1] / B as u32;
            let begin = rows.len();
            let mut found = Vec::new();
            let mut add = |row: u32| {
                if row >= own.end && seen[row as usize] != s as u32 {
                    seen[row as usize] = s as u32;
                    found.push(row);
                }
            };
            for column in own.clone() {
                let old = old_position[column as usize] as usize;
                below
                    .of(old)
                    .iter()
                    .for_each(|&k| add(new_position[k as usize]));
            }
            for &child in &children[s] {
                let range = row_start[child as usize]..row_start[child as usize + 1];
                rows[range]
                    .iter()
                    .step_by(B)
                    .for_each(|&row: &u32| add(row / B as u32));
            }
            found.sort_unstable();
            debug_assert_eq!(found.len(), self.below[s] as usize);
            let unknowns = |&row: &u32| B as u32 * row..B as u32 * (row + 1);
            rows.extend(found.iter().flat_map(unknowns));
            row_start.push(rows.len());
            let (w, r) = (B * own.len(), rows.len() - begin);
            block_start.push(block_start[s] + w * (w + r));
            work.push(below_work[s] + flops(w as f64, r as f64));
            if self.parent[s] != NONE {
                let parent = self.parent[s] as usize;
                below_work[parent] += work[s];
                first_descendant[parent] = first_descendant[parent].min(first_descendant[s]);
            }
        }
        let mut supernodes = Supernodes {
            first_column,
            parent: self.parent,
            first_descendant,
            row_start,
            rows,
            place: Vec::new(),
            block_start,
            flops: work,
        };
        supernodes.find_places();
        (supernodes, final_order)
    }
}
