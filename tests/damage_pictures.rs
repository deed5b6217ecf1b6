//! Pictures of the damage: of chosen steps, of the end, and while the run goes.

mod workplace;

use std::process::Stdio;
use std::time::{Duration, Instant};
use workplace::{Ended, Workplace};

/// The small plate with pictures of two steps, and of one that the run does not come to.
fn plate() -> Workplace {
    let place = Workplace::with_plate();
    let pictures = "output: { every: 1000, pictures_at: [100, 40, 5000] }";
    place.edit(
        "plate.yaml",
        "output: { every: 7, pictures: false }",
        pictures,
    );
    place
}

fn run(place: &Workplace, more: &[&str]) -> Ended {
    place
        .call(&[&["run", "plate.yaml"], more].concat())
        .succeeded()
}

fn steps(place: &Workplace) -> [usize; 2] {
    let summary = place.read("results/plate/summary.json");
    let summary: serde_json::Value = serde_json::from_slice(&summary).expect("JSON");
    ["first_break", "end"].map(|point| {
        let step = summary["fracture"][point]["step"].as_u64();
        step.expect("a step") as usize
    })
}

fn exists(place: &Workplace, file: &str) -> bool {
    place.path(&format!("results/plate/{file}")).exists()
}

#[test]
fn chosen_steps_have_a_frame_and_a_picture() {
    let place = plate();
    let ended = run(&place, &[]);
    for file in ["damage_000040.png", "damage_000100.png"] {
        assert!(exists(&place, file), "{file}");
        assert!(ended.out.contains(file), "{}", ended.out);
    }
    for file in ["frames/000040.bin", "plate_points_000100.vtu"] {
        assert!(exists(&place, file), "{file}");
    }
    // Two damages, two pictures.
    let [at_40, at_100] =
        [40, 100].map(|k| place.read(&format!("results/plate/damage_{k:06}.png")));
    assert!(at_40 != at_100);
    assert!(
        ended
            .err
            .contains("output.pictures_at: no picture of step 5000: the run ended with step 145")
    );
    assert!(run(&place, &[]).stages().is_empty());
}

#[test]
fn the_last_picture_is_that_of_the_last_step_and_old_ones_go() {
    let place = plate();
    run(&place, &["--set", "output.pictures_at=[40]"]);
    let [_, end] = steps(&place);
    let last = place.read("results/plate/damage.png");
    let ended = run(&place, &["--set", &format!("output.pictures_at=[{end}]")]);
    assert!(!ended.err.contains("pictures_at"), "{}", ended.err);
    assert!(!exists(&place, "damage_000040.png"));
    assert!(last == place.read(&format!("results/plate/damage_{end:06}.png")));
}

#[test]
fn without_steps_or_without_pictures_none_is_drawn() {
    let place = plate();
    let ended = run(&place, &["--set", "output.pictures=false"]);
    assert!(!exists(&place, "damage_000040.png") && !exists(&place, "damage.png"));
    assert!(!ended.err.contains("pictures_at"), "{}", ended.err);
    place.edit(
        "plate.yaml",
        "loading: { control: one-pass, steps: 200 }\n",
        "",
    );
    let ended = run(&place, &[]);
    let said = "no picture of step 100, 40, 5000: without `loading` there are no steps";
    assert!(ended.err.contains(said), "{}", ended.err);
}

/// Slow enough to be killed on the way.
const SLOWLY: &str = "--reference-solver";

/// Kills a run once its history has a line of this step, and there is a picture.
fn kill_after(place: &Workplace, step: usize) {
    let mut command = place.command(&["run", "plate.yaml", SLOWLY]);
    let child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    let mut child = child.expect("the binary starts");
    let begin = Instant::now();
    let lines = || {
        let text = std::fs::read_to_string(place.path("results/plate/history.csv"));
        text.unwrap_or_default().lines().count()
    };
    let is_there = || lines() > step && exists(place, "damage.png");
    while !is_there() && child.try_wait().expect("a child").is_none() {
        assert!(begin.elapsed() < Duration::from_secs(60), "no step {step}");
        std::thread::sleep(Duration::from_micros(200));
    }
    let _ = child.kill();
    child.wait().expect("it has ended");
}

#[test]
fn a_picture_can_be_looked_at_while_the_run_goes() {
    let whole = plate();
    run(&whole, &[]);
    let [first, end] = steps(&whole);
    let all: Vec<usize> = (first..=end).collect();
    run(&whole, &["--set", &format!("output.pictures_at={all:?}")]);
    let at_end = whole.read("results/plate/damage.png");

    let place = plate();
    kill_after(&place, first + 10);
    // Of the first break, less than five seconds old; or of a step soon after, where the thread that
    // draws was busy then.
    let looked_at = place.read("results/plate/damage.png");
    let of_step = |step: &usize| whole.read(&format!("results/plate/damage_{step:06}.png"));
    assert!(all.iter().any(|step| of_step(step) == looked_at));
    // It is no result: the run goes on, and ends with the same bytes.
    run(&place, &["--until", "solve", SLOWLY]);
    assert!(
        !exists(&place, "damage.png"),
        "the solve stage takes it away"
    );
    run(&place, &[]);
    assert!(place.read("results/plate/damage.png") == at_end);
}

#[test]
fn clean_takes_the_picture_of_a_killed_run() {
    let place = plate();
    kill_after(&place, 100);
    assert!(exists(&place, "damage.png"));
    place.call(&["clean", "plate.yaml"]).succeeded();
    assert!(!place.path("results/plate").exists());
}
