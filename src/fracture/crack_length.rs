//! The length of crack that the breaking of an interaction stands for, and the bonds on a straight crack.

use super::bond_laws::BondLaws;
use crate::model::{Model, PointRegion};
use rayon::prelude::*;

/// ½ k (ξ s_t)² / (G h_t) of every interaction, with G = c0 s_t² M3 [m]; zero where it never breaks in
/// tension. Summed over the bonds that cross a cut this is the length of the cut.
pub fn crack_lengths(model: &Model, laws: &BondLaws) -> Vec<f64> {
    let length = |interaction: usize| {
        let regions = model.regions_of_interaction(interaction);
        let points = regions.and_then(|[r, _]| model.points_of(r));
        let breaks = laws.first_limits(interaction).tension.is_finite();
        let Some(points) = points.filter(|_| breaks) else {
            return 0.0;
        };
        let xi = model.interactions.length(interaction, &model.positions);
        // The critical stretch cancels.
        let stiffness = model.interactions.stiffness[interaction];
        // A part of a clipped bond takes the energy of the whole.
        let energy = 0.5 * stiffness * xi * xi / model.length_share(interaction).min(1.0);
        let c0 = model.material_factor(interaction) * points.micromodulus.c0;
        let rate = c0 * points.micromodulus.third_moment();
        energy / (rate * model.settings.thickness)
    };
    (0..model.interactions.len())
        .into_par_iter()
        .map(length)
        .collect()
}

/// A straight cut through the middle of a lattice, across its longer side.
pub struct Cut {
    /// Bonds that cross it, initial cracks left out.
    pub bonds: usize,
    /// The shorter side [m].
    pub length: f64,
}

impl Cut {
    pub fn across(model: &Model, points: &PointRegion) -> Cut {
        let positions = &model.positions[points.nodes.clone()];
        let [low, high] = [f64::min, f64::max].map(|pick: fn(f64, f64) -> f64| {
            let start = positions[0];
            positions
                .iter()
                .fold(start, |most, x| [0, 1].map(|k| pick(most[k], x[k])))
        });
        let sides = [0, 1].map(|axis| high[axis] - low[axis] + points.micromodulus.spacing);
        let along = usize::from(sides[1] > sides[0]);
        let middle = 0.5 * (low[along] + high[along]);
        let crosses = |&bond: &usize| {
            let nodes = model.interactions.nodes(bond);
            let [a, b] = model.interactions.segment(bond, &model.positions);
            model.integrity[bond] > 0.0
                && nodes
                    .iter()
                    .any(|&node| points.nodes.contains(&(node as usize)))
                && (a[along] < middle) != (b[along] < middle)
        };
        Cut {
            bonds: model.interactions.bonds().filter(crosses).count(),
            length: sides[1 - along],
        }
    }
}
