//! Forces per volume.
//!
//! A force per volume b acts on elements by ∫ N_a b h_t dA and on material points by b h_t times the part
//! of their squares in the surface that it is given for, slivers as in [`crate::peridynamics::lattice`]; so
//! the resultant is exact, whatever the areas A_i.

use super::{Boundary, BoundaryError};
use crate::fem::element;
use crate::geometry::Outline;
use crate::model::{Method, Model, PointRegion};
use crate::peridynamics::lattice::areas_within;
use std::collections::BTreeSet;

impl Boundary {
    /// Adds a force per volume [N/m³] on the body's cells of a physical surface.
    ///
    /// # Errors
    /// [`BoundaryError::NothingThere`].
    pub fn add_body_force(
        &mut self,
        model: &Model,
        group: &str,
        density: [f64; 2],
    ) -> Result<(), BoundaryError> {
        let nothing = || BoundaryError::NothingThere {
            group: group.to_owned(),
        };
        let surface = model.mesh.surfaces.get(group).ok_or_else(nothing)?;
        let cells: BTreeSet<usize> = surface.iter().copied().collect();
        let in_body = model.regions.iter().flat_map(|region| &region.cells);
        if !in_body.clone().any(|cell| cells.contains(cell)) {
            return Err(nothing());
        }
        for element in 0..model.elements.len() {
            if cells.contains(&model.elements[element].1) {
                let nodes = model.element_nodes(element);
                for (node, share) in nodes.into_iter().zip(self.volumes(model, element)) {
                    self.add_nodal_force(node as usize, density.map(|b| b * share));
                }
            }
        }
        for points in &model.points {
            for (node, volume) in volumes_of_points(model, points, &cells) {
                self.add_nodal_force(node, density.map(|b| b * volume));
            }
        }
        Ok(())
    }

    /// ∫ N_a h_t dA of an element's nodes [m³].
    fn volumes(&self, model: &Model, element: usize) -> Vec<f64> {
        let coordinates = model.element_coordinates(element);
        let shares = element::shape_integrals(model.cell(element).kind, &coordinates);
        let thickness = model.settings.thickness;
        shares.into_iter().map(|share| share * thickness).collect()
    }
}

/// The volume of some cells that each material point stands for [m³].
fn volumes_of_points(
    model: &Model,
    points: &PointRegion,
    cells: &BTreeSet<usize>,
) -> Vec<(usize, f64)> {
    let Method::Peridynamics(settings) = model.regions[points.region].method else {
        return Vec::new();
    };
    let lattice = model.topology.lattice_of(points.region);
    let own = lattice.into_iter().flat_map(|lattice| &lattice.part.cells);
    let part: Vec<usize> = own.copied().filter(|c| cells.contains(c)).collect();
    if part.is_empty() {
        return Vec::new();
    }
    let axes = settings.lattice.axes();
    let thickness = model.settings.thickness;
    let positions: Vec<[f64; 2]> = points
        .nodes
        .clone()
        .map(|node| axes.local(model.positions[node]))
        .collect();
    let part = axes.outline(&Outline::of_cells(&model.mesh, &part));
    let anchor = axes.outline(&points.outline);
    let areas = areas_within(&part, &anchor, &settings.lattice.along_axes(), &positions);
    let areas = areas.into_iter().zip(points.nodes.clone());
    areas
        .map(|(area, node)| (node, area * thickness))
        .filter(|(_, volume)| *volume > 0.0)
        .collect()
}
