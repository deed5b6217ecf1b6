//! What of K stays the same while bonds break: the elements' part, the pattern, the structure of the
//! factors. Symmetric for most couplings, full for the splice.

use crate::assembly::full::{Equations, FullPattern};
use crate::assembly::stiffness::Stiffness;
use crate::assembly::{ElementStiffness, Lists, Pattern};
use crate::linear_solver::ordering::{Ordering, elimination_order};
use crate::linear_solver::{Factor, SolverError, cholesky, lu};
use crate::model::Model;
use crate::phases::Phases;
use crate::springs::Springs;

pub(super) enum Structure {
    Symmetric {
        elements: Vec<ElementStiffness>,
        pattern: Pattern,
        symbolic: cholesky::Symbolic,
    },
    Full {
        equations: Vec<Equations>,
        pattern: FullPattern,
        symbolic: lu::Symbolic,
    },
}

impl Structure {
    /// # Errors
    /// [`SolverError::Ordering`], [`SolverError::OutOfMemory`].
    pub(super) fn new(model: &Model, phases: &mut Phases) -> Result<Structure, SolverError> {
        let nodes = model.node_count();
        let Some(splice) = &model.splice else {
            let elements = phases.measure("elements", || model.element_stiffness());
            let pattern =
                phases.measure("pattern", || Pattern::new(nodes, &model.springs, &elements));
            let order = phases.measure("ordering", || order(&pattern.graph))?;
            let symbolic = phases.measure("symbolic", || {
                cholesky::Symbolic::with_order(pattern.symbolic(), &order)
            });
            return Ok(Structure::Symmetric {
                elements,
                pattern,
                symbolic,
            });
        };
        let equations = phases.measure("elements", || model.equations(splice));
        let first_point = model.fe_node_count() as u32;
        let pattern = phases.measure("pattern", || {
            FullPattern::new(nodes, first_point, &model.springs, &equations)
        });
        let order = phases.measure("ordering", || order(&pattern.graph))?;
        let symbolic = phases.measure("symbolic", || {
            lu::Symbolic::new(pattern.symbolic(), pattern.symmetrised().as_ref(), &order)
        });
        Ok(Structure::Full {
            equations,
            pattern,
            symbolic,
        })
    }

    /// K with these springs.
    pub(super) fn assemble(&self, positions: &[[f64; 2]], springs: &Springs) -> Stiffness {
        match self {
            Structure::Symmetric {
                elements, pattern, ..
            } => Stiffness::Symmetric(pattern.assemble(positions, springs, elements)),
            Structure::Full {
                equations, pattern, ..
            } => Stiffness::Full(pattern.assemble(positions, springs, equations)),
        }
    }

    /// # Errors
    /// [`SolverError::NotPositiveDefinite`] or [`SolverError::Singular`] for a mechanism,
    /// [`SolverError::OutOfMemory`].
    pub(super) fn factorise(&self, stiffness: &Stiffness) -> Result<Factor, SolverError> {
        match (self, stiffness) {
            (Structure::Symmetric { symbolic, .. }, Stiffness::Symmetric(lower)) => {
                symbolic.factorise(lower).map(Factor::Cholesky)
            }
            (Structure::Full { symbolic, .. }, Stiffness::Full(full)) => symbolic
                .factorise(full)
                .map(|factor| Factor::Lu(Box::new(factor))),
            _ => unreachable!("a structure assembles its own form"),
        }
    }

    /// Stored entries of K.
    pub(super) fn stiffness_entries(&self) -> usize {
        match self {
            Structure::Symmetric { pattern, .. } => pattern.stored_entries(),
            Structure::Full { pattern, .. } => pattern.stored_entries(),
        }
    }

    /// Stored entries of L, or of L and U as long as pivots stay within their supernodes.
    pub(super) fn factor_entries(&self) -> usize {
        match self {
            Structure::Symmetric { symbolic, .. } => symbolic.factor_entries(),
            Structure::Full { symbolic, .. } => symbolic.factor_entries(),
        }
    }

    /// Multiplications and additions of a factorisation, under the same condition.
    pub(super) fn flops(&self) -> f64 {
        match self {
            Structure::Symmetric { symbolic, .. } => symbolic.flops(),
            Structure::Full { symbolic, .. } => symbolic.flops(),
        }
    }

    /// Indices of the springs with stiffness at a node.
    pub(super) fn springs_at(&self, node: usize) -> &[u32] {
        match self {
            Structure::Symmetric { pattern, .. } => pattern.springs_at(node),
            Structure::Full { pattern, .. } => pattern.springs_at(node),
        }
    }
}

fn order(graph: &Lists) -> Result<Vec<u32>, SolverError> {
    elimination_order(Ordering::Metis, graph).map_err(|status| SolverError::Ordering {
        nodes: graph.len(),
        status,
    })
}
