//! The law of a bond between two materials: it changes as soon as one of the two laws would let it.

use super::{BondLaw, StretchLimits};
use std::sync::Arc;

#[derive(Clone, Debug)]
pub struct Weaker {
    laws: [Arc<dyn BondLaw>; 2],
}

impl Weaker {
    pub fn of(first: Arc<dyn BondLaw>, second: Arc<dyn BondLaw>) -> Weaker {
        Weaker {
            laws: [first, second],
        }
    }
}

impl BondLaw for Weaker {
    fn limits(&self, integrity: f64) -> StretchLimits {
        let [a, b] = &self.laws;
        a.limits(integrity).and(b.limits(integrity))
    }

    /// The integrity by the law whose limit the stretch has reached, or passed by more.
    fn next(&self, integrity: f64, s: f64) -> f64 {
        let [a, b] = &self.laws;
        let [of_a, of_b] = [a, b].map(|law| law.limits(integrity).utilisation(s));
        let law = if of_a >= of_b { a } else { b };
        law.next(integrity, s)
    }

    fn of_part(&self, t: f64) -> Arc<dyn BondLaw> {
        let [a, b] = &self.laws;
        Arc::new(Weaker::of(a.of_part(t), b.of_part(t)))
    }
}
