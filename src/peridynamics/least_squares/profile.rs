//! The rows of lattice points across a straight edge.

use crate::peridynamics::lattice::Sites;
use crate::peridynamics::visibility::Visibility;

/// The orientation of a strip on the lattice.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Frame {
    /// The axis along the edge.
    pub tangent: usize,
    /// The sign of the other axis from row to row.
    pub inward: i32,
}

/// The rows across an edge, and which of them a site is in.
pub(super) struct Profile {
    /// Area of a point over dx², in units of 1/[`PARTS`], from the edge inward.
    pub shares: Vec<i64>,
    /// Whether the body goes on behind the last row.
    pub open: bool,
    pub row: usize,
    pub frame: Frame,
}

/// Areas are alike to so many parts of dx²: they carry rounding errors.
pub(super) const PARTS: f64 = 1e9;

/// Whether a site's family is what the rows say: all that they hold, and no more. Not so beside the tip of
/// a slit.
pub(super) fn is_strip(
    sites: &Sites,
    site: usize,
    profile: &Profile,
    offsets: &[[i32; 2]],
    visibility: &Visibility,
) -> bool {
    let [columns, rows] = sites.counts();
    let at = [site % columns, site / columns].map(|k| k as i64);
    let view = visibility.from(sites.position(site));
    let Frame { tangent, inward } = profile.frame;
    offsets.iter().all(|offset| {
        let [x, y] = [0, 1].map(|axis| at[axis] + i64::from(offset[axis]));
        let is_on = x >= 0 && y >= 0 && x < columns as i64 && y < rows as i64;
        let other = y as usize * columns + x as usize;
        let found = is_on && sites.shares[other] > 0.0 && view.sees(sites.position(other));
        let row = profile.row as i64 + i64::from(offset[1 - tangent] * inward);
        let expected = row >= 0 && (profile.open || row < profile.shares.len() as i64);
        found == expected
    })
}

/// `depth`: so many rows tell all, since cut-off families at two edges farther apart share no bond.
pub(super) fn profile(
    sites: &Sites,
    site: usize,
    tangent: usize,
    depth: usize,
    visibility: &Visibility,
) -> Option<Profile> {
    let [columns, rows] = sites.counts();
    let at = [site % columns, site / columns];
    let normal = 1 - tangent;
    let count = [columns, rows][normal];
    let share = |k: usize| {
        let mut at = at;
        at[normal] = k;
        sites.shares[at[1] * columns + at[0]]
    };
    // First and one past the last row of the body around the site, as far as `depth`.
    let low = at[normal].saturating_sub(depth);
    let high = (at[normal] + depth).min(count - 1);
    let position = |k: usize| {
        let mut at = at;
        at[normal] = k;
        sites.position(at[1] * columns + at[0])
    };
    let goes_on = |k: usize, next: usize| visibility.sees(position(k), position(next));
    let is_next = |k: usize, before: usize| share(k) > 0.0 && (k == before || goes_on(before, k));
    let from = (low..=at[normal]).rev();
    let from = from.take_while(|&k| is_next(k, (k + 1).min(at[normal])));
    let from = from.last()?;
    let to = (at[normal]..=high).take_while(|&k| is_next(k, k.saturating_sub(1).max(at[normal])));
    let to = to.last()?;
    let (ends_low, ends_high) = (from > low, to < high);
    let quantised = |k: usize| (share(k) * PARTS).round() as i64;
    let upward: Vec<i64> = (from..=to).map(quantised).collect();
    let downward: Vec<i64> = upward.iter().rev().copied().collect();
    let (below, above) = (at[normal] - from, to - at[normal]);
    let is_thin = ends_low && ends_high && upward.len() <= depth;
    let starts_low = match (ends_low, ends_high) {
        _ if is_thin => upward <= downward,
        (true, true) => below <= above,
        (true, false) => true,
        (false, true) => false,
        (false, false) => return None,
    };
    let (mut shares, row, inward) = if starts_low {
        (upward, below, 1)
    } else {
        (downward, above, -1)
    };
    shares.truncate(depth);
    (row < shares.len()).then_some(Profile {
        shares,
        open: !is_thin,
        row,
        frame: Frame { tangent, inward },
    })
}
