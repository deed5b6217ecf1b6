//! The integrity φ of all interactions as frames and checkpoints hold it: most are 1, so that only the
//! others are listed.

use serde::{Deserialize, Serialize};

/// Integrity of every interaction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SparseIntegrity {
    count: usize,
    /// Number and integrity of every interaction whose integrity is not 1, ascending.
    reduced: Vec<(u32, f64)>,
}

impl SparseIntegrity {
    pub fn new(integrity: &[f64]) -> SparseIntegrity {
        let numbered = (0u32..).zip(integrity.iter().copied());
        SparseIntegrity {
            count: integrity.len(),
            reduced: numbered.filter(|&(_, phi)| phi != 1.0).collect(),
        }
    }

    /// Integrity φ by number of the interaction [-].
    pub fn to_vec(&self) -> Vec<f64> {
        let mut integrity = vec![1.0; self.count];
        for &(interaction, phi) in &self.reduced {
            integrity[interaction as usize] = phi;
        }
        integrity
    }

    /// Whether it can be the integrity of so many interactions.
    pub fn fits(&self, interactions: usize) -> bool {
        let is_sound = |&(interaction, phi): &(u32, f64)| {
            (interaction as usize) < interactions && (0.0..=1.0).contains(&phi)
        };
        self.count == interactions && self.reduced.iter().all(is_sound)
    }

    /// Bytes that it takes in memory.
    pub(crate) fn raw_bytes(&self) -> u64 {
        size_of_val(self.reduced.as_slice()) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_integrity_comes_back() {
        let integrity = [1.0, 0.0, 1.0, 0.4, 1.0];
        let sparse = SparseIntegrity::new(&integrity);
        let bytes = postcard::to_stdvec(&sparse).expect("plain data");
        let read: SparseIntegrity = postcard::from_bytes(&bytes).expect("the same");
        assert_eq!(read.to_vec(), integrity);
        assert!(read.fits(5) && !read.fits(4));
    }

    #[test]
    fn numbers_that_no_model_has_do_not_fit() {
        for reduced in [vec![(5, 0.0)], vec![(1, 1.5)], vec![(1, f64::NAN)]] {
            assert!(!SparseIntegrity { count: 5, reduced }.fits(5));
        }
    }
}
