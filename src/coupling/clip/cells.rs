//! Cells at the interface Γ: lattice squares that it cuts, by boundary integrals.
//!
//! R is the part of a square inside the region, and u on ∂R is linear along the lattice's edges, between points or
//! the places where they meet Γ, and along free sides; along Γ it is the elements' own trace:
//!
//! ```text
//! g_a = ∮_∂R N_a ν ds,   ∇u = (1/|R|) Σ_a u_a ⊗ g_a
//! ```
//!
//! Neighbours use the same u on their common edge, so that in a uniform stress all inner forces cancel and
//! ∮_Γ N_a σ·ν ds is left: exact for any elements and any interface.
//!
//! 1. A site without a point within 0.3 dx of Γ is moved to its foot on Γ and takes the trace there.
//! 2. Beyond a free side an edge goes on as u_P + t (u_P − u_P').
//! 3. A cell smaller than 0.3 dx² is merged with the neighbour over the longest common edge, or with several
//!    that share equally long ones.
//!
//! A cell must reproduce every linear field; one that does not is an error, with its place.

mod integral;
mod overlay;
mod squares;

use crate::coupling::Parts;
use crate::peridynamics::cells::{self, CORNERS, Cell};
use integral::Integral;
use overlay::{Overlay, beside};
use std::collections::{BTreeMap, BTreeSet};

/// Cells smaller than this are merged with a neighbour [dx²].
const LEAST_AREA: f64 = 0.3;

/// Common edges that differ by less are equally long [dx].
const AS_LONG: f64 = 1e-6;

/// A site of the lattice, or the square of which it is the lower left corner.
type Site = [i64; 2];

type Point = [f64; 2];

/// All cells of a lattice: those at the interface, and the whole squares.
pub fn cells_of(parts: &Parts) -> Result<Vec<Cell>, [f64; 2]> {
    let mut overlay = Overlay::new(parts);
    let found = overlay.integrals().map_err(|at| parts.axes.global(at))?;
    let elsewhere: BTreeSet<Site> = found.keys().copied().collect();
    let whole = cells::cells(
        parts.lattice,
        parts.outline,
        parts.visibility,
        parts.first_node,
        &|square| elsewhere.contains(&square),
    );
    for (&square, part) in &found {
        let has_area = part.integral.area() > 0.0;
        let points = CORNERS.map(|corner| overlay.point(beside(square, corner)));
        let is_whole = points.iter().all(Option::is_some);
        if has_area && is_whole && !cells::is_seen(parts.lattice, square, parts.visibility) {
            return Err(parts.axes.global(parts.lattice.index.position(square)));
        }
    }
    let mut all = found;
    for cell in whole {
        let square = cell.squares[0];
        all.insert(square, Part::of_whole(&cell));
    }
    let dx = overlay.dx;
    merge(&mut all, &elsewhere, dx);
    all.into_iter()
        .map(|(square, part)| {
            let is_sound = part.is_whole || part.integral.is_closed(dx);
            match is_sound {
                true => Ok(part.cell()),
                false => Err(parts.axes.global(parts.lattice.index.position(square))),
            }
        })
        .collect()
}

/// A cell while it is made.
struct Part {
    integral: Integral,
    squares: Vec<Site>,
    /// Length of the common edge with each neighbour [m].
    common: Vec<(Site, f64)>,
    shares: Vec<(u32, f64)>,
    /// Whether it is a whole square, which owns what lies beyond a free side.
    is_whole: bool,
}

impl Part {
    fn of_whole(cell: &Cell) -> Part {
        let half = 0.5 * cell.area;
        Part {
            integral: Integral {
                g: cell.terms.iter().copied().collect(),
                closure: [[2.0 * half, 0.0], [0.0, 2.0 * half]],
                normal: [0.0; 2],
            },
            squares: cell.squares.clone(),
            common: Vec::new(),
            shares: cell.shares.clone(),
            is_whole: true,
        }
    }

    fn cell(self) -> Cell {
        let area = self.integral.area();
        let total: f64 = self.shares.iter().map(|share| share.1).sum();
        Cell {
            terms: self.integral.g.into_iter().collect(),
            area,
            shares: (self.shares.iter())
                .map(|&(node, share)| (node, share * area / total))
                .collect(),
            squares: self.squares,
        }
    }
}

/// Merges small cells at the interface with others.
fn merge(all: &mut BTreeMap<Site, Part>, at_interface: &BTreeSet<Site>, dx: f64) {
    let least = LEAST_AREA * dx * dx;
    let mut small: Vec<(f64, Site)> = at_interface
        .iter()
        .map(|&square| (all[&square].integral.area(), square))
        .filter(|(area, _)| *area < least)
        .collect();
    small.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
    for (_, square) in small {
        if all[&square].integral.area() >= least {
            continue;
        }
        let common = &all[&square].common;
        let there: Vec<&(Site, f64)> = common.iter().filter(|(s, _)| all.contains_key(s)).collect();
        let longest = there.iter().map(|c| c.1).fold(0.0, f64::max);
        let takers: Vec<Site> = there
            .iter()
            .filter(|c| c.1 > longest - AS_LONG * dx)
            .map(|c| c.0)
            .collect();
        if takers.is_empty() {
            continue;
        }
        let part = all.remove(&square).expect("it is there until it is merged");
        for taker in &takers {
            let other = all.get_mut(taker).expect("takers are there");
            other
                .integral
                .add_all(&part.integral, 1.0 / takers.len() as f64);
            other.squares.extend(&part.squares);
        }
    }
}
