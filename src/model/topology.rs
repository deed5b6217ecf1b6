//! Topology of the body: the outline of each part, and the edges at which parts meet. It is derived once from
//! the mesh and the regions.

use super::{Method, ModelError, PeridynamicSettings, Region};
use crate::geometry::Outline;
use crate::mesh::{Edge, Mesh};
use std::collections::{BTreeMap, HashMap};

/// Some cells of the mesh and what bounds them.
#[derive(Clone, Debug)]
pub struct Part {
    /// Indices of the mesh's cells.
    pub cells: Vec<usize>,
    /// Edges of the outline, with the part on their left.
    pub edges: Vec<Edge>,
    pub outline: Outline,
}

impl Part {
    fn new(mesh: &Mesh, cells: Vec<usize>) -> Part {
        let edges = mesh.outline(&cells);
        let outline = Outline::from_edges(&edges, &mesh.nodes);
        Part {
            cells,
            edges,
            outline,
        }
    }

    /// The cells of several regions, ascending.
    fn of_regions(mesh: &Mesh, regions: &[Region], members: &[usize]) -> Part {
        let cells = members.iter().flat_map(|&r| regions[r].cells.iter());
        let mut cells: Vec<usize> = cells.copied().collect();
        cells.sort_unstable();
        Part::new(mesh, cells)
    }
}

/// A finite-element and a peridynamic region that meet.
#[derive(Clone, Debug)]
pub struct Interface {
    /// Index of the finite-element region.
    pub finite_elements: usize,
    /// Index of the peridynamic region.
    pub peridynamics: usize,
    /// Edges with the finite elements on the left.
    pub edges: Vec<Edge>,
}

/// Peridynamic regions that touch each other and have one lattice.
#[derive(Clone, Debug)]
pub struct LatticePart {
    /// Indices of the regions, ascending. The first one leads: it names the lattice, and its material is that of
    /// the lattice's micromodulus.
    pub members: Vec<usize>,
    pub settings: PeridynamicSettings,
    pub part: Part,
    /// Edges shared with finite elements, which lie on the left.
    pub interface: Vec<Edge>,
}

impl LatticePart {
    pub fn leader(&self) -> usize {
        self.members[0]
    }
}

/// The parts of a body, and where they meet.
#[derive(Clone, Debug)]
pub struct Topology {
    /// All regions together.
    pub body: Part,
    /// Each region by itself.
    pub regions: Vec<Part>,
    pub interfaces: Vec<Interface>,
    /// The lattices, in the order of their leaders.
    pub lattices: Vec<LatticePart>,
    /// The lattice of every peridynamic region.
    lattice_of: Vec<Option<usize>>,
}

impl Topology {
    /// # Errors
    /// [`ModelError::RegionsTouch`] where the lattices of touching regions differ.
    pub(super) fn new(mesh: &Mesh, regions: &[Region]) -> Result<Topology, ModelError> {
        let parts: Vec<Part> = regions
            .iter()
            .map(|region| Part::new(mesh, region.cells.clone()))
            .collect();
        let shared = shared_edges(&parts);
        let interfaces = interfaces(regions, &shared);
        let mut lattices = Vec::new();
        let mut lattice_of = vec![None; regions.len()];
        for members in touching_lattices(regions, &shared) {
            check_lattices_agree(regions, &members, &shared)?;
            let Method::Peridynamics(settings) = regions[members[0]].method else {
                continue;
            };
            for &region in &members {
                lattice_of[region] = Some(lattices.len());
            }
            let meets = |i: &&Interface| members.contains(&i.peridynamics);
            let interface = interfaces.iter().filter(meets);
            let interface = interface.flat_map(|i| i.edges.clone()).collect();
            lattices.push(LatticePart {
                part: Part::of_regions(mesh, regions, &members),
                interface,
                settings,
                members,
            });
        }
        let all: Vec<usize> = (0..regions.len()).collect();
        Ok(Topology {
            body: Part::of_regions(mesh, regions, &all),
            regions: parts,
            interfaces,
            lattices,
            lattice_of,
        })
    }

    /// The lattice of a peridynamic region.
    pub fn lattice_of(&self, region: usize) -> Option<&LatticePart> {
        self.lattice_of[region].map(|lattice| &self.lattices[lattice])
    }

    /// Whether several regions share a lattice.
    pub fn has_joints(&self) -> bool {
        self.lattices.iter().any(|l| l.members.len() > 1)
    }
}

/// Edges that two regions share, with the first region on their left, in the order of its outline.
type SharedEdges = BTreeMap<(usize, usize), Vec<Edge>>;

fn shared_edges(parts: &[Part]) -> SharedEdges {
    let mut owners: HashMap<[usize; 2], Vec<usize>> = HashMap::new();
    for (region, part) in parts.iter().enumerate() {
        for edge in &part.edges {
            owners.entry(edge.key()).or_default().push(region);
        }
    }
    let mut shared = SharedEdges::new();
    for (region, part) in parts.iter().enumerate() {
        for edge in &part.edges {
            for &other in owners[&edge.key()].iter().filter(|&&other| other != region) {
                shared.entry((region, other)).or_default().push(*edge);
            }
        }
    }
    shared
}

fn is_peridynamic(region: &Region) -> bool {
    region.method != Method::FiniteElements
}

fn interfaces(regions: &[Region], shared: &SharedEdges) -> Vec<Interface> {
    let meet = shared.iter().filter(|((first, second), _)| {
        !is_peridynamic(&regions[*first]) && is_peridynamic(&regions[*second])
    });
    let interface =
        |(&(finite_elements, peridynamics), edges): (&(usize, usize), &Vec<Edge>)| Interface {
            finite_elements,
            peridynamics,
            edges: edges.clone(),
        };
    meet.map(interface).collect()
}

/// The sets of peridynamic regions that touch each other, each ascending, in the order of their first regions.
fn touching_lattices(regions: &[Region], shared: &SharedEdges) -> Vec<Vec<usize>> {
    let mut leader: Vec<usize> = (0..regions.len()).collect();
    for &(first, second) in shared.keys() {
        if is_peridynamic(&regions[first]) && is_peridynamic(&regions[second]) {
            let (a, b) = (leader[first], leader[second]);
            let led = leader.iter_mut().filter(|l| **l == a || **l == b);
            led.for_each(|l| *l = a.min(b));
        }
    }
    let mut sets: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for region in (0..regions.len()).filter(|&r| is_peridynamic(&regions[r])) {
        sets.entry(leader[region]).or_default().push(region);
    }
    sets.into_values().collect()
}

fn check_lattices_agree(
    regions: &[Region],
    members: &[usize],
    shared: &SharedEdges,
) -> Result<(), ModelError> {
    for &second in members {
        for &first in members.iter().take_while(|&&first| first < second) {
            let touch = shared.contains_key(&(first, second));
            if touch && regions[first].method != regions[second].method {
                return Err(ModelError::RegionsTouch {
                    first: regions[first].name.clone(),
                    second: regions[second].name.clone(),
                });
            }
        }
    }
    Ok(())
}

/// The peridynamic regions that share a lattice, with the outline of their cells.
pub(super) fn lattice_outlines(mesh: &Mesh, regions: &[Region]) -> Vec<(Vec<usize>, Outline)> {
    let parts: Vec<Part> = regions
        .iter()
        .map(|region| Part::new(mesh, region.cells.clone()))
        .collect();
    let sets = touching_lattices(regions, &shared_edges(&parts)).into_iter();
    sets.map(|members| {
        let outline = Part::of_regions(mesh, regions, &members).outline;
        (members, outline)
    })
    .collect()
}
