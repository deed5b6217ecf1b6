//! One static solve, without artificial damping: K U = R, Qian et al. (2021), eq. (11).

mod estimate;
mod factorised;
mod residual;
mod structure;
mod system;

use crate::boundary::Boundary;
use crate::linear_solver::held::Held;
use crate::linear_solver::{Factorisation, SolverError};
use crate::model::Model;
use crate::model::node_axes::direction;
use crate::phases::{Phases, machine_memory};
use crate::support::{self, NotHeld};
use residual::Residual;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use structure::Structure;
use system::{Case, Solved, System, vectors};
use thiserror::Error;

pub use crate::linear_solver::Backend;
pub use estimate::Estimate;
pub use factorised::Factorised;

/// Displacements of all nodes, and what holds them; from a [`Solver`] in the axes of the nodes
/// ([`crate::model::node_axes`]), from [`solve`] along x and y.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Solution {
    /// u of every node [m].
    pub displacement: Vec<[f64; 2]>,
    /// Force that the supports exert at every node [N]; zero where nothing is prescribed.
    pub reaction: Vec<[f64; 2]>,
    /// Normwise backward error ‖f − K u‖ / (‖K‖ ‖u‖ + ‖f‖) [-], see `statics/residual.rs`.
    pub residual: f64,
    pub size: SystemSize,
}

/// Sizes of the linear system.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct SystemSize {
    pub dofs: usize,
    /// Stored entries of the lower triangle of K.
    pub stiffness_entries: usize,
    /// Stored entries of L; of the coarse level's where the system is solved on two levels.
    pub factor_entries: usize,
    pub backend: Backend,
}

#[derive(Debug, Error)]
pub enum StaticsError {
    #[error(transparent)]
    NotHeld(#[from] NotHeld),
    #[error(transparent)]
    Solver(#[from] SolverError),
    #[error(
        "{what} at ({x:.6e}, {y:.6e}) m is not held in every direction: {interactions} bonds or trusses \
         with stiffness end there"
    )]
    Mechanism {
        what: &'static str,
        x: f64,
        y: f64,
        interactions: usize,
    },
    #[error(
        "what hangs on {what} at ({x:.6e}, {y:.6e}) m swings freely under its load: the residual \
         is {residual:.1e}"
    )]
    Swings {
        what: &'static str,
        x: f64,
        y: f64,
        residual: f64,
    },
    #[error("the solution is not finite at {what} ({x:.6e}, {y:.6e}) m")]
    NotFinite { what: &'static str, x: f64, y: f64 },
    #[error(
        "the solution leaves a residual of {residual:.1e}, more than {limit:.0e}: the system is close to singular"
    )]
    Residual { residual: f64, limit: f64 },
    #[error(
        "the solution of {dofs} equations needs {:.1} GB, and the machine has {:.1}",
        *.bytes as f64 / 1e9, *.machine as f64 / 1e9
    )]
    Memory {
        dofs: usize,
        bytes: u64,
        machine: u64,
    },
}

/// Assembles and solves once, initial cracks open.
///
/// # Errors
/// See [`StaticsError`].
pub fn solve(
    model: &Model,
    boundary: &Boundary,
    phases: &mut Phases,
) -> Result<Solution, StaticsError> {
    solve_by(model, boundary, None, phases)
}

/// The same by a given backend.
///
/// # Errors
/// See [`StaticsError`].
pub fn solve_by(
    model: &Model,
    boundary: &Boundary,
    backend: Option<Backend>,
    phases: &mut Phases,
) -> Result<Solution, StaticsError> {
    let unsupported = phases.measure("support", || {
        support::check(model, boundary)?;
        Ok::<_, NotHeld>(support::loose_parts(model, boundary, &model.integrity))
    })?;
    let pinned: Vec<Vec<usize>> = unsupported.into_iter().map(|part| part.nodes).collect();
    let solver = Solver::with_backend(model, boundary, backend, phases)?;
    let solution = solver.solve(&model.integrity, &pinned, phases)?;
    Ok(Solution {
        displacement: model.in_space(&solution.displacement),
        reaction: model.in_space(&solution.reaction),
        ..solution
    })
}

/// What stays the same while bonds break: elements, the pattern of K, the structure of L.
pub struct Solver<'a> {
    model: &'a Model,
    boundary: &'a Boundary,
    structure: Structure,
    /// What stands on the diagonal of held dofs: the same while bonds break [N/m].
    diagonal: f64,
}

impl<'a> Solver<'a> {
    /// # Errors
    /// [`SolverError::Ordering`], [`SolverError::OutOfMemory`].
    pub fn new(
        model: &'a Model,
        boundary: &'a Boundary,
        phases: &mut Phases,
    ) -> Result<Solver<'a>, StaticsError> {
        Solver::with_backend(model, boundary, None, phases)
    }

    /// Solves by this backend; `None`: by the one that suits the size of K.
    ///
    /// # Errors
    /// [`SolverError::Ordering`], [`SolverError::OutOfMemory`].
    pub fn with_backend(
        model: &'a Model,
        boundary: &'a Boundary,
        backend: Option<Backend>,
        phases: &mut Phases,
    ) -> Result<Solver<'a>, StaticsError> {
        assert_eq!(
            model.node_axes, boundary.node_axes,
            "`Model::with_node_axes` has been given the supports' axes"
        );
        let structure = Structure::new(model, backend, phases)?;
        Estimate::of(&structure, boundary, 0).fits(machine_memory())?;
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
        phases: &mut Phases,
    ) -> Result<Solution, StaticsError> {
        let system = self.system(integrity, pinned, &BTreeSet::new(), phases);
        let factor = self.factorise(&system, phases);
        let factor = factor.map_err(|error| self.locate(error))?;
        self.finish(&system, &system.case(self.boundary), &*factor, None, phases)
    }

    /// The same for a body in which bonds break, under each of `cases`, which prescribe displacements
    /// on the same dofs. A chunk may hang on a hinge: K is positive semidefinite, so that a pivot
    /// vanishes where such a mechanism begins, and
    /// holding that dof holds it: without force, if no load acts along it, which the residual of the free
    /// system tells. `mechanisms` collects these dofs;
    /// since bonds never heal, they stay.
    ///
    /// # Errors
    /// See [`StaticsError`]; [`StaticsError::Swings`] where a load acts along a mechanism.
    pub fn solve_broken(
        &self,
        cases: &[&Boundary],
        integrity: &[f64],
        pinned: &[Vec<usize>],
        mechanisms: &mut BTreeSet<usize>,
        phases: &mut Phases,
    ) -> Result<Vec<Solution>, StaticsError> {
        let factorised = self.factorise_broken(integrity, pinned, mechanisms, phases)?;
        let solve = |case: &&Boundary| self.solve_with(&factorised, case, None, mechanisms, phases);
        cases.iter().map(solve).collect()
    }

    /// What [`Solver::solve_broken`] solves with.
    ///
    /// # Errors
    /// See [`StaticsError`].
    pub fn factorise_broken(
        &self,
        integrity: &[f64],
        pinned: &[Vec<usize>],
        mechanisms: &mut BTreeSet<usize>,
        phases: &mut Phases,
    ) -> Result<Factorised, StaticsError> {
        loop {
            let system = self.system(integrity, pinned, mechanisms, phases);
            match self.factorise(&system, phases) {
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
    /// to, and to parts that are pinned since: the bits of [`Solver::factorise_broken`]. False where K is to be factorised as
    /// a whole.
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
        phases: &mut Phases,
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
        phases.measure("assembly", || {
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
            let held = Held {
                dofs: &system.is_held,
                diagonal: self.diagonal,
            };
            let nodes: Vec<u32> = around.iter().copied().collect();
            let done = phases.measure("refactorisation", || {
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

    /// Adds a node and those with which it shares stiffness.
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
        phases: &mut Phases,
    ) -> Result<Solution, StaticsError> {
        let Factorised { system, factor, .. } = factorised;
        let solution = self.finish(system, &system.case(case), &**factor, guess, phases);
        solution.map_err(|error| self.swings(error, mechanisms))
    }

    /// A residual where dofs are held that nothing but a mechanism lets go.
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

    fn system(
        &self,
        integrity: &[f64],
        pinned: &[Vec<usize>],
        mechanisms: &BTreeSet<usize>,
        phases: &mut Phases,
    ) -> System {
        let Solver {
            model,
            boundary,
            structure,
            ..
        } = self;
        let stiffness = phases.measure("assembly", || structure.assemble(model, integrity));
        System::new(stiffness, boundary, pinned, mechanisms)
    }

    fn factorise(
        &self,
        system: &System,
        phases: &mut Phases,
    ) -> Result<Box<dyn Factorisation>, SolverError> {
        let held = Held {
            dofs: &system.is_held,
            diagonal: self.diagonal,
        };
        // Nothing is kept before the first change: many runs never come to it.
        phases.measure("factorisation", || {
            (self.structure.solver).factorise(&system.stiffness, held, &[])
        })
    }

    fn finish(
        &self,
        system: &System,
        case: &Case,
        factor: &dyn Factorisation,
        guess: Option<&[[f64; 2]]>,
        phases: &mut Phases,
    ) -> Result<Solution, StaticsError> {
        let Solved {
            displacement,
            force,
            residual,
        } = phases.measure("solution", || system.solve(case, factor, guess));
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
}

impl Solver<'_> {
    /// How many interactions with stiffness act on a node.
    fn interactions_at(&self, node: usize) -> usize {
        let interactions = &self.model.interactions;
        let acts = |&s: &usize| {
            interactions.stiffness[s] != 0.0 && interactions.nodes(s).contains(&(node as u32))
        };
        (0..interactions.len()).filter(acts).count()
    }
}

fn check(
    model: &Model,
    solution: &Solution,
    residual: Residual,
    goal: f64,
) -> Result<(), StaticsError> {
    let finite = |u: &[f64; 2]| u[0].is_finite() && u[1].is_finite();
    if let Some(node) = solution.displacement.iter().position(|u| !finite(u)) {
        let [x, y] = model.positions[node];
        return Err(StaticsError::NotFinite {
            what: kind(model, node),
            x,
            y,
        });
    }
    match residual.violation(goal) {
        Some((residual, limit)) => Err(StaticsError::Residual { residual, limit }),
        None => Ok(()),
    }
}

fn kind(model: &Model, node: usize) -> &'static str {
    if node < model.fe_node_count() {
        "the finite-element node"
    } else {
        "the material point"
    }
}

/// Sum of the nodes' reactions on each group that prescribes a displacement, from those along x and y [N].
pub fn group_reactions(boundary: &Boundary, reaction: &[[f64; 2]]) -> BTreeMap<String, [f64; 2]> {
    let mut sums: BTreeMap<String, [f64; 2]> = BTreeMap::new();
    for (&dof, (_, group)) in &boundary.prescribed {
        let sum = sums.entry(group.clone()).or_default();
        let [x, y] = direction(&boundary.node_axes, dof);
        let along = x * reaction[dof / 2][0] + y * reaction[dof / 2][1];
        *sum = [sum[0] + along * x, sum[1] + along * y];
    }
    sums
}
