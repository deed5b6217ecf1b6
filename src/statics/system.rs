//! K u = f with supports: what is held, what is prescribed, and a solution refined until its residual is small.

use super::residual::Residual;
use crate::assembly::LowerMatrix;
use crate::boundary::Boundary;
use crate::linear_solver::Factorisation;
use crate::linear_solver::policy::MOST_REFINEMENTS;
use std::collections::BTreeSet;

/// K with its supports.
pub(super) struct System {
    /// K as assembled [N/m].
    pub stiffness: LowerMatrix,
    /// ‖K‖∞ when K was assembled [N/m]; it only falls while interactions break.
    norm: f64,
    /// Whether each dof is held.
    pub is_held: Vec<bool>,
    /// Dofs of pinned parts.
    pinned: Vec<usize>,
}

/// Supports and loads that a system is solved for.
pub(super) struct Case {
    /// Prescribed displacement of each dof [m].
    prescribed: Vec<Option<f64>>,
    /// f in the axes of the nodes [N].
    load: Vec<f64>,
}

/// A solution, dof by dof.
pub(super) struct Solved {
    /// u [m].
    pub displacement: Vec<f64>,
    /// K u [N].
    pub force: Vec<f64>,
    pub residual: Residual,
}

impl System {
    pub fn new(
        stiffness: LowerMatrix,
        boundary: &Boundary,
        pinned: &[Vec<usize>],
        mechanisms: &BTreeSet<usize>,
    ) -> System {
        let mut system = System {
            is_held: vec![false; stiffness.ncols()],
            norm: stiffness.infinity_norm(),
            stiffness,
            pinned: Vec::new(),
        };
        for &dof in boundary.prescribed.keys().chain(mechanisms) {
            system.is_held[dof] = true;
        }
        system.pin(pinned);
        system
    }

    /// Holds the nodes of parts, which only grow.
    pub fn pin(&mut self, parts: &[Vec<usize>]) {
        let nodes = parts.iter().flatten();
        self.pinned = nodes.flat_map(|&n| [2 * n, 2 * n + 1]).collect();
        self.pinned.iter().for_each(|&dof| self.is_held[dof] = true);
    }

    /// The supports and loads of a boundary, pinned parts held at zero.
    pub fn case(&self, boundary: &Boundary) -> Case {
        let mut prescribed = vec![None; boundary.load.len()];
        self.pinned
            .iter()
            .for_each(|&dof| prescribed[dof] = Some(0.0));
        for (&dof, &(value, _)) in &boundary.prescribed {
            prescribed[dof] = Some(value);
        }
        Case {
            prescribed,
            load: boundary.own_load(),
        }
    }

    /// Solves and refines. `guess`: displacements near the solution, by node [m].
    pub fn solve(
        &self,
        case: &Case,
        factor: &dyn Factorisation,
        guess: Option<&[[f64; 2]]>,
    ) -> Solved {
        let mut u: Vec<f64> = case.prescribed.iter().map(|p| p.unwrap_or(0.0)).collect();
        let mut force = self.stiffness.multiply(&u);
        let mut residual = case.residual(&force);
        let load = norm(&residual);
        if let Some(guess) = guess.filter(|_| load > 0.0 && factor.gains_by_guess()) {
            let free = u.iter_mut().zip(guess.as_flattened()).zip(&self.is_held);
            let free = free.filter(|(_, held)| !**held);
            free.for_each(|((u, guess), _)| *u = *guess);
            force = self.stiffness.multiply(&u);
            residual = case.residual(&force);
        }
        let goal = factor.residual_goal() * load;
        let is_reached = |residual: f64| residual < goal;
        let mut turn = 0;
        let mut now = norm(&residual);
        // Also for a residual that is not a number: the check that follows reports it.
        while turn <= MOST_REFINEMENTS && now != 0.0 && !is_reached(now) {
            let mut correction = residual.clone();
            factor.solve_in_place(&mut correction, &[0.5 * goal]);
            let refined: Vec<f64> = u.iter().zip(&correction).map(|(u, c)| u + c).collect();
            let refined_force = self.stiffness.multiply(&refined);
            let rest = case.residual(&refined_force);
            let next = norm(&rest);
            let better = next < now;
            if better || turn == 0 {
                (u, force, residual, now) = (refined, refined_force, rest, next);
            }
            if !better {
                break;
            }
            turn += 1;
        }
        Solved {
            residual: self.measure(&residual, load, &u),
            displacement: u,
            force,
        }
    }

    /// How well u [m] solves a case. `residual`: f − K u; `load`: ‖f‖₂ [N].
    pub fn measure(&self, residual: &[f64], load: f64, u: &[f64]) -> Residual {
        Residual {
            force: norm(residual),
            load,
            scale: self.norm * norm(u),
        }
    }

    /// f − K u at free dofs, zero at prescribed ones [N].
    pub fn residual(&self, case: &Case, u: &[f64]) -> Vec<f64> {
        case.residual(&self.stiffness.multiply(u))
    }

    /// ‖f‖₂ over the free dofs, prescribed displacements in f [N].
    pub fn load_norm(&self, case: &Case) -> f64 {
        let u: Vec<f64> = case.prescribed.iter().map(|p| p.unwrap_or(0.0)).collect();
        norm(&self.residual(case, &u)).max(f64::MIN_POSITIVE)
    }
}

impl Case {
    /// f − r at free dofs, zero at prescribed ones, where r = K u [N].
    pub fn residual(&self, force: &[f64]) -> Vec<f64> {
        let dofs = self.prescribed.iter().zip(&self.load).zip(force);
        dofs.map(|((prescribed, f), r)| if prescribed.is_some() { 0.0 } else { f - r })
            .collect()
    }

    /// r − f at prescribed dofs, by node, where r = K u [N].
    pub fn reaction(&self, force: &[f64]) -> Vec<[f64; 2]> {
        let dofs = self.prescribed.iter().zip(&self.load).zip(force);
        let reaction =
            dofs.map(|((prescribed, f), r)| if prescribed.is_some() { r - f } else { 0.0 });
        vectors(&reaction.collect::<Vec<f64>>())
    }
}

/// Numbers by dof as vectors by node.
pub(super) fn vectors(dofs: &[f64]) -> Vec<[f64; 2]> {
    dofs.chunks_exact(2).map(|d| [d[0], d[1]]).collect()
}

/// ‖v‖₂.
pub(super) fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}
