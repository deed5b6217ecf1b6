//! The law of every interaction of a model.

use super::laws::brittle::Brittle;
use super::laws::weaker::Weaker;
use super::laws::{BondLaw, Strength, StretchLimits};
use crate::interactions::InteractionKind;
use crate::model::{Method, Model};
use crate::peridynamics::kernel::Micromodulus;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The law of bonds of a material with Young's modulus `young` [Pa].
fn law_of(strength: Strength, young: f64, micromodulus: &Micromodulus) -> Arc<dyn BondLaw> {
    match strength {
        Strength::Stress { .. } | Strength::EnergyReleaseRate(_) => {
            Arc::new(Brittle::new(strength, young, micromodulus))
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

/// The interactions that may change.
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
                laws.push(law_of(*strength, material.young, &micromodulus));
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
            let is_truss = model.interactions.kind(interaction) == InteractionKind::Truss;
            let mut nodes = model.interactions.nodes(interaction).iter();
            let is_unbreakable = nodes.any(|&node| breakable.unbreakable[node as usize]);
            if is_unbreakable || (is_truss && !breakable.trusses) {
                return 0;
            }
            let regions = model.regions_of_interaction(interaction);
            regions.map_or(0, |[a, b]| match [class_of[a], class_of[b]] {
                [first, second] if first == second => first as u32,
                [first, second] => (own * (1 + first) + second) as u32,
            })
        };
        let numbers = (0..model.interactions.len()).into_par_iter();
        let mut class: Vec<u32> = numbers.map(class).collect();
        let mut of_parts: BTreeMap<(u32, u64), u32> = BTreeMap::new();
        for interaction in model.interactions.clipped_bonds() {
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
