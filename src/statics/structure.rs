//! What of K stays the same while bonds break: the elements' part, the pattern, the structure of the
//! factors.

mod cells;

use crate::assembly::{ElementStiffness, Lists, LowerMatrix, Pattern};
use crate::interactions::Interactions;
use crate::linear_solver::held::Held;
use crate::linear_solver::ordering::{Ordering, elimination_order};
use crate::linear_solver::two_level::TwoLevel;
use crate::linear_solver::{Factor, Method, SolverError, cholesky, expected_factor_entries};
use crate::model::Model;
use crate::phases::Phases;

pub(super) struct Structure {
    elements: Vec<ElementStiffness>,
    pattern: Pattern,
    way: Way,
}

/// How K is solved with.
enum Way {
    Direct(cholesky::Symbolic),
    /// The cells of the nodes in which they may share an aggregate.
    TwoLevel(Vec<u32>),
}

impl Structure {
    /// `method`: `None`: whichever its size suggests.
    ///
    /// # Errors
    /// [`SolverError::Ordering`], [`SolverError::OutOfMemory`].
    pub(super) fn new(
        model: &Model,
        method: Option<Method>,
        phases: &mut Phases,
    ) -> Result<Structure, SolverError> {
        let nodes = model.node_count();
        let elements = phases.measure("elements", || model.element_stiffness());
        let pattern = phases.measure("pattern", || Pattern::new(nodes, &model.springs, &elements));
        let way = match method.unwrap_or_else(|| Method::choose(&pattern.graph)) {
            Method::Direct => {
                let order = phases.measure("ordering", || order(&pattern.graph))?;
                Way::Direct(phases.measure("symbolic", || {
                    cholesky::Symbolic::with_order(pattern.symbolic(), &order)
                }))
            }
            Method::TwoLevel => Way::TwoLevel(cells::cells(model)),
        };
        Ok(Structure {
            elements,
            pattern,
            way,
        })
    }

    /// K with the integrity φ of every interaction, in the axes of the nodes.
    pub(super) fn assemble(&self, model: &Model, integrity: &[f64]) -> LowerMatrix {
        let integrity = |spring: usize| integrity[spring];
        let (springs, positions) = (&model.springs, &model.positions);
        let mut stiffness =
            (self.pattern).assemble_with(positions, springs, integrity, &self.elements);
        stiffness.turn(&model.node_axes);
        stiffness
    }

    /// Brings the columns of some nodes up to the integrity φ of now.
    pub(super) fn reassemble(
        &self,
        stiffness: &mut LowerMatrix,
        nodes: &[u32],
        (positions, springs): (&[[f64; 2]], &Interactions),
        integrity: &[f64],
    ) {
        let integrity = |spring: usize| integrity[spring];
        let elements = &self.elements;
        (self.pattern).reassemble(stiffness, nodes, positions, springs, integrity, elements);
    }

    /// What to solve with, given which dofs are held. `likely`: nodes near which K will change, if it is to be
    /// followed.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`] for a mechanism, [`SolverError::OutOfMemory`].
    pub(super) fn factorise(
        &self,
        positions: &[[f64; 2]],
        stiffness: &LowerMatrix,
        held: Held,
        likely: &[u32],
    ) -> Result<Factor, SolverError> {
        match &self.way {
            Way::Direct(symbolic) => {
                (symbolic.factorise_held(stiffness, held, likely)).map(Factor::Cholesky)
            }
            Way::TwoLevel(cells) => {
                TwoLevel::new(stiffness, &self.pattern.graph, cells, positions, held.dofs)
                    .map(|solver| Factor::TwoLevel(Box::new(solver)))
            }
        }
    }

    /// Who shares stiffness with whom.
    pub(super) fn graph(&self) -> &Lists {
        &self.pattern.graph
    }

    /// Some mean of K's diagonal, the same whatever has broken: its scale [N/m].
    pub(super) fn mean_diagonal(&self, springs: &Interactions, dofs: usize) -> f64 {
        let of_springs: f64 = springs.stiffness.iter().map(|k| 2.0 * k).sum();
        let elements = self.elements.iter();
        let own: f64 = elements.map(|element| element.matrix.trace()).sum();
        (of_springs + own) / dofs as f64
    }

    pub(super) fn method(&self) -> Method {
        match self.way {
            Way::Direct(_) => Method::Direct,
            Way::TwoLevel(_) => Method::TwoLevel,
        }
    }

    /// Stored entries of K.
    pub(super) fn stiffness_entries(&self) -> usize {
        self.pattern.stored_entries()
    }

    /// Stored entries of L; zero where there is none.
    pub(super) fn factor_entries(&self) -> usize {
        self.symbolic()
            .map_or(0, cholesky::Symbolic::factor_entries)
    }

    /// Entries that a factorisation holds beside those of its factors.
    pub(super) fn waiting_entries(&self) -> usize {
        self.symbolic()
            .map_or(0, cholesky::Symbolic::waiting_entries)
    }

    /// What L of the coarse level may have: a guess, aggregates being all connected to those around them.
    pub(super) fn expected_coarse_entries(&self) -> usize {
        let Way::TwoLevel(cells) = &self.way else {
            return 0;
        };
        let is_first = |&(node, cell): &(usize, &u32)| node == *cell as usize;
        let aggregates = cells.iter().enumerate().filter(is_first).count();
        // Eight around each, four dofs for two.
        (4.0 * expected_factor_entries(aggregates, 8 * aggregates)) as usize
    }

    /// Multiplications and additions of a factorisation.
    pub(super) fn flops(&self) -> f64 {
        self.symbolic().map_or(0.0, cholesky::Symbolic::flops)
    }

    fn symbolic(&self) -> Option<&cholesky::Symbolic> {
        match &self.way {
            Way::Direct(symbolic) => Some(symbolic),
            Way::TwoLevel(_) => None,
        }
    }
}

fn order(graph: &Lists) -> Result<Vec<u32>, SolverError> {
    elimination_order(Ordering::Metis, graph).map_err(|status| SolverError::Ordering {
        nodes: graph.len(),
        status,
    })
}
