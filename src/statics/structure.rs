//! What of K stays the same while bonds break: the elements' part, the pattern, the structure of the
//! factors. Symmetric for most couplings, full for the splice.

mod cells;

use crate::assembly::full::{Equations, FullPattern};
use crate::assembly::stiffness::Stiffness;
use crate::assembly::{ElementStiffness, Lists, Pattern};
use crate::linear_solver::held::Held;
use crate::linear_solver::ordering::{Ordering, elimination_order};
use crate::linear_solver::two_level::TwoLevel;
use crate::linear_solver::{Factor, Method, SolverError, cholesky, expected_factor_entries, lu};
use crate::model::Model;
use crate::phases::Phases;
use crate::springs::Springs;

pub(super) enum Structure {
    Symmetric {
        elements: Vec<ElementStiffness>,
        pattern: Pattern,
        way: Way,
    },
    Full {
        equations: Vec<Equations>,
        pattern: FullPattern,
        symbolic: lu::Symbolic,
    },
}

/// How a symmetric K is solved with.
pub(super) enum Way {
    Direct(cholesky::Symbolic),
    /// The cells of the nodes in which they may share an aggregate.
    TwoLevel(Vec<u32>),
}

impl Structure {
    /// `method`: where K is symmetric; `None`: whichever its size suggests.
    ///
    /// # Errors
    /// [`SolverError::Ordering`], [`SolverError::OutOfMemory`].
    pub(super) fn new(
        model: &Model,
        method: Option<Method>,
        phases: &mut Phases,
    ) -> Result<Structure, SolverError> {
        let nodes = model.node_count();
        let Some(splice) = &model.splice else {
            let elements = phases.measure("elements", || model.element_stiffness());
            let pattern =
                phases.measure("pattern", || Pattern::new(nodes, &model.springs, &elements));
            let way = match method.unwrap_or_else(|| Method::choose(&pattern.graph)) {
                Method::Direct => {
                    let order = phases.measure("ordering", || order(&pattern.graph))?;
                    Way::Direct(phases.measure("symbolic", || {
                        cholesky::Symbolic::with_order(pattern.symbolic(), &order)
                    }))
                }
                Method::TwoLevel => Way::TwoLevel(cells::cells(model)),
            };
            return Ok(Structure::Symmetric {
                elements,
                pattern,
                way,
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

    /// K with the springs that are intact, in the axes of the nodes.
    pub(super) fn assemble(&self, model: &Model, intact: &[bool]) -> Stiffness {
        let is_intact = |spring: usize| intact[spring];
        let (springs, positions) = (&model.springs, &model.positions);
        let mut stiffness = match self {
            Structure::Symmetric {
                elements, pattern, ..
            } => Stiffness::Symmetric(
                pattern.assemble_intact(positions, springs, is_intact, elements),
            ),
            Structure::Full {
                equations, pattern, ..
            } => Stiffness::Full(pattern.assemble_intact(positions, springs, is_intact, equations)),
        };
        stiffness.turn(&model.node_axes);
        stiffness
    }

    /// Brings the columns of some nodes up to the springs that are intact.
    pub(super) fn reassemble(
        &self,
        stiffness: &mut Stiffness,
        nodes: &[u32],
        (positions, springs): (&[[f64; 2]], &Springs),
        intact: &[bool],
    ) {
        let is_intact = |spring: usize| intact[spring];
        match (self, stiffness) {
            (
                Structure::Symmetric {
                    elements, pattern, ..
                },
                Stiffness::Symmetric(lower),
            ) => pattern.reassemble(lower, nodes, positions, springs, is_intact, elements),
            (
                Structure::Full {
                    equations, pattern, ..
                },
                Stiffness::Full(full),
            ) => pattern.reassemble(full, nodes, positions, springs, is_intact, equations),
            _ => unreachable!("a structure assembles its own form"),
        }
    }

    /// What to solve with, given which dofs are held. `likely`: nodes near which K will change, if it is to be
    /// followed.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`] or [`SolverError::Singular`] for a mechanism,
    /// [`SolverError::OutOfMemory`].
    pub(super) fn factorise(
        &self,
        positions: &[[f64; 2]],
        stiffness: &Stiffness,
        held: Held,
        likely: &[u32],
    ) -> Result<Factor, SolverError> {
        match (self, stiffness) {
            (
                Structure::Symmetric {
                    way: Way::Direct(symbolic),
                    ..
                },
                Stiffness::Symmetric(lower),
            ) => (symbolic.factorise_held(lower, held, likely)).map(Factor::Cholesky),
            (
                Structure::Symmetric {
                    way: Way::TwoLevel(cells),
                    pattern,
                    ..
                },
                Stiffness::Symmetric(lower),
            ) => TwoLevel::new(lower, &pattern.graph, cells, positions, held.dofs)
                .map(|solver| Factor::TwoLevel(Box::new(solver))),
            (Structure::Full { symbolic, .. }, Stiffness::Full(full)) => symbolic
                .factorise_held(full, held, likely)
                .map(|factor| Factor::Lu(Box::new(factor))),
            _ => unreachable!("a structure assembles its own form"),
        }
    }

    /// Who shares stiffness with whom.
    pub(super) fn graph(&self) -> &Lists {
        match self {
            Structure::Symmetric { pattern, .. } => &pattern.graph,
            Structure::Full { pattern, .. } => &pattern.graph,
        }
    }

    /// Some mean of K's diagonal, the same whatever has broken: its scale [N/m].
    pub(super) fn mean_diagonal(&self, springs: &Springs, dofs: usize) -> f64 {
        let of_springs: f64 = springs.stiffness.iter().map(|k| 2.0 * k).sum();
        let own: f64 = match self {
            Structure::Symmetric { elements, .. } => {
                elements.iter().map(|element| element.matrix.trace()).sum()
            }
            Structure::Full { .. } => 0.0,
        };
        (of_springs + own) / dofs as f64
    }

    pub(super) fn method(&self) -> Method {
        match self {
            Structure::Symmetric {
                way: Way::TwoLevel(_),
                ..
            } => Method::TwoLevel,
            _ => Method::Direct,
        }
    }

    /// Stored entries of K.
    pub(super) fn stiffness_entries(&self) -> usize {
        match self {
            Structure::Symmetric { pattern, .. } => pattern.stored_entries(),
            Structure::Full { pattern, .. } => pattern.stored_entries(),
        }
    }

    /// Stored entries of L, or of L and U as long as pivots stay within their supernodes; zero where there
    /// is none.
    pub(super) fn factor_entries(&self) -> usize {
        match self {
            Structure::Symmetric {
                way: Way::Direct(symbolic),
                ..
            } => symbolic.factor_entries(),
            Structure::Symmetric { .. } => 0,
            Structure::Full { symbolic, .. } => symbolic.factor_entries(),
        }
    }

    /// Entries that a factorisation holds beside those of its factors.
    pub(super) fn waiting_entries(&self) -> usize {
        match self {
            Structure::Symmetric {
                way: Way::Direct(symbolic),
                ..
            } => symbolic.waiting_entries(),
            Structure::Symmetric { .. } => 0,
            Structure::Full { symbolic, .. } => symbolic.waiting_entries(),
        }
    }

    /// What L of the coarse level may have: a guess, aggregates being all connected to those around them.
    pub(super) fn expected_coarse_entries(&self) -> usize {
        let Structure::Symmetric {
            way: Way::TwoLevel(cells),
            ..
        } = self
        else {
            return 0;
        };
        let is_first = |&(node, cell): &(usize, &u32)| node == *cell as usize;
        let aggregates = cells.iter().enumerate().filter(is_first).count();
        // Eight around each, four dofs for two.
        (4.0 * expected_factor_entries(aggregates, 8 * aggregates)) as usize
    }

    /// Multiplications and additions of a factorisation, under the same condition.
    pub(super) fn flops(&self) -> f64 {
        match self {
            Structure::Symmetric {
                way: Way::Direct(symbolic),
                ..
            } => symbolic.flops(),
            Structure::Symmetric { .. } => 0.0,
            Structure::Full { symbolic, .. } => symbolic.flops(),
        }
    }
}

fn order(graph: &Lists) -> Result<Vec<u32>, SolverError> {
    elimination_order(Ordering::Metis, graph).map_err(|status| SolverError::Ordering {
        nodes: graph.len(),
        status,
    })
}
