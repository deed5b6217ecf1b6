//! One lattice line: the chains of bonds along it, through each part of its strip.

use super::side::Frame;
use super::stencil::{self, Stencil};
use super::strip::{Crossing, Interval, SubStrip};
use super::{ClippedBonds, FamilyShare, Region};
use std::collections::BTreeMap;

/// Sites nearer than this to an end in the finite elements are left out of a chain [dx]. Less than the
/// clearance of the material points, lest one in a corner takes part in no chain.
const LEAST: f64 = 0.125;

/// Shares of a strip this near to one are one.
const WHOLE: f64 = 1e-9;

/// One lattice line of a family: the sites `first` + k `step`.
pub struct Line<'a> {
    pub region: &'a Region<'a>,
    pub frame: Frame,
    pub first: [i64; 2],
    pub step: [i64; 2],
    /// Steps in a bond: so many chains interleave.
    pub chains: i64,
    /// |ξ| [m].
    pub length: f64,
    /// Whole-bond stiffness over A_i A_j [N/m⁵].
    pub stiffness: f64,
}

/// An end of a chain's member.
#[derive(Clone, Copy)]
enum End<'a> {
    Trace(&'a super::side::Average),
    Site { k: i64, along: f64 },
}

impl End<'_> {
    fn along(&self) -> f64 {
        match self {
            End::Trace(average) => average.along,
            End::Site { along, .. } => *along,
        }
    }
}

struct Member<'a> {
    sub_strip: usize,
    ends: [End<'a>; 2],
}

impl Line<'_> {
    /// Adds the interactions of the line's chains, and the bonds that they stand for.
    pub fn clip(&self, sub_strips: &[SubStrip], clip: &mut ClippedBonds) {
        let members = self.members(sub_strips);
        let mut covered: BTreeMap<i64, f64> = BTreeMap::new();
        for member in &members {
            if let Some(k) = self.as_bond(member) {
                *covered.entry(k).or_insert(0.0) += sub_strips[member.sub_strip].share;
            }
        }
        let is_whole = |k: i64| covered.get(&k).is_some_and(|share| *share > 1.0 - WHOLE);
        for k in self.sites_in_box() {
            if let [Some(a), Some(b)] = [k, k + self.chains].map(|k| self.point(k))
                && !is_whole(k)
            {
                clip.replaced.push([a.min(b), a.max(b)]);
            }
        }
        let derivatives = &mut BTreeMap::new();
        for member in &members {
            if !self.as_bond(member).is_some_and(is_whole) {
                self.add(member, &sub_strips[member.sub_strip], derivatives, clip);
            }
        }
    }

    fn site(&self, k: i64) -> [i64; 2] {
        [0, 1].map(|axis| self.first[axis] + k * self.step[axis])
    }

    fn point(&self, k: i64) -> Option<u32> {
        self.region.index.point(self.site(k))
    }

    fn along(&self, k: i64) -> f64 {
        self.frame.along(self.region.index.position(self.site(k)))
    }

    /// Steps of the line with ℓ between two bounds.
    fn sites_between(&self, [low, high]: [f64; 2]) -> std::ops::RangeInclusive<i64> {
        let origin = self.along(0);
        let step = self.length / self.chains as f64;
        let index = |along: f64| (along - origin) / step;
        index(low).ceil() as i64..=index(high).floor() as i64
    }

    fn sites_in_box(&self) -> std::ops::RangeInclusive<i64> {
        self.sites_between(self.box_range())
    }

    /// ℓ of the sites that hold points lies within [m].
    fn box_range(&self) -> [f64; 2] {
        let index = self.region.index;
        let [columns, rows] = index.counts;
        let corners = [[0, 0], [columns, 0], [0, rows], [columns, rows]];
        let along = corners.map(|site| self.frame.along(index.position(site)));
        [
            along.into_iter().fold(f64::INFINITY, f64::min) - index.spacing,
            along.into_iter().fold(f64::NEG_INFINITY, f64::max) + index.spacing,
        ]
    }

    fn members<'s>(&self, sub_strips: &'s [SubStrip]) -> Vec<Member<'s>> {
        let mut members = Vec::new();
        for (number, sub_strip) in sub_strips.iter().enumerate() {
            for (i, interval) in sub_strip.intervals.iter().enumerate() {
                let range = self.range(sub_strip, i);
                for chain in 0..self.chains {
                    let ends = self.chain(sub_strip, interval, range, chain);
                    for pair in ends.windows(2) {
                        if self.may_join(interval, [&pair[0], &pair[1]]) {
                            members.push(Member {
                                sub_strip: number,
                                ends: [pair[0], pair[1]],
                            });
                        }
                    }
                }
            }
        }
        members
    }

    /// Range of ℓ in which an interval's sites may be [m].
    fn range(&self, sub_strip: &SubStrip, i: usize) -> [f64; 2] {
        let [low, high] = self.box_range();
        let intervals = &sub_strip.intervals;
        let margin = LEAST * self.region.index.spacing;
        let [start, end] = &intervals[i].ends;
        let from = match start {
            Crossing::Interface(average) => average.along + margin,
            // Points beside a free side belong to the chain wherever the side's mean is.
            Crossing::Free(_) if i == 0 => low,
            Crossing::Free(_) => intervals[i - 1].ends[1].along(),
        };
        let to = match end {
            Crossing::Interface(average) => average.along - margin,
            Crossing::Free(_) if i + 1 == intervals.len() => high,
            Crossing::Free(_) => intervals[i + 1].ends[0].along(),
        };
        [from, to]
    }

    fn chain<'s>(
        &self,
        sub_strip: &SubStrip,
        interval: &'s Interval,
        range: [f64; 2],
        chain: i64,
    ) -> Vec<End<'s>> {
        let trace = |crossing: &'s Crossing| match crossing {
            Crossing::Interface(average) => Some(End::Trace(average)),
            Crossing::Free(_) => None,
        };
        let sites = self
            .sites_between(range)
            .filter(|k| k.rem_euclid(self.chains) == chain)
            .filter(|&k| self.is_member(k, sub_strip))
            .map(|k| End::Site {
                k,
                along: self.along(k),
            });
        let [start, end] = &interval.ends;
        trace(start)
            .into_iter()
            .chain(sites)
            .chain(trace(end))
            .collect()
    }

    /// A site takes part where there is a point, or, off the line, where one can be interpolated.
    fn is_member(&self, k: i64, sub_strip: &SubStrip) -> bool {
        if self.point(k).is_some() {
            return true;
        }
        let at = self.place(k, sub_strip);
        sub_strip.offset != 0.0
            && self.region.outline.contains(at)
            && stencil::value(self.region.index, self.region.visibility, at).is_some()
    }

    /// Position of a site's stand-in on the sub-strip's middle [m].
    fn place(&self, k: i64, sub_strip: &SubStrip) -> [f64; 2] {
        let [x, y] = self.region.index.position(self.site(k));
        let p = self.frame.perpendicular();
        [x + sub_strip.offset * p[0], y + sub_strip.offset * p[1]]
    }

    /// Chains do not bridge the empty outside; a bond between two points tells by itself whether it does,
    /// for all parts of its strip.
    fn may_join(&self, interval: &Interval, [p, q]: [&End; 2]) -> bool {
        let bridges = |gap: &[f64; 2]| gap[0] < q.along() && gap[1] > p.along();
        match self.is_bond([p, q]) {
            Some(k) => {
                let position = |k: i64| self.region.index.position(self.site(k));
                let visibility = self.region.visibility;
                visibility.sees(position(k), position(k + self.chains))
            }
            None => !interval.gaps.iter().any(bridges),
        }
    }

    fn is_bond(&self, ends: [&End; 2]) -> Option<i64> {
        match ends {
            [End::Site { k, .. }, End::Site { k: other, .. }] if k + self.chains == *other => {
                let points = [*k, *other].map(|k| self.point(k));
                points.iter().all(Option::is_some).then_some(*k)
            }
            _ => None,
        }
    }

    /// The first site of a member that is a bond between two points.
    fn as_bond(&self, member: &Member) -> Option<i64> {
        self.is_bond([&member.ends[0], &member.ends[1]])
    }

    fn add(
        &self,
        member: &Member,
        sub_strip: &SubStrip,
        derivatives: &mut BTreeMap<i64, Stencil>,
        clip: &mut ClippedBonds,
    ) {
        let Region {
            index,
            axes,
            areas,
            thickness,
            first_node,
            ..
        } = *self.region;
        let mut segment = [[0.0; 2]; 2];
        let mut shares: [Stencil; 2] = Default::default();
        for (end, (at, shares)) in member.ends.iter().zip(segment.iter_mut().zip(&mut shares)) {
            match end {
                End::Trace(average) => {
                    *at = self.frame.point(average.along, sub_strip.across);
                    shares.clone_from(&average.shares);
                }
                End::Site { k, .. } => {
                    *at = self.place(*k, sub_strip);
                    *shares = self.site_shares(*k, sub_strip, derivatives);
                    shares.iter_mut().for_each(|(node, _)| *node += first_node);
                }
            }
        }
        let points = member.ends.map(|end| match end {
            End::Site { k, .. } => self.point(k),
            End::Trace(_) => None,
        });
        let own = points.map(|point| point.map(|point| areas[point as usize]));
        let square = index.spacing * index.spacing;
        let area = |end: usize| own[end].or(own[1 - end]).unwrap_or(square);
        let factor = match (self.region.surface, self.bond_of(member)) {
            (Some(surface), Some(bond)) => surface.factor(bond[0], bond[1]),
            _ => 1.0,
        };
        let whole = factor * self.stiffness * area(0) * area(1) * thickness;
        let ratio = (member.ends[1].along() - member.ends[0].along()) / self.length;
        for (end, point) in points.into_iter().enumerate() {
            if let Some(point) = point {
                let fraction = self.region.micromodulus.area_fraction(self.length);
                clip.shares.push(FamilyShare {
                    interaction: clip.interactions.len() as u32,
                    point: first_node + point,
                    area: sub_strip.share * fraction * own[1 - end].unwrap_or(square),
                });
            }
        }
        clip.interactions.push_clipped_bond(
            segment.map(|x| axes.global(x)),
            [&shares[0], &shares[1]],
            sub_strip.share * whole / ratio,
        );
    }

    /// Ends of the bond that a member is a part of; `None` between finite elements.
    fn bond_of(&self, member: &Member) -> Option<[[f64; 2]; 2]> {
        let first = match member.ends {
            [End::Site { k, .. }, _] => k,
            [_, End::Site { k, .. }] => k - self.chains,
            _ => return None,
        };
        let sites = [first, first + self.chains].map(|k| self.site(k));
        Some(sites.map(|site| self.region.index.position(site)))
    }

    /// The displacement of a site's stand-in. That of a point is u + Δη ∂u/∂η with one derivative for
    /// all parts of the strip, so that their shares add up to the point itself.
    fn site_shares(
        &self,
        k: i64,
        sub_strip: &SubStrip,
        derivatives: &mut BTreeMap<i64, Stencil>,
    ) -> Stencil {
        let index = self.region.index;
        let Some(point) = self.point(k) else {
            return stencil::value(index, self.region.visibility, self.place(k, sub_strip))
                .expect("only such sites are members");
        };
        let mut shares = vec![(point, 1.0)];
        if sub_strip.offset != 0.0 {
            let derivative = derivatives.entry(k).or_insert_with(|| {
                let direction = self.frame.perpendicular();
                stencil::derivative(index, self.region.visibility, self.site(k), direction)
                    .unwrap_or_default()
            });
            let scaled = derivative
                .iter()
                .map(|&(node, share)| (node, sub_strip.offset * share));
            shares.extend(scaled);
        }
        shares
    }
}
