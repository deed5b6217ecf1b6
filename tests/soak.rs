//! A sweep of many small runs: the memory and the open files of the process that leads them stay what they
//! are, no child is left, and each result is that of its run alone. Forty runs here; as many as wanted by
//!
//! ```text
//! RUNS=500 cargo test --release --test soak -- --nocapture
//! ```

mod workplace;

use std::process::Stdio;
use std::time::{Duration, Instant};
use workplace::{PIPELINE, Workplace};

fn runs() -> usize {
    let text = std::env::var("RUNS");
    text.map_or(40, |text| text.parse().expect("a number"))
}

/// `VmRSS` [kB].
fn memory(process: u32) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
    line.split_whitespace().nth(1)?.parse().ok()
}

fn handles(process: u32) -> Option<usize> {
    Some(
        std::fs::read_dir(format!("/proc/{process}/fd"))
            .ok()?
            .count(),
    )
}

/// Runs that have a result.
fn done(place: &Workplace) -> usize {
    let folders = std::fs::read_dir(place.path("results/bar_sweep"));
    let folders = folders.into_iter().flatten().flatten();
    folders
        .filter(|folder| folder.path().join("summary.json").is_file())
        .count()
}

#[test]
fn a_long_sweep_takes_no_more_than_a_short_one() {
    let count = runs();
    let place = Workplace::new();
    let sweep =
        format!("sweep: {{ over: {{ thickness: {{ from: 1, to: 2, count: {count} }} }} }}\n");
    let pipeline = PIPELINE.to_owned() + "output: { pictures: false, report: false }\n" + &sweep;
    place.write("bar.yaml", pipeline);
    let mut command = place.command(&["sweep", "bar.yaml"]);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let begin = Instant::now();
    let mut child = command.spawn().expect("the binary starts");
    // Of the first and of the last quarter of the runs: the largest.
    let (mut first, mut last) = ((0, 0), (0, 0));
    while child.try_wait().expect("a child").is_none() {
        let done = done(&place);
        if let (Some(memory), Some(handles)) = (memory(child.id()), handles(child.id())) {
            let share = match done {
                done if 4 * done < count => Some(&mut first),
                done if 4 * done >= 3 * count => Some(&mut last),
                _ => None,
            };
            if let Some((most_memory, most_handles)) = share {
                *most_memory = memory.max(*most_memory);
                *most_handles = handles.max(*most_handles);
            }
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    let status = child.wait().expect("it has ended");
    println!(
        "{count} runs in {:.0} s: {} → {} kB, {} → {} open files",
        begin.elapsed().as_secs_f64(),
        first.0,
        last.0,
        first.1,
        last.1
    );
    assert!(status.success());
    assert_eq!(done(&place), count);
    assert!(first.0 > 0 && last.0 > 0, "both quarters were seen");
    // The estimate of each run is made in this process, whose model comes and goes: 4 to 7 MB more were seen
    // between the first and the last quarter of 40, 250 and 500 runs alike. What each run left behind would
    // grow with their number: 100 kB each, of a model, would be 37 MB of 500.
    assert!(last.0 < first.0 + 12_000, "{first:?} {last:?} kB");
    // A child that starts has a few for a moment.
    assert!(last.1 <= first.1 + 4, "{first:?} {last:?} open files");

    let table = String::from_utf8(place.read("results/bar_sweep/sweep.csv")).expect("UTF-8");
    assert_eq!(table.lines().count(), count + 1);
    assert_eq!(
        table.matches(",done,").count() + table.matches(",done\n").count(),
        count
    );
    // u = σL/E, whatever the thickness: one number but for rounding.
    let tips: Vec<f64> = std::fs::read_dir(place.path("results/bar_sweep"))
        .expect("runs")
        .flatten()
        .filter_map(|run| std::fs::read(run.path().join("summary.json")).ok())
        .map(|bytes| {
            let summary: serde_json::Value = serde_json::from_slice(&bytes).expect("JSON");
            summary["probes"][0]["displacement_m"].as_f64().expect("u")
        })
        .collect();
    assert_eq!(tips.len(), count);
    for tip in &tips {
        assert!((tip / tips[0] - 1.0).abs() < 1e-10, "{tip}");
    }
}
