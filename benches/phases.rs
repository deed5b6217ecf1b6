//! Time and memory of each phase of a solve beside its floor: `cargo bench`, or
//! `cargo bench -- 100 200` for lattices of 100² and 200² points only.
//!
//! The floor of a phase is the time that this machine needs, on one thread, for the multiplications
//! (dense matrix product of 1500²) or the bytes (one pass over 256 MB) that the phase cannot avoid.

use faer::Par;
use peristitch::assembly::{ElementStiffness, LowerMatrix, Pattern};
use peristitch::geometry::Outline;
use peristitch::interactions::Interactions;
use peristitch::linear_solver::cholesky::Symbolic;
use peristitch::linear_solver::ordering::{Ordering, elimination_order};
use peristitch::material::{Material, PlaneState};
use peristitch::peridynamics::bonds::bonds;
use peristitch::peridynamics::kernel::{Kernel, Micromodulus, PartialArea};
use peristitch::peridynamics::lattice::{CellArea, LatticeSettings, Placement, lattice};
use peristitch::peridynamics::visibility::Visibility;
use peristitch::pipeline::read::plan::Plan;
use peristitch::pipeline::stages::run::{Options, discretised};
use std::path::Path;
use std::time::Instant;

/// Every figure is the median of this many runs.
const RUNS: usize = 5;

fn main() {
    let sides: Vec<usize> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let sides = if sides.is_empty() {
        vec![100, 200, 400]
    } else {
        sides
    };
    let machine = Machine::measure();
    println!(
        "{:.1} Gflop/s, {:.1} GB/s on one thread; medians of {RUNS}\n",
        machine.flops / 1e9,
        machine.bytes / 1e9
    );
    cantilever(&machine);
    for side in sides {
        square(side, &machine);
    }
}

struct Machine {
    /// Multiply–add pairs count as two.
    flops: f64,
    bytes: f64,
}

impl Machine {
    fn measure() -> Machine {
        let n = 1500;
        let a = faer::Mat::<f64>::from_fn(n, n, |i, j| (i + 2 * j) as f64);
        let mut c = faer::Mat::<f64>::zeros(n, n);
        let product = median(|| {
            faer::linalg::matmul::matmul(&mut c, faer::Accum::Replace, &a, &a, 1.0, Par::Seq);
        });
        let data = vec![1.0f64; 32 << 20];
        let pass = median(|| {
            // Eight sums at a time: one would wait for its own additions, not for the memory.
            let mut sums = [0.0; 8];
            for chunk in data.chunks_exact(8) {
                for (sum, x) in sums.iter_mut().zip(chunk) {
                    *sum += x;
                }
            }
            std::hint::black_box(sums);
        });
        Machine {
            flops: 2.0 * (n as f64).powi(3) / product,
            bytes: 8.0 * data.len() as f64 / pass,
        }
    }
}

fn median(mut work: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..RUNS)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_unstable_by(f64::total_cmp);
    times[RUNS / 2]
}

/// Memory that the process gains at its peak while `work` runs [MB].
fn gained<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let kilobytes = |key: &str| {
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let line = status
            .lines()
            .find(|line| line.starts_with(key))
            .unwrap_or("")
            .to_owned();
        line.split_whitespace()
            .nth(1)
            .and_then(|k| k.parse::<f64>().ok())
            .unwrap_or(f64::NAN)
    };
    // Resets the peak to what is held now; without the right to do so the gain reads low.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
    let before = kilobytes("VmRSS:");
    let result = work();
    (result, (kilobytes("VmHWM:") - before) / 1e3)
}

fn row(name: &str, seconds: f64, megabytes: f64, floor: Option<f64>) {
    let floor = floor.map_or(String::new(), |f| {
        format!("{:>10.4}  {:>6.1}", f, seconds / f)
    });
    println!("  {name:<34} {seconds:>9.4}  {megabytes:>8.1}  {floor}");
}

fn head(title: &str) {
    println!(
        "{title}\n  {:<34} {:>9}  {:>8}  {:>10}  {:>6}",
        "phase", "s", "MB", "floor s", "ratio"
    );
}

fn cantilever(machine: &Machine) {
    let pipeline =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/cantilever_hybrid_q8.yaml");
    let plan = Plan::read(&pipeline, &[], None).expect("the pipeline is sound");
    let options = Options {
        gmsh: peristitch::gmsh::Options {
            worker: Some(env!("CARGO_BIN_EXE_peristitch").into()),
            ..Default::default()
        },
        ..Default::default()
    };
    head("cantilever_hybrid_q8");
    let ((model, _, _), memory) = gained(|| discretised(&plan, &options).expect("a sound model"));
    let whole = median(|| {
        discretised(&plan, &options).expect("a sound model");
    });
    row("Gmsh and discretisation", whole, memory, None);
    let (elements, memory) = gained(|| model.element_stiffness());
    let time = median(|| {
        model.element_stiffness();
    });
    // Bᵀ(DB) at nine points: 3·3·16 + 16·3·16 multiply–add pairs.
    let flops = elements.len() as f64 * 9.0 * 2.0 * (144.0 + 768.0);
    row(
        "element stiffness",
        time,
        memory,
        Some(flops / machine.flops),
    );
    system(&model.positions, &model.interactions, &elements, machine);
}

fn square(side: usize, machine: &Machine) {
    let spacing = 1.0 / side as f64;
    let outline = Outline {
        loops: vec![vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]],
    };
    let plane = PlaneState::Stress;
    let material = Material {
        young: 30e9,
        poisson: plane.bond_based_poisson(),
    };
    let micromodulus = Micromodulus::new(
        Kernel::Quartic,
        PartialArea::Full,
        &material,
        plane,
        4.0 * spacing,
        spacing,
    );
    head(&format!("\nlattice of {side} × {side} points, m = 4"));
    let settings = LatticeSettings::upright(spacing, Placement::CellCentred, CellArea::Clipped);
    let points = || lattice(&outline, &[], &settings);
    let (found, memory) = gained(points);
    let time = median(|| {
        points();
    });
    let floor = 24.0 * found.positions.len() as f64 / machine.bytes;
    row("lattice", time, memory, Some(floor));
    let all = || {
        let visibility = Visibility::new(&outline, spacing, micromodulus.reach());
        bonds(&found, &micromodulus, 1.0, 0, &visibility)
    };
    let (interactions, memory) = gained(all);
    let time = median(|| {
        all();
    });
    let floor = 16.0 * interactions.len() as f64 / machine.bytes;
    row("families and bonds", time, memory, Some(floor));
    system(&found.positions, &interactions, &[], machine);
}

fn system(
    positions: &[[f64; 2]],
    interactions: &Interactions,
    elements: &[ElementStiffness],
    machine: &Machine,
) {
    let nodes = positions.len();
    let (pattern, memory) = gained(|| Pattern::new(nodes, interactions, elements));
    let entries = pattern.stored_entries() as f64;
    let time = median(|| {
        Pattern::new(nodes, interactions, elements);
    });
    row("pattern", time, memory, Some(4.0 * entries / machine.bytes));
    let (stiffness, memory) = gained(|| pattern.assemble(positions, interactions, elements));
    let time = median(|| {
        pattern.assemble(positions, interactions, elements);
    });
    let floor = (8.0 * entries + 2.0 * 16.0 * interactions.len() as f64) / machine.bytes;
    row("assembly (all threads)", time, memory, Some(floor));
    let held = hold_first_nodes(&stiffness);
    for ordering in [Ordering::Metis, Ordering::Amd] {
        factorisation(ordering, &pattern, &held, machine);
    }
}

/// A positive definite matrix: the first tenth of the nodes is held by stiff springs.
fn hold_first_nodes(stiffness: &LowerMatrix) -> LowerMatrix {
    let mut held = stiffness.clone();
    let count = held.ncols() / 10;
    let (symbolic, values) = held.parts_mut();
    for column in 0..count {
        let diagonal = symbolic.col_range(column).start;
        values[diagonal] *= 10.0;
    }
    held
}

fn factorisation(ordering: Ordering, pattern: &Pattern, matrix: &LowerMatrix, machine: &Machine) {
    let order = || elimination_order(ordering, &pattern.graph).expect("METIS orders it");
    let (nodes, memory) = gained(order);
    let time = median(|| {
        order();
    });
    row(&format!("ordering: {ordering:?}"), time, memory, None);
    let analyse = || Symbolic::<2>::with_order(pattern.symbolic(), &nodes);
    let (symbolic, memory) = gained(analyse);
    let time = median(|| {
        analyse();
    });
    row("  symbolic", time, memory, None);
    println!(
        "  {:<34} {:.3e} entries of L, {:.3e} flops",
        "",
        symbolic.factor_entries() as f64,
        symbolic.flops()
    );
    for (threads, name) in [(1, "1 thread"), (2, "2 threads")] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.expect("a pool");
        let factorise = || pool.install(|| symbolic.factorise(matrix).expect("positive definite"));
        let (_, memory) = gained(factorise);
        let time = median(|| {
            factorise();
        });
        let floor = symbolic.flops() / machine.flops;
        row(&format!("  numeric, {name}"), time, memory, Some(floor));
    }
    let factor = symbolic.factorise(matrix).expect("positive definite");
    let mut rhs = vec![1.0; matrix.ncols()];
    let (_, memory) = gained(|| factor.solve_in_place(&mut rhs));
    let time = median(|| factor.solve_in_place(&mut rhs));
    let bytes = 2.0 * 8.0 * symbolic.factor_entries() as f64;
    row("  solution", time, memory, Some(bytes / machine.bytes));
}
