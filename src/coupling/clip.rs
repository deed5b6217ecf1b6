//! The clip coupling: bonds that end in the finite elements where they cross the interface.
//!
//! After Shapeev (2012). The lattice goes on beyond the interface in thought. Of every bond that meets
//! the peridynamic region, each part AB inside it is an interaction of its own; with t = |AB|/ξ
//!
//! ```text
//! E = Σ (k / 2t) [n·(u_B − u_A)]² + ½ ∫_FE ε:D:ε h_t dA
//! ```
//!
//! where an end on the interface moves with the finite elements there. For a uniform strain the forces
//! at the finite-element nodes must be ∮ N_a σ·ν ds. They are, for any interface that is made of the
//! elements' edges, if a bond stands for its whole *strip*: the bonds ξ = (a, b) dx of one family lie on
//! parallel lines d = g dx/√(a² + b²) apart, g = gcd(|a|, |b|), and the strips |η − η_c| ≤ d/2 about
//! these lines tile the plane.
//!
//! 1. Each strip is cut wherever its lines begin to cross other sides of the region's outline, and
//!    where they cross more than 2 dx of the interface (`strip`); a part of the width w has the share
//!    φ = w/d of the strip's bonds.
//! 2. Where it crosses the interface, ū = Σ_a (1/w) ∫ N_a dη u_a and ℓ̄ = (1/w) ∫ ℓ dη (`side`).
//! 3. Each of the g chains of bonds along the line (`chain`) runs from ū over its sites, those within
//!    dx/8 of the interface left out, to ū where it leaves. Members have the stiffness φ k/t; t may be
//!    more than 1, and a chain without sites joins finite elements to finite elements.
//! 4. Where the part's middle is off the line, sites stand beside their material point, at
//!    u + Δη ∂u/∂η (`stencil`). Where all parts of the strip have a bond in common, their sum is the
//!    plain bond, since Σ φ = 1 and Σ φ Δη = 0: away from the interface nothing is interpolated.
//!
//! A free side ends a chain at its last material point, as it ends a family anywhere else. No member
//! joins two points that do not see each other ([`crate::peridynamics::visibility`]).
//!
//! A patch of uniform strain is exact to rounding if the lattice's moduli are the finite elements': the
//! kernel must be isotropised.

mod cells;
mod chain;
mod side;
mod stencil;
mod strip;

use super::{Parts, Tie, Tied};
use crate::geometry::Outline;
use crate::interactions::Interactions;
use crate::mesh::Edge;
use crate::peridynamics::axes::Axes;
use crate::peridynamics::bonds::family_offsets;
use crate::peridynamics::cells::Cell;
use crate::peridynamics::kernel::Micromodulus;
use crate::peridynamics::point_index::PointIndex;
use crate::peridynamics::surface::Surface;
use crate::peridynamics::visibility::Visibility;
use chain::Line;
use rayon::prelude::*;
use side::{Frame, Side};
use std::collections::{BTreeMap, HashSet};
use strip::Outlook;

/// Material points nearer to the interface than this share of dx are left out [-]. A little more than a
/// quarter, so that rounding does not decide a tie.
const CLEARANCE: f64 = 0.25 + 1e-6;

/// The longest piece of interface, along the bonds, that one part of a strip crosses [dx]. Bonds nearly
/// along the interface would cross many spacings of it, and their mean end would be far from most.
const LONGEST: f64 = 2.0;

/// The clip coupling.
pub struct Clip;

impl Tie for Clip {
    fn name(&self) -> &'static str {
        "clipped bonds"
    }

    fn clearance(&self) -> f64 {
        CLEARANCE
    }

    fn interface_cuts_areas(&self) -> bool {
        false
    }

    fn cells(&self, parts: &Parts) -> Result<Vec<Cell>, [f64; 2]> {
        cells::cells_of(parts)
    }

    fn tie(&self, bonds: Interactions, parts: &Parts) -> Tied {
        let clipped = clip(&Region {
            outline: parts.outline,
            sides: &sides(parts),
            index: &parts.lattice.index,
            axes: parts.axes,
            areas: &parts.lattice.areas,
            micromodulus: parts.micromodulus,
            surface: parts.surface,
            visibility: parts.visibility,
            thickness: parts.thickness,
            first_node: parts.first_node,
        });
        let mut interactions = bonds;
        interactions.retain_bonds(|pair| {
            let pair = pair.map(|node| node - parts.first_node);
            clipped.replaced.binary_search(&pair).is_err()
        });
        interactions.append(clipped.interactions);
        Tied {
            interactions,
            family_shares: clipped.shares,
            bond_lengths: clipped.bond_lengths,
        }
    }
}

/// The sides of a lattice's outline, with the lattice on the left, along its axes.
fn sides(parts: &Parts) -> Vec<Side> {
    let interface: HashSet<[usize; 2]> = parts.interface.iter().map(Edge::key).collect();
    let position = |node: usize| parts.axes.local(parts.mesh.nodes[node]);
    let node_of = |node: usize| parts.node_of[node];
    let side = |edge: &Edge| Side {
        ends: edge.ends.map(position),
        middle: edge.middle.map(position),
        nodes: if interface.contains(&edge.key()) {
            edge.nodes().filter_map(node_of).collect()
        } else {
            Vec::new()
        },
    };
    parts.edges.iter().map(side).collect()
}

/// A peridynamic region and its lattice.
struct Region<'a> {
    /// Outline along the lattice's axes.
    outline: &'a Outline,
    /// All sides of the outline, along the lattice's axes.
    sides: &'a [Side],
    index: &'a PointIndex,
    axes: Axes,
    /// A_i [m²].
    areas: &'a [f64],
    micromodulus: &'a Micromodulus,
    /// Correction of bonds near free surfaces.
    surface: Option<&'a Surface>,
    /// Visibility along the lattice's axes.
    visibility: &'a Visibility,
    /// h_t [m].
    thickness: f64,
    /// The node of the first point.
    first_node: u32,
}

/// The clipped bonds of a lattice, and the bonds that they replace.
#[derive(Clone, Debug, Default)]
struct ClippedBonds {
    interactions: Interactions,
    /// ξ of the bond that each interaction is a part of [m].
    bond_lengths: Vec<f64>,
    /// Places of the interactions in the points' families.
    shares: Vec<FamilyShare>,
    /// Bonds between two points that `interactions` stand for, lower point first, ascending.
    replaced: Vec<[u32; 2]>,
}

/// An interaction that holds the place of a neighbour, or of a part of one, in a point's family.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FamilyShare {
    /// Number of the interaction among the clipped bonds.
    pub interaction: u32,
    /// The point's node.
    pub point: u32,
    /// The part of the neighbour's area that counts [m²].
    pub area: f64,
}

/// Clips the bonds of a region.
fn clip(region: &Region) -> ClippedBonds {
    let half = |&[a, b]: &[i32; 2]| a > 0 || (a == 0 && b > 0);
    let families: Vec<[i32; 2]> = family_offsets(region.micromodulus)
        .into_iter()
        .filter(half)
        .collect();
    let parts: Vec<ClippedBonds> = families
        .par_iter()
        .map(|&family| clip_family(region, family.map(i64::from)))
        .collect();
    let mut all = ClippedBonds::default();
    for ([a, b], part) in families.into_iter().zip(parts) {
        let bond_length = region.index.spacing * f64::from(a).hypot(f64::from(b));
        let interactions = std::iter::repeat_n(bond_length, part.interactions.len());
        all.bond_lengths.extend(interactions);
        let before = all.interactions.len() as u32;
        all.shares
            .extend(part.shares.iter().map(|share| FamilyShare {
                interaction: before + share.interaction,
                ..*share
            }));
        all.interactions.append(part.interactions);
        all.replaced.extend(part.replaced);
    }
    all.replaced.sort_unstable();
    all
}

fn clip_family(region: &Region, family: [i64; 2]) -> ClippedBonds {
    let mut clip = ClippedBonds::default();
    let Region {
        index,
        micromodulus,
        ..
    } = region;
    let dx = index.spacing;
    let bond = family.map(|steps| steps as f64 * dx);
    let stiffness = micromodulus.axial_stiffness(bond, [1.0; 2], 1.0);
    if stiffness == 0.0 {
        return clip;
    }
    let length = bond[0].hypot(bond[1]);
    let frame = Frame {
        n: bond.map(|x| x / length),
    };
    let chains = gcd(family[0].abs(), family[1].abs());
    let step = family.map(|steps| steps / chains);
    let beside = beside(step);
    let width = chains as f64 * dx * dx / length;
    let outlook = outlook(region, frame);
    let origin = frame.across(index.first);
    for (number, arcs) in crossed_strips(&outlook, origin, width) {
        let sub_strips = outlook.sub_strips(origin + number as f64 * width, width, &arcs);
        let line = Line {
            region,
            frame,
            first: beside.map(|steps| steps * number),
            step,
            chains,
            length,
            stiffness,
        };
        line.clip(&sub_strips, &mut clip);
    }
    clip
}

/// Mesh coordinates and their products carry some units of the last digit.
fn tolerance(region: &Region) -> f64 {
    let ends = region.sides.iter().flat_map(|side| side.ends).flatten();
    let size = ends.fold(0.0, |size: f64, x| size.max(x.abs()));
    (16.0 * f64::EPSILON * size).max(1e-13 * region.index.spacing)
}

fn outlook<'a>(region: &Region<'a>, frame: Frame) -> Outlook<'a> {
    let tolerance = tolerance(region);
    let mut arcs = Vec::new();
    let mut edges = Vec::new();
    for (number, side) in region.sides.iter().enumerate() {
        let of_side = side.arcs(number, &frame, tolerance);
        if of_side.is_empty() && side.is_free() {
            edges.push(frame.across(side.ends[0]));
        }
        arcs.extend(of_side);
    }
    Outlook {
        frame,
        sides: region.sides,
        arcs,
        edges,
        tolerance,
        longest: LONGEST * region.index.spacing,
    }
}

/// The strips that cross an interface, by number, and the arcs that reach into each.
fn crossed_strips(outlook: &Outlook, origin: f64, width: f64) -> BTreeMap<i64, Vec<usize>> {
    let mut strips: BTreeMap<i64, Vec<usize>> = BTreeMap::new();
    for (number, arc) in outlook.arcs.iter().enumerate() {
        let [low, high] = arc.range;
        let strip = |eta: f64| ((eta - origin) / width).round() as i64;
        let reached = strip(low + outlook.tolerance)..=strip(high - outlook.tolerance);
        reached.for_each(|s| strips.entry(s).or_default().push(number));
    }
    let meets = |arcs: &Vec<usize>| arcs.iter().any(|&a| !outlook.arcs[a].is_free);
    strips.retain(|_, arcs| meets(arcs));
    strips
}

fn gcd(a: i64, b: i64) -> i64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// The steps (p, q) from one lattice line to the next on its left: a q − b p = 1.
fn beside([a, b]: [i64; 2]) -> [i64; 2] {
    let range = -(a.abs() + b.abs())..=(a.abs() + b.abs());
    let mut pairs = range
        .clone()
        .flat_map(|p| range.clone().map(move |q| [p, q]));
    pairs
        .find(|[p, q]| a * q - b * p == 1)
        .expect("a and b are coprime")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_next_line_is_one_strip_on_the_left() {
        for step in [[1, 0], [0, 1], [1, 1], [1, -1], [3, 2], [2, -3], [3, 1]] {
            let [p, q] = beside(step);
            assert_eq!(step[0] * q - step[1] * p, 1, "{step:?}");
        }
        assert_eq!([gcd(4, 2), gcd(0, 3), gcd(3, 0), gcd(3, 2)], [2, 3, 3, 1]);
    }
}
