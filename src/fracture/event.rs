//! The next bond to break where the stretches are linear in the load,
//!
//! ```text
//! s = μ (s_held + λ s_unit)
//! ```
//!
//! so that every limit of a bond bounds λ from one side.

use super::laws::StretchLimits;
use serde::{Deserialize, Serialize};

/// A point in the space of loads.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct Load {
    /// μ, the share of all loads that acts [-].
    pub share: f64,
    /// λ of the current phase [-].
    pub factor: f64,
}

impl Load {
    /// All that is held acts in full.
    pub fn full(factor: f64) -> Load {
        Load { share: 1.0, factor }
    }

    /// μ (held + λ unit).
    pub fn combine(&self, [held, unit]: [f64; 2]) -> f64 {
        self.share * (held + self.factor * unit)
    }
}

/// Result of the event-driven control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// A bond reaches its limit.
    Break(Load),
    /// The phase ends before that.
    PhaseEnd,
    /// No load breaks another bond.
    None,
}

/// Bounds of the load factor that some bonds allow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// λ must not be below this [-].
    pub lower: f64,
    /// λ must not be above this [-].
    pub upper: f64,
    /// The largest stretch over its limit at the load that acts now [-]; nothing where none is beyond it.
    pub excess: f64,
}

impl Bounds {
    pub const NONE: Bounds = Bounds {
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        excess: 0.0,
    };

    /// Bounds of one bond, with its stretches under the held loads and per unit of λ; λ is `last` now.
    pub fn of([held, unit]: [f64; 2], limit: StretchLimits, last: f64) -> Bounds {
        let now = held + last * unit;
        let excess = match limit.is_exceeded(now) {
            true => limit.utilisation(now),
            false => 0.0,
        };
        if unit == 0.0 {
            return Bounds {
                excess,
                ..Bounds::NONE
            };
        }
        // The limit that the stretch runs towards as λ grows bounds λ from above.
        let (towards, away) = match unit > 0.0 {
            true => (limit.tension, -limit.compression),
            false => (-limit.compression, limit.tension),
        };
        let over = 1.0 / unit;
        Bounds {
            lower: (away - held) * over,
            upper: (towards - held) * over,
            excess,
        }
    }

    pub fn and(self, other: Bounds) -> Bounds {
        Bounds {
            lower: self.lower.max(other.lower),
            upper: self.upper.min(other.upper),
            excess: self.excess.max(other.excess),
        }
    }

    /// Whether a load is well within, all that is held acting in full.
    pub fn allow(&self, load: Load) -> bool {
        let rest = 1e-9 * load.factor.abs();
        load.share == 1.0 && self.lower < load.factor - rest && load.factor + rest < self.upper
    }

    /// The load at which the next bond breaks; `last` is λ now, `end` that of the phase's end. If no λ
    /// can carry what is held, all loads together recede until only one bond is at its limit
    /// (proportional unloading, DeJong et al. 2008).
    pub fn event(&self, last: f64, end: Option<f64>) -> Event {
        if self.lower > self.upper && self.excess > 1.0 {
            Event::Break(Load {
                share: 1.0 / self.excess,
                factor: last,
            })
        } else if end.is_some_and(|end| self.upper >= end) {
            Event::PhaseEnd
        } else if self.upper.is_finite() {
            Event::Break(Load::full(self.upper))
        } else {
            Event::None
        }
    }
}

/// Whether a bond is at its limit, or within the share `tie` of it and bound to reach it.
pub fn is_at_limit(stretches: [f64; 2], limit: StretchLimits, load: Load, tie: f64) -> bool {
    let stretch = load.combine(stretches);
    let outwards = load.share < 1.0 || stretch * stretches[1] > 0.0;
    let nearly = stretch * (1.0 + tie);
    outwards && (nearly >= limit.tension || nearly <= -limit.compression)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMIT: StretchLimits = StretchLimits {
        tension: 2.0,
        compression: 10.0,
    };

    #[test]
    fn a_bond_bounds_the_load_from_both_sides() {
        let bounds = Bounds::of([1.0, 0.5], LIMIT, 0.0);
        assert_eq!(
            (bounds.lower, bounds.upper, bounds.excess),
            (-22.0, 2.0, 0.0)
        );
        let turned = Bounds::of([1.0, -0.5], LIMIT, 0.0);
        assert_eq!((turned.lower, turned.upper), (-2.0, 22.0));
        let both = bounds.and(turned);
        assert_eq!((both.lower, both.upper), (-2.0, 2.0));
        assert_eq!(both.event(0.0, None), Event::Break(Load::full(2.0)));
        assert_eq!(both.event(0.0, Some(1.5)), Event::PhaseEnd);
        assert_eq!(Bounds::NONE.event(0.0, None), Event::None);
    }

    #[test]
    fn what_no_load_factor_carries_recedes() {
        // Held at twice its limit, and another bond that breaks before λ has relieved it.
        let bounds = Bounds::of([4.0, -0.5], LIMIT, 0.0).and(Bounds::of([1.0, 0.5], LIMIT, 0.0));
        let event = bounds.event(0.0, None);
        assert_eq!(
            event,
            Event::Break(Load {
                share: 0.5,
                factor: 0.0
            })
        );
    }
}
