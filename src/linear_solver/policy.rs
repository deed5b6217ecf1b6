//! Thresholds of the linear solver: choices, each with its reason.
//!
//! [`PANEL`], [`TILE_ROWS`] and [`PIECE`] cut sums into parts, so that the last bits of results change with them.

/// The least pivot L_jj² over K_jj. A singular K leaves pivots of rounding size, some 1e-16, of either
/// sign. A body that is held has larger ones: beam theory gives some 1e-10 for a cantilever a thousand
/// times as long as deep, and they fall with the cube of that ratio.
pub const LEAST_PIVOT: f64 = 1e-13;

/// The residual over the load that solutions by factors are refined to [-]: rounding errors.
pub const DIRECT_RESIDUAL: f64 = 1e-14;

/// The residual over the load at which conjugate gradients end [-]: displacements then agree with those by factors
/// to 1e-9 (tests/two_level.rs).
pub const ITERATIVE_RESIDUAL: f64 = 1e-10;

/// Beyond this ‖f − K u‖/‖f‖ rounding leaves u few digits or none [-]: K is close to singular.
pub const LARGEST_RELATIVE_RESIDUAL: f64 = 1e-4;

/// Solutions are refined as often at most: the first takes a residual to rounding as a rule.
pub const MOST_REFINEMENTS: usize = 3;

/// Squares of the coarse level are at least as many spacings wide: their 16 points have
/// eight times as many unknowns as an aggregate has motions.
pub const LEAST_CELL_SPACINGS: f64 = 4.0;

/// Systems whose L is expected to have more entries are solved on two levels: 4 GB.
pub const MOST_FACTOR_ENTRIES: f64 = 5e8;

/// Columns of a panel and of a tile, a piece that stays in the cache of a processor.
pub const PANEL: usize = 64;

/// Rows of a tile, for the same reason.
pub const TILE_ROWS: usize = 256;

/// A subtree with less than this share of all work stays with one thread: enough tasks for any number of threads.
pub const SUBTREE_SHARE: f64 = 1.0 / 64.0;

/// A subtree with less work (multiplications and additions) stays with one thread: a task of its own
/// would not pay.
pub const SUBTREE_WORK: f64 = 1e7;

/// A subtree with fewer entries of L stays with one thread in a solution, for the same reason.
pub const SUBTREE_ENTRIES: usize = 500_000;

/// Right-hand sides that go through L together: they fill the lanes of a processor.
pub const TOGETHER: usize = 8;

/// A block of L with more entries below its own rows is shared out to the threads in a solution.
pub const LARGE_BLOCK: usize = 50_000;

/// The parts of such a block, whatever the number of threads.
pub const BLOCK_PARTS: usize = 4;

/// The most unit loads that one thread takes up the tree at a time: enough for products of dense blocks at their
/// full rate.
pub const UNIT_LOADS: usize = 480;

/// Fewer unit loads are not shared out: their blocks would be too narrow.
pub const FEW_UNIT_LOADS: usize = 24;

/// A mode of an aggregate is dropped if supports and the other modes leave a smaller share of it: it is rounding.
pub const INDEPENDENT_SHARE: f64 = 1e-6;

/// Iterations end here for systems that are too close to singular: others need some 45.
pub const MOST_ITERATIONS: usize = 2000;

/// Terms of a part of a sum over all unknowns: long enough to be shared out.
pub const PIECE: usize = 1 << 14;
