//! The structure of L: supernodes, that is sets of columns with the same rows below them, in a tree.
//!
//! A supernode of w columns with r rows below is stored as one dense block of w + r rows. Small ones are
//! merged into their parents, zeros and all, where the blocks that result cost less time than before.
//!
//! Every node of the graph has two dofs, which stay together: the analysis looks at nodes, four times
//! fewer entries than K has.

use super::elimination_tree::{self, NONE};
use super::extend_add::update_entries;
use crate::assembly::Lists;
use faer::sparse::SymbolicSparseColMatRef;
use std::collections::BTreeSet;
use std::ops::Range;

/// Multiplications and additions per second of a product of large blocks, and the width of blocks that
/// reach half of it. Seconds to add an entry of an update to the parent's, to stream an entry of L through a
/// solution, and to begin with a supernode. Measured on one thread; they decide what is merged, and
/// results change in the last bits with them.
const RATE: f64 = 5e10;
const HALF_WIDTH: f64 = 8.0;
const ENTRY: f64 = 0.6e-9;
const STREAM: f64 = 3e-9;
const BEGIN: f64 = 1e-6;

#[derive(Debug)]
pub struct Supernodes {
    /// The nodes as they are eliminated.
    order: Vec<u32>,
    /// The inverse: where a node is in the order.
    position: Vec<u32>,
    /// First column (dof in elimination order) of each supernode, and of none.
    first_column: Vec<u32>,
    parent: Vec<u32>,
    /// First supernode of each one's subtree; the subtree is in one piece and ends with its root.
    first_descendant: Vec<u32>,
    /// Rows below each supernode, ascending.
    row_start: Vec<usize>,
    rows: Vec<u32>,
    /// Where these rows are among the parent's columns and rows.
    place: Vec<u32>,
    /// Where each supernode's block begins among the entries of L.
    block_start: Vec<usize>,
    /// Multiplications and additions of each subtree.
    flops: Vec<f64>,
    source_start: Vec<usize>,
    sources: Vec<Source>,
}

/// Two columns and two rows of K, in the lower triangle of K as reordered.
#[derive(Clone, Copy, Debug, Default)]
pub struct Source {
    /// Row of the supernode's block.
    pub row: u32,
    /// Where K's two columns are among its entries, two rows each; of a node with itself, the lower triangle.
    pub columns: [u32; 2],
    /// K's columns are the block's rows.
    pub transposed: bool,
}

impl Supernodes {
    /// `pattern`: lower triangle of K, two dofs to a node, columns sorted. `order`: the nodes as they are to
    /// be eliminated; subtrees may be reordered.
    pub fn new(pattern: SymbolicSparseColMatRef<'_, u32>, order: &[u32]) -> Supernodes {
        let order = postordered(pattern, order);
        let below = below(pattern, &inverse(&order));
        let parent = elimination_tree::parents(&below);
        let counts = elimination_tree::column_counts(&below, &parent);
        let tree = Tree::fundamental(&parent, &counts).amalgamated();
        let mut supernodes = tree.supernodes(&order, &below);
        supernodes.find_places();
        supernodes.find_sources(pattern);
        supernodes
    }

    pub fn n_supernodes(&self) -> usize {
        self.parent.len()
    }

    pub fn dofs(&self) -> usize {
        2 * self.order.len()
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

    /// Where the rows of a supernode are in all supernodes' rows, one after the other.
    pub fn row_range(&self, s: usize) -> Range<usize> {
        self.row_start[s]..self.row_start[s + 1]
    }

    /// Where [`Supernodes::rows`] are among the parent's columns and rows.
    pub fn places(&self, s: usize) -> &[u32] {
        &self.place[self.row_start[s]..self.row_start[s + 1]]
    }

    /// Where a supernode's block begins; of the number of supernodes, where the last one ends.
    pub fn block_start(&self, s: usize) -> usize {
        self.block_start[s]
    }

    /// The first column of a supernode; of the number of supernodes, how many columns there are.
    pub fn first_column(&self, s: usize) -> usize {
        self.first_column[s] as usize
    }

    /// Where a supernode's block, column by column, is among the entries of L.
    pub fn block(&self, s: usize) -> Range<usize> {
        self.block_start[s]..self.block_start[s + 1]
    }

    /// Stored entries of L; blocks count whole.
    pub fn entries(&self) -> usize {
        self.block_start[self.n_supernodes()]
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

    /// Ascending.
    pub fn children(&self, s: usize) -> Vec<usize> {
        let mut children: Vec<usize> = self.children_from_last(s).collect();
        children.reverse();
        children
    }

    pub fn roots(&self) -> Vec<usize> {
        (0..self.n_supernodes())
            .filter(|&s| self.parent[s] == NONE)
            .collect()
    }

    /// The most entries of updates that wait for their parents at a time, one subtree after the other.
    pub fn waiting_entries(&self) -> usize {
        let update = |s: usize| update_entries(self.rows(s).len());
        let (mut waiting, mut most) = (0, 0);
        for s in 0..self.n_supernodes() {
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

    /// Of all subtrees, by Cholesky: w³/3 + w²r + wr² for each supernode of w columns with r rows below.
    pub fn total_flops(&self) -> f64 {
        self.roots().into_iter().map(|root| self.flops[root]).sum()
    }

    /// Of a single supernode.
    pub fn flops(&self, s: usize) -> f64 {
        flops(self.width(s) as f64, self.rows(s).len() as f64)
    }

    /// The supernode of a column.
    pub fn supernode_of(&self, column: usize) -> usize {
        self.first_column.partition_point(|&c| c as usize <= column) - 1
    }

    /// The supernodes of some nodes and those above them, ascending.
    pub fn above(&self, nodes: &[u32]) -> Vec<usize> {
        let column = |&node: &u32| 2 * self.position[node as usize] as usize;
        self.above_columns(nodes.iter().map(column))
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

    /// The dof that a column eliminates.
    pub fn dof(&self, column: usize) -> usize {
        2 * self.order[column / 2] as usize + column % 2
    }

    /// The column that eliminates a dof.
    pub fn column(&self, dof: usize) -> usize {
        2 * self.position[dof / 2] as usize + dof % 2
    }

    /// What of K stands in the columns of a node, named by its first column.
    pub fn sources(&self, column: usize) -> &[Source] {
        &self.sources[self.source_start[column / 2]..self.source_start[column / 2 + 1]]
    }

    fn find_places(&mut self) {
        let mut place = vec![0; self.rows.len()];
        for s in 0..self.n_supernodes() {
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

    fn find_sources(&mut self, pattern: SymbolicSparseColMatRef<'_, u32>) {
        let n = self.order.len();
        let mut start = vec![0; n + 1];
        for_each_block(pattern, |a, b, _| {
            start[self.position[a].min(self.position[b]) as usize + 1] += 1;
        });
        for k in 0..n {
            start[k + 1] += start[k];
        }
        let mut next = start.clone();
        let mut sources = vec![Source::default(); start[n]];
        for_each_block(pattern, |a, b, columns| {
            let (a, b) = (self.position[a], self.position[b]);
            let owner = a.min(b) as usize;
            sources[next[owner]] = Source {
                row: 2 * a.max(b),
                columns,
                transposed: b < a,
            };
            next[owner] += 1;
        });
        let mut row_of = vec![0; 2 * n];
        for s in 0..self.n_supernodes() {
            let columns = self.columns(s);
            let own = columns
                .clone()
                .chain(self.rows(s).iter().map(|&r| r as usize));
            own.zip(0..).for_each(|(row, k)| row_of[row] = k);
            for source in &mut sources[start[columns.start / 2]..start[columns.end / 2]] {
                source.row = row_of[source.row as usize];
            }
        }
        self.source_start = start;
        self.sources = sources;
    }
}

/// Every two nodes of the lower triangle of K, first the column's, and where the entries of the two
/// columns are.
fn for_each_block(
    pattern: SymbolicSparseColMatRef<'_, u32>,
    mut block: impl FnMut(usize, usize, [u32; 2]),
) {
    for node in 0..pattern.ncols() / 2 {
        let [first, second] = [0, 1].map(|axis| pattern.col_range(2 * node + axis).start as u32);
        block(node, node, [first, second]);
        for (k, row) in upper(pattern, node).enumerate() {
            let k = 2 * k as u32;
            block(node, row as usize, [first + 2 + k, second + 1 + k]);
        }
    }
}

/// Neighbours of a node with a larger number.
fn upper(pattern: SymbolicSparseColMatRef<'_, u32>, node: usize) -> impl Iterator<Item = u32> + '_ {
    let rows = &pattern.row_idx()[pattern.col_range(2 * node)];
    rows[2..].iter().step_by(2).map(|row| row / 2)
}

/// By position in the order: neighbours that come later.
fn below(pattern: SymbolicSparseColMatRef<'_, u32>, position: &[u32]) -> Lists {
    let n = position.len();
    Lists::collect(n, || {
        (0..n).flat_map(|node| {
            let a = position[node];
            upper(pattern, node).map(move |other| {
                let b = position[other as usize];
                (a.min(b), a.max(b))
            })
        })
    })
}

/// The nodes of an elimination order such that every subtree of the elimination tree is in one piece.
pub fn postordered(pattern: SymbolicSparseColMatRef<'_, u32>, order: &[u32]) -> Vec<u32> {
    let parent = elimination_tree::parents(&below(pattern, &inverse(order)));
    let post = elimination_tree::postorder(&parent);
    post.iter().map(|&k| order[k as usize]).collect()
}

fn inverse(order: &[u32]) -> Vec<u32> {
    let mut inverse = vec![0; order.len()];
    for (new, &old) in order.iter().enumerate() {
        inverse[old as usize] = new as u32;
    }
    inverse
}

/// w³/3 + w² r + w r².
pub fn flops(w: f64, r: f64) -> f64 {
    w * (w * w / 3.0 + w * r + r * r)
}

/// Seconds that a supernode of so many nodes is expected to take.
fn cost(width: u32, below: u32) -> f64 {
    let (w, r) = (2.0 * f64::from(width), 2.0 * f64::from(below));
    flops(w, r) / RATE * (1.0 + HALF_WIDTH / w)
        + ENTRY * r * r / 2.0
        + STREAM * w * (w / 2.0 + r)
        + BEGIN
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
    /// Chains of columns of which each has the rows of the next, and the next itself.
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
    fn amalgamated(mut self) -> Tree {
        let n = self.parent.len();
        let mut children = self.children();
        let mut gone = vec![false; n];
        for p in 0..n {
            let mut candidates = std::mem::take(&mut children[p]);
            candidates.sort_by_key(|&c| std::cmp::Reverse(self.below[c as usize]));
            let mut kept = Vec::with_capacity(candidates.len());
            for c in candidates {
                let child = c as usize;
                let apart =
                    cost(self.width[child], self.below[child]) + cost(self.width[p], self.below[p]);
                let width = self.width[child] + self.width[p];
                if cost(width, self.below[p]) > apart {
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

    fn supernodes(mut self, order: &[u32], below: &Lists) -> Supernodes {
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
            first_column.push(2 * final_order.len() as u32);
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
            let own = first_column[s] / 2..first_column[s + 1] / 2;
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
                    .step_by(2)
                    .for_each(|&row: &u32| add(row / 2));
            }
            found.sort_unstable();
            debug_assert_eq!(found.len(), self.below[s] as usize);
            rows.extend(found.iter().flat_map(|&row| [2 * row, 2 * row + 1]));
            row_start.push(rows.len());
            let (w, r) = (2 * own.len(), rows.len() - begin);
            block_start.push(block_start[s] + w * (w + r));
            work.push(below_work[s] + flops(w as f64, r as f64));
            if self.parent[s] != NONE {
                let parent = self.parent[s] as usize;
                below_work[parent] += work[s];
                first_descendant[parent] = first_descendant[parent].min(first_descendant[s]);
            }
        }
        Supernodes {
            position: inverse(&final_order),
            order: final_order,
            first_column,
            parent: self.parent,
            first_descendant,
            row_start,
            rows,
            place: Vec::new(),
            block_start,
            flops: work,
            source_start: Vec::new(),
            sources: Vec::new(),
        }
    }
}
