//! A stiffness matrix that is not symmetric, for couplings in which one side reads the other's
//! displacements without acting back on it: all of K, on a pattern that is fixed once.
//!
//! Springs act on the nodes from a first one on, the material points; [`Equations`] hold what
//! elements add to the rows of some nodes. Every column is gathered by one thread, in a fixed order.

use super::Lists;
use crate::springs::Springs;
use faer::sparse::{SparseColMat, SymbolicSparseColMat, SymbolicSparseColMatRef};
use nalgebra::DMatrix;
use rayon::prelude::*;

/// All entries of a square matrix, columns sorted.
pub type FullMatrix = SparseColMat<u32, f64>;

/// Mean of the diagonal: the scale of a stiffness matrix.
pub fn mean_diagonal(matrix: &FullMatrix) -> f64 {
    let n = matrix.ncols();
    let entry = |j| matrix.get(j, j).copied().unwrap_or(0.0);
    (0..n).map(entry).sum::<f64>() / n as f64
}

/// Forces on some nodes from the displacements of others: matrix · u(columns), two rows and columns per
/// node [N/m].
#[derive(Clone, Debug)]
pub struct Equations {
    pub rows: Vec<u32>,
    pub columns: Vec<u32>,
    pub matrix: DMatrix<f64>,
}

/// Which rows each column has, and what adds to it.
#[derive(Clone, Debug)]
pub struct FullPattern {
    /// Neighbours of each node in K + Kᵀ, ascending, itself left out.
    pub graph: Lists,
    /// Springs act on nodes from this one on.
    first_point: u32,
    /// Nodes with rows in each node's columns, ascending.
    rows: Lists,
    springs_at: Lists,
    equations_at: Lists,
    symbolic: SymbolicSparseColMat<u32>,
}

impl FullPattern {
    /// Springs without stiffness take no place.
    pub fn new(
        nodes: usize,
        first_point: u32,
        springs: &Springs,
        equations: &[Equations],
    ) -> FullPattern {
        let stiff = || {
            let all = (0..springs.len()).filter(|&s| springs.stiffness[s] != 0.0);
            all.map(|s| (s as u32, springs.nodes(s)))
        };
        let springs_at = Lists::collect(nodes, || {
            stiff().flat_map(|(s, nodes)| nodes.iter().map(move |&node| (node, s)))
        });
        let equations_at = Lists::collect(nodes, || {
            let numbered = equations.iter().enumerate();
            numbered.flat_map(|(e, equations)| {
                equations.columns.iter().map(move |&node| (node, e as u32))
            })
        });
        let entries = || {
            let by_spring = stiff().flat_map(move |(_, nodes)| {
                let rows = nodes.iter().filter(move |&&row| row >= first_point);
                rows.flat_map(move |&row| nodes.iter().map(move |&column| (column, row)))
            });
            let by_equations = equations.iter().flat_map(|equations| {
                let rows = equations.rows.iter();
                rows.flat_map(|&row| equations.columns.iter().map(move |&column| (column, row)))
            });
            // Every node has a diagonal, so that it can be held.
            let diagonal = (0..nodes as u32).map(|node| (node, node));
            diagonal.chain(by_spring).chain(by_equations)
        };
        let rows = Lists::collect(nodes, entries).into_sets();
        let links = || (0..nodes).flat_map(|c| rows.of(c).iter().map(move |&r| [c as u32, r]));
        let graph = Lists::collect(nodes, || {
            let both = links().flat_map(|[a, b]| [(a, b), (b, a)]);
            both.filter(|(a, b)| a != b)
        })
        .into_sets();
        let symbolic = symbolic(&rows);
        FullPattern {
            graph,
            first_point,
            rows,
            springs_at,
            equations_at,
            symbolic,
        }
    }

    pub fn nodes(&self) -> usize {
        self.rows.len()
    }

    pub fn symbolic(&self) -> SymbolicSparseColMatRef<'_, u32> {
        self.symbolic.as_ref()
    }

    /// Where the entries of the lower triangle of K + Kᵀ are.
    pub fn symmetrised(&self) -> SymbolicSparseColMat<u32> {
        super::lower_pattern(&self.graph)
    }

    pub fn stored_entries(&self) -> usize {
        self.symbolic.row_idx().len()
    }

    /// K [N/m].
    pub fn assemble(
        &self,
        positions: &[[f64; 2]],
        springs: &Springs,
        equations: &[Equations],
    ) -> FullMatrix {
        self.assemble_intact(positions, springs, |_| true, equations)
    }

    /// The same with those springs alone that are intact.
    pub fn assemble_intact(
        &self,
        positions: &[[f64; 2]],
        springs: &Springs,
        is_intact: impl Fn(usize) -> bool + Sync,
        equations: &[Equations],
    ) -> FullMatrix {
        let mut values = vec![0.0; self.stored_entries()];
        self.columns_mut(&mut values)
            .into_par_iter()
            .enumerate()
            .with_min_len(64)
            .for_each(|(node, values)| {
                self.gather(node, values, (springs, positions, equations), &is_intact);
            });
        FullMatrix::new(self.symbolic.clone(), values)
    }

    /// Brings the columns of some nodes up to the springs that are intact: the same bits as
    /// [`FullPattern::assemble_intact`], if no other spring has changed than those that end at these nodes alone.
    pub fn reassemble(
        &self,
        matrix: &mut FullMatrix,
        nodes: &[u32],
        positions: &[[f64; 2]],
        springs: &Springs,
        is_intact: impl Fn(usize) -> bool,
        equations: &[Equations],
    ) {
        let (symbolic, values) = matrix.parts_mut();
        for &node in nodes {
            let node = node as usize;
            let columns = symbolic.col_range(2 * node).start..symbolic.col_range(2 * node + 1).end;
            let own = &mut values[columns];
            own.fill(0.0);
            self.gather(node, own, (springs, positions, equations), &is_intact);
        }
    }

    fn gather(
        &self,
        node: usize,
        values: &mut [f64],
        (springs, positions, equations): (&Springs, &[[f64; 2]], &[Equations]),
        is_intact: &impl Fn(usize) -> bool,
    ) {
        let mut column = Column {
            node: node as u32,
            rows: self.rows.of(node),
            values,
        };
        let springs_here = self.springs_at.of(node).iter().map(|&s| s as usize);
        for s in springs_here.filter(|&s| is_intact(s)) {
            column.add_spring(springs, s, positions, self.first_point);
        }
        for &e in self.equations_at.of(node) {
            column.add_equations(&equations[e as usize]);
        }
    }

    /// The two columns of each node as one slice.
    fn columns_mut<'a>(&self, mut values: &'a mut [f64]) -> Vec<&'a mut [f64]> {
        let split = |node| {
            let length = 4 * self.rows.of(node).len();
            let (column, rest) = std::mem::take(&mut values).split_at_mut(length);
            values = rest;
            column
        };
        (0..self.nodes()).map(split).collect()
    }
}

fn symbolic(rows: &Lists) -> SymbolicSparseColMat<u32> {
    let n = rows.len();
    let mut start = Vec::with_capacity(2 * n + 1);
    let mut indices: Vec<u32> = Vec::new();
    start.push(0);
    for node in 0..n {
        for _ in 0..2 {
            indices.extend(rows.of(node).iter().flat_map(|&row| [2 * row, 2 * row + 1]));
            start.push(indices.len() as u32);
        }
    }
    SymbolicSparseColMat::new_checked(2 * n, 2 * n, start, None, indices)
}

/// The two columns of one node while they are gathered.
struct Column<'a> {
    node: u32,
    rows: &'a [u32],
    values: &'a mut [f64],
}

impl Column<'_> {
    fn add_block(&mut self, row: u32, block: [[f64; 2]; 2]) {
        let place = self.rows.binary_search(&row);
        let place = place.expect("the pattern holds every pair");
        for (axis, values) in block.into_iter().enumerate() {
            for (column, value) in values.into_iter().enumerate() {
                self.values[2 * column * self.rows.len() + 2 * place + axis] += value;
            }
        }
    }

    fn add_spring(
        &mut self,
        springs: &Springs,
        spring: usize,
        positions: &[[f64; 2]],
        first_point: u32,
    ) {
        let mut own = [0.0; 2];
        springs.for_each_term(spring, positions, |node, w| {
            if node == self.node {
                own = w;
            }
        });
        let stiffness = springs.stiffness[spring];
        springs.for_each_term(spring, positions, |node, w| {
            if node >= first_point {
                self.add_block(
                    node,
                    w.map(|row| own.map(|column| stiffness * row * column)),
                );
            }
        });
    }

    fn add_equations(&mut self, equations: &Equations) {
        let own = equations.columns.iter().position(|&n| n == self.node);
        let own = 2 * own.expect("equations are listed at their own columns only");
        for (r, &row) in equations.rows.iter().enumerate() {
            let entry = |i: usize, j: usize| equations.matrix[(2 * r + i, own + j)];
            self.add_block(row, [0, 1].map(|i| [0, 1].map(|j| entry(i, j))));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;

    #[test]
    fn the_gathered_matrix_is_the_sum_of_dense_contributions() {
        let positions = [[0.0, 0.0], [1.0, 0.2], [0.3, 1.0], [1.2, 1.1], [0.7, 2.0]];
        let mut springs = Springs::of_pairs(vec![[2, 4], [3, 4]], vec![2.0, 3.0]);
        springs.push_interpolated(
            [positions[3], [0.5, 0.1]],
            [&[(3, 1.0)], &[(0, 0.6), (1, 0.4)]],
            7.0,
        );
        let equations = [Equations {
            rows: vec![1, 0],
            columns: vec![0, 4, 1],
            matrix: DMatrix::from_fn(4, 6, |i, j| (10 * i + j) as f64),
        }];
        let first_point = 2;
        let mut dense = DMatrix::<f64>::zeros(10, 10);
        for s in 0..springs.len() {
            let mut w = DVector::<f64>::zeros(10);
            springs.for_each_term(s, &positions, |node, [x, y]| {
                w[2 * node as usize] += x;
                w[2 * node as usize + 1] += y;
            });
            let mut rows = w.clone();
            rows.rows_mut(0, 2 * first_point as usize).fill(0.0);
            dense += springs.stiffness[s] * rows * w.transpose();
        }
        for (r, &row) in equations[0].rows.iter().enumerate() {
            for (c, &column) in equations[0].columns.iter().enumerate() {
                for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    dense[(2 * row as usize + i, 2 * column as usize + j)] +=
                        equations[0].matrix[(2 * r + i, 2 * c + j)];
                }
            }
        }
        let pattern = FullPattern::new(5, first_point, &springs, &equations);
        let sparse = pattern.assemble(&positions, &springs, &equations);
        assert_eq!(pattern.graph.of(4), [0, 1, 2, 3]);
        for j in 0..10 {
            for i in 0..10 {
                let value = sparse.get(i, j).copied().unwrap_or(0.0);
                assert!((value - dense[(i, j)]).abs() < 1e-14, "({i}, {j})");
            }
        }
    }
}
