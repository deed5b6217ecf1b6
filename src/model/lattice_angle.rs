//! Angles of lattices that a user leaves open.

use super::topology::lattice_outlines;
use super::{Method, Region};
use crate::mesh::Mesh;
use crate::peridynamics::axes::dominant_angle;

/// Gives lattices whose angle is `by_default` the angle of most of their outline, see [`dominant_angle`].
/// Regions that touch each other have one lattice; the angle that is chosen for one of them holds for all.
pub fn turn_lattices(mesh: &Mesh, regions: &mut [Region], by_default: &[bool]) {
    for (members, outline) in lattice_outlines(mesh, regions) {
        let angle_of = |region: usize| match regions[region].method {
            Method::Peridynamics(settings) => settings.lattice.angle,
            Method::FiniteElements => 0.0,
        };
        let chosen = members.iter().find(|&&region| !by_default[region]);
        let angle = chosen.map_or_else(|| dominant_angle(&outline), |&region| angle_of(region));
        for region in members.into_iter().filter(|&region| by_default[region]) {
            if let Method::Peridynamics(settings) = &mut regions[region].method {
                settings.lattice.angle = angle;
            }
        }
    }
}
