//! Measured rates of the ways to the next response (`costs.rs`).
//!
//! Costs are counts of operations times the rates of this table, so that they do not depend on the clock: a run
//! takes the same decisions everywhere. Measured on two cores with AVX-512 of an AMD EPYC by
//! `cargo bench --bench fracture -- 1/2 1/3 1/4 1/8 threads=2`, see docs/performance.md. The unit is a
//! multiplication in a dense product for updates, and a multiplication or an addition there for zones.

/// An update after a pass: a flop of a sparse factorisation, which runs at some fifth of the rate of a dense
/// product; the assembly and the refined solution after it, and a solution, for each entry of L.
pub const UPDATE_FACTORISATION: f64 = 4.0;
pub const UPDATE_REFINEMENT: f64 = 200.0;
pub const UPDATE_SOLUTION: f64 = 100.0;
/// An update: X of a dof that comes in, for each entry of L; the dense system, for each third power of its size.
pub const UPDATE_DOF: f64 = 0.6;
pub const UPDATE_SYSTEM: f64 = 2.0;

/// A zone: a flop of a sparse factorisation; assembly and a first solution, and the end of a zone, for each entry
/// of L; a bond, for each entry of A'.
pub const ZONE_FACTORISATION: f64 = 2.5;
pub const ZONE_ASSEMBLY: f64 = 200.0;
pub const ZONE_END: f64 = 300.0;
pub const ZONE_BOND: f64 = 6.0;

/// Dofs n of a zone, n³ = this × the entries of L: per bond a zone costs n², and the solutions at its end 1/n. And
/// the fewest.
pub const ZONE_DOFS: f64 = 30.0;
pub const FEWEST_ZONE_DOFS: f64 = 1200.0;

/// X and A of a zone are taken over from the one before where at least this share of its dofs was there, and X
/// has fewer blocks than these: smaller products run slower.
pub const LEAST_SHARED: f64 = 0.3;
pub const MOST_BLOCKS: usize = 12;

/// So many dofs come in at a time, if there are any to expect: they cost little more than one.
pub const DOFS_AT_A_TIME: usize = 64;
