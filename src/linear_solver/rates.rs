//! Measured rates: what operations cost, in time and in memory.
//!
//! All were measured on two cores with AVX-512 and 24 GB, and are a rough guide elsewhere. The rates of
//! [`super::amalgamation`] decide which supernodes are merged: the last bits of results change with them.

// Measured on one thread; `cargo bench --bench solvers` shows the factorisations and solutions that they lead to.

/// Multiplications and additions per second in a product of large blocks.
pub const BLOCK_RATE: f64 = 5e10;

/// The width of a block that reaches half of [`BLOCK_RATE`].
pub const HALF_RATE_WIDTH: f64 = 8.0;

/// Seconds to add an entry of an update to the parent's front.
pub const ADDED_ENTRY: f64 = 0.6e-9;

/// Seconds to stream an entry of L through a solution.
pub const STREAMED_ENTRY: f64 = 3e-9;

/// Seconds to begin with a supernode.
pub const SUPERNODE: f64 = 1e-6;

// Of lattices of 62 500 to 10⁶ points, `cargo bench --bench million -- SIDE direct`.

/// Entries of L for each link of the graph, each squared unknown of a node, and each level of nested dissection.
pub const ENTRIES_PER_LINK: f64 = 0.7675;

// The estimate of `check` (statics/estimate.rs); `cargo test --release --test two_level` compares its memory.

/// Multiplications and additions per second of a factorisation, on lattices of 16 000 to 258 000 dofs.
pub const FACTOR_RATE: f64 = 2e10;

/// Entries of K per second of all that a direct solution does besides, on the same lattices.
pub const ENTRY_RATE: f64 = 3e6;

/// Entries of K per second and iteration on two levels, on lattices of 62 500 to 10⁶ points.
pub const ITERATION_RATE: f64 = 4e8;

/// Iterations of a solution on two levels, on the same lattices.
pub const ITERATIONS: f64 = 45.0;

/// Memory of an entry of K or L [bytes].
pub const ENTRY_BYTES: f64 = 8.0;

/// Vectors of all dofs that a solution by factors holds at a time, results included.
pub const DIRECT_VECTORS: f64 = 12.0;

/// Vectors that conjugate gradients hold, with smoother and coarse space.
pub const ITERATIVE_VECTORS: f64 = 20.0;

/// Updates that wait for their parents, with the room that was kept for smaller and larger ones and on
/// other threads, over those of one subtree after the other: 41 000 points on two threads.
pub const WAITING_SHARE: f64 = 2.5;

/// Memory of an interaction in a fracture run [bytes]: its law, the length of crack that it stands for, its integrity
/// in the state. 41 000 points, by conjugate gradients.
pub const BREAKABLE_BYTES: f64 = 20.0;

/// Memory of a fracture run of any size [bytes]; 41 000 and 10⁶ points.
pub const FRACTURE_BYTES: f64 = 15e6;

/// Memory of looking ahead in event-driven runs [bytes], of up to [`FEW_EVENTS`] and of more; these also factorise
/// again, and hold [`MANY_EVENTS_SHARE`] more entries over those of L. `pipelines/`, 4 000 to 19 000 dofs: within a
/// quarter of what they take.
pub const FEW_EVENTS: usize = 500;
pub const FEW_EVENTS_BYTES: f64 = 30e6;
pub const MANY_EVENTS_BYTES: f64 = 112e6;
pub const MANY_EVENTS_SHARE: f64 = 1.0;

/// Seconds that the breaking of a bond takes, event by event, and of them those per entry of L: `pipelines/`, within
/// a factor of three. In load steps, where some bonds break in each pass, it takes a fifth.
pub const BOND_SECONDS: f64 = 2e-4;
pub const BOND_ENTRY_SECONDS: f64 = 1.2e-10;
pub const STEPPED_SHARE: f64 = 0.2;

/// Entries that a fracture run holds besides those of L, over these: to factorise again only above what broke, and
/// to update the response. None where little breaks, 0.8 to 1.4 where a body is torn apart (31 000 to 118 000
/// dofs); between the two.
pub const KEPT_SHARE: f64 = 0.5;
