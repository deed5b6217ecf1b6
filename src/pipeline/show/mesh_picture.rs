//! The picture of the mesh and its regions.

use super::lattice_cells::{LatticeCell, lattice_cells};
use super::maps::titled;
use crate::geometry::{Outline, chords};
use crate::model::{Method, Model};
use crate::output::picture::{self, Dot, Filling, MeshPicture, Patch};
use crate::pipeline::read::plan::Plan;
use std::collections::{BTreeMap, BTreeSet};

/// Elements, material points, interfaces, cracks; regions of one material look alike.
pub(crate) fn mesh_picture(plan: &Plan, model: &Model) -> MeshPicture {
    let parts = Parts::of(plan, model);
    let (dots, pieces) = points(model, &parts);
    let cells: Vec<Patch> = model
        .elements
        .iter()
        .map(|&(region, cell)| Patch {
            outline: picture::outline(&model.mesh.cells[cell], |n| model.mesh.nodes[n]),
            region: parts.of_region[region],
        })
        .collect();
    let edges = model
        .topology
        .interfaces
        .iter()
        .flat_map(|interface| &interface.edges);
    let cracks = plan.cracks.iter();
    let cracks = cracks.flat_map(|name| &model.mesh.curves[name]);
    let count = |part: usize| {
        let points = dots.iter().filter(|dot| dot.region == part).count();
        points + cells.iter().filter(|cell| cell.region == part).count()
    };
    MeshPicture {
        title: titled(plan, "mesh and regions"),
        regions: (0..parts.members.len())
            .map(|part| parts.describe(part, count(part), plan))
            .collect(),
        neighbours: parts.neighbours(model),
        interfaces: edges.map(|e| chords(e, &model.mesh.nodes)).collect(),
        cracks: cracks.map(|edge| chords(edge, &model.mesh.nodes)).collect(),
        points: dots,
        pieces,
        cells,
    }
}

/// The regions, those of one material and one discretisation together.
struct Parts {
    /// The regions of each part.
    members: Vec<Vec<usize>>,
    /// The part of each region.
    of_region: Vec<usize>,
}

impl Parts {
    fn of(plan: &Plan, model: &Model) -> Parts {
        let mut members: Vec<Vec<usize>> = Vec::new();
        let mut of_region = Vec::new();
        let mut known = BTreeMap::new();
        for (index, region) in plan.regions.iter().enumerate() {
            let is_points = filling(&model.regions[index].method) == Filling::Points;
            let part = *known
                .entry((&region.material_name, is_points))
                .or_insert(members.len());
            if part == members.len() {
                members.push(Vec::new());
            }
            members[part].push(index);
            of_region.push(part);
        }
        Parts { members, of_region }
    }

    fn describe(&self, part: usize, count: usize, plan: &Plan) -> picture::Region {
        let members = &self.members[part];
        let first = &plan.regions[members[0]];
        let groups: Vec<&String> = members
            .iter()
            .flat_map(|&r| &plan.regions[r].groups)
            .collect();
        let mut name = groups[0].clone();
        if groups.len() > 1 {
            name += &format!(" + {} more", groups.len() - 1);
        }
        let is_of_several = plan
            .regions
            .iter()
            .any(|r| r.material_name != first.material_name);
        if is_of_several {
            name += &format!(" ({})", first.material_name);
        }
        let filling = filling(&first.method);
        picture::Region {
            name,
            model: match filling {
                Filling::Points => "peridynamics",
                Filling::Cells => "finite elements",
            }
            .to_owned(),
            filling,
            count,
        }
    }

    /// Pairs of parts with a common edge in the mesh.
    fn neighbours(&self, model: &Model) -> Vec<[usize; 2]> {
        let mut beside = BTreeMap::new();
        let mut pairs = BTreeSet::new();
        for (region, &part) in model.regions.iter().zip(&self.of_region) {
            let edges = region
                .cells
                .iter()
                .flat_map(|&cell| model.mesh.cells[cell].edges());
            for edge in edges {
                let other = *beside.entry(edge.key()).or_insert(part);
                if other != part {
                    pairs.insert([other.min(part), other.max(part)]);
                }
            }
        }
        pairs.into_iter().collect()
    }
}

fn filling(method: &Method) -> Filling {
    match method {
        Method::Peridynamics(_) => Filling::Points,
        Method::FiniteElements => Filling::Cells,
    }
}

/// Every material point, and the pieces of squares that the outlines of regions cut.
fn points(model: &Model, parts: &Parts) -> (Vec<Dot>, Vec<Patch>) {
    let (mut dots, mut pieces) = (Vec::new(), Vec::new());
    for points in &model.points {
        for region in model.members(points.region) {
            let is_inside = |node: usize| model.region_of_point(node) == Some(region);
            let outline = Outline::of_cells(&model.mesh, &model.regions[region].cells);
            let part = parts.of_region[region];
            let mut whole = BTreeSet::new();
            for cell in lattice_cells(points, &outline, is_inside) {
                match cell {
                    LatticeCell::Square(node) => {
                        whole.insert(node);
                    }
                    LatticeCell::Piece(_, outline) => pieces.push(Patch {
                        outline,
                        region: part,
                    }),
                }
            }
            let nodes = points.nodes.clone().filter(|&node| is_inside(node));
            dots.extend(nodes.map(|node| Dot {
                centre: model.positions[node],
                side: points.side(),
                is_whole: whole.contains(&node),
                region: part,
            }));
        }
    }
    (dots, pieces)
}
