//! Checks before a model is built: values, sound cells, and a number of points that memory holds.

use super::{ModelError, ModelSettings, PeridynamicSettings, Region};
use crate::coupling::Coupling;
use crate::coupling::truss::NodeArea;
use crate::fem::element;
use crate::geometry::Outline;
use crate::mesh::{Cell, Mesh};
use crate::phases::machine_memory;

/// More material points than these are a slip of the pen: their factor takes terabytes.
const MOST_POINTS: f64 = 1e7;

/// Least memory of a bond, in the lists of bonds and in K: three quarters of what a million points
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

/// Checks what a model is built from.
pub(super) fn check(
    mesh: &Mesh,
    regions: &[Region],
    settings: &ModelSettings,
) -> Result<(), ModelError> {
    let ModelSettings {
        thickness,
        coupling,
        ..
    } = *settings;
    if !is_positive(thickness) {
        return Err(ModelError::ThicknessNotPositive { thickness });
    }
    if let Coupling::Truss(NodeArea::Given(area)) = coupling
        && !is_positive(area)
    {
        return Err(ModelError::NodeAreaNotPositive { area });
    }
    if regions.is_empty() {
        return Err(ModelError::NoRegion);
    }
    check_mesh(mesh)?;
    check_cells(mesh, regions)?;
    for region in regions {
        let name = || region.name.clone();
        let checked = region.check(settings);
        checked.map_err(|source| ModelError::Settings {
            region: name(),
            source,
        })?;
    }
    Ok(())
}

fn is_positive(value: f64) -> bool {
    value > 0.0 && value.is_finite()
}

fn check_mesh(mesh: &Mesh) -> Result<(), ModelError> {
    let nodes = mesh.nodes.len();
    let is_not_finite = |x: &[f64; 2]| !x.iter().all(|x| x.is_finite());
    if let Some(node) = mesh.nodes.iter().position(is_not_finite) {
        let [x, y] = mesh.nodes[node];
        return Err(ModelError::NodeNotFinite { node, x, y });
    }
    for (cell, of_cell) in mesh.cells.iter().enumerate() {
        if let Some(&node) = of_cell.nodes().iter().find(|&&node| node >= nodes) {
            return Err(ModelError::NodeMissing { cell, node, nodes });
        }
    }
    Ok(())
}

/// Every region has cells, and every cell belongs to one region at most.
fn check_cells(mesh: &Mesh, regions: &[Region]) -> Result<(), ModelError> {
    let mut owner: Vec<Option<usize>> = vec![None; mesh.cells.len()];
    for (index, region) in regions.iter().enumerate() {
        let name = || region.name.clone();
        if region.cells.is_empty() {
            return Err(ModelError::RegionEmpty { region: name() });
        }
        let cells = mesh.cells.len();
        if let Some(&cell) = region.cells.iter().find(|&&cell| cell >= cells) {
            let region = name();
            return Err(ModelError::CellMissing {
                region,
                cell,
                cells,
            });
        }
        let taken = region.cells.iter().find_map(|&cell| owner[cell]);
        if let Some(other) = taken {
            let is_shared = |&&cell: &&usize| owner[cell] == Some(other);
            return Err(ModelError::RegionsOverlap {
                first: regions[other].name.clone(),
                second: name(),
                cells: region.cells.iter().filter(is_shared).count(),
            });
        }
        for &cell in &region.cells {
            if owner[cell].replace(index).is_some() {
                let region = name();
                return Err(ModelError::CellTwice { region, cell });
            }
        }
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
