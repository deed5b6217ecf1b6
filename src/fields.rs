//! Fields derived from the displacements: strain and stress at the finite-element nodes and at the
//! material points, stretches.

pub mod damage;
pub mod points;
pub mod stress;
mod tractions;

use crate::fem::recovery::nodal_strain;
use crate::material::{Material, PlaneState};
use crate::model::Model;
use nalgebra::Vector3;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Strain and stress at the finite-element nodes, averaged over the elements of one material; a
/// node where materials meet has a copy for each, since strain and stress jump there.
#[derive(Clone, Debug, Default)]
pub struct NodalFields {
    /// The node of every copy.
    pub nodes: Vec<u32>,
    /// The copies that each element's nodes are, element by element.
    pub element_copies: Vec<Vec<usize>>,
    /// xx, yy, zz, xy [-]; xy is γ/2.
    pub strain: Vec<[f64; 4]>,
    /// xx, yy, zz, xy [Pa].
    pub stress: Vec<[f64; 4]>,
}

impl NodalFields {
    pub fn new(model: &Model, displacement: &[[f64; 2]]) -> NodalFields {
        let mut fields = NodalFields::default();
        let mut copies: BTreeMap<(usize, u32), usize> = BTreeMap::new();
        let mut materials = Vec::new();
        for element in 0..model.elements.len() {
            let material = material_index(model, element);
            let copy_of = |node: u32| {
                *copies.entry((material, node)).or_insert_with(|| {
                    fields.nodes.push(node);
                    materials.push(model.regions[material].material);
                    fields.nodes.len() - 1
                })
            };
            let nodes = model
                .element_nodes(element)
                .into_iter()
                .map(copy_of)
                .collect();
            fields.element_copies.push(nodes);
        }
        let mean = fields.mean_strain(model, displacement);
        let plane = model.settings.plane;
        for (strain, material) in mean.into_iter().zip(materials) {
            fields.strain.push(strain_tensor(&strain, &material, plane));
            fields.stress.push(stress_tensor(&strain, &material, plane));
        }
        fields
    }

    fn mean_strain(&self, model: &Model, displacement: &[[f64; 2]]) -> Vec<Vector3<f64>> {
        let of_element = |element: usize| {
            let nodes = model.element_nodes(element);
            let u: Vec<[f64; 2]> = nodes.iter().map(|&n| displacement[n as usize]).collect();
            nodal_strain(
                model.cell(element).kind,
                &model.element_coordinates(element),
                &u,
            )
        };
        let strains: Vec<Vec<Vector3<f64>>> = (0..model.elements.len())
            .into_par_iter()
            .map(of_element)
            .collect();
        let mut sum = vec![(Vector3::zeros(), 0.0); self.nodes.len()];
        for (copies, strains) in self.element_copies.iter().zip(&strains) {
            for (&copy, strain) in copies.iter().zip(strains) {
                sum[copy].0 += strain;
                sum[copy].1 += 1.0;
            }
        }
        sum.into_iter()
            .map(|(strain, count)| strain / count)
            .collect()
    }
}

/// The first region with the same material as the element's.
fn material_index(model: &Model, element: usize) -> usize {
    let material = model.regions[model.elements[element].0].material;
    let same = model
        .regions
        .iter()
        .position(|region| region.material == material);
    same.expect("the element's own region has its material")
}

fn strain_tensor(strain: &Vector3<f64>, material: &Material, plane: PlaneState) -> [f64; 4] {
    let zz = match plane {
        PlaneState::Strain => 0.0,
        PlaneState::Stress => {
            -material.poisson / (1.0 - material.poisson) * (strain[0] + strain[1])
        }
    };
    [strain[0], strain[1], zz, 0.5 * strain[2]]
}

fn stress_tensor(strain: &Vector3<f64>, material: &Material, plane: PlaneState) -> [f64; 4] {
    let stress = material.elasticity(plane) * strain;
    let zz = material.out_of_plane_stress(plane, stress[0], stress[1]);
    [stress[0], stress[1], zz, stress[2]]
}

/// Stretch of every interaction [-].
pub fn stretches(model: &Model, displacement: &[[f64; 2]]) -> Vec<f64> {
    let stretch = |s| {
        model
            .interactions
            .stretch(s, &model.positions, displacement)
    };
    (0..model.interactions.len())
        .into_par_iter()
        .map(stretch)
        .collect()
}
