//! Peridynamic regions that touch each other: one lattice, and bonds across.
//!
//! The first of them in the pipeline leads; the lattice is laid over all of their cells, and each
//! material point has the material of the region in which it lies. A bond between two materials has
//! the harmonic mean of their micromoduli, as if half of it were made of either,
//!
//! ```text
//! c = 2 c_i c_j / (c_i + c_j)
//! ```
//!
//! and an end in finite elements counts as the other end's material. So where two bars of equal
//! section are glued end to end, the bonds across the joint carry what either side does.

use super::{Interface, Method, Model, ModelError, PointRegion, Region};
use crate::geometry::Outline;
use crate::interactions::Interactions;
use crate::mesh::Mesh;
use crate::peridynamics::axes::dominant_angle;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// For every region the one that leads its lattice; itself where it touches no other.
///
/// # Errors
/// [`ModelError::RegionsTouch`] where their lattices differ.
pub(super) fn leaders(mesh: &Mesh, regions: &[Region]) -> Result<Vec<usize>, ModelError> {
    let mut leader: Vec<usize> = (0..regions.len()).collect();
    let is_peridynamic = |r: usize| regions[r].method != Method::FiniteElements;
    for second in (0..regions.len()).filter(|&r| is_peridynamic(r)) {
        for first in (0..second).filter(|&r| is_peridynamic(r)) {
            let (cells, others) = (&regions[first].cells, &regions[second].cells);
            if mesh.shared_edges(cells, others).is_empty() {
                continue;
            }
            if regions[first].method != regions[second].method {
                return Err(ModelError::RegionsTouch {
                    first: regions[first].name.clone(),
                    second: regions[second].name.clone(),
                });
            }
            let (a, b) = (leader[first], leader[second]);
            let led = leader.iter_mut().filter(|l| **l == a || **l == b);
            led.for_each(|l| *l = a.min(b));
        }
    }
    Ok(leader)
}

/// Gives lattices whose angle is not chosen that of most of their region's outline, see
/// [`dominant_angle`]; regions that touch each other have one lattice, and one that is chosen holds for all.
pub fn turn_lattices(mesh: &Mesh, regions: &mut [Region], by_default: &[bool]) {
    let lattices: Vec<usize> = (0..regions.len())
        .filter(|&r| regions[r].method != Method::FiniteElements)
        .collect();
    let mut done = vec![false; regions.len()];
    for &first in &lattices {
        if done[first] {
            continue;
        }
        let mut together = vec![first];
        done[first] = true;
        let mut next = 0;
        while let Some(&region) = together.get(next) {
            next += 1;
            for &other in &lattices {
                let touches = || mesh.shared_edges(&regions[region].cells, &regions[other].cells);
                if !done[other] && !touches().is_empty() {
                    done[other] = true;
                    together.push(other);
                }
            }
        }
        together.sort_unstable();
        let angle_of = |region: &Region| match region.method {
            Method::Peridynamics(settings) => settings.lattice.angle,
            Method::FiniteElements => 0.0,
        };
        let chosen = together.iter().find(|&&r| !by_default[r]);
        let angle = chosen.map_or_else(
            || {
                let cells = together.iter().flat_map(|&r| regions[r].cells.clone());
                let mut cells: Vec<usize> = cells.collect();
                cells.sort_unstable();
                dominant_angle(&Outline::of_cells(mesh, &cells))
            },
            |&r| angle_of(&regions[r]),
        );
        for &region in together.iter().filter(|&&r| by_default[r]) {
            if let Method::Peridynamics(settings) = &mut regions[region].method {
                settings.lattice.angle = angle;
            }
        }
    }
}

/// How far from its ends, in its lengths, it is asked which regions an interaction begins and ends in: ends may
/// lie on an interface.
const INWARDS: f64 = 0.01;

impl Model {
    /// The regions of one lattice, its leader first.
    pub fn members(&self, leader: usize) -> impl Iterator<Item = usize> + '_ {
        let led = self.leader.iter().enumerate();
        led.filter(move |&(_, &l)| l == leader)
            .map(|(region, _)| region)
    }

    /// The material points of a region, with those of the regions that it touches.
    pub fn points_of(&self, region: usize) -> Option<&PointRegion> {
        self.points.iter().find(|p| p.region == self.leader[region])
    }

    /// The mesh's cells below one lattice, ascending.
    pub fn lattice_cells(&self, leader: usize) -> Vec<usize> {
        let members = self.members(leader);
        let mut cells: Vec<usize> = members
            .flat_map(|r| self.regions[r].cells.clone())
            .collect();
        cells.sort_unstable();
        cells
    }

    /// Where finite elements meet one lattice.
    pub(super) fn interfaces_of(&self, leader: usize) -> impl Iterator<Item = &Interface> {
        let interfaces = self.interfaces.iter();
        interfaces.filter(move |i| self.leader[i.peridynamics] == leader)
    }

    /// The region in which each of these points lies; on the line between two, the first one.
    pub(super) fn label(&self, leader: usize, positions: &[[f64; 2]]) -> Vec<u32> {
        let members: Vec<usize> = self.members(leader).collect();
        if members.len() == 1 {
            return vec![leader as u32; positions.len()];
        }
        let outlines = self.outlines(&members);
        let region = |&x: &[f64; 2]| {
            let inside = outlines.iter().position(|outline| outline.contains(x));
            members[inside.unwrap_or(0)] as u32
        };
        positions.iter().map(region).collect()
    }

    fn outlines(&self, regions: &[usize]) -> Vec<Outline> {
        let cells = regions.iter().map(|&r| &self.regions[r].cells);
        cells
            .map(|cells| Outline::of_cells(&self.mesh, cells))
            .collect()
    }

    /// The peridynamic regions in which an interaction begins and ends; `None` between finite elements.
    pub fn regions_of_interaction(&self, interaction: usize) -> Option<[usize; 2]> {
        let Some(pair) = self.interactions.pair(interaction) else {
            return self.clipped_regions[interaction - self.interactions.clipped_bonds().start];
        };
        let regions = pair.map(|node| self.region_of_point(node as usize));
        let first = regions[0].or(regions[1])?;
        Some(regions.map(|region| region.unwrap_or(first)))
    }

    /// The peridynamic regions in which each clipped bond begins and ends.
    fn find_clipped_regions(&self) -> Vec<Option<[usize; 2]>> {
        let mut outlines: BTreeMap<usize, Vec<(usize, Outline)>> = BTreeMap::new();
        for leader in self.points.iter().map(|points| points.region) {
            let members: Vec<usize> = self.members(leader).collect();
            let of_member = self.outlines(&members).into_iter();
            outlines.insert(leader, members.into_iter().zip(of_member).collect());
        }
        let find = |interaction: usize| {
            let mut nodes = self.interactions.nodes(interaction).iter();
            let first = nodes.find_map(|&n| self.region_of_point(n as usize))?;
            let members = &outlines[&self.leader[first]];
            if members.len() == 1 {
                return Some([first; 2]);
            }
            let [a, b] = self.interactions.segment(interaction, &self.positions);
            let region = |share: f64| {
                let x = [0, 1].map(|axis| a[axis] + share * (b[axis] - a[axis]));
                let mut inside = members.iter().filter(|(_, outline)| outline.contains(x));
                inside.next().map(|&(region, _)| region)
            };
            let ends = [region(INWARDS), region(1.0 - INWARDS)];
            let other = ends[0].or(ends[1]).unwrap_or(first);
            Some(ends.map(|end| end.unwrap_or(other)))
        };
        let clipped = self.interactions.clipped_bonds();
        clipped.into_par_iter().map(find).collect()
    }

    /// The mean Young's modulus of the two ends of an interaction [Pa], c being proportional to it; `None` between
    /// finite elements.
    pub fn mean_young(&self, interaction: usize) -> Option<f64> {
        let [a, b] =
            (self.regions_of_interaction(interaction)?).map(|r| self.regions[r].material.young);
        Some(harmonic_mean(a, b))
    }

    /// Mean Young's modulus of the two ends of an interaction over that of its lattice's leader [-].
    pub fn material_factor(&self, interaction: usize) -> f64 {
        let Some([a, b]) = self.regions_of_interaction(interaction) else {
            return 1.0;
        };
        let leader = self.regions[self.leader[a]].material.young;
        let [a, b] = [a, b].map(|region| self.regions[region].material.young);
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
        let leads_others = (0..self.regions.len()).any(|r| self.leader[r] != r);
        if leads_others {
            let factors: Vec<f64> = (0..self.interactions.len())
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
