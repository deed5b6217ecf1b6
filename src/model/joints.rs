//! Joints of several materials in one lattice: which material a point and a bond have.
//!
//! A lattice is laid over all regions that touch each other, and each material point has the material of the
//! region in which it lies. A bond between two materials has the harmonic mean of their micromoduli, as if
//! half of it were made of either,
//!
//! ```text
//! c = 2 c_i c_j / (c_i + c_j)
//! ```
//!
//! and an end in finite elements counts as the other end's material. So where two bars of equal
//! section are glued end to end, the bonds across the joint carry what either side does.

use super::topology::LatticePart;
use super::{Model, PointRegion, Topology};
use crate::interactions::Interactions;
use rayon::prelude::*;

/// The regions of a clipped bond's ends are looked up this share of its length inside it [-]: the ends may
/// lie on an interface.
const INWARDS: f64 = 0.01;

impl Topology {
    /// The region of a lattice in which a position lies; on the line between two, the first one.
    fn region_at(&self, lattice: &LatticePart, x: [f64; 2]) -> Option<usize> {
        let mut members = lattice.members.iter().copied();
        members.find(|&region| self.regions[region].outline.contains(x))
    }

    /// The region in which each point of a lattice lies.
    pub(super) fn regions_of(&self, lattice: &LatticePart, positions: &[[f64; 2]]) -> Vec<u32> {
        if lattice.members.len() == 1 {
            return vec![lattice.leader() as u32; positions.len()];
        }
        let region = |&x: &[f64; 2]| self.region_at(lattice, x).unwrap_or(lattice.leader()) as u32;
        positions.iter().map(region).collect()
    }
}

impl Model {
    /// The regions of the lattice that a region leads, ascending.
    pub fn members(&self, leader: usize) -> impl Iterator<Item = usize> + '_ {
        let lattice = self.topology.lattice_of(leader).into_iter();
        lattice.flat_map(|lattice| lattice.members.iter().copied())
    }

    /// The material points of a region, with those of the regions that it touches.
    pub fn points_of(&self, region: usize) -> Option<&PointRegion> {
        let leader = self.topology.lattice_of(region)?.leader();
        self.points.iter().find(|points| points.region == leader)
    }

    /// The peridynamic regions in which an interaction begins and ends; `None` between finite elements, and for a
    /// cell.
    pub fn regions_of_interaction(&self, interaction: usize) -> Option<[usize; 2]> {
        let Some(pair) = self.interactions.pair(interaction) else {
            let clipped = interaction - self.interactions.clipped_bonds().start;
            return self.clipped_regions.get(clipped).copied().flatten();
        };
        let regions = pair.map(|node| self.region_of_point(node as usize));
        let first = regions[0].or(regions[1])?;
        Some(regions.map(|region| region.unwrap_or(first)))
    }

    /// The peridynamic regions in which each clipped bond begins and ends.
    fn find_clipped_regions(&self) -> Vec<Option<[usize; 2]>> {
        let find = |interaction: usize| {
            let mut nodes = self.interactions.nodes(interaction).iter();
            let first = nodes.find_map(|&n| self.region_of_point(n as usize))?;
            let lattice = self.topology.lattice_of(first)?;
            if lattice.members.len() == 1 {
                return Some([first; 2]);
            }
            let [a, b] = self.interactions.segment(interaction, &self.positions);
            let region = |share: f64| {
                let x = [0, 1].map(|axis| a[axis] + share * (b[axis] - a[axis]));
                self.topology.region_at(lattice, x)
            };
            let ends = [region(INWARDS), region(1.0 - INWARDS)];
            let other = ends[0].or(ends[1]).unwrap_or(first);
            Some(ends.map(|end| end.unwrap_or(other)))
        };
        let clipped = self.interactions.clipped_bonds();
        clipped.into_par_iter().map(find).collect()
    }

    /// Young's modulus of a region's bonds alone [Pa].
    pub fn bond_young(&self, region: usize) -> f64 {
        let material = &self.regions[region].material;
        material.on_lattice(self.settings.plane).bond_young
    }

    /// Young's modulus of the bonds alone at the node of a material point [Pa].
    ///
    /// # Panics
    /// Panics for the node of a finite element.
    pub fn bond_young_of_point(&self, node: usize) -> f64 {
        let region = self.region_of_point(node);
        self.bond_young(region.expect("the node of a material point"))
    }

    /// The mean Young's modulus of the bonds at the two ends of an interaction [Pa], c being proportional to it;
    /// `None` between finite elements.
    pub fn mean_young(&self, interaction: usize) -> Option<f64> {
        let [a, b] = (self.regions_of_interaction(interaction)?).map(|r| self.bond_young(r));
        Some(harmonic_mean(a, b))
    }

    /// Whether an interaction joins two materials.
    pub fn is_across_joint(&self, interaction: usize) -> bool {
        let regions = self.regions_of_interaction(interaction);
        regions.is_some_and(|[a, b]| self.bond_young(a) != self.bond_young(b))
    }

    /// Mean Young's modulus of the bonds at the two ends of an interaction over that of its lattice's leader [-].
    pub fn material_factor(&self, interaction: usize) -> f64 {
        let Some([a, b]) = self.regions_of_interaction(interaction) else {
            return 1.0;
        };
        let Some(lattice) = self.topology.lattice_of(a) else {
            return 1.0;
        };
        let leader = self.bond_young(lattice.leader());
        let [a, b] = [a, b].map(|region| self.bond_young(region));
        // Exactly one where all are the same.
        if a == leader && b == leader {
            1.0
        } else {
            harmonic_mean(a, b) / leader
        }
    }

    /// Gives all interactions, which were made with the micromoduli of the leaders, those of their ends.
    pub(super) fn mix_materials(&mut self) {
        self.clipped_regions = self.find_clipped_regions();
        if self.topology.has_joints() {
            let factors: Vec<f64> = (self.interactions.axial())
                .map(|interaction| self.material_factor(interaction))
                .collect();
            let Interactions { stiffness, .. } = &mut self.interactions;
            stiffness.iter_mut().zip(factors).for_each(|(k, f)| *k *= f);
        }
    }
}

fn harmonic_mean(a: f64, b: f64) -> f64 {
    2.0 * a * b / (a + b)
}
