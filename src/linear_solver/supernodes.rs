//! The structure of L: supernodes, that is sets of columns with the same rows below them, in a tree.
//!
//! A supernode of w columns with r rows below is stored as one dense block of w + r rows.

use super::elimination_tree::NONE;
use super::extend_add::update_entries;
use std::collections::BTreeSet;
use std::ops::Range;

#[derive(Debug)]
pub struct Supernodes {
    /// First column of each supernode; at the end the number of columns.
    pub(super) first_column: Vec<u32>,
    /// The parent of each supernode, or none.
    pub(super) parent: Vec<u32>,
    /// First supernode of each one's subtree; the subtree is in one piece and ends with its root.
    pub(super) first_descendant: Vec<u32>,
    /// Rows below each supernode, ascending.
    pub(super) row_start: Vec<usize>,
    pub(super) rows: Vec<u32>,
    /// The places of these rows among the parent's columns and rows.
    pub(super) place: Vec<u32>,
    /// The first entry of each supernode's block among those of L.
    pub(super) block_start: Vec<usize>,
    /// Multiplications and additions of each subtree.
    pub(super) flops: Vec<f64>,
}

impl Supernodes {
    /// The number of supernodes.
    pub fn len(&self) -> usize {
        self.parent.len()
    }

    /// The number of unknowns.
    pub fn dofs(&self) -> usize {
        self.first_column[self.len()] as usize
    }

    /// The columns of L of a supernode.
    pub fn columns(&self, s: usize) -> Range<usize> {
        self.first_column[s] as usize..self.first_column[s + 1] as usize
    }

    pub fn width(&self, s: usize) -> usize {
        self.columns(s).len()
    }

    /// Rows of L below a supernode's own, ascending.
    pub fn rows(&self, s: usize) -> &[u32] {
        &self.rows[self.row_start[s]..self.row_start[s + 1]]
    }

    /// The range of a supernode's rows in all supernodes' rows, one after the other.
    pub fn row_range(&self, s: usize) -> Range<usize> {
        self.row_start[s]..self.row_start[s + 1]
    }

    /// The places of [`Supernodes::rows`] among the parent's columns and rows.
    pub fn places(&self, s: usize) -> &[u32] {
        &self.place[self.row_start[s]..self.row_start[s + 1]]
    }

    /// The first entry of a supernode's block among those of L; at the number of supernodes, the count of all.
    pub fn block_start(&self, s: usize) -> usize {
        self.block_start[s]
    }

    /// The range of a supernode's block, column by column, among the entries of L.
    pub fn block(&self, s: usize) -> Range<usize> {
        self.block_start[s]..self.block_start[s + 1]
    }

    /// Stored entries of L; blocks count whole.
    pub fn entries(&self) -> usize {
        self.block_start[self.len()]
    }

    pub fn parent(&self, s: usize) -> Option<usize> {
        (self.parent[s] != NONE).then(|| self.parent[s] as usize)
    }

    /// A supernode and all below it.
    pub fn subtree(&self, s: usize) -> Range<usize> {
        self.first_descendant[s] as usize..s + 1
    }

    /// Children of a supernode, the last first.
    pub fn children_from_last(&self, s: usize) -> impl Iterator<Item = usize> + '_ {
        let begin = self.subtree(s).start;
        let last = move |end: usize| (end > begin).then(|| end - 1);
        std::iter::successors(last(s), move |&c| last(self.subtree(c).start))
    }

    /// Children of a supernode, ascending.
    pub fn children(&self, s: usize) -> Vec<usize> {
        let mut children: Vec<usize> = self.children_from_last(s).collect();
        children.reverse();
        children
    }

    pub fn roots(&self) -> Vec<usize> {
        (0..self.len())
            .filter(|&s| self.parent[s] == NONE)
            .collect()
    }

    /// The most entries of updates that wait for their parents at a time, one subtree after the other.
    pub fn waiting_entries(&self) -> usize {
        let update = |s: usize| update_entries(self.rows(s).len());
        let (mut waiting, mut most) = (0, 0);
        for s in 0..self.len() {
            waiting += update(s);
            most = most.max(waiting);
            waiting -= self.children_from_last(s).map(update).sum::<usize>();
        }
        most
    }

    /// Multiplications and additions to factorise a subtree.
    pub fn subtree_flops(&self, s: usize) -> f64 {
        self.flops[s]
    }

    /// Multiplications and additions of a factorisation: w³/3 + w²r + wr² for each supernode of w columns with r rows below.
    pub fn total_flops(&self) -> f64 {
        self.roots().into_iter().map(|root| self.flops[root]).sum()
    }

    /// Multiplications and additions to eliminate a single supernode.
    pub fn flops(&self, s: usize) -> f64 {
        flops(self.width(s) as f64, self.rows(s).len() as f64)
    }

    /// The supernode of a column.
    pub fn supernode_of(&self, column: usize) -> usize {
        self.first_column.partition_point(|&c| c as usize <= column) - 1
    }

    /// The supernodes of some columns and those above them, ascending.
    pub fn above_columns(&self, columns: impl Iterator<Item = usize>) -> Vec<usize> {
        let mut found = BTreeSet::new();
        for column in columns {
            let mut next = Some(self.supernode_of(column));
            while let Some(s) = next.filter(|&s| found.insert(s)) {
                next = self.parent(s);
            }
        }
        found.into_iter().collect()
    }

    /// Finds where the rows of each supernode are in its parent.
    pub(super) fn find_places(&mut self) {
        let mut place = vec![0; self.rows.len()];
        for s in 0..self.len() {
            let Some(parent) = self.parent(s) else {
                continue;
            };
            let columns = self.columns(parent);
            let mut above = self.rows(parent).iter().zip(columns.len() as u32..);
            for (place, &row) in place[self.row_range(s)].iter_mut().zip(self.rows(s)) {
                *place = if (row as usize) < columns.end {
                    row - columns.start as u32
                } else {
                    let found = above.find(|&(&r, _)| r == row);
                    found.expect("rows of a child are the parent's").1
                };
            }
        }
        self.place = place;
    }
}

/// w³/3 + w² r + w r².
pub fn flops(w: f64, r: f64) -> f64 {
    w * (w * w / 3.0 + w * r + r * r)
}
