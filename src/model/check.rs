//! What is found out before a model is built: sound cells, and a number of points that memory holds.

use super::{ModelError, PeridynamicSettings, Region};
use crate::fem::element;
use crate::geometry::Outline;
use crate::mesh::{Cell, Mesh};
use crate::phases::machine_memory;

/// More material points than these are a slip of the pen: their factor takes terabytes.
const MOST_POINTS: f64 = 1e7;

/// What a bond takes at least, in the lists of bonds and in K: three quarters of what a million points
/// with 24 bonds each took in all [bytes].
const BOND_BYTES: f64 = 90.0;

/// The lattice is laid over the outline's bounding box: that must fit into memory.
pub(super) fn check_count(
    region: &Region,
    outline: &Outline,
    settings: &PeridynamicSettings,
) -> Result<(), ModelError> {
    let spacing = settings.lattice.spacing;
    let [low, high] = outline.bounds();
    let points = [0, 1]
        .iter()
        .map(|&axis| 1.0 + (high[axis] - low[axis]) / spacing)
        .product();
    if points > MOST_POINTS {
        let region = region.name.clone();
        return Err(ModelError::TooManyPoints {
            region,
            points,
            limit: MOST_POINTS,
        });
    }
    let points = outline.area() / (spacing * spacing);
    let family = std::f64::consts::PI * settings.horizon_ratio * settings.horizon_ratio;
    let bonds = 0.5 * points * family.min(points);
    let bytes = BOND_BYTES * bonds;
    if let Some(machine) = machine_memory().map(|machine| machine as f64)
        && bytes > machine
    {
        return Err(ModelError::TooManyBonds {
            region: region.name.clone(),
            points,
            bonds,
            bytes,
            machine,
        });
    }
    Ok(())
}

pub(super) fn check_cells(mesh: &Mesh, regions: &[Region]) -> Result<(), ModelError> {
    let mut owner: Vec<Option<usize>> = vec![None; mesh.cells.len()];
    for (index, region) in regions.iter().enumerate() {
        if region.cells.is_empty() {
            return Err(ModelError::RegionEmpty {
                region: region.name.clone(),
            });
        }
        let taken = region.cells.iter().find_map(|&cell| owner[cell]);
        if let Some(other) = taken {
            return Err(ModelError::RegionsOverlap {
                first: regions[other].name.clone(),
                second: region.name.clone(),
                cells: region
                    .cells
                    .iter()
                    .filter(|&&cell| owner[cell] == Some(other))
                    .count(),
            });
        }
        region
            .cells
            .iter()
            .for_each(|&cell| owner[cell] = Some(index));
    }
    Ok(())
}

pub(super) fn check_jacobian(mesh: &Mesh, region: &Region, cell: usize) -> Result<(), ModelError> {
    let Cell { kind, .. } = mesh.cells[cell];
    let coordinates: Vec<_> = mesh.cells[cell]
        .nodes()
        .iter()
        .map(|&n| mesh.nodes[n])
        .collect();
    let (determinant, [x, y]) = element::smallest_jacobian(kind, &coordinates);
    if determinant > 0.0 {
        return Ok(());
    }
    Err(ModelError::Jacobian {
        region: region.name.clone(),
        cell,
        x,
        y,
        determinant,
    })
}
