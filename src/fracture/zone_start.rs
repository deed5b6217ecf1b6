//! Zones on one factor, one after the other: the compliance that each begins with (`low_rank.rs`).
//!
//! M is formed anew for each zone: rounding of the updates there does not pile up from zone to zone.

use super::low_rank::{Loss, LowRankChange, changed_compliance};
use super::problem::Problem;
use super::solutions::Solutions;
use super::zone::Zone;
use super::zone_compliance::ZoneCompliance;
use crate::boundary::Boundary;
use crate::linear_solver::columns::{add, slice};
use crate::statics::{Factorised, Solution};
use faer::Mat;

/// The zones on one factor.
#[derive(Default)]
pub struct ZoneSequence {
    /// The losses before the zone that begins next.
    change: LowRankChange,
    /// X and A of the last zone.
    last: Option<ZoneCompliance>,
}

/// A zone when it begins.
pub struct ZoneStart {
    /// A_zz and A_Tz of the factorised K.
    compliance: ZoneCompliance,
    between: Mat<f64>,
    /// Multiplications and additions that it took.
    pub flops: f64,
}

/// How the losses before a zone answer to forces there.
pub struct EarlierLosses {
    /// M A_Tz.
    moved: Mat<f64>,
    /// M u_T of each case when the zone began [N].
    forces: [Vec<f64>; 2],
}

impl ZoneSequence {
    /// T.
    pub fn dofs(&self) -> &[usize] {
        self.change.dofs()
    }

    /// `None` where what is left is a mechanism, or the factor not Cholesky's.
    pub fn start(
        &mut self,
        factorised: &Factorised,
        zone: &Zone,
        base: &Solutions,
    ) -> Option<(ZoneStart, EarlierLosses)> {
        let compliance = ZoneCompliance::new(factorised, &zone.dofs, self.last.take())?;
        let [touched, n] = [self.dofs().len(), zone.dofs.len()];
        let mut start = ZoneStart {
            flops: compliance.flops
                + flops(n as f64, touched as f64, compliance.loads.rows() as f64),
            between: Mat::zeros(touched, n),
            compliance,
        };
        let mut earlier = EarlierLosses {
            moved: Mat::zeros(touched, n),
            forces: [Vec::new(), Vec::new()],
        };
        if touched > 0 {
            start.between = self.change.between(&start.compliance.loads);
            let system = self.change.factorise(&[]).ok()?;
            earlier.moved.copy_from(&start.between);
            self.change.reduce(&system, earlier.moved.as_mut());
            let forces = |u: &Solution| self.change.forces(&system, u);
            earlier.forces = [
                base.held.as_ref().map(forces).unwrap_or_default(),
                forces(&base.unit),
            ];
        }
        Some((start, earlier))
    }

    /// Leaves a zone, where some stiffness has been lost.
    pub fn finish(&mut self, problem: &Problem, zone: &Zone, start: ZoneStart, losses: &[Loss]) {
        let model = problem.model;
        let nodes = losses
            .iter()
            .flat_map(|l| model.interactions.nodes(l.interaction));
        let dofs = nodes.flat_map(|&node| [2 * node as usize, 2 * node as usize + 1]);
        self.change.activate(dofs);
        let place = |dof: &usize| zone.dofs.binary_search(dof).expect("a dof of the zone");
        let places: Vec<usize> = self.change.new_dofs().iter().map(place).collect();
        let ZoneStart {
            compliance,
            between,
            ..
        } = start;
        self.change
            .extend_from(&compliance.loads, &between, &compliance.own, &places);
        self.change.lose(model, losses);
        self.last = Some(compliance);
    }
}

/// u_held and u_unit everywhere, from those when K was factorised, after these losses, whose forces of each case
/// are given at all dofs [N].
pub fn respond(
    problem: &Problem,
    phase: usize,
    factorised: &Factorised,
    base: &Solutions,
    [held, unit]: [Vec<f64>; 2],
    losses: &[Loss],
) -> Solutions {
    let (model, programme) = (problem.model, problem.programme);
    let after = |mut change: Vec<f64>, case: &Boundary, before: &Solution| {
        factorised.respond(&mut change);
        let case = (case, factorised.load_norm(case));
        factorised.changed(model, case, before, &change, losses.iter().map(Loss::parts))
    };
    let before = (base.held.as_ref()).zip(programme.held(phase));
    Solutions {
        unit: after(unit, &programme.phases[phase].boundary, &base.unit),
        held: before.map(|(u, case)| after(held, &case, u)),
    }
}

impl ZoneStart {
    /// A'_zz.
    pub fn compliance(&self, earlier: &EarlierLosses) -> Mat<f64> {
        changed_compliance(&self.compliance.own, &self.between, &earlier.moved)
    }
}

impl EarlierLosses {
    /// v' on the zone: v there, a response to loads that stay, and what the earlier losses add.
    pub fn field(&self, touched: &[usize], zone: &Zone, v: &[f64]) -> Vec<f64> {
        let mut own: Vec<f64> = zone.dofs.iter().map(|&d| v[d]).collect();
        for (j, own) in own.iter_mut().enumerate() {
            let moved = self.moved.col(j).iter().zip(touched);
            *own += moved.map(|(m, &dof)| m * v[dof]).sum::<f64>();
        }
        own
    }

    /// Adds to the forces at all dofs [N] those of the earlier losses, on the dofs `touched`, and those of the losses
    /// in the zone, which are `own` on its dofs [N].
    pub fn add_forces(
        &self,
        touched: &[usize],
        zone: &Zone,
        case: usize,
        own: &[f64],
        all: &mut [f64],
    ) {
        for (&dof, f) in zone.dofs.iter().zip(own) {
            all[dof] += f;
        }
        let mut before = self.forces[case].clone();
        for (j, &f) in own.iter().enumerate().filter(|(_, f)| **f != 0.0) {
            add(&mut before, f, slice(self.moved.col(j)));
        }
        for (&dof, f) in touched.iter().zip(before) {
            all[dof] += f;
        }
    }
}

/// Multiplications and additions for a zone of `n` dofs with `p` rows of X, when `t` are touched: X_TᵀX,
/// I − A_TT S factorised and applied, A'.
fn flops(n: f64, t: f64, p: f64) -> f64 {
    2.0 * t * n * p + 2.0 / 3.0 * t * t * t + 2.0 * t * t * n + n * n * t
}
