//! The part of a system that stays the same while bonds break: the elements' stiffness, the pattern of K, the
//! structure of its factors.

mod cells;

use crate::assembly::{ElementStiffness, Lists, LowerMatrix, Pattern, UNKNOWNS};
use crate::interactions::Interactions;
use crate::linear_solver::ordering::{Ordering, elimination_order};
use crate::linear_solver::two_level::Coarsening;
use crate::linear_solver::{Backend, SolverError, SymmetricSolver, cholesky, faer};
use crate::model::Model;
use crate::phases::measure;

/// The elements' stiffness, the pattern of K, and the backend that has analysed it.
pub(super) struct Structure {
    elements: Vec<ElementStiffness>,
    pattern: Pattern,
    pub solver: Box<dyn SymmetricSolver>,
}

impl Structure {
    /// `backend`: `None` for the one that suits the size of K.
    ///
    /// # Errors
    /// [`SolverError::Ordering`], [`SolverError::OutOfMemory`].
    pub(super) fn new(model: &Model, backend: Option<Backend>) -> Result<Structure, SolverError> {
        let nodes = model.node_count();
        let elements = measure("elements", || model.element_stiffness());
        let pattern = measure("pattern", || {
            Pattern::new(nodes, &model.interactions, &elements)
        });
        let solver: Box<dyn SymmetricSolver> =
            match backend.unwrap_or_else(|| Backend::choose::<UNKNOWNS>(&pattern.graph)) {
                Backend::Multifrontal => {
                    let order = measure("ordering", || order(&pattern.graph))?;
                    Box::new(measure("symbolic", || {
                        cholesky::Symbolic::<UNKNOWNS>::with_order(pattern.symbolic(), &order)
                    }))
                }
                Backend::Faer => {
                    let order = measure("ordering", || order(&pattern.graph))?;
                    Box::new(measure("symbolic", || {
                        faer::Symbolic::with_order::<UNKNOWNS>(pattern.symbolic(), &order)
                    })?)
                }
                Backend::TwoLevel => Box::new(Coarsening {
                    graph: pattern.graph.clone(),
                    cells: cells::cells(model),
                    positions: model.positions.clone(),
                }),
            };
        Ok(Structure {
            elements,
            pattern,
            solver,
        })
    }

    /// K with the integrity φ of every interaction, in the axes of the nodes.
    pub(super) fn assemble(&self, model: &Model, integrity: &[f64]) -> LowerMatrix {
        let integrity = |interaction: usize| integrity[interaction];
        let (interactions, positions) = (&model.interactions, &model.positions);
        let mut stiffness =
            (self.pattern).assemble_with(positions, interactions, integrity, &self.elements);
        stiffness.turn(&model.node_axes);
        stiffness
    }

    /// Brings the columns of some nodes up to the integrity φ of now.
    pub(super) fn reassemble(
        &self,
        stiffness: &mut LowerMatrix,
        nodes: &[u32],
        (positions, interactions): (&[[f64; 2]], &Interactions),
        integrity: &[f64],
    ) {
        let integrity = |interaction: usize| integrity[interaction];
        let elements = &self.elements;
        (self.pattern).reassemble(
            stiffness,
            nodes,
            positions,
            interactions,
            integrity,
            elements,
        );
    }

    /// The nodes with which each node shares stiffness.
    pub(super) fn graph(&self) -> &Lists {
        &self.pattern.graph
    }

    /// A mean of K's diagonal, the same whatever has broken: the scale of K [N/m].
    pub(super) fn mean_diagonal(&self, interactions: &Interactions, dofs: usize) -> f64 {
        let of_interactions: f64 = interactions.stiffness.iter().map(|k| 2.0 * k).sum();
        let elements = self.elements.iter();
        let own: f64 = elements.map(|element| element.matrix.trace()).sum();
        (of_interactions + own) / dofs as f64
    }

    /// Stored entries of K.
    pub(super) fn stiffness_entries(&self) -> usize {
        self.pattern.stored_entries()
    }
}

fn order(graph: &Lists) -> Result<Vec<u32>, SolverError> {
    elimination_order(Ordering::Metis, graph).map_err(|status| SolverError::Ordering {
        nodes: graph.len(),
        status,
    })
}
