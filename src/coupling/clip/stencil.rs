//! Displacements beside the lattice's points, linear in those of the points nearby that are seen from
//! there.

use crate::peridynamics::point_index::PointIndex;
use crate::peridynamics::visibility::Visibility;
use nalgebra::{Matrix3, Vector3};

/// Points with their shares.
pub type Stencil = Vec<(u32, f64)>;

/// Distances up to which points are looked for to interpolate from, one after the other [dx].
const RADII: [f64; 3] = [1.5, 2.0, 2.5];

/// Least eigenvalue of the moments of a sound set of points; 0.27 for the half of a square.
const SPREAD: f64 = 0.1;

/// The derivative of u along `direction` at a point's site [1/m]: central differences along the
/// lattice's axes, one-sided ones at its rim. `None` where there are no neighbours.
pub fn derivative(
    index: &PointIndex,
    visibility: &Visibility,
    site: [i64; 2],
    direction: [f64; 2],
) -> Option<Stencil> {
    let here = index.point(site)?;
    let view = visibility.from(index.position(site));
    let mut stencil = Vec::new();
    for axis in 0..2 {
        let beside = |step: i64| {
            let mut other = site;
            other[axis] += step;
            index
                .point(other)
                .filter(|_| view.sees(index.position(other)))
        };
        let slope = direction[axis] / index.spacing;
        match [beside(-1), beside(1)] {
            [Some(before), Some(after)] => {
                stencil.extend([(before, -0.5 * slope), (after, 0.5 * slope)]);
            }
            [Some(before), None] => stencil.extend([(before, -slope), (here, slope)]),
            [None, Some(after)] => stencil.extend([(here, -slope), (after, slope)]),
            [None, None] => {
                let [x, y] = direction.map(|d| d / index.spacing);
                let wanted = Vector3::new(0.0, x, y);
                return linear(index, visibility, index.position(site), wanted);
            }
        }
    }
    Some(stencil)
}

/// u at a position along the lattice's axes [m]; `None` far from all points.
pub fn value(index: &PointIndex, visibility: &Visibility, position: [f64; 2]) -> Option<Stencil> {
    linear(index, visibility, position, Vector3::new(1.0, 0.0, 0.0))
}

/// The least shares that give `wanted` (value, derivatives by x/dx and y/dx) of every linear field.
fn linear(
    index: &PointIndex,
    visibility: &Visibility,
    about: [f64; 2],
    wanted: Vector3<f64>,
) -> Option<Stencil> {
    RADII.into_iter().find_map(|radius| {
        let nearby = points_within(index, visibility, about, radius);
        let moments: Matrix3<f64> = nearby.iter().map(|(_, x)| x * x.transpose()).sum();
        if moments.symmetric_eigenvalues().min() < SPREAD {
            return None;
        }
        let factors = moments.try_inverse()? * wanted;
        let shares = nearby.iter().map(|(point, x)| (*point, x.dot(&factors)));
        Some(shares.collect())
    })
}

/// Points with (1, x, y), x and y in spacings from `about`.
fn points_within(
    index: &PointIndex,
    visibility: &Visibility,
    about: [f64; 2],
    radius: f64,
) -> Vec<(u32, Vector3<f64>)> {
    let view = visibility.from(about);
    let local = [0, 1].map(|axis| (about[axis] - index.first[axis]) / index.spacing);
    let [columns, rows] = local.map(|x| {
        let low = (x - radius).ceil() as i64;
        low..=(x + radius).floor() as i64
    });
    let mut found = Vec::new();
    for j in rows {
        for i in columns.clone() {
            let x = Vector3::new(1.0, i as f64 - local[0], j as f64 - local[1]);
            if x[1].hypot(x[2]) <= radius
                && let Some(point) = index.point([i, j])
                && view.sees(index.position([i, j]))
            {
                found.push((point, x));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 6 × 4 sites without the corner (5, 3), and one lone point on top of it.
    fn index() -> PointIndex {
        let kept: Vec<bool> = (0..30).map(|k| k < 23 || k == 29).collect();
        PointIndex::new([0.1, 0.2], 0.5, [6, 5], &kept)
    }

    fn apply(index: &PointIndex, stencil: &Stencil, field: impl Fn([f64; 2]) -> f64) -> f64 {
        let sites = (0..5).flat_map(|j| (0..6).map(move |i| [i, j]));
        let at: Vec<[f64; 2]> = sites
            .filter(|&site| index.point(site).is_some())
            .map(|site| index.position(site))
            .collect();
        stencil
            .iter()
            .map(|&(point, share)| share * field(at[point as usize]))
            .sum()
    }

    #[test]
    fn linear_fields_are_exact_inside_at_the_rim_and_at_a_lone_point() {
        let (index, view) = (index(), Visibility::unlimited());
        let field = |[x, y]: [f64; 2]| 0.7 + 2.0 * x - 3.0 * y;
        for site in [[2, 2], [0, 0], [5, 2], [5, 4]] {
            let stencil = derivative(&index, &view, site, [0.6, 0.8]).expect("points nearby");
            let slope = apply(&index, &stencil, field);
            assert!((slope - (1.2 - 2.4)).abs() < 1e-13, "{site:?} {slope}");
        }
        for position in [[0.93, 1.07], [0.0, 0.1], [2.7, 2.4]] {
            let stencil = value(&index, &view, position).expect("points nearby");
            let found = apply(&index, &stencil, field);
            assert!((found - field(position)).abs() < 1e-13, "{position:?}");
        }
        assert_eq!(value(&index, &view, [9.0, 9.0]), None);
    }
}
