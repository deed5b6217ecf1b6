//! Rigid motions store no energy, and nothing else does: three eigenvalues of K are zero, no more.

use super::bodies::{TRUSS, build, default_lattice, material, paper_lattice, region};
use super::{Check, Reference, VerificationError};
use crate::assembly::Pattern;
use crate::coupling::Coupling;
use crate::mesh::CellKind;
use crate::mesh::grid::{Grid, name_cells};
use crate::model::{Method, Model, PeridynamicSettings};
use nalgebra::DMatrix;

/// K as a full matrix [N/m].
pub fn dense(model: &Model) -> DMatrix<f64> {
    let elements = model.element_stiffness();
    let pattern = Pattern::new(model.node_count(), &model.interactions, &elements);
    let lower = pattern.assemble(&model.positions, &model.interactions, &elements);
    let n = lower.ncols();
    let mut k = DMatrix::zeros(n, n);
    for j in 0..n {
        let rows = lower.row_idx_of_col_raw(j);
        for (&i, &value) in rows.iter().zip(lower.val_of_col(j)) {
            k[(i as usize, j)] = value;
            k[(j, i as usize)] = value;
        }
    }
    k
}

/// Eigenvalues over the largest, ascending by size.
pub fn spectrum(k: &DMatrix<f64>) -> Vec<f64> {
    let mut values: Vec<f64> = k.symmetric_eigenvalues().iter().copied().collect();
    values.sort_unstable_by(|a, b| a.abs().total_cmp(&b.abs()));
    let largest = values[values.len() - 1];
    values.into_iter().map(|value| value / largest).collect()
}

const DX: f64 = 0.1;

/// Elements left of 12 × 8 material points.
fn hybrid(coupling: Coupling, settings: PeridynamicSettings) -> Result<Model, VerificationError> {
    let grid = Grid {
        size: [2.0, 0.8],
        count: [5, 2],
        kind: CellKind::Quad8,
    };
    let mut mesh = grid.plain();
    name_cells(&mut mesh, "elements", |x| x[0] < 0.8);
    name_cells(&mut mesh, "points", |x| x[0] > 0.8);
    let points = Method::Peridynamics(settings);
    let regions = vec![
        region(&mesh, &["elements"], material(1.0), Method::FiniteElements),
        region(&mesh, &["points"], material(1.0), points),
    ];
    build(mesh, regions, coupling)
}

pub fn measure() -> Result<Vec<Check>, VerificationError> {
    let check = |quantity, coupling, settings| {
        let spectrum = spectrum(&dense(&hybrid(coupling, settings)?));
        let zeros = spectrum.iter().filter(|value| value.abs() < 1e-12);
        Ok::<_, VerificationError>(Check {
            case: "rigid modes",
            quantity,
            // A count.
            reference: Reference::Value {
                value: 3.0,
                within: 0.0,
            },
            source: "exact",
            measured: zeros.count() as f64,
        })
    };
    Ok(vec![
        check("zero eigenvalues, truss, Q8", TRUSS, paper_lattice(DX))?,
        check(
            "zero eigenvalues, clip, Q8",
            Coupling::Clip,
            default_lattice(DX),
        )?,
    ])
}
