//! K with its supports, factorised, for many solutions while interactions change.

use super::Solution;
use super::system::{System, norm, vectors};
use crate::boundary::Boundary;
use crate::linear_solver::Factorisation;
use crate::linear_solver::compliance::UnitLoads;
use crate::model::Model;

/// K with its supports, factorised; interactions that change later are rank-one changes of it.
pub struct Factorised {
    pub(super) system: System,
    pub(super) factor: Box<dyn Factorisation>,
    /// Stored entries of L.
    pub entries: usize,
    /// Multiplications and additions of a whole factorisation.
    pub flops: f64,
}

impl Factorised {
    /// Whether supports, a fragment or a mechanism hold a dof.
    pub fn is_held(&self, dof: usize) -> bool {
        self.system.is_held[dof]
    }

    /// L⁻¹ E of these dofs, nothing for held ones, if the backend has them.
    pub fn unit_loads(&self, dofs: &[usize]) -> Option<UnitLoads> {
        self.factor.unit_loads(dofs, &|dof| !self.is_held(dof))
    }

    /// The place of a dof in the order of elimination, if the backend has one.
    pub fn elimination(&self, dof: usize) -> Option<usize> {
        self.factor.elimination(dof)
    }

    /// Multiplications and additions that it takes to follow a change between these nodes, as
    /// [`Solver::refactorise`](super::Solver::refactorise) does.
    pub fn flops_above(&self, nodes: &[u32]) -> f64 {
        let flops = self.factor.refactorisation_flops(nodes);
        flops.unwrap_or(self.flops)
    }

    /// Overwrites forces [N] by the displacements [m] that they add, dof by dof, case after case.
    pub fn respond(&self, forces: &mut [f64]) {
        self.clear_held(forces);
        let goal = self.factor.residual_goal();
        let cases = forces.chunks_exact(self.dofs());
        let goals: Vec<f64> = cases.map(|case| goal * norm(case)).collect();
        self.factor.solve_in_place(forces, &goals);
        // Held dofs stand apart in the factor, so that this clears signed zeros only.
        self.clear_held(forces);
    }

    /// Does as [`Factorised::respond`] where only the displacements of some nodes are needed; those of others may
    /// be missing.
    pub fn respond_at(&self, nodes: &[u32], forces: &mut [f64]) {
        self.clear_held(forces);
        match self.factor.solve_at(nodes, forces) {
            true => self.clear_held(forces),
            false => self.respond(forces),
        }
    }

    fn clear_held(&self, forces: &mut [f64]) {
        for case in forces.chunks_exact_mut(self.dofs()) {
            let dofs = case.iter_mut().zip(&self.system.is_held);
            dofs.filter(|(_, held)| **held).for_each(|(f, _)| *f = 0.0);
        }
    }

    /// ‖f‖₂ of a case over the free dofs, prescribed displacements in f [N].
    pub fn load_norm(&self, case: &Boundary) -> f64 {
        self.system.load_norm(&self.system.case(case))
    }

    /// The solution of a case after interactions have changed, from the one before and its change [m]. `load`:
    /// ‖f‖₂ of the case [N]; `losses`: interactions, and the stiffness that each has lost [N/m].
    pub fn changed(
        &self,
        model: &Model,
        (case, load): (&Boundary, f64),
        before: &Solution,
        change: &[f64],
        losses: impl Iterator<Item = (usize, f64)>,
    ) -> Solution {
        let (interactions, positions) = (&model.interactions, &model.positions);
        let before_dofs = before.displacement.iter().flatten();
        let u: Vec<f64> = before_dofs.zip(change).map(|(u, c)| u + c).collect();
        let displacement = vectors(&u);
        let case = self.system.case(case);
        let mut force = self.force(&u);
        for (interaction, loss) in losses {
            let elongation = interactions.length(interaction, positions)
                * model.stretch(interaction, &displacement);
            let taken = -loss * elongation;
            add_interaction_force(&mut force, model, interaction, taken);
        }
        let residual = self.system.measure(&case.residual(&force), load, &u);
        Solution {
            displacement,
            reaction: case.reaction(&force),
            residual: residual.backward_error(),
            size: before.size,
        }
    }

    /// The number of unknowns.
    pub fn dofs(&self) -> usize {
        self.system.is_held.len()
    }

    /// Whether the response to changes of K follows from compliances of few dofs.
    pub fn has_compliances(&self) -> bool {
        self.factor.has_compliances()
    }

    /// K u [N].
    pub fn force(&self, displacement: &[f64]) -> Vec<f64> {
        self.system.stiffness.multiply(displacement)
    }
}

/// Adds f w to forces by dof.
fn add_interaction_force(force: &mut [f64], model: &Model, interaction: usize, f: f64) {
    model.for_each_term(interaction, |node, w| {
        let node = node as usize;
        force[2 * node] += f * w[0];
        force[2 * node + 1] += f * w[1];
    });
}
