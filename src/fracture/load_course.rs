//! Fall and recovery of the load, by which a run ends whose cracks are stopped (`unbreakable.rs`).

use super::policy::RECOVERED;
use serde::{Deserialize, Serialize};

/// Fall and recovery of the load in the first phase of a run: the force along the prescribed displacements, or λ
/// where there are none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct LoadCourse {
    peak: f64,
    /// The least since the peak.
    low: f64,
    has_recovered: bool,
}

impl LoadCourse {
    /// Whether the load had fallen below half of its peak, and is above that again and twice its least since.
    pub(super) fn has_recovered(&self) -> bool {
        self.has_recovered
    }

    pub(super) fn follow(&mut self, load: f64) {
        let has_fallen = self.low < RECOVERED * self.peak;
        self.has_recovered =
            has_fallen && load > RECOVERED * self.peak && self.low < RECOVERED * load;
        if load > self.peak {
            *self = LoadCourse {
                peak: load,
                low: load,
                ..*self
            };
        }
        self.low = self.low.min(load);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_recovers_after_a_fall_and_not_by_a_tooth() {
        let recovers_at = |loads: &[f64]| {
            let mut course = LoadCourse::default();
            loads.iter().position(|&load| {
                course.follow(load);
                course.has_recovered
            })
        };
        assert_eq!(recovers_at(&[1.0, 2.0, 3.0, 4.0]), None);
        assert_eq!(recovers_at(&[1.0, 4.0, 9.0]), None);
        // Teeth around half of the peak, and far below it.
        assert_eq!(recovers_at(&[4.0, 1.9, 2.1, 1.9, 2.1, 3.0]), None);
        assert_eq!(recovers_at(&[4.0, 0.3, 0.1, 0.9, 1.9]), None);
        assert_eq!(recovers_at(&[4.0, 0.3, 1.9, 2.1]), Some(3));
        assert_eq!(recovers_at(&[4.0, 0.3, 9.0]), Some(2));
    }
}
