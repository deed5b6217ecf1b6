//! The picture of the mesh and its regions.

use crate::geometry::chords;
use crate::model::{Method, Model};
use crate::output::picture::{self, Dot, Filling, MeshPicture, Patch};
use crate::pipeline::read::plan::Plan;

/// Elements, material points, interfaces, cracks.
pub(crate) fn mesh_picture(plan: &Plan, model: &Model) -> MeshPicture {
    let dots = dots(model);
    let region = |(index, region): (usize, &crate::model::Region)| {
        let (name, filling, count) = match region.method {
            Method::Peridynamics(_) => {
                let points = dots.iter().filter(|dot| dot.region == index);
                ("peridynamics", Filling::Points, points.count())
            }
            Method::FiniteElements => ("finite elements", Filling::Cells, region.cells.len()),
        };
        picture::Region {
            name: region.name.clone(),
            model: name.to_owned(),
            filling,
            count,
        }
    };
    let patch = |&(region, cell): &(usize, usize)| Patch {
        outline: picture::outline(&model.mesh.cells[cell], |n| model.mesh.nodes[n]),
        region,
    };
    let edges = model
        .topology
        .interfaces
        .iter()
        .flat_map(|interface| &interface.edges);
    let cracks = plan.cracks.iter();
    let cracks = cracks.flat_map(|name| &model.mesh.curves[name]);
    MeshPicture {
        title: format!("{}: mesh and regions", plan.name),
        regions: model.regions.iter().enumerate().map(region).collect(),
        points: dots,
        cells: model.elements.iter().map(patch).collect(),
        interfaces: edges.map(|e| chords(e, &model.mesh.nodes)).collect(),
        cracks: cracks.map(|edge| chords(edge, &model.mesh.nodes)).collect(),
    }
}

/// Every material point, in the order of the nodes.
fn dots(model: &Model) -> Vec<Dot> {
    let dot = |node: usize, side: [f64; 2]| Dot {
        centre: model.positions[node],
        side,
        region: model.region_of_point(node).expect("a material point"),
    };
    let points = model.points.iter();
    let dots = points.flat_map(|p| p.nodes.clone().map(|n| dot(n, p.side())));
    dots.collect()
}
