//! Micromoduli near straight free edges by least squares, after Prakash (2019).
//!
//! Along a free edge with the tangent t the stress is σ = t⊗t times a number, and nothing else. A
//! family is balanced if under the strain ε_t of that stress its forces cancel and its part of the
//! stress is σ:
//!
//! ```text
//! Σ_j β_ij k_ij ξ (n·ε_t·n) n = 0,    ½ Σ_j β_ij k_ij ξ² (n·ε_t·n) (n·t)² = A_i h_t
//! ```
//!
//! ε_t is that of the lattice's own moduli, so that the interior is balanced anyway. The β are the factors
//! λ of the force method with the least change, Σ (β_ij − λ_ij)², that balance every row of points along
//! the edge. Only bonds between two cut-off families change, and β = 1 between such a family and a whole
//! one: whole families stay balanced. A strip in tension is then exact.
//!
//! An edge along one of the lattice's axes looks the same from every point of a row, so the β are found
//! once, for an infinite strip with the rows' areas. A point has them if its family meets no other
//! edge. All other points keep the factors of the force method. Where a family meets a corner or a curve,
//! no uniform stress but zero leaves the surface free, and there is nothing to balance. Oblique edges
//! leave steps in the lattice, and the factors that balance those can be negative: −3.78 at 1°, −0.11 at
//! 10°, from 0.30 on at 20° and more (quartic kernel, m = 4).

mod profile;
mod strip;

use super::bonds::family_offsets;
use super::kernel::Micromodulus;
use super::lattice::Sites;
use super::surface::SurfaceError;
use super::visibility::Visibility;
use crate::geometry::{Outline, nearest_on_segment};
use profile::{Frame, Profile, is_strip, profile};
use rayon::prelude::*;
use std::collections::BTreeMap;
use strip::Strip;

/// The factors along all straight edges of a body.
#[derive(Default)]
pub struct EdgeFactors {
    strips: Vec<Strip>,
    places: BTreeMap<u32, Place>,
}

/// The place of a site in a strip.
#[derive(Clone, Copy, PartialEq)]
struct Place {
    strip: usize,
    row: usize,
    frame: Frame,
}

/// Directions within this angle are parallel.
const PARALLEL: f64 = 1e-6;

impl EdgeFactors {
    /// `is_cut`: whether a site's family is cut off.
    ///
    /// # Errors
    /// No factors balance the families, or only negative ones.
    pub fn new(
        sites: &Sites,
        is_cut: &(dyn Fn(usize) -> bool + Sync),
        (body, visibility): (&Outline, &Visibility),
        micromodulus: &Micromodulus,
    ) -> Result<EdgeFactors, SurfaceError> {
        let segments: Vec<_> = body.segments().collect();
        let reach = (micromodulus.reach() / micromodulus.spacing) as usize;
        let [columns, rows] = sites.counts();
        let offsets = family_offsets(micromodulus);
        let place = |site: usize| {
            let tangent = tangent(sites.position(site), &segments, micromodulus.reach())?;
            let profile = profile(sites, site, tangent, 3 * reach, visibility)?;
            let offsets = &offsets;
            is_strip(sites, site, &profile, offsets, visibility).then_some((site, profile))
        };
        let found: Vec<(usize, Profile)> = (0..columns * rows)
            .into_par_iter()
            .filter(|&site| is_cut(site))
            .filter_map(place)
            .collect();
        let mut factors = EdgeFactors::default();
        let mut known: BTreeMap<(Vec<i64>, bool), usize> = BTreeMap::new();
        for (site, profile) in found {
            let key = (profile.shares.clone(), profile.open);
            let strip = match known.get(&key) {
                Some(&strip) => strip,
                None => {
                    let strip = Strip::new(&profile, micromodulus)?;
                    factors.strips.push(strip);
                    known.insert(key, factors.strips.len() - 1);
                    factors.strips.len() - 1
                }
            };
            let Profile { row, frame, .. } = profile;
            factors
                .places
                .insert(site as u32, Place { strip, row, frame });
        }
        Ok(factors)
    }

    /// β of the bond from one site to another at `offset`, where the edge says something of it.
    pub fn factor(
        &self,
        [i, j]: [usize; 2],
        offset: [i32; 2],
        is_cut: impl Fn(usize) -> bool,
    ) -> Option<f64> {
        match [i, j].map(|site| self.places.get(&(site as u32))) {
            [Some(a), Some(b)] if a.strip == b.strip && a.frame == b.frame => {
                let along = offset[a.frame.tangent];
                let inward = offset[1 - a.frame.tangent] * a.frame.inward;
                self.strips[a.strip].factor(a.row, [along, inward])
            }
            [Some(_), None] if !is_cut(j) => Some(1.0),
            [None, Some(_)] if !is_cut(i) => Some(1.0),
            _ => None,
        }
    }
}

/// The axis along the edges within `reach` of a position, if they are all along one.
fn tangent(position: [f64; 2], segments: &[[[f64; 2]; 2]], reach: f64) -> Option<usize> {
    let mut found = None;
    for &segment in segments {
        let [a, b] = segment;
        let far = (0..2).any(|axis| {
            let (low, high) = (a[axis].min(b[axis]), a[axis].max(b[axis]));
            position[axis] < low - reach || position[axis] > high + reach
        });
        if far || nearest_on_segment(position, segment).1 > reach {
            continue;
        }
        let (along, across) = ((b[0] - a[0]).abs(), (b[1] - a[1]).abs());
        let axis = usize::from(across > along);
        let is_straight = along.min(across) <= PARALLEL * along.max(across);
        if !is_straight || found.is_some_and(|other| other != axis) {
            return None;
        }
        found = Some(axis);
    }
    found
}
