//! Cells: what of the elasticity axial bonds cannot carry sits on the squares between four neighbouring points.
//!
//! The rest of D over that of the bonds ([`crate::material::LatticeElasticity`]) acts on the mean strain of a cell, one
//! or two functionals of rank one (one-point integration as in the smoothed finite element method, Liu, Dai &
//! Nguyen 2007):
//!
//! ```text
//! ∇u = (1/A) Σ_a u_a ⊗ g_a,   g_a = ∮ N_a ν ds = A ∇N_a at the centroid
//! area      e = Σ (g_x u_x + g_y u_y)/A                                         k = κ A h_t
//! deviator  e = Σ (g_x u_x − g_y u_y)/A  and  e = Σ (g_y u_x + g_x u_y)/A       k = μ_D A h_t
//! ```
//!
//! A cell owns its square, and what the body has beyond the outermost rows: each quarter of a point's square that lies
//! in no cell goes to the quarters beside it that do. At a straight free side A is 1.5 dx², with the centroid dx/4
//! outwards: the forces of a uniform stress along the side vanish there.
//!
//! A cell breaks with the first of its six short bonds, the four sides and the two diagonals.

use super::lattice::Lattice;
use super::visibility::Visibility;
use crate::geometry::Outline;

/// A cell of a lattice.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// Nodes, ascending, each once, and their g along the lattice's axes [m].
    pub terms: Vec<(u32, [f64; 2])>,
    /// A [m²].
    pub area: f64,
    /// The nodes of material points whose material the cell has, and how much of A each stands for [m²].
    pub shares: Vec<(u32, f64)>,
    /// Lattice squares that it stands for, by the site at their lower left.
    pub squares: Vec<[i64; 2]>,
}

/// The four corners of a square, from its lower left.
pub const CORNERS: [[i64; 2]; 4] = [[0, 0], [1, 0], [0, 1], [1, 1]];

/// Short bonds are at most this long [dx]: the sides and the diagonals of a square.
pub const LONGEST_SIDE: f64 = 1.5;

/// State of a square of the lattice.
#[derive(Clone, Copy, PartialEq)]
enum Square {
    Missing,
    Whole,
    /// Not made here, and what it owns neither.
    Elsewhere,
}

/// Area and centroid of a piece [m², m].
type Piece = (f64, [f64; 2]);

/// The part of the body that a cell owns around one of its corners.
#[derive(Clone, Copy, Default)]
struct Owned {
    area: f64,
    /// ∫ x dA [m³].
    moment: [f64; 2],
}

impl Owned {
    fn add(&mut self, (area, at): Piece) {
        self.area += area;
        (0..2).for_each(|axis| self.moment[axis] += area * at[axis]);
    }
}

/// The squares between four points that see each other.
struct Squares<'a> {
    lattice: &'a Lattice,
    outline: &'a Outline,
    /// Squares whose lower left site is in the box.
    states: Vec<Square>,
    is_elsewhere: &'a dyn Fn([i64; 2]) -> bool,
}

/// The cells of a lattice, whose nodes count from `first_node`, but for the squares that are made `elsewhere`.
/// `outline`: what the points stand for.
pub fn cells(
    lattice: &Lattice,
    outline: &Outline,
    visibility: &Visibility,
    first_node: u32,
    elsewhere: &dyn Fn([i64; 2]) -> bool,
) -> Vec<Cell> {
    let index = &lattice.index;
    let [columns, rows] = index.counts;
    let sites = || (0..rows).flat_map(|j| (0..columns).map(move |i| [i, j]));
    let state = |square: [i64; 2]| {
        if elsewhere(square) {
            return Square::Elsewhere;
        }
        let points = CORNERS.map(|corner| index.point(beside(square, corner)));
        if points.iter().any(Option::is_none) || !is_seen(lattice, square, visibility) {
            return Square::Missing;
        }
        Square::Whole
    };
    let squares = Squares {
        lattice,
        outline,
        states: sites().map(state).collect(),
        is_elsewhere: elsewhere,
    };
    let mut owned = vec![[Owned::default(); 4]; squares.states.len()];
    for site in sites() {
        squares.share_out(site, &mut owned);
    }
    let whole = sites().zip(owned).zip(&squares.states);
    let whole = whole.filter(|(_, state)| **state == Square::Whole);
    whole
        .map(|((square, owned), _)| squares.cell(square, &owned, first_node))
        .collect()
}

/// The site or square some steps away.
fn beside([i, j]: [i64; 2], [p, q]: [i64; 2]) -> [i64; 2] {
    [i + p, j + q]
}

/// Whether the corners of a square see each other.
pub fn is_seen(lattice: &Lattice, square: [i64; 2], visibility: &Visibility) -> bool {
    let at = CORNERS.map(|corner| lattice.index.position(beside(square, corner)));
    (0..3).all(|a| {
        let view = visibility.from(at[a]);
        !view.is_near() || at[a + 1..].iter().all(|&other| view.sees(other))
    })
}

impl Squares<'_> {
    fn state(&self, square @ [i, j]: [i64; 2]) -> Square {
        let [columns, rows] = self.lattice.index.counts;
        match (0..columns).contains(&i) && (0..rows).contains(&j) {
            true => self.states[(j * columns + i) as usize],
            false if (self.is_elsewhere)(square) => Square::Elsewhere,
            false => Square::Missing,
        }
    }

    /// Shares out the area of the point at a site to the corners of the cells around it.
    fn share_out(&self, site: [i64; 2], owned: &mut [[Owned; 4]]) {
        let index = &self.lattice.index;
        let Some(point) = index.point(site) else {
            return;
        };
        // The square of which the site is a corner.
        let square = |corner: [i64; 2]| beside(site, corner.map(|step| -step));
        let states = CORNERS.map(|corner| self.state(square(corner)));
        if states.iter().all(|state| *state == Square::Elsewhere) {
            return;
        }
        let area = self.lattice.areas[point as usize];
        let pieces = match states.contains(&Square::Missing) {
            // Beside an interface the point's area goes on beyond it.
            true if states.contains(&Square::Elsewhere) => self.quarters(site, None),
            true => self.quarters(site, Some(area)),
            false => self.whole_quarters(site, area),
        };
        for (k, piece) in pieces.into_iter().enumerate() {
            let is_whole = |q: &usize| states[*q] == Square::Whole;
            let takers: Vec<usize> = match states[k] {
                Square::Whole => vec![k],
                Square::Elsewhere => Vec::new(),
                Square::Missing => {
                    let near: Vec<usize> = [k ^ 1, k ^ 2].into_iter().filter(is_whole).collect();
                    match near.is_empty() {
                        true => (0..4).filter(is_whole).collect(),
                        false => near,
                    }
                }
            };
            for &taker in &takers {
                let [i, j] = square(CORNERS[taker]);
                let cell = (j * index.counts[0] + i) as usize;
                owned[cell][taker].add((piece.0 / takers.len() as f64, piece.1));
            }
        }
    }

    /// The quarters of a point's square in the squares of which it is a corner, in the order of [`CORNERS`].
    fn whole_quarters(&self, site: [i64; 2], area: f64) -> [Piece; 4] {
        let index = &self.lattice.index;
        let at = index.position(site);
        CORNERS.map(|corner| {
            let sign = |step: i64| (1 - 2 * step) as f64;
            let centre = [0, 1].map(|axis| at[axis] + 0.25 * sign(corner[axis]) * index.spacing);
            (0.25 * area, centre)
        })
    }

    /// The same of a square that the body may not fill, with the sum `area`.
    fn quarters(&self, site: [i64; 2], area: Option<f64>) -> [Piece; 4] {
        let index = &self.lattice.index;
        let [x, y] = index.position(site);
        let half = 0.5 * index.spacing;
        let row = self.outline.strip(1, y - half, y + half);
        let square = row.strip(0, x - half, x + half);
        let range = |x: f64, step: i64| match step {
            0 => [x, x + half],
            _ => [x - half, x],
        };
        let pieces = CORNERS.map(|[p, q]| {
            let ([left, right], [low, high]) = (range(x, p), range(y, q));
            let piece = square.strip(0, left, right).strip(1, low, high);
            match piece.area() > 1e-9 * half * half {
                true => (piece.area(), piece.centroid()),
                false => (0.0, [x, y]),
            }
        });
        let sum: f64 = pieces.iter().map(|piece| piece.0).sum();
        match area {
            // Slivers that belong to the point lie elsewhere.
            Some(area) if sum > 0.0 => pieces.map(|(own, at)| (own * area / sum, at)),
            Some(area) => self.whole_quarters(site, area),
            None => pieces,
        }
    }

    fn cell(&self, square: [i64; 2], owned: &[Owned; 4], first_node: u32) -> Cell {
        let index = &self.lattice.index;
        let area: f64 = owned.iter().map(|corner| corner.area).sum();
        let [x, y] = index.position(square);
        let centre = [x + 0.5 * index.spacing, y + 0.5 * index.spacing];
        let off = [0, 1].map(|axis| {
            let moment: f64 = owned.iter().map(|corner| corner.moment[axis]).sum();
            (moment / area - centre[axis]) / index.spacing
        });
        let node = |corner: [i64; 2]| {
            let point = index.point(beside(square, corner));
            first_node + point.expect("a whole square has a point at each corner")
        };
        let scale = area / (2.0 * index.spacing);
        let terms = CORNERS.map(|corner| {
            let sign = corner.map(|step| (2 * step - 1) as f64);
            let g = [0, 1].map(|axis| {
                let across = 1 - axis;
                scale * sign[axis] * (1.0 + 2.0 * sign[across] * off[across])
            });
            (node(corner), g)
        });
        Cell {
            terms: terms.to_vec(),
            area,
            shares: (0..4).map(|k| (node(CORNERS[k]), owned[k].area)).collect(),
            squares: vec![square],
        }
    }
}
