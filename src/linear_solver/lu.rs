//! Sparse LU factorisation for a K that is not symmetric: symbolic once, numeric as often as K changes.
//!
//! Fronts are those of K + Kᵀ, and pivots are sought among a supernode's own rows only: most of K is
//! symmetric and positive, so that they are good enough nearly always. Of a front,
//!
//! ```text
//! P A11 = L11 U11,   L21 = A21 U11⁻¹,   U12 = L11⁻¹ P A12,   passed up: U = A22 − L21 U12
//! ```
//!
//! Every factor is probed: K x = b for a fixed pseudo-random b. Where x is too large or leaves too much of
//! b, K is factorised again with all rows to choose from (`partial_pivoting`), which also
//! tells whether K is singular.

use super::SolverError;
use super::extend_add::{Entries, Part};
use super::held::{Held, HeldColumns};
use super::multifrontal::{self, Child, Front, NotPositive, Pool};
use super::partial_pivoting::{self, MOST_GROWTH, norm, random};
use super::refactorisation::{self, Kept};
use super::supernodes::Supernodes;
use super::tiles;
use super::triangular::{self, Factors, Wanted, pivoted_start};
use crate::assembly::full::{FullMatrix, mean_diagonal};
use crate::assembly::stiffness::hold;
use faer::dyn_stack::{MemStack, StackReq};
use faer::sparse::SymbolicSparseColMatRef;
use faer::{Accum, MatMut};
use std::sync::Arc;

/// ‖b − K x‖ over ‖K‖ ‖x‖ of the probe, the mean diagonal for ‖K‖. Rounding leaves some 1e-16 times the
/// growth of the pivots; refinement divides the residual by its inverse each time.
const MOST_LEFT: f64 = 1e-12;

/// The structure of the factors, from the pattern of K alone.
#[derive(Clone, Debug)]
pub struct Symbolic {
    order: Arc<[u32]>,
    structure: Arc<Supernodes>,
    places: Arc<Places>,
    pool: Arc<Pool>,
}

impl Symbolic {
    /// `lower`: the lower triangle of K + Kᵀ, two dofs to a node. `order`: the nodes as they are eliminated.
    pub fn new(
        pattern: SymbolicSparseColMatRef<'_, u32>,
        lower: SymbolicSparseColMatRef<'_, u32>,
        order: &[u32],
    ) -> Symbolic {
        let structure = Supernodes::new(lower, order);
        let places = Places::new(&structure, pattern);
        Symbolic {
            order: order.into(),
            structure: Arc::new(structure),
            places: Arc::new(places),
            pool: Arc::default(),
        }
    }

    /// Stored entries of L and U.
    pub fn factor_entries(&self) -> usize {
        2 * self.structure.entries()
    }

    /// Entries that the factorisation holds beside those of L and U.
    pub fn waiting_entries(&self) -> usize {
        self.structure.waiting_entries(Fronts::PASSED)
    }

    /// Multiplications and additions of the numeric factorisation.
    pub fn flops(&self) -> f64 {
        2.0 * self.structure.total_flops()
    }

    /// The factors of a matrix with this pattern, on all threads.
    ///
    /// # Errors
    /// [`SolverError::Singular`], [`SolverError::OutOfMemory`].
    pub fn factorise(&self, matrix: &FullMatrix) -> Result<Factor, SolverError> {
        self.factorise_held(matrix, Held::NONE, &[])
    }

    /// The same of the matrix with some dofs held, to be followed by [`Factor::refactorise`]. `likely`: nodes near
    /// which K will change.
    ///
    /// # Errors
    /// As [`Symbolic::factorise`].
    pub fn factorise_held(
        &self,
        matrix: &FullMatrix,
        held: Held,
        likely: &[u32],
    ) -> Result<Factor, SolverError> {
        let factor = self.numeric(matrix, held, &self.structure.above(likely))?;
        if factor.is_sound(matrix, held) {
            return Ok(Factor(Kind::Own(Box::new(factor))));
        }
        let mut matrix = matrix.clone();
        hold(matrix.parts_mut(), |dof| held.holds(dof), held.diagonal);
        self.factorise_with_all_rows(&matrix)
    }

    /// The same with all rows to choose pivots from, on one thread.
    ///
    /// # Errors
    /// [`SolverError::Singular`], [`SolverError::OutOfMemory`].
    pub fn factorise_with_all_rows(&self, matrix: &FullMatrix) -> Result<Factor, SolverError> {
        let symbolic = partial_pivoting::Symbolic::new(matrix.symbolic(), &self.order)?;
        let factor = symbolic.factorise(matrix)?;
        Ok(Factor(Kind::AllRows(Box::new(factor))))
    }

    fn numeric(
        &self,
        matrix: &FullMatrix,
        held: Held,
        parents: &[usize],
    ) -> Result<Own, SolverError> {
        let structure = &self.structure;
        let out_of_memory = || SolverError::OutOfMemory {
            dofs: matrix.ncols(),
        };
        let count = pivoted_start(structure, structure.n_supernodes());
        let mut values = super::zeros(count).ok_or_else(out_of_memory)?;
        let fronts = Fronts {
            structure,
            places: &self.places,
            matrix: matrix.val(),
            held: held.columns(structure),
        };
        // No pivot is refused: the probe tells what they were worth.
        let kept = multifrontal::factorise(structure, &fronts, &mut values, &self.pool, parents);
        Ok(Own {
            structure: structure.clone(),
            pool: self.pool.clone(),
            places: self.places.clone(),
            kept: Kept::new(kept.expect("fronts of LU refuse no pivot")),
            values,
        })
    }
}

/// L and U.
#[derive(Clone, Debug)]
pub struct Factor(Kind);

#[derive(Clone, Debug)]
enum Kind {
    Own(Box<Own>),
    AllRows(Box<partial_pivoting::Factor>),
}

impl Factor {
    /// Overwrites `rhs` by K⁻¹ rhs.
    pub fn solve_in_place(&self, rhs: &mut [f64]) {
        match &self.0 {
            Kind::Own(own) => own.solve_in_place(rhs),
            Kind::AllRows(factor) => factor.solve_in_place(rhs),
        }
    }

    /// The factors of a matrix that differs between some nodes only: the same bits as of a whole
    /// factorisation. Whether they are sound; if they are not, this is no factor any more.
    pub fn refactorise(&mut self, matrix: &FullMatrix, held: Held, nodes: &[u32]) -> bool {
        match &mut self.0 {
            Kind::Own(own) => {
                own.refactorise(matrix, held, nodes);
                own.is_sound(matrix, held)
            }
            Kind::AllRows(_) => false,
        }
    }

    /// Whether pivots were found among each supernode's own rows.
    pub fn kept_to_its_rows(&self) -> bool {
        matches!(self.0, Kind::Own(_))
    }
}

#[derive(Clone, Debug)]
struct Own {
    structure: Arc<Supernodes>,
    places: Arc<Places>,
    pool: Arc<Pool>,
    kept: Kept,
    values: Vec<f64>,
}

impl Own {
    fn refactorise(&mut self, matrix: &FullMatrix, held: Held, nodes: &[u32]) {
        let structure = &self.structure;
        let fronts = Fronts {
            structure,
            places: &self.places,
            matrix: matrix.val(),
            held: held.columns(structure),
        };
        let path = structure.above(nodes);
        let (values, kept) = (&mut self.values, &mut self.kept);
        let refused =
            refactorisation::refactorise(structure, &fronts, values, &self.pool, kept, &path);
        refused.expect("fronts of LU refuse no pivot");
    }

    fn solve_in_place(&self, rhs: &mut [f64]) {
        let factors = Factors::Pivoted(&self.values);
        triangular::solve(&self.structure, factors, rhs, Wanted::All);
    }

    fn is_sound(&self, matrix: &FullMatrix, held: Held) -> bool {
        let b = random(matrix.ncols());
        let mut x = b.clone();
        self.solve_in_place(&mut x);
        let mut rest = b.clone();
        for (column, &x) in x.iter().enumerate() {
            if held.holds(column) {
                rest[column] -= held.diagonal * x;
                continue;
            }
            let rows = matrix.row_idx_of_col_raw(column).iter();
            for (&row, &value) in rows.zip(matrix.val_of_col(column)) {
                if !held.holds(row as usize) {
                    rest[row as usize] -= value * x;
                }
            }
        }
        let size = mean_diagonal(matrix) * norm(&x);
        // False for what is not a number.
        size / norm(&b) < MOST_GROWTH && norm(&rest) < MOST_LEFT * size
    }
}

/// Two rows and two columns of K in a front.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    row: u32,
    column: u32,
    /// Where the two columns are among K's entries, two rows each.
    entries: [u32; 2],
}

/// Where K's entries go, supernode by supernode.
#[derive(Debug)]
struct Places {
    start: Vec<usize>,
    places: Vec<Place>,
}

impl Places {
    fn new(structure: &Supernodes, pattern: SymbolicSparseColMatRef<'_, u32>) -> Places {
        let blocks = || {
            (0..pattern.ncols()).step_by(2).flat_map(move |dof| {
                let [first, second] = [0, 1].map(|axis| pattern.col_range(dof + axis).start);
                let rows = pattern.row_idx_of_col_raw(dof).iter().step_by(2);
                rows.enumerate().map(move |(k, &row)| Place {
                    row: structure.column(row as usize) as u32,
                    column: structure.column(dof) as u32,
                    entries: [first + 2 * k, second + 2 * k].map(|at| at as u32),
                })
            })
        };
        let owner = |place: &Place| structure.supernode_of(place.row.min(place.column) as usize);
        let count = structure.n_supernodes();
        let mut start = vec![0; count + 1];
        blocks().for_each(|place| start[owner(&place) + 1] += 1);
        for s in 0..count {
            start[s + 1] += start[s];
        }
        let mut next = start.clone();
        let mut places = vec![Place::default(); start[count]];
        for place in blocks() {
            let owner = owner(&place);
            places[next[owner]] = place;
            next[owner] += 1;
        }
        let mut local = vec![0; structure.dofs()];
        for s in 0..count {
            let own = structure.columns(s);
            let all = own.chain(structure.rows(s).iter().map(|&row| row as usize));
            all.zip(0..).for_each(|(row, k)| local[row] = k);
            for place in &mut places[start[s]..start[s + 1]] {
                place.row = local[place.row as usize];
                place.column = local[place.column as usize];
            }
        }
        Places { start, places }
    }

    fn of(&self, s: usize) -> &[Place] {
        &self.places[self.start[s]..self.start[s + 1]]
    }
}

struct Fronts<'a> {
    structure: &'a Supernodes,
    places: &'a Places,
    /// Entries of K.
    matrix: &'a [f64],
    held: HeldColumns,
}

impl Front for Fronts<'_> {
    const PASSED: Entries = Entries::All;

    fn start(&self, s: usize) -> usize {
        pivoted_start(self.structure, s)
    }

    fn scratch(&self, columns: usize) -> StackReq {
        tiles::lu_scratch(columns)
    }

    fn eliminate(
        &self,
        s: usize,
        own: &mut [f64],
        children: &[Child],
        update: &mut [f64],
        memory: &mut MemStack,
    ) -> Result<(), NotPositive> {
        let structure = self.structure;
        let (width, rows) = (structure.width(s), structure.rows(s).len());
        let height = width + rows;
        // The columns of the front, and its rows as columns.
        let (left, right) = own.split_at_mut(height * width);
        let (right, order) = right.split_at_mut(height * width);
        left.fill(0.0);
        right.fill(0.0);
        self.add_matrix(s, left, right);
        let part = Part {
            values: left,
            columns: 0..width,
            first_row: 0,
            height,
        };
        multifrontal::add_children(children, part, Entries::All);
        for child in children {
            add_rows(child, right, height);
        }
        let l = MatMut::from_column_major_slice_mut(left, height, width);
        let (mut l11, mut l21) = l.split_at_row_mut(width);
        let rows_of = tiles::lu(l11.as_mut(), memory);
        let unchanged = (0..width).all(|k| rows_of[k] as usize == k);
        if !unchanged {
            let before = right.to_vec();
            for (column, &from) in right.chunks_exact_mut(height).zip(&rows_of) {
                column.copy_from_slice(&before[from as usize * height..][..height]);
            }
        }
        for (number, &from) in order.iter_mut().zip(&rows_of) {
            *number = f64::from(from);
        }
        let u = MatMut::from_column_major_slice_mut(right, height, width);
        let (mut u11, mut u12) = u.split_at_row_mut(width);
        for j in 0..width {
            for i in 0..=j {
                u11[(j, i)] = l11[(i, j)];
            }
            l11[(j, j)] = 1.0;
        }
        if rows == 0 {
            return Ok(());
        }
        tiles::solve_rows(u11.as_ref(), l21.as_mut());
        tiles::solve_unit_rows(l11.as_ref(), u12.as_mut());
        let (l21, u12) = (l21.as_ref(), u12.as_ref().transpose());
        let product = |passed: MatMut<f64>, first: usize| {
            let u12 = u12.subcols(first, passed.ncols());
            tiles::subtract_product(passed, l21, u12, Accum::Replace);
        };
        multifrontal::pass_up(children, width, rows, update, Fronts::PASSED, product);
        Ok(())
    }
}

impl Fronts<'_> {
    fn add_matrix(&self, s: usize, left: &mut [f64], right: &mut [f64]) {
        let width = self.structure.width(s);
        let height = width + self.structure.rows(s).len();
        for place in self.places.of(s) {
            let (row, column) = (place.row as usize, place.column as usize);
            for (b, &at) in place.entries.iter().enumerate() {
                for (a, &value) in self.matrix[at as usize..][..2].iter().enumerate() {
                    if column < width {
                        left[(column + b) * height + row + a] = value;
                    } else {
                        right[(row + a) * height + column + b] = value;
                    }
                }
            }
        }
        for place in self.held.among(self.structure, s) {
            for column in 0..width {
                left[column * height + place] = 0.0;
                right[column * height + place] = 0.0;
            }
            if place < width {
                left[place * height..][..height].fill(0.0);
                right[place * height..][..height].fill(0.0);
                left[place * height + place] = self.held.diagonal;
            }
        }
    }
}

/// Adds what falls into the parent's rows and not into its columns.
fn add_rows(child: &Child, right: &mut [f64], height: usize) {
    let places: Vec<usize> = child.runs.places().collect();
    let (inside, count) = (child.runs.inside(), places.len());
    for j in inside..count {
        for (&i, value) in places[..inside].iter().zip(&child.update[j * count..]) {
            right[i * height + places[j]] += value;
        }
    }
}
