//! Surface correction: factors λ_ij on the bonds near a free surface, where families are cut off.
//!
//! A point near a free surface misses part of its family, and the material there is softer than it
//! should be. Each bond's stiffness is multiplied by a factor that its two ends share. With the sums
//!
//! ```text
//! volume   V_i = Σ A_j, own area included
//! energy   S_x,i = Σ c ξ n_x⁴ A_j,   S_y,i = Σ c ξ n_y⁴ A_j      (Madenci & Oterkus 2014)
//! force    S_x,i = Σ c |n_x|³ A_j,   S_y,i = Σ c |n_y|³ A_j
//! ```
//!
//! over the family, and over a whole one (V0, S∞), the factors are λ = 2 V0/(V_i + V_j) (Le & Bobaru
//! 2018) and λ = [(n_x/g_x)² + (n_y/g_y)²]^(−1/2), g the mean of S∞/S_i and S∞/S_j by component.
//!
//! A family is what the *body* offers: lattice sites in finite elements behind an interface count as
//! present, since the material goes on there, and sites that a point does not see
//! ([`super::visibility`]) as absent. So only free surfaces are corrected. They are those of the
//! intact body: initial cracks, and bonds that break, change no factor.

use super::bonds::family_offsets;
use super::kernel::Micromodulus;
use super::lattice::{LatticeSettings, Sites};
use super::least_squares::EdgeFactors;
use super::visibility::Visibility;
use crate::geometry::Outline;
use crate::interactions::Interactions;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Stiffness of bonds near free surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SurfaceCorrection {
    /// Bonds near a surface are as any other: the paper's.
    None,
    /// By the areas of the families.
    Volume,
    /// By the energies of two uniaxial strains.
    Energy,
    /// By the forces of two uniaxial strains.
    Force,
    /// The least change of `force` that makes straight edges exact in tension.
    LeastSquares,
}

#[derive(Debug, Error, PartialEq)]
pub enum SurfaceError {
    #[error("no factors balance the families at the straight edges: {residual:.1e} remains")]
    Unbalanced { residual: f64 },
    #[error("a bond at a straight edge would get the stiffness factor {factor:.2}")]
    NotPositive { factor: f64 },
}

/// The factors of all bonds of one lattice, also of those whose ends lie up to δ outside its region,
/// in the body.
pub struct Surface {
    correction: SurfaceCorrection,
    sites: Sites,
    /// The share of a whole family that each site has, by component [-].
    completeness: Vec<[f64; 2]>,
    edges: EdgeFactors,
}

impl Surface {
    /// `outline` of the region, which anchors its lattice; `body`: of all that is material.
    ///
    /// # Errors
    /// Least squares alone can fail.
    pub fn new(
        correction: SurfaceCorrection,
        outline: &Outline,
        body: &Outline,
        settings: &LatticeSettings,
        micromodulus: &Micromodulus,
        visibility: &Visibility,
    ) -> Result<Surface, SurfaceError> {
        // Ends of bonds reach δ out of the region, least squares asks for their neighbours' families.
        let reach = (micromodulus.reach() / micromodulus.spacing) as usize;
        let sites = Sites::new(outline, body, settings, 3 * reach);
        let completeness = completeness(correction, &sites, micromodulus, visibility);
        let edges = if correction == SurfaceCorrection::LeastSquares {
            let is_cut = |site: usize| completeness[site] != WHOLE;
            EdgeFactors::new(&sites, &is_cut, (body, visibility), micromodulus)?
        } else {
            EdgeFactors::default()
        };
        Ok(Surface {
            correction,
            sites,
            completeness,
            edges,
        })
    }

    /// λ of the bond between two lattice sites, given by their positions [m].
    pub fn factor(&self, a: [f64; 2], b: [f64; 2]) -> f64 {
        let [i, j] = [a, b].map(|position| self.sites.nearest(position));
        let (own, other) = (self.completeness[i], self.completeness[j]);
        if own == WHOLE && other == WHOLE {
            return 1.0;
        }
        if self.correction == SurfaceCorrection::Volume {
            return 2.0 / (own[0] + other[0]);
        }
        let columns = self.sites.counts()[0] as i32;
        let [from, to] = [i, j].map(|site| [site as i32 % columns, site as i32 / columns]);
        let offset = [to[0] - from[0], to[1] - from[1]];
        let is_cut = |site: usize| self.completeness[site] != WHOLE;
        let edge = self.edges.factor([i, j], offset, is_cut);
        edge.unwrap_or_else(|| mean_factor(offset.map(f64::from), own, other))
    }

    /// Multiplies the stiffness of every bond by its factor. `positions`: of the points, whose nodes
    /// count from `first_node` [m].
    pub fn correct(&self, bonds: &mut Interactions, positions: &[[f64; 2]], first_node: u32) {
        let is_whole = |&position| self.completeness[self.sites.nearest(position)] == WHOLE;
        let is_whole: Vec<bool> = positions.par_iter().map(is_whole).collect();
        let correct = |(stiffness, pair): (&mut f64, &[u32; 2])| {
            let ends = pair.map(|node| (node - first_node) as usize);
            if !ends.iter().all(|&point| is_whole[point]) {
                let [a, b] = ends.map(|point| positions[point]);
                *stiffness *= self.factor(a, b);
            }
        };
        let (pairs, stiffness) = bonds.pairs_mut();
        let bonds = stiffness.par_iter_mut().zip(pairs);
        bonds.with_min_len(1024).for_each(correct);
    }
}

/// S_i/S∞ of a family that misses nothing.
const WHOLE: [f64; 2] = [1.0; 2];

/// λ = [(n_x/g_x)² + (n_y/g_y)²]^(−1/2) of a bond along `bond`, with S_i/S∞ and S_j/S∞.
pub(super) fn mean_factor(bond: [f64; 2], own: [f64; 2], other: [f64; 2]) -> f64 {
    let length = bond[0].hypot(bond[1]);
    let inverse: f64 = (0..2)
        .map(|axis| {
            let g = 0.5 * (1.0 / own[axis] + 1.0 / other[axis]);
            (bond[axis] / length / g).powi(2)
        })
        .sum();
    1.0 / inverse.sqrt()
}

/// S_i/S∞ of every site in the body, by component; V_i/V0 twice [-]. Exactly one where nothing is
/// missing: both sums have the same terms in the same order.
fn completeness(
    correction: SurfaceCorrection,
    sites: &Sites,
    micromodulus: &Micromodulus,
    visibility: &Visibility,
) -> Vec<[f64; 2]> {
    let offsets = family_offsets(micromodulus);
    let weights: Vec<[f64; 2]> = offsets
        .iter()
        .map(|offset| weight(correction, micromodulus, *offset))
        .collect();
    let own = f64::from(u8::from(correction == SurfaceCorrection::Volume));
    let [columns, rows] = sites.counts();
    let sum = |own_share: f64, share: &dyn Fn([i32; 2]) -> f64| {
        let mut sum = [own * own_share; 2];
        for (offset, weight) in offsets.iter().zip(&weights) {
            let share = share(*offset);
            (0..2).for_each(|axis| sum[axis] += weight[axis] * share);
        }
        sum
    };
    let whole = sum(1.0, &|_| 1.0);
    let of_site = |site: usize| {
        if sites.shares[site] == 0.0 || correction == SurfaceCorrection::None {
            return WHOLE;
        }
        let (column, row) = ((site % columns) as i64, (site / columns) as i64);
        let view = visibility.from(sites.position(site));
        let sees = |other: usize| sites.shares[other] > 0.0 && view.sees(sites.position(other));
        let found = sum(sites.shares[site], &|[p, q]| {
            let (x, y) = (column + i64::from(p), row + i64::from(q));
            let inside = x >= 0 && y >= 0 && x < columns as i64 && y < rows as i64;
            let other = y as usize * columns + x as usize;
            if inside && (!view.is_near() || sees(other)) {
                sites.shares[other]
            } else {
                0.0
            }
        });
        [0, 1].map(|axis| found[axis] / whole[axis])
    };
    (0..columns * rows).into_par_iter().map(of_site).collect()
}

/// The contribution of a neighbour with the area dx² to S_x and S_y, or to V/dx² twice.
fn weight(
    correction: SurfaceCorrection,
    micromodulus: &Micromodulus,
    offset: [i32; 2],
) -> [f64; 2] {
    let dx = micromodulus.spacing;
    let bond = offset.map(|steps| f64::from(steps) * dx);
    let c = micromodulus.density(bond);
    let xi = bond[0].hypot(bond[1]);
    let n = bond.map(|x| x / xi);
    match correction {
        SurfaceCorrection::None => [0.0; 2],
        SurfaceCorrection::Volume if c == 0.0 => [0.0; 2],
        SurfaceCorrection::Volume => [micromodulus.area_fraction(xi); 2],
        SurfaceCorrection::Energy => n.map(|n| c * xi * n.powi(4)),
        SurfaceCorrection::Force | SurfaceCorrection::LeastSquares => {
            n.map(|n| c * n.abs().powi(3))
        }
    }
}
