//! A solver for one model and its supports, which is kept while bonds break.

use super::error::{check, kind};
use super::structure::Structure;
use super::system::{Case, Solved, System, vectors};
use super::{Backend, Breaks, Estimate, Factorised, Solution, StaticsError, SystemSize};
use crate::boundary::Boundary;
use crate::linear_solver::held::HeldDofs;
use crate::linear_solver::{Factorisation, SolverError};
use crate::model::Model;
use crate::phases::{machine_memory, measure};
use std::collections::BTreeSet;

/// The part of a solve that stays the same while bonds break: elements, the pattern of K, the structure of L.
pub struct Solver<'a> {
    model: &'a Model,
    boundary: &'a Boundary,
    structure: Structure,
    /// The entry on the diagonal of held dofs, the same while bonds break [N/m].
    diagonal: f64,
}

impl<'a> Solver<'a> {
    /// A solver by the backend that suits the size of K.
    ///
    /// # Errors
    /// [`SolverError::Ordering`], [`SolverError::OutOfMemory`].
    pub fn new(model: &'a Model, boundary: &'a Boundary) -> Result<Solver<'a>, StaticsError> {
        Solver::with_backend(model, boundary, None)
    }

    /// A solver by this backend; `None` for the one that suits the size of K.
    ///
    /// # Errors
    /// [`SolverError::Ordering`], [`SolverError::OutOfMemory`].
    pub fn with_backend(
        model: &'a Model,
        boundary: &'a Boundary,
        backend: Option<Backend>,
    ) -> Result<Solver<'a>, StaticsError> {
        assert_eq!(
            model.node_axes, boundary.node_axes,
            "`Model::with_node_axes` has been given the supports' axes"
        );
        let structure = Structure::new(model, backend)?;
        Estimate::of(&structure, boundary, Breaks::Never, 0).fits(machine_memory())?;
        Ok(Solver {
            diagonal: structure.mean_diagonal(&model.interactions, boundary.load.len()),
            model,
            boundary,
            structure,
        })
    }

    pub fn size(&self) -> SystemSize {
        SystemSize {
            dofs: self.boundary.load.len(),
            stiffness_entries: self.structure.stiffness_entries(),
            factor_entries: self.structure.solver.size().entries,
            backend: self.structure.solver.backend(),
        }
    }

    /// Solves with the `integrity` φ of every interaction; the nodes of `pinned` parts, which nothing holds,
    /// do not move.
    ///
    /// # Errors
    /// See [`StaticsError`]; a mechanism is one.
    pub fn solve(
        &self,
        integrity: &[f64],
        pinned: &[Vec<usize>],
    ) -> Result<Solution, StaticsError> {
        let system = self.system(integrity, pinned, &BTreeSet::new());
        let factor = self.factorise(&system);
        let factor = factor.map_err(|error| self.locate(error))?;
        self.finish(&system, &system.case(self.boundary), &*factor, None)
    }

    /// Factorises K of a body in which bonds break, for [`Solver::solve_with`]. A chunk may hang on a hinge: K is
    /// positive semidefinite, so that a pivot vanishes where such a mechanism begins, and to hold that dof holds
    /// the chunk, without force if no load acts along the mechanism: the residual of the free system confirms it.
    /// `mechanisms` collects these dofs; since bonds never heal, they stay.
    ///
    /// # Errors
    /// See [`StaticsError`].
    pub fn factorise_broken(
        &self,
        integrity: &[f64],
        pinned: &[Vec<usize>],
        mechanisms: &mut BTreeSet<usize>,
    ) -> Result<Factorised, StaticsError> {
        loop {
            let system = self.system(integrity, pinned, mechanisms);
            match self.factorise(&system) {
                Ok(factor) => {
                    let size = self.structure.solver.size();
                    return Ok(Factorised {
                        system,
                        factor,
                        entries: size.entries,
                        flops: size.flops,
                    });
                }
                // The set grows with every turn, so that the loop ends.
                Err(SolverError::NotPositiveDefinite { dof }) if mechanisms.insert(dof) => {}
                Err(error) => return Err(self.locate(error)),
            }
        }
    }

    /// Brings a factorisation up to the `integrity` φ of now, which only `changed` interactions have changed
    /// to, and to parts that are pinned since: the bits of [`Solver::factorise_broken`]. False where K is to be
    /// factorised as a whole.
    ///
    /// # Errors
    /// See [`StaticsError`].
    pub fn refactorise(
        &self,
        factorised: &mut Factorised,
        changed: &[u32],
        integrity: &[f64],
        pinned: &[Vec<usize>],
        mechanisms: &mut BTreeSet<usize>,
    ) -> Result<bool, StaticsError> {
        let Model {
            interactions,
            positions,
            ..
        } = self.model;
        if !self.model.node_axes.is_empty() {
            // Columns are assembled anew in the axes of space.
            return Ok(false);
        }
        let Factorised { system, factor, .. } = factorised;
        let of_interaction = |&interaction: &u32| interactions.nodes(interaction as usize);
        let mut around: BTreeSet<u32> = changed.iter().flat_map(of_interaction).copied().collect();
        let nodes: Vec<u32> = around.iter().copied().collect();
        measure("assembly", || {
            let stiffness = &mut system.stiffness;
            (self.structure).reassemble(stiffness, &nodes, (positions, interactions), integrity);
        });
        let is_free = |node: &usize| [0, 1].iter().any(|axis| !system.is_held[2 * node + axis]);
        let new: Vec<usize> = pinned.iter().flatten().copied().filter(is_free).collect();
        new.iter()
            .for_each(|&node| self.add_around(&mut around, node));
        system.pin(pinned);
        let new = mechanisms.iter().filter(|&&dof| !system.is_held[dof]);
        for dof in new.copied().collect::<Vec<_>>() {
            system.is_held[dof] = true;
            self.add_around(&mut around, dof / 2);
        }
        loop {
            let held = HeldDofs {
                is_held: &system.is_held,
                diagonal: self.diagonal,
            };
            let nodes: Vec<u32> = around.iter().copied().collect();
            let done = measure("refactorisation", || {
                factor.refactorise(&system.stiffness, held, &nodes)
            });
            match done {
                Ok(is_done) => return Ok(is_done),
                // The set grows with every turn, so that the loop ends.
                Err(SolverError::NotPositiveDefinite { dof }) if mechanisms.insert(dof) => {
                    system.is_held[dof] = true;
                    around.clear();
                    self.add_around(&mut around, dof / 2);
                }
                Err(error) => return Err(self.locate(error)),
            }
        }
    }

    /// Adds a node and those with which it shares stiffness to some nodes.
    fn add_around(&self, nodes: &mut BTreeSet<u32>, node: usize) {
        nodes.insert(node as u32);
        nodes.extend(self.structure.graph().of(node));
    }

    /// Solves a case, which prescribes displacements on the same dofs. `guess`: displacements that may be
    /// near the solution [m], from which conjugate gradients start.
    ///
    /// # Errors
    /// See [`StaticsError`]; [`StaticsError::Swings`] where a load acts along a mechanism.
    pub fn solve_with(
        &self,
        factorised: &Factorised,
        case: &Boundary,
        guess: Option<&[[f64; 2]]>,
        mechanisms: &BTreeSet<usize>,
    ) -> Result<Solution, StaticsError> {
        let Factorised { system, factor, .. } = factorised;
        let solution = self.finish(system, &system.case(case), &**factor, guess);
        solution.map_err(|error| self.swings(error, mechanisms))
    }

    /// A residual means that a load acts along a mechanism, if there is one.
    fn swings(&self, error: StaticsError, mechanisms: &BTreeSet<usize>) -> StaticsError {
        match (error, mechanisms.last()) {
            (StaticsError::Residual { residual, .. }, Some(&dof)) => {
                let [x, y] = self.model.positions[dof / 2];
                StaticsError::Swings {
                    what: kind(self.model, dof / 2),
                    x,
                    y,
                    residual,
                }
            }
            (error, _) => error,
        }
    }

    /// K with the `integrity` φ of every interaction, and its supports.
    pub(super) fn system(
        &self,
        integrity: &[f64],
        pinned: &[Vec<usize>],
        mechanisms: &BTreeSet<usize>,
    ) -> System {
        let Solver {
            model,
            boundary,
            structure,
            ..
        } = self;
        let stiffness = measure("assembly", || structure.assemble(model, integrity));
        System::new(stiffness, boundary, pinned, mechanisms)
    }

    /// Factorises K with its supports.
    pub(super) fn factorise(&self, system: &System) -> Result<Box<dyn Factorisation>, SolverError> {
        let held = HeldDofs {
            is_held: &system.is_held,
            diagonal: self.diagonal,
        };
        // Nothing is kept before the first change: many runs never come to it.
        measure("factorisation", || {
            (self.structure.solver).factorise(&system.stiffness, held, &[])
        })
    }

    fn finish(
        &self,
        system: &System,
        case: &Case,
        factor: &dyn Factorisation,
        guess: Option<&[[f64; 2]]>,
    ) -> Result<Solution, StaticsError> {
        let Solved {
            displacement,
            force,
            residual,
        } = measure("solution", || system.solve(case, factor, guess));
        let solution = Solution {
            reaction: case.reaction(&force),
            displacement: vectors(&displacement),
            residual: residual.backward_error(),
            size: SystemSize {
                factor_entries: factor.entries(),
                ..self.size()
            },
        };
        check(self.model, &solution, residual, factor.residual_goal())?;
        Ok(solution)
    }

    fn locate(&self, error: SolverError) -> StaticsError {
        let SolverError::NotPositiveDefinite { dof } = error else {
            return error.into();
        };
        let node = dof / 2;
        let [x, y] = self.model.positions[node];
        StaticsError::Mechanism {
            what: kind(self.model, node),
            x,
            y,
            interactions: self.interactions_at(node),
        }
    }

    /// The number of interactions with stiffness that act on a node.
    fn interactions_at(&self, node: usize) -> usize {
        let interactions = &self.model.interactions;
        let acts = |&s: &usize| {
            interactions.stiffness[s] != 0.0 && interactions.nodes(s).contains(&(node as u32))
        };
        interactions.axial().filter(acts).count()
    }
}
