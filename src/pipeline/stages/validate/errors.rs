//! Errors of the model and of its boundary conditions, at their keys in the pipeline.

use crate::boundary::BoundaryError;
use crate::model::ModelError;
use crate::pipeline::read::plan::Plan;
use crate::pipeline::read::source::InputError;

pub(super) fn model_error(plan: &Plan, error: &ModelError) -> InputError {
    let key = |name: &str| {
        let index = plan
            .regions
            .iter()
            .rposition(|region| region.name() == name);
        format!("regions/{}/group", index.unwrap_or(0))
    };
    let spacing = |name: &str| key(name).replace("group", "spacing");
    let (key, help) = match error {
        ModelError::RegionEmpty { region } => (
            key(region),
            "mesh the surface in the .geo, or name another group".to_owned(),
        ),
        ModelError::RegionsOverlap { second, .. } => (
            key(second),
            "every surface belongs to one region: change the physical groups or the regions".to_owned(),
        ),
        ModelError::RegionsTouch { first, second } => (
            key(second),
            format!(
                "regions that touch share one lattice: give both the same `spacing`, `horizon`, `kernel`, \
                 `points` and the like, or make them one region, `group: [{}, {}]`, or put a \
                 finite-element region between",
                first.replace('+', ", "),
                second.replace('+', ", ")
            ),
        ),
        ModelError::ThicknessNotPositive { .. } => {
            ("thickness".to_owned(), "write a length greater than zero, such as `1 mm`".to_owned())
        }
        ModelError::NodeAreaNotPositive { .. } => (
            "coupling/truss/node_area".to_owned(),
            "write `lumped`, `half-edge` or an area such as `12.5 mm^2`".to_owned(),
        ),
        ModelError::NoRegion => (
            "regions".to_owned(),
            "name a physical surface and its model: `fem` or `peridynamics`".to_owned(),
        ),
        ModelError::Settings { region, .. } => {
            (key(region), "look at the region's material and lattice".to_owned())
        }
        ModelError::NodeNotFinite { .. } | ModelError::NodeMissing { .. } => {
            ("geometry/file".to_owned(), "make the mesh anew".to_owned())
        }
        ModelError::CellMissing { region, .. } | ModelError::CellTwice { region, .. } => {
            (key(region), "make the mesh anew".to_owned())
        }
        ModelError::Jacobian { region, .. } => (
            key(region),
            "look at the mesh there; curved sides may need smaller elements, and a `.msh` the node \
             order of Gmsh"
                .to_owned(),
        ),
        ModelError::NoMaterialPoint { region } => {
            (spacing(region), "choose a smaller `spacing`".to_owned())
        }
        ModelError::Cells { region, .. } => (
            spacing(region),
            "change `spacing` or `origin` a little, so that no tip or notch of the body lies in a square that the \
             interface cuts, or write `coupling: truss`"
                .to_owned(),
        ),
        ModelError::Surface { region, .. } => (
            key(region).replace("group", "surface_correction"),
            "write `surface_correction: force`".to_owned(),
        ),
        ModelError::TooManyPoints { region, .. } => {
            (spacing(region), "choose a larger `spacing`, and look at its unit".to_owned())
        }
        ModelError::TooManyBonds { region, .. } => (
            spacing(region),
            "choose a larger `spacing` or a smaller `horizon`, and look at their units".to_owned(),
        ),
    };
    plan.source.error(&key, error.to_string(), Some(help))
}

pub(super) fn boundary_error(plan: &Plan, index: usize, error: &BoundaryError) -> InputError {
    let help = match error {
        BoundaryError::NothingThere { .. } => {
            "is its surface part of a region? A curve acts on the element nodes on it and, where it \
             bounds a peridynamic region, on the material points beside it; inside such a region it \
             acts on nothing. A point acts on the node at it, or on a material point \
             within 0.71 spacings"
        }
        BoundaryError::NoOutline { .. } => {
            "loads act on curves that bound the body; this one lies inside it or off it"
        }
        BoundaryError::NoNormal { .. } => {
            "`normal` and `tangential` need a curve; on a point, and where a curve turns back on \
             itself, give `x`, `y` and an `angle`"
        }
        BoundaryError::Contradiction { .. } => {
            "where two groups meet, what they prescribe must be possible together; leave the \
             component to one of them"
        }
        BoundaryError::LoadOnPoint { .. } => {
            "give the traction to a physical curve, or a `force` to the point"
        }
        BoundaryError::Conflict { .. } => {
            "where two groups meet, they must prescribe the same value, or only one of them"
        }
    };
    plan.source.error(
        &plan.conditions[index].key,
        error.to_string(),
        Some(help.to_owned()),
    )
}
