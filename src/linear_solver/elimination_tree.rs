//! The elimination tree of a symmetric pattern and what follows from it without computing L: an order
//! that keeps every subtree in one piece, and how many entries each column of L has.
//!
//! Parent of column j: the row of the first entry of L below the diagonal (Liu 1990). Counts: an entry
//! is counted at the leaves of each row's subtree and taken back where two leaves meet (Gilbert, Ng &
//! Peyton 1994, as in Davis 2006), in a time almost linear in the entries of K.

use crate::assembly::Lists;

/// Parent of a root.
pub const NONE: u32 = u32::MAX;

/// Parent of each column, given by column the rows of K below the diagonal.
pub fn parents(below: &Lists) -> Vec<u32> {
    let n = below.len();
    let before = Lists::collect(n, || {
        (0..n as u32).flat_map(|column| {
            below
                .of(column as usize)
                .iter()
                .map(move |&row| (row, column))
        })
    });
    let mut parent = vec![NONE; n];
    let mut ancestor = vec![NONE; n];
    for row in 0..n as u32 {
        for &column in before.of(row as usize) {
            let mut next = column;
            while next < row {
                let above = std::mem::replace(&mut ancestor[next as usize], row);
                if above == NONE {
                    parent[next as usize] = row;
                    break;
                }
                next = above;
            }
        }
    }
    parent
}

/// Children before parents and each subtree in one piece; the children of one parent keep their order.
pub fn postorder(parent: &[u32]) -> Vec<u32> {
    let n = parent.len();
    let mut first_child = vec![NONE; n + 1];
    let mut next_sibling = vec![NONE; n];
    for k in (0..n).rev() {
        let up = (parent[k] as usize).min(n);
        next_sibling[k] = first_child[up];
        first_child[up] = k as u32;
    }
    let mut result = Vec::with_capacity(n);
    let mut path = vec![n];
    while let Some(&k) = path.last() {
        let child = first_child[k];
        if child == NONE {
            path.pop();
            if k < n {
                result.push(k as u32);
            }
        } else {
            first_child[k] = next_sibling[child as usize];
            path.push(child as usize);
        }
    }
    result
}

/// Entries of each column of L, the diagonal's included; columns must be postordered.
pub fn column_counts(below: &Lists, parent: &[u32]) -> Vec<u32> {
    let n = parent.len();
    let mut first = vec![NONE; n];
    let mut counts = vec![0_i64; n];
    for k in 0..n {
        counts[k] = i64::from(first[k] == NONE);
        let mut j = k as u32;
        while j != NONE && first[j as usize] == NONE {
            first[j as usize] = k as u32;
            j = parent[j as usize];
        }
    }
    let mut leaves = Leaves::new(n);
    for j in 0..n {
        if parent[j] != NONE {
            counts[parent[j] as usize] -= 1;
        }
        for &row in below.of(j) {
            if let Some(meeting) = leaves.add(row, j as u32, first[j]) {
                counts[j] += 1;
                if let Some(meeting) = meeting {
                    counts[meeting as usize] -= 1;
                }
            }
        }
        if parent[j] != NONE {
            leaves.ancestor[j] = parent[j];
        }
    }
    for j in 0..n {
        if parent[j] != NONE {
            counts[parent[j] as usize] += counts[j];
        }
    }
    counts.into_iter().map(|count| count as u32).collect()
}

/// Leaves of the subtrees of L's rows, found column by column.
struct Leaves {
    /// 1 + the largest first descendant so far, by row.
    reached: Vec<u32>,
    last: Vec<u32>,
    ancestor: Vec<u32>,
}

impl Leaves {
    fn new(n: usize) -> Leaves {
        Leaves {
            reached: vec![0; n],
            last: vec![NONE; n],
            ancestor: (0..n as u32).collect(),
        }
    }

    /// Whether `column` is a new leaf of the row's subtree, and where its path meets that of the one before.
    fn add(&mut self, row: u32, column: u32, first: u32) -> Option<Option<u32>> {
        let row = row as usize;
        if first < self.reached[row] {
            return None;
        }
        self.reached[row] = first + 1;
        let before = std::mem::replace(&mut self.last[row], column);
        if before == NONE {
            return Some(None);
        }
        let mut meeting = before;
        while meeting != self.ancestor[meeting as usize] {
            meeting = self.ancestor[meeting as usize];
        }
        let mut next = before;
        while next != meeting {
            next = std::mem::replace(&mut self.ancestor[next as usize], meeting);
        }
        Some(Some(meeting))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The path 0 – 1 – 2 – 3 – 4, eliminated 0, 4, 2, 1, 3: the tree is 0 → 1, 2 → 1, 4 → 3, 1 → 3.
    #[test]
    fn the_tree_of_a_path_is_postordered() {
        // By position: 0 is node 0, 1 is node 4, 2 is node 2, 3 is node 1, 4 is node 3.
        let links = [(0, 3), (1, 4), (2, 3), (2, 4)];
        let below = Lists::collect(5, || links.into_iter());
        let parent = parents(&below);
        assert_eq!(parent, [3, 4, 3, 4, NONE]);
        assert_eq!(postorder(&parent), [1, 0, 2, 3, 4]);
    }

    /// Counts against L's pattern, eliminated entry by entry.
    #[test]
    fn counts_are_those_of_elimination() {
        let side = 7_u32;
        let n = (side * side) as usize;
        let links = || {
            (0..n as u32).flat_map(move |k| {
                let steps = [1, side, side + 1, side - 1, 2, 2 * side];
                let inside = move |&step: &u32| {
                    let (a, b) = (k % side, (k + step) % side);
                    k + step < side * side && a.abs_diff(b) <= 2
                };
                steps
                    .into_iter()
                    .filter(inside)
                    .map(move |step| (k, k + step))
            })
        };
        let order = |k: u32| (k * 20) % n as u32;
        let pair = |(a, b)| (order(a).min(order(b)), order(a).max(order(b)));
        let below = Lists::collect(n, || links().map(pair));
        let post = postorder(&parents(&below));
        let mut place = vec![0; n];
        for (new, &old) in post.iter().enumerate() {
            place[old as usize] = new as u32;
        }
        let again = |(a, b): (u32, u32)| {
            let (a, b) = (place[a as usize], place[b as usize]);
            (a.min(b), a.max(b))
        };
        let below = Lists::collect(n, || links().map(pair).map(again));
        let counts = column_counts(&below, &parents(&below));
        let mut columns: Vec<std::collections::BTreeSet<u32>> = (0..n)
            .map(|j| below.of(j).iter().copied().collect())
            .collect();
        for j in 0..n {
            let rows = columns[j].clone();
            if let Some(&parent) = rows.first() {
                columns[parent as usize].extend(rows.iter().skip(1));
            }
            assert_eq!(counts[j] as usize, rows.len() + 1, "column {j}");
        }
    }
}
