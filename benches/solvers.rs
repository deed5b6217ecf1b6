//! This crate's solver beside faer's, CHOLMOD, MUMPS and MKL PARDISO, on the same matrices:
//!
//! ```sh
//! make bench-solvers                     # lattices of 100², 200² and 400² points; half an hour
//! make bench-solvers ARGS='100 200'      # of 100² and 200² points only
//! cargo bench --bench solvers -- 100     # with the rivals that are there
//! cargo bench --bench solvers -- 400 rounds=1
//! ```
//!
//! Every solver runs in a process of its own, with one thread and with two, and in turn with the others,
//! three rounds; each measures itself (median of five after a warm-up; the analysis once) and
//! computes its residuals. The tables have the medians over the rounds: processor time for one thread,
//! so that a busy machine disturbs less, and wall time for two.
//!
//! The rivals (`benches/rivals/`) read the lower triangle of K from a file: n and the number of entries
//! (i64), column starts and rows (i32), values (f64). Those that are not installed are left out.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::{Conj, MatMut, Par, Side};
use peristitch::assembly::{LowerMatrix, Pattern};
use peristitch::geometry::Outline;
use peristitch::linear_solver::cholesky::Symbolic;
use peristitch::linear_solver::ordering::{
    Ordering, dof_permutation, elimination_order, postordered,
};
use peristitch::material::{Material, PlaneState};
use peristitch::peridynamics::bonds::bonds;
use peristitch::peridynamics::kernel::{Kernel, Micromodulus, PartialArea};
use peristitch::peridynamics::lattice::{self, CellArea, LatticeSettings, Placement};
use peristitch::peridynamics::visibility::Visibility;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

const RUNS: usize = 5;
const MANY: usize = 8;
const PHASES: [&str; 4] = ["analysis", "numeric", "solve", "solve8"];

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if let [_, child, side, threads, ..] = arguments.as_slice()
        && let Some(name) = child.strip_prefix("--solver=")
    {
        let side = side.parse().expect("a side");
        let threads = threads.parse().expect("threads");
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .use_current_thread()
            .build_global()
            .expect("the first pool");
        match name {
            "faer" => faer(side, threads),
            _ => ours(side),
        }
        return;
    }
    let sides: Vec<usize> = arguments.iter().filter_map(|a| a.parse().ok()).collect();
    let sides = if sides.is_empty() {
        vec![100, 200, 400]
    } else {
        sides
    };
    let rounds = arguments
        .iter()
        .find_map(|a| a.strip_prefix("rounds=")?.parse().ok());
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("solvers");
    std::fs::create_dir_all(&folder).expect("a folder for the matrices");
    let rivals = rivals(&folder);
    for side in sides {
        compare(side, rounds.unwrap_or(3), &rivals, &folder);
    }
}

/// What to run, but for the matrix.
struct Rival {
    name: &'static str,
    command: Vec<PathBuf>,
}

fn rivals(folder: &Path) -> Vec<Rival> {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/rivals");
    let compiled = |name: &'static str, options: &[&str]| {
        let program = folder.join(name.to_lowercase());
        let compiler = Command::new("cc")
            .args(["-O2", "-o"])
            .arg(&program)
            .arg(sources.join(name.to_lowercase() + ".c"))
            .args(options)
            .output();
        let done = compiler.is_ok_and(|output| output.status.success());
        done.then(|| Rival {
            name,
            command: vec![program],
        })
        .ok_or(name)
    };
    let python = sources.join("../../target/rivals/bin/python3");
    let pardiso = python.exists().then(|| Rival {
        name: "PARDISO",
        command: vec![python, sources.join("pardiso.py")],
    });
    let this = std::env::current_exe().expect("this program has a path");
    let all = [
        Ok(Rival {
            name: "faer",
            command: vec![this, "--solver=faer".into()],
        }),
        compiled(
            "CHOLMOD",
            &["-I/usr/include/suitesparse", "-lcholmod", "-lm"],
        ),
        compiled(
            "MUMPS",
            &["-I/usr/include/mumps_seq", "-ldmumps_seq", "-lm"],
        ),
        pardiso.ok_or("PARDISO"),
    ];
    let mut found = Vec::new();
    for rival in all {
        match rival {
            Ok(rival) => found.push(rival),
            Err(name) => {
                println!("{name} is left out: not installed (`make bench-solvers` does that)")
            }
        }
    }
    found
}

/// By phase: wall and processor time [s] of every round; and what else a solver said.
#[derive(Default)]
struct Record {
    times: BTreeMap<String, Vec<[f64; 2]>>,
    /// The largest residual.
    residual: f64,
    entries: f64,
}

impl Record {
    fn read(&mut self, output: &str) {
        for line in output.lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            let number = |k: usize| words.get(k).and_then(|w| w.parse::<f64>().ok());
            match (words.first(), number(1), number(2)) {
                (Some(&name), Some(wall), Some(cpu)) => {
                    self.times
                        .entry(name.to_owned())
                        .or_default()
                        .push([wall, cpu]);
                }
                (Some(&"residual"), Some(residual), _) => {
                    self.residual = self.residual.max(residual);
                }
                (Some(&"entries"), Some(entries), _) => self.entries = entries,
                _ => {}
            }
        }
    }

    fn median(&self, phase: &str, threads: usize) -> f64 {
        let times = self.times.get(phase).into_iter().flatten();
        let mut times: Vec<f64> = times.map(|t| t[usize::from(threads == 1)]).collect();
        times.sort_unstable_by(f64::total_cmp);
        times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
    }
}

fn compare(side: usize, rounds: usize, rivals: &[Rival], folder: &Path) {
    let file = folder.join(format!("lattice_{side}.bin"));
    write(&lattice(side).1, &file);
    println!(
        "\nlattice of {side} × {side} points, m = 4: {} dofs",
        2 * side * side
    );
    for threads in [1, 2] {
        let mut records: BTreeMap<usize, Record> = BTreeMap::new();
        for _ in 0..rounds {
            let this = std::env::current_exe().expect("this program has a path");
            let mut own = Command::new(this);
            own.args(["--solver=ours", &side.to_string(), &threads.to_string()]);
            records.entry(0).or_default().read(&run(own, "peristitch"));
            for (k, rival) in rivals.iter().enumerate() {
                let mut command = Command::new(&rival.command[0]);
                command.args(&rival.command[1..]);
                if rival.name == "faer" {
                    command.args([side.to_string(), threads.to_string()]);
                } else {
                    command.arg(&file);
                }
                for variable in ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"] {
                    command.env(variable, threads.to_string());
                }
                records
                    .entry(k + 1)
                    .or_default()
                    .read(&run(command, rival.name));
            }
        }
        table(threads, rivals, &records);
    }
    // The matrix of 320 000 dofs has 190 MB.
    let _ = std::fs::remove_file(file);
}

fn run(mut command: Command, name: &str) -> String {
    match command.output() {
        Ok(output) if output.status.success() => String::from_utf8_lossy(&output.stdout).into(),
        Ok(output) => {
            println!(
                "{name} failed: {}",
                String::from_utf8_lossy(&output.stderr).trim()
            );
            String::new()
        }
        Err(error) => {
            println!("{name} does not start: {error}");
            String::new()
        }
    }
}

fn table(threads: usize, rivals: &[Rival], records: &BTreeMap<usize, Record>) {
    let clock = if threads == 1 { "processor" } else { "wall" };
    println!("\n{threads} thread(s), {clock} time [s]");
    println!("| | analysis | numeric | solution | 8 solutions | entries of L | residual |");
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    let names = ["peristitch"]
        .into_iter()
        .chain(rivals.iter().map(|r| r.name));
    for (record, name) in records.values().zip(names) {
        let times = PHASES.map(|phase| format!("{:.4}", record.median(phase, threads)));
        let [entries, residual] = [record.entries, record.residual].map(|x| format!("{x:.1e}"));
        println!(
            "| {name} | {} | {entries} | {residual} |",
            times.join(" | ")
        );
    }
    let ratio = |phase: &&str| {
        let of = |record: &Record| record.median(phase, threads);
        let best = records
            .values()
            .skip(1)
            .map(of)
            .fold(f64::INFINITY, f64::min);
        format!("{:.2}", of(&records[&0]) / best)
    };
    let ratios: Vec<String> = PHASES.iter().map(ratio).collect();
    println!("| × the best rival | {} | | |", ratios.join(" | "));
}

/// K of a lattice on a unit square of 30 GPa, one edge held.
fn lattice(side: usize) -> (Pattern, LowerMatrix) {
    let spacing = 1.0 / side as f64;
    let outline = Outline {
        loops: vec![vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]],
    };
    let cells = LatticeSettings::upright(spacing, Placement::CellCentred, CellArea::Full);
    let points = lattice::lattice(&outline, &[], &cells);
    let positions = &points.positions;
    let plane = PlaneState::Stress;
    let material = Material {
        young: 30e9,
        poisson: plane.bond_based_poisson(),
    };
    let reach = 4.0 * spacing;
    let micromodulus = Micromodulus::new(
        Kernel::Quartic,
        PartialArea::Full,
        &material,
        plane,
        reach,
        spacing,
    );
    let interactions = bonds(&points, &micromodulus, 1.0, 0, &Visibility::unlimited());
    let pattern = Pattern::new(positions.len(), &interactions, &[]);
    let stiffness = pattern.assemble(positions, &interactions, &[]);
    let held: Vec<bool> = (0..2 * positions.len()).map(|dof| dof < 2 * side).collect();
    let matrix = stiffness.hold(&held, stiffness.mean_diagonal());
    (pattern, matrix)
}

fn write(matrix: &LowerMatrix, path: &Path) {
    let file = std::fs::File::create(path).expect("room for the matrix");
    let mut file = std::io::BufWriter::new(file);
    let mut put = |bytes: &[u8]| file.write_all(bytes).expect("room for the matrix");
    put(&(matrix.ncols() as i64).to_le_bytes());
    put(&(matrix.val().len() as i64).to_le_bytes());
    let integers = matrix.as_ref().symbolic();
    let integers = integers.col_ptr().iter().chain(integers.row_idx());
    integers.for_each(|&i| put(&(i as i32).to_le_bytes()));
    matrix.val().iter().for_each(|v| put(&v.to_le_bytes()));
}

/// The same as the rivals do.
fn ours(side: usize) {
    let (pattern, matrix) = lattice(side);
    let analyse = || {
        Symbolic::<2>::new(pattern.symbolic(), &pattern.graph, Ordering::Metis)
            .expect("METIS works")
    };
    let symbolic = measure("analysis", 1, || (), |()| analyse());
    let factor = measure(
        "numeric",
        RUNS,
        || (),
        |()| symbolic.factorise(&matrix).expect("positive definite"),
    );
    solve(&matrix, |x, _| factor.solve_in_place(x));
    println!("entries {}", symbolic.factor_entries());
    println!("flops {:.6e}", symbolic.flops());
}

/// Times one solution and several, and prints the residuals.
fn solve(matrix: &LowerMatrix, mut work: impl FnMut(&mut [f64], usize)) {
    let n = matrix.ncols();
    let load = |k: usize| 1.0 + ((k % n * 7 + k / n) % 13) as f64;
    for (name, columns) in [("solve", 1), ("solve8", MANY)] {
        let b: Vec<f64> = (0..n * columns).map(load).collect();
        let x = measure(
            name,
            RUNS,
            || b.clone(),
            |mut x| {
                work(&mut x, columns);
                x
            },
        );
        let rest = |(x, b): (&[f64], &[f64])| {
            let force = matrix.multiply(x);
            let squares = force.iter().zip(b).map(|(f, b)| (f - b).powi(2));
            (squares.sum::<f64>() / b.iter().map(|b| b * b).sum::<f64>()).sqrt()
        };
        let worst = x.chunks(n).zip(b.chunks(n)).map(rest).fold(0.0, f64::max);
        println!("residual {worst:.3e}");
    }
}

/// faer's supernodal Cholesky in the same order.
fn faer(side: usize, threads: usize) {
    let (pattern, matrix) = lattice(side);
    let n = matrix.ncols();
    let par = if threads == 1 {
        Par::Seq
    } else {
        Par::rayon(threads)
    };
    let analyse = || {
        let order = elimination_order(Ordering::Metis, &pattern.graph).expect("METIS works");
        let order = postordered::<2>(pattern.symbolic(), &order);
        let order = dof_permutation::<2>(&order);
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let order = SymmetricOrdering::Custom(order.as_ref());
        factorize_symbolic_cholesky(pattern.symbolic(), Side::Lower, order, params)
            .expect("there is memory")
    };
    let symbolic = measure("analysis", 1, || (), |()| analyse());
    let scratch = symbolic.factorize_numeric_llt_scratch::<f64>(par, Default::default());
    let mut memory = MemBuffer::new(scratch);
    let mut values = vec![0.0; symbolic.len_val()];
    measure(
        "numeric",
        RUNS,
        || (),
        |()| {
            let factor = symbolic.factorize_numeric_llt(
                &mut values,
                matrix.as_ref(),
                Side::Lower,
                Default::default(),
                par,
                MemStack::new(&mut memory),
                Default::default(),
            );
            factor.map(|_| ()).expect("positive definite");
        },
    );
    solve(&matrix, |x, columns| {
        let mut memory = MemBuffer::new(symbolic.solve_in_place_scratch::<f64>(columns, par));
        LltRef::new(&symbolic, &values).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(x, n, columns),
            par,
            MemStack::new(&mut memory),
        );
    });
    println!("entries {}", symbolic.len_val());
}

/// Prints NAME, wall and processor time: medians of `runs` after one that is not counted.
fn measure<S, T>(
    name: &str,
    runs: usize,
    mut begin: impl FnMut() -> S,
    mut work: impl FnMut(S) -> T,
) -> T {
    let (mut wall, mut cpu) = (Vec::new(), Vec::new());
    let warm_up = usize::from(runs > 1);
    let mut result = None;
    for run in 0..runs + warm_up {
        let input = begin();
        drop(result.take());
        let (start, before) = (Instant::now(), processor_time());
        result = Some(work(input));
        if run >= warm_up {
            wall.push(start.elapsed().as_secs_f64());
            cpu.push(processor_time() - before);
        }
    }
    let median = |mut times: Vec<f64>| {
        times.sort_unstable_by(f64::total_cmp);
        times[runs / 2]
    };
    println!("{name} {:.6} {:.6}", median(wall), median(cpu));
    result.expect("it ran")
}

/// Of this process [s].
fn processor_time() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}
