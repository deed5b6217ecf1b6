//! Lists of numbers, one behind the other.

use rayon::prelude::*;

/// Compressed lists: what belongs to item i is `entries[start[i]..start[i + 1]]`.
#[derive(Clone, Debug, Default)]
pub struct Lists {
    start: Vec<usize>,
    entries: Vec<u32>,
}

impl Lists {
    /// Counting sort of (item, entry) pairs; entries keep their order.
    pub fn collect<I: Iterator<Item = (u32, u32)>>(items: usize, pairs: impl Fn() -> I) -> Lists {
        let mut start = vec![0; items + 1];
        pairs().for_each(|(item, _)| start[item as usize + 1] += 1);
        for i in 0..items {
            start[i + 1] += start[i];
        }
        let mut next = start.clone();
        let mut entries = vec![0; start[items]];
        for (item, entry) in pairs() {
            entries[next[item as usize]] = entry;
            next[item as usize] += 1;
        }
        Lists { start, entries }
    }

    /// The list of each item in turn, from `list`, which fills an empty one; on all threads.
    pub fn gather(items: usize, list: impl Fn(usize, &mut Vec<u32>) + Sync) -> Lists {
        const BLOCK: usize = 1 << 12;
        let of_block = |block: usize| {
            let (mut lengths, mut entries, mut own) = (Vec::new(), Vec::new(), Vec::new());
            for item in block * BLOCK..items.min((block + 1) * BLOCK) {
                own.clear();
                list(item, &mut own);
                lengths.push(own.len());
                entries.extend_from_slice(&own);
            }
            (lengths, entries)
        };
        let blocks = (0..items.div_ceil(BLOCK)).into_par_iter();
        let blocks: Vec<(Vec<usize>, Vec<u32>)> = blocks.map(of_block).collect();
        let total = blocks.iter().map(|(_, entries)| entries.len()).sum();
        let mut all = Lists {
            start: Vec::with_capacity(items + 1),
            entries: Vec::with_capacity(total),
        };
        all.start.push(0);
        let mut next = 0;
        for (lengths, entries) in blocks {
            all.start.extend(lengths.into_iter().map(|length| {
                next += length;
                next
            }));
            all.entries.extend(entries);
        }
        all
    }

    /// Sorts each list and drops repetitions.
    pub fn into_sets(mut self) -> Lists {
        let mut kept = 0;
        for i in 0..self.len() {
            let range = self.start[i]..self.start[i + 1];
            self.entries[range.clone()].sort_unstable();
            let begin = kept;
            for k in range {
                let entry = self.entries[k];
                if kept == begin || self.entries[kept - 1] != entry {
                    self.entries[kept] = entry;
                    kept += 1;
                }
            }
            self.start[i] = begin;
        }
        let last = self.len();
        self.start[last] = kept;
        self.entries.truncate(kept);
        self
    }

    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub fn of(&self, item: usize) -> &[u32] {
        &self.entries[self.start[item]..self.start[item + 1]]
    }

    /// Offsets and entries, as METIS and other graph libraries want them.
    pub fn parts(&self) -> (&[usize], &[u32]) {
        (&self.start, &self.entries)
    }
}
