//! Sparse Cholesky factorisation K = L Lᵀ: symbolic once, numeric as often as K changes. Of a front,
//!
//! ```text
//! L11 L11ᵀ = A11,   L21 = A21 L11⁻ᵀ,   passed up: U = A22 − L21 L21ᵀ
//! ```

use super::compliance::UnitLoads;
use super::extend_add::Part;
use super::held::{Held, HeldColumns};
use super::multifrontal::{self, Child, Front, NotPositive, Pool};
use super::ordering::{Ordering, elimination_order};
use super::refactorisation::{self, Kept};
use super::supernodes::Supernodes;
use super::tiles::{self, PANEL};
use super::triangular::{self, Wanted};
use super::{Backend, FactorSize, Factorisation, SolverError, SymmetricSolver};
use crate::assembly::{Lists, LowerMatrix};
use faer::dyn_stack::{MemStack, StackReq};
use faer::sparse::SymbolicSparseColMatRef;
use faer::{Accum, MatMut};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

/// The least pivot L_jj² over K_jj. A singular K leaves pivots of rounding size, some 1e-16, of either
/// sign. A body that is held has larger ones: beam theory gives some 1e-10 for a cantilever a thousand
/// times as long as deep, and they fall with the cube of that ratio.
pub(super) const LEAST_PIVOT: f64 = 1e-13;

/// Rounding errors of a solution by factors, of its residual over its load [-].
pub(super) const RESIDUAL_GOAL: f64 = 1e-14;

/// The structure of L, from the pattern of K alone.
#[derive(Clone, Debug)]
pub struct Symbolic {
    structure: Arc<Supernodes>,
    spare: Spare,
    pool: Arc<Pool>,
}

/// The entries of a factor that is no longer needed, for the next one: to get fresh pages takes longer
/// than to fill them.
type Spare = Arc<Mutex<Option<Vec<f64>>>>;

impl Symbolic {
    /// # Errors
    /// See [`SolverError`].
    pub fn new(
        pattern: SymbolicSparseColMatRef<'_, u32>,
        graph: &Lists,
        ordering: Ordering,
    ) -> Result<Symbolic, SolverError> {
        let order = elimination_order(ordering, graph).map_err(|status| SolverError::Ordering {
            nodes: graph.len(),
            status,
        })?;
        Ok(Symbolic::with_order(pattern, &order))
    }

    /// `order`: the nodes as they are eliminated.
    pub fn with_order(pattern: SymbolicSparseColMatRef<'_, u32>, order: &[u32]) -> Symbolic {
        Symbolic {
            structure: Arc::new(Supernodes::new(pattern, order)),
            spare: Spare::default(),
            pool: Arc::default(),
        }
    }

    /// Stored entries of L; blocks of supernodes count whole.
    pub fn factor_entries(&self) -> usize {
        self.structure.entries()
    }

    /// Multiplications and additions of the numeric factorisation: w³/3 + w²r + wr² for each
    /// supernode of w columns with r rows below them.
    pub fn flops(&self) -> f64 {
        self.structure.total_flops()
    }

    /// L of a matrix with this pattern, on all threads.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`], [`SolverError::OutOfMemory`].
    pub fn factorise(&self, matrix: &LowerMatrix) -> Result<Factor, SolverError> {
        self.numeric(matrix, Held::NONE, &[])
    }

    /// The same of the matrix with some dofs held, to be followed by [`Factor::refactorise`]. `likely`: nodes near
    /// which K will change.
    ///
    /// # Errors
    /// As [`Symbolic::factorise`].
    pub fn factorise_held(
        &self,
        matrix: &LowerMatrix,
        held: Held,
        likely: &[u32],
    ) -> Result<Factor, SolverError> {
        let factor = self.numeric(matrix, held, &self.structure.above(likely));
        // What follows needs a little of it.
        self.pool.clear();
        factor
    }

    fn numeric(
        &self,
        matrix: &LowerMatrix,
        held: Held,
        parents: &[usize],
    ) -> Result<Factor, SolverError> {
        let spare = self
            .spare
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        let mut values = match spare {
            Some(values) => values,
            None => {
                super::zeros(self.factor_entries()).ok_or_else(|| SolverError::OutOfMemory {
                    dofs: matrix.ncols(),
                })?
            }
        };
        let structure = &self.structure;
        let fronts = Fronts {
            structure,
            matrix: matrix.val(),
            held: held.columns(structure),
        };
        let kept = multifrontal::factorise(structure, &fronts, &mut values, &self.pool, parents);
        Ok(Factor {
            kept: Kept::new(kept.map_err(|pivot| not_positive(structure, pivot))?),
            structure: structure.clone(),
            values,
            pool: self.pool.clone(),
            spare: self.spare.clone(),
        })
    }
}

fn not_positive(structure: &Supernodes, NotPositive(column): NotPositive) -> SolverError {
    SolverError::NotPositiveDefinite {
        dof: structure.dof(column),
    }
}

/// L.
#[derive(Clone, Debug)]
pub struct Factor {
    structure: Arc<Supernodes>,
    values: Vec<f64>,
    kept: Kept,
    pool: Arc<Pool>,
    spare: Spare,
}

impl Drop for Factor {
    fn drop(&mut self) {
        let mut spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner);
        *spare = Some(std::mem::take(&mut self.values));
    }
}

impl Factor {
    pub(super) fn values(&self) -> &[f64] {
        &self.values
    }

    pub(super) fn supernodes(&self) -> &Supernodes {
        &self.structure
    }

    /// Multiplications and additions of the supernodes of some nodes and those above them.
    pub fn flops_above(&self, nodes: &[u32]) -> f64 {
        let above = self.structure.above(nodes);
        above.into_iter().map(|s| self.structure.flops(s)).sum()
    }

    /// L of a matrix that differs between some nodes only: the same bits as of a whole factorisation.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`]: this is no factor until it has followed another change.
    pub fn refactorise(
        &mut self,
        matrix: &LowerMatrix,
        held: Held,
        nodes: &[u32],
    ) -> Result<(), SolverError> {
        let structure = &self.structure;
        let fronts = Fronts {
            structure,
            matrix: matrix.val(),
            held: held.columns(structure),
        };
        let path = structure.above(nodes);
        let (values, kept) = (&mut self.values, &mut self.kept);
        refactorisation::refactorise(structure, &fronts, values, &self.pool, kept, &path)
            .map_err(|pivot| not_positive(structure, pivot))
    }

    /// The column of L that eliminates a dof.
    pub fn column(&self, dof: usize) -> usize {
        self.structure.column(dof)
    }

    /// Overwrites `rhs`, right-hand sides one after the other, by K⁻¹ rhs: eight cost twice as much as one.
    pub fn solve_in_place(&self, rhs: &mut [f64]) {
        triangular::solve(&self.structure, &self.values, rhs, Wanted::All);
    }

    /// The same where only the unknowns of some nodes are asked for; the others may become nothing. Reads no more
    /// of L than what is above the nodes, and above those with forces.
    pub fn solve_at(&self, nodes: &[u32], rhs: &mut [f64]) {
        let mut wanted = vec![false; self.structure.n_supernodes()];
        for s in self.structure.above(nodes) {
            wanted[s] = true;
        }
        triangular::solve(&self.structure, &self.values, rhs, Wanted::Some(&wanted));
    }
}

impl SymmetricSolver for Symbolic {
    fn backend(&self) -> Backend {
        Backend::Multifrontal
    }

    fn size(&self) -> FactorSize {
        FactorSize {
            entries: self.factor_entries(),
            waiting_entries: self.structure.waiting_entries(),
            flops: self.flops(),
        }
    }

    fn factorise(
        &self,
        stiffness: &LowerMatrix,
        held: Held,
        likely: &[u32],
    ) -> Result<Box<dyn Factorisation>, SolverError> {
        Ok(Box::new(self.factorise_held(stiffness, held, likely)?))
    }
}

impl Factorisation for Factor {
    fn solve_in_place(&self, rhs: &mut [f64], _: &[f64]) {
        Factor::solve_in_place(self, rhs);
    }

    fn residual_goal(&self) -> f64 {
        RESIDUAL_GOAL
    }

    fn entries(&self) -> usize {
        self.values.len()
    }

    fn refactorise(
        &mut self,
        stiffness: &LowerMatrix,
        held: Held,
        nodes: &[u32],
    ) -> Result<bool, SolverError> {
        Factor::refactorise(self, stiffness, held, nodes).map(|()| true)
    }

    fn refactorisation_flops(&self, nodes: &[u32]) -> Option<f64> {
        Some(self.flops_above(nodes))
    }

    fn has_compliances(&self) -> bool {
        true
    }

    fn unit_loads(&self, dofs: &[usize], is_loaded: &dyn Fn(usize) -> bool) -> Option<UnitLoads> {
        Some(Factor::unit_loads(self, dofs, is_loaded))
    }

    fn elimination(&self, dof: usize) -> Option<usize> {
        Some(self.column(dof))
    }

    fn solve_at(&self, nodes: &[u32], rhs: &mut [f64]) -> bool {
        Factor::solve_at(self, nodes, rhs);
        true
    }
}

struct Fronts<'a> {
    structure: &'a Supernodes,
    /// Entries of K.
    matrix: &'a [f64],
    held: HeldColumns,
}

impl Front for Fronts<'_> {
    fn start(&self, s: usize) -> usize {
        self.structure.block_start(s)
    }

    fn scratch(&self, columns: usize) -> StackReq {
        tiles::cholesky_scratch(columns)
    }

    fn eliminate(
        &self,
        s: usize,
        block: &mut [f64],
        children: &[Child],
        update: &mut [f64],
        memory: &mut MemStack,
    ) -> Result<(), NotPositive> {
        let structure = self.structure;
        let (width, rows) = (structure.width(s), structure.rows(s).len());
        let height = width + rows;
        let mut diagonal = vec![0.0; width];
        for (column, diagonal) in diagonal.iter_mut().enumerate() {
            *diagonal = self.diagonal(s, column);
        }
        self.gather(s, block, children);
        let first = structure.columns(s).start;
        let mut l = MatMut::from_column_major_slice_mut(block, height, width);
        tiles::cholesky(l.as_mut(), memory).map_err(|column| NotPositive(first + column))?;
        for (j, &diagonal) in diagonal.iter().enumerate() {
            // False for a pivot that is not a number.
            let sound = l[(j, j)].powi(2) > LEAST_PIVOT * diagonal;
            if !sound {
                return Err(NotPositive(first + j));
            }
        }
        let l21 = l.as_ref().subrows(width, rows);
        let product = |passed: MatMut<f64>, first: usize| {
            tiles::subtract_square(passed, first, l21, Accum::Replace);
        };
        multifrontal::pass_up(children, width, rows, update, product);
        Ok(())
    }
}

impl Fronts<'_> {
    /// A front's columns: what is K's, and what children pass up.
    fn gather(&self, s: usize, block: &mut [f64], children: &[Child]) {
        let width = self.structure.width(s);
        let height = width + self.structure.rows(s).len();
        let columns = block.par_chunks_mut(PANEL * height).enumerate();
        columns.for_each(|(k, values)| {
            let columns = k * PANEL..width.min((k + 1) * PANEL);
            self.fill(s, columns.clone(), values);
            let part = Part {
                values,
                columns,
                first_row: 0,
                height,
            };
            multifrontal::add_children(children, part);
        });
    }

    fn diagonal(&self, s: usize, column: usize) -> f64 {
        let first = self.structure.columns(s).start + column - column % 2;
        let sources = self.structure.sources(first);
        let own = sources
            .iter()
            .find(|source| source.row as usize == column - column % 2);
        match own {
            _ if self.held.holds(first + column % 2) => self.held.diagonal,
            Some(own) => self.matrix[own.columns[column % 2] as usize],
            None => 0.0,
        }
    }

    /// K's entries in some columns of a supernode.
    fn fill(&self, s: usize, part: Range<usize>, block: &mut [f64]) {
        block.fill(0.0);
        let columns = self.structure.columns(s);
        let height = columns.len() + self.structure.rows(s).len();
        for (pair, pairs) in part
            .clone()
            .step_by(2)
            .zip(block.chunks_exact_mut(2 * height))
        {
            let first = columns.start + pair;
            let (left, right) = pairs.split_at_mut(height);
            for source in self.structure.sources(first) {
                let row = source.row as usize;
                let [a, b] = source.columns.map(|at| at as usize);
                if row == pair {
                    left[row] = self.matrix[a];
                    left[row + 1] = self.matrix[a + 1];
                    right[row + 1] = self.matrix[b];
                } else if source.transposed {
                    left[row] = self.matrix[a];
                    right[row] = self.matrix[a + 1];
                    left[row + 1] = self.matrix[b];
                    right[row + 1] = self.matrix[b + 1];
                } else {
                    left[row..row + 2].copy_from_slice(&self.matrix[a..a + 2]);
                    right[row..row + 2].copy_from_slice(&self.matrix[b..b + 2]);
                }
            }
        }
        for row in self.held.among(self.structure, s) {
            let own = part.start..part.end.min(row.max(part.start));
            own.for_each(|column| block[(column - part.start) * height + row] = 0.0);
            if part.contains(&row) {
                let column = &mut block[(row - part.start) * height..][..height];
                column[row..].fill(0.0);
                column[row] = self.held.diagonal;
            }
        }
    }
}
