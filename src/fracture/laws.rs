//! Bond laws: what happens to an interaction at which stretch.
//!
//! Between two events every interaction is linear, f = φ k e, and its integrity φ stays. A [`BondLaw`]
//! gives the limits of that branch and the integrity after one of them has been reached. A change from φ
//! to φ' between two states of equilibrium, with the elongations e and e', takes the energy
//! [`released`]. A law is one file here and one line in [`Strength::law`].

pub mod brittle;
mod weaker;

use crate::interactions::InteractionKind;
use crate::model::{Method, Model};
use crate::peridynamics::kernel::Micromodulus;
use brittle::Brittle;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fmt::Debug;
use std::sync::Arc;
use weaker::Weaker;

/// The stretches between which an interaction stays on its branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StretchLimits {
    /// Largest stretch of the branch; infinite where elongation has no limit [-].
    pub tension: f64,
    /// Largest shortening of the branch, −s; infinite where compression has no limit [-].
    pub compression: f64,
}

impl StretchLimits {
    /// No stretch ends the branch.
    pub const NONE: StretchLimits = StretchLimits {
        tension: f64::INFINITY,
        compression: f64::INFINITY,
    };

    /// The stretches that lie within both.
    pub fn and(self, other: StretchLimits) -> StretchLimits {
        StretchLimits {
            tension: self.tension.min(other.tension),
            compression: self.compression.min(other.compression),
        }
    }

    /// Qian et al. (2021), eq. (5): whether the stretch `s` is beyond a limit.
    pub fn is_exceeded(&self, s: f64) -> bool {
        s > self.tension || s < -self.compression
    }

    /// The stretch over the limit of its sign: the branch ends at 1 [-].
    pub fn utilisation(&self, s: f64) -> f64 {
        match s > 0.0 {
            true => s / self.tension,
            false => -s / self.compression,
        }
    }
}

/// What happens to an interaction at which stretch.
pub trait BondLaw: Debug + Send + Sync {
    /// Limits of the branch of an interaction that has this integrity φ.
    fn limits(&self, integrity: f64) -> StretchLimits;

    /// Integrity after the stretch `s` has reached a limit of the branch [-].
    fn next(&self, integrity: f64, s: f64) -> f64;

    /// The law of a clipped bond, the part t of a bond's length.
    fn of_part(&self, t: f64) -> Arc<dyn BondLaw>;
}

/// Energy that a change of integrity takes, with the elongations before and after it [J]:
///
/// ```text
/// ½ (φ − φ') k e e'
/// ```
pub fn released([before, after]: [f64; 2], stiffness: f64, elongations: [f64; 2]) -> f64 {
    0.5 * ((before - after) * stiffness) * elongations[0] * elongations[1]
}

/// The strength of a material, from which its law follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Strength {
    /// s_t = f_t/E, s_c = f_c/E, Qian et al. (2021), eq. (6): the energy release rate depends on the
    /// horizon.
    Stress {
        /// Tensile strength f_t [Pa].
        tensile: f64,
        /// Compressive strength f_c [Pa]; `None`: compression does not break.
        compressive: Option<f64>,
    },
    /// G0 = c0 s0² M3 [J/m²]: the strength depends on the horizon.
    EnergyReleaseRate(f64),
}

impl Strength {
    /// The law of bonds of a material with Young's modulus `young` [Pa].
    pub fn law(self, young: f64, micromodulus: &Micromodulus) -> Arc<dyn BondLaw> {
        match self {
            Strength::Stress { .. } | Strength::EnergyReleaseRate(_) => {
                Arc::new(Brittle::new(self, young, micromodulus))
            }
        }
    }
}

/// The law of every interaction.
#[derive(Clone, Debug)]
pub struct BondLaws {
    /// The different laws, and the limits of each for φ = 1, which most interactions have.
    laws: Vec<Arc<dyn BondLaw>>,
    whole: Vec<StretchLimits>,
    /// Number of each interaction's law.
    class: Vec<u32>,
}

/// Which interactions may change.
pub struct Breakable<'a> {
    /// Strength of each region's material; `None`: its bonds never change.
    pub strengths: &'a [Option<Strength>],
    /// Whether the interactions of each node never change.
    pub unbreakable: &'a [bool],
    /// Whether trusses have the law of their material point's bonds.
    pub trusses: bool,
}

impl BondLaws {
    /// `class`: number of each interaction's law.
    pub fn new(laws: Vec<Arc<dyn BondLaw>>, class: Vec<u32>) -> BondLaws {
        BondLaws {
            whole: laws.iter().map(|law| law.limits(1.0)).collect(),
            laws,
            class,
        }
    }

    /// Brittle laws with these limits. `class`: number of each interaction's law.
    pub fn brittle(limits: Vec<StretchLimits>, class: Vec<u32>) -> BondLaws {
        let law = |limits| Arc::new(Brittle { limits }) as Arc<dyn BondLaw>;
        BondLaws::new(limits.into_iter().map(law).collect(), class)
    }

    /// The laws of a model's interactions. A bond between two materials has the weaker law, and an end in
    /// finite elements counts as the material of the other end; clipped bonds that join finite elements
    /// to finite elements never break.
    pub fn of_model(model: &Model, breakable: &Breakable) -> BondLaws {
        let mut laws: Vec<Arc<dyn BondLaw>> = vec![Arc::new(Brittle::UNBREAKABLE)];
        let mut class_of = vec![0; model.regions.len()];
        for (index, (region, strength)) in model.regions.iter().zip(breakable.strengths).enumerate()
        {
            if let (Some(strength), Method::Peridynamics(settings)) = (strength, region.method) {
                class_of[index] = laws.len();
                let material = &region.material;
                let micromodulus = settings.micromodulus(material, model.settings.plane);
                laws.push(strength.law(material.young, &micromodulus));
            }
        }
        let own = laws.len();
        for first in 0..own {
            for second in 0..own {
                let pair = Weaker::of(laws[first].clone(), laws[second].clone());
                laws.push(Arc::new(pair));
            }
        }
        let class = |interaction: usize| {
            let is_truss = model.springs.kind(interaction) == InteractionKind::Truss;
            let mut nodes = model.springs.nodes(interaction).iter();
            let is_unbreakable = nodes.any(|&node| breakable.unbreakable[node as usize]);
            if is_unbreakable || (is_truss && !breakable.trusses) {
                return 0;
            }
            let regions = model.regions_of_spring(interaction);
            regions.map_or(0, |[a, b]| match [class_of[a], class_of[b]] {
                [first, second] if first == second => first as u32,
                [first, second] => (own * (1 + first) + second) as u32,
            })
        };
        let numbers = (0..model.springs.len()).into_par_iter();
        let mut class: Vec<u32> = numbers.map(class).collect();
        let mut of_parts: BTreeMap<(u32, u64), u32> = BTreeMap::new();
        for interaction in model.springs.clipped_bonds() {
            let (t, whole) = (model.length_share(interaction), class[interaction]);
            if t < 1.0 && whole != 0 {
                let part = of_parts.entry((whole, t.to_bits())).or_insert_with(|| {
                    laws.push(laws[whole as usize].of_part(t));
                    laws.len() as u32 - 1
                });
                class[interaction] = *part;
            }
        }
        BondLaws::new(laws, class)
    }

    /// Limits of the branch of an interaction that has this integrity φ.
    pub fn limits(&self, interaction: usize, integrity: f64) -> StretchLimits {
        let class = self.class[interaction] as usize;
        match integrity == 1.0 {
            true => self.whole[class],
            false => self.laws[class].limits(integrity),
        }
    }

    /// Limits of a whole interaction: where it never breaks, they are [`StretchLimits::NONE`].
    pub fn first_limits(&self, interaction: usize) -> StretchLimits {
        self.whole[self.class[interaction] as usize]
    }

    /// Integrity of an interaction after the stretch `s` has reached a limit of its branch [-].
    pub fn next(&self, interaction: usize, integrity: f64, s: f64) -> f64 {
        self.laws[self.class[interaction] as usize].next(integrity, s)
    }
}
