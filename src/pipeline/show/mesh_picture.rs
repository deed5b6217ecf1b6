//! The picture of the mesh and its regions.

use crate::geometry::chords;
use crate::model::{Method, Model};
use crate::output::picture::{self, Dot, Filling, MeshPicture, Patch};
use crate::pipeline::read::plan::Plan;
use std::collections::{BTreeMap, BTreeSet};

/// Elements, material points, interfaces, cracks; regions of one material look alike.
pub(crate) fn mesh_picture(plan: &Plan, model: &Model) -> MeshPicture {
    let parts = Parts::of(plan, model);
    let dots = dots(model, &parts);
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
        title: format!("{}: mesh and regions", plan.name),
        regions: (0..parts.members.len())
            .map(|part| parts.describe(part, count(part), plan))
            .collect(),
        neighbours: parts.neighbours(model),
        interfaces: edges.map(|e| chords(e, &model.mesh.nodes)).collect(),
        cracks: cracks.map(|edge| chords(edge, &model.mesh.nodes)).collect(),
        points: dots,
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

/// Every material point, in the order of the nodes.
fn dots(model: &Model, parts: &Parts) -> Vec<Dot> {
    let dot = |node: usize, side: [f64; 2]| {
        let region = model.region_of_point(node).expect("a material point");
        Dot {
            centre: model.positions[node],
            side,
            region: parts.of_region[region],
        }
    };
    let points = model.points.iter();
    let dots = points.flat_map(|p| p.nodes.clone().map(|n| dot(n, p.side())));
    dots.collect()
}
