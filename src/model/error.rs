//! Errors of building a model.

use super::settings::SettingsError;
use crate::peridynamics::surface::SurfaceError;
use thiserror::Error;

/// The first thing that makes a model impossible.
#[derive(Debug, Error)]
pub enum ModelError {
    #[error("the thickness {thickness} m is not positive")]
    ThicknessNotPositive { thickness: f64 },
    #[error("the area {area} m² of an interface node is not positive")]
    NodeAreaNotPositive { area: f64 },
    #[error("a model needs a region")]
    NoRegion,
    #[error("region `{region}`: {source}")]
    Settings {
        region: String,
        source: SettingsError,
    },
    #[error("the coordinates ({x}, {y}) m of node {node} of the mesh are not finite")]
    NodeNotFinite { node: usize, x: f64, y: f64 },
    #[error("cell {cell} names node {node}, and the mesh has {nodes} nodes")]
    NodeMissing {
        cell: usize,
        node: usize,
        nodes: usize,
    },
    #[error("region `{region}` names cell {cell}, and the mesh has {cells} cells")]
    CellMissing {
        region: String,
        cell: usize,
        cells: usize,
    },
    #[error("region `{region}` names cell {cell} twice")]
    CellTwice { region: String, cell: usize },
    #[error("region `{region}` has no elements in the mesh")]
    RegionEmpty { region: String },
    #[error("regions `{first}` and `{second}` overlap: {cells} cells of the mesh belong to both")]
    RegionsOverlap {
        first: String,
        second: String,
        cells: usize,
    },
    #[error("peridynamic regions `{first}` and `{second}` touch, and their lattices differ")]
    RegionsTouch { first: String, second: String },
    #[error(
        "element {cell} of region `{region}` is folded or clockwise at ({x:.6e}, {y:.6e}) m: \
         its Jacobian there is {determinant:.3e} m²"
    )]
    Jacobian {
        region: String,
        cell: usize,
        x: f64,
        y: f64,
        determinant: f64,
    },
    #[error("region `{region}` holds no material point: the spacing is larger than the region")]
    NoMaterialPoint { region: String },
    #[error("region `{region}` would hold {points:.1e} material points, more than {limit:.0e}")]
    TooManyPoints {
        region: String,
        points: f64,
        limit: f64,
    },
    /// Before memory is taken for them.
    #[error(
        "region `{region}` would hold {points:.1e} material points and {bonds:.1e} bonds: that needs {:.0} \
         GB, and the machine has {:.0}", .bytes / 1e9, .machine / 1e9
    )]
    TooManyBonds {
        region: String,
        points: f64,
        bonds: f64,
        bytes: f64,
        machine: f64,
    },
    #[error(
        "region `{region}`: the lattice's square at ({x:.6e}, {y:.6e}) m and its interface make no cell, and a \
         Poisson's ratio other than that of bonds needs one"
    )]
    Cells { region: String, x: f64, y: f64 },
    #[error("the surface correction of region `{region}` fails: {source}")]
    Surface {
        region: String,
        source: SurfaceError,
    },
}
