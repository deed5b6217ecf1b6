//! Boundary integrals of shape functions around a cell.

use super::Point;
use crate::coupling::clip::stencil::Stencil;
use std::collections::BTreeMap;

/// How far a cell may be from reproducing linear fields [-].
const CLOSED: f64 = 1e-7;

/// A place on ∂R with its displacement by nodes.
#[derive(Clone)]
pub struct Place {
    pub at: Point,
    pub u: Stencil,
}

/// A part of a cell's boundary integral.
#[derive(Clone, Default)]
pub struct Integral {
    /// g by node [m].
    pub g: BTreeMap<u32, Point>,
    /// ∮ x ν ds by component of x and ν [m²].
    pub closure: [[f64; 2]; 2],
    /// ∮ ν ds [m].
    pub normal: Point,
}

impl Integral {
    /// Adds `weight` · N_a ν ds of one place.
    pub fn add(&mut self, weight: Point, place: &Place) {
        for (axis, weight) in weight.into_iter().enumerate() {
            self.normal[axis] += weight;
            (0..2).for_each(|k| self.closure[k][axis] += weight * place.at[k]);
        }
        for &(node, share) in &place.u {
            let g = self.g.entry(node).or_default();
            (0..2).for_each(|axis| g[axis] += share * weight[axis]);
        }
    }

    pub fn add_all(&mut self, other: &Integral, share: f64) {
        for axis in 0..2 {
            self.normal[axis] += share * other.normal[axis];
            (0..2).for_each(|k| self.closure[k][axis] += share * other.closure[k][axis]);
        }
        for (&node, other) in &other.g {
            let g = self.g.entry(node).or_default();
            (0..2).for_each(|axis| g[axis] += share * other[axis]);
        }
    }

    /// Adds a straight piece along which u is linear, with the cell on its left.
    pub fn add_line(&mut self, [from, to]: [&Place; 2], sign: f64) {
        let half = 0.5 * sign;
        let normal = [
            half * (to.at[1] - from.at[1]),
            half * (from.at[0] - to.at[0]),
        ];
        self.add(normal, from);
        self.add(normal, to);
    }

    /// Twice the area over two [m²].
    pub fn area(&self) -> f64 {
        0.5 * (self.closure[0][0] + self.closure[1][1])
    }

    /// Whether linear fields have their own gradient, the lattice's spacing being `dx`.
    pub fn is_closed(&self, dx: f64) -> bool {
        let area = self.area();
        let [[xx, xy], [yx, yy]] = self.closure;
        let small = CLOSED * area;
        let is_flat = self.normal.iter().all(|n| n.abs() * dx < small);
        is_flat
            && [xx - area, yy - area, xy, yx]
                .iter()
                .all(|x| x.abs() < small)
    }
}
