//! `peristitch watch` on a small plate: what is saved is run; errors are told and the watching goes on;
//! it ends as it should. Every wait is for something to appear, for a minute at most.

mod workplace;

use serde_json::Value;
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};
use workplace::Workplace;

const PATIENCE: Duration = Duration::from_secs(60);

/// A watch that goes on; killed when it is dropped.
struct Watching {
    child: Child,
    lines: Receiver<String>,
    said: String,
}

impl Watching {
    fn start(place: &Workplace, arguments: &[&str]) -> Watching {
        let mut child = place
            .command(&[&["watch"], arguments].concat())
            .spawn()
            .expect("the binary starts");
        let (sender, lines) = channel();
        let out: Box<dyn Read + Send> = Box::new(child.stdout.take().expect("a pipe"));
        let err: Box<dyn Read + Send> = Box::new(child.stderr.take().expect("a pipe"));
        for stream in [out, err] {
            let sender = sender.clone();
            std::thread::spawn(move || {
                for line in BufReader::new(stream).lines().map_while(Result::ok) {
                    let _ = sender.send(line);
                }
            });
        }
        Watching {
            child,
            lines,
            said: String::new(),
        }
    }

    /// What is said up to a line with this text.
    #[track_caller]
    fn waits_for(&mut self, text: &str) -> String {
        let end = Instant::now() + PATIENCE;
        let mut said = String::new();
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let line = self.lines.recv_timeout(left);
            let line = line.unwrap_or_else(|_| panic!("no {text:?} in\n{}{said}", self.said));
            said += &format!("{line}\n");
            if line.contains(text) {
                self.said += &said;
                return said;
            }
        }
    }

    fn interrupt(&mut self, signal: &str) -> Option<i32> {
        let id = self.child.id().to_string();
        let sent = Command::new("kill").args([signal, &id]).status();
        assert!(sent.expect("kill").success());
        self.child.wait().expect("a child").code()
    }

    fn is_alive(&mut self) -> bool {
        self.child.try_wait().expect("a child").is_none()
    }
}

impl Drop for Watching {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

const DONE: &str = "s after the save";

fn summary(place: &Workplace) -> Value {
    serde_json::from_slice(&place.read("results/plate/summary.json")).expect("JSON")
}

fn with_pictures() -> Workplace {
    let place = Workplace::with_plate();
    place.edit("plate.yaml", "pictures: false", "pictures: true");
    place
}

#[test]
fn a_saved_geometry_is_run_and_a_broken_one_told() {
    let place = with_pictures();
    let mut watching = Watching::start(&place, &["plate.yaml"]);
    let first = watching.waits_for(DONE);
    assert!(first.contains("plate.yaml: the first run"), "{first}");
    let [numbers, picture] = [
        summary(&place),
        place.read("results/plate/damage.png").into(),
    ];
    let peak = |summary: &Value| {
        summary["fracture"]["peak"]["reaction_n"]
            .as_f64()
            .expect("N")
    };
    for wanted in ["peak reaction: step", "results/plate/damage.png"] {
        assert!(first.contains(wanted), "{wanted} is not in\n{first}");
    }
    assert!(!first.contains("summary.json"), "a short block\n{first}");

    // A longer crack breaks earlier.
    place.edit("plate.yaml", "crack: 10", "crack: 16");
    let second = watching.waits_for(DONE);
    assert!(second.contains("plate.yaml: plate.yaml saved"), "{second}");
    assert!(peak(&summary(&place)) < 0.95 * peak(&numbers));
    assert_ne!(Value::from(place.read("results/plate/damage.png")), picture);

    place.edit("geo/plate.geo", "side = 50;", "side = 50\nside = ;");
    let broken = watching.waits_for("the next save runs it again");
    assert!(broken.contains("geo/plate.geo saved"), "{broken}");
    assert!(broken.contains("the input is wrong"), "{broken}");
    // Where, as Gmsh tells it.
    assert!(
        broken.contains("geo/plate.geo:24: syntax error"),
        "{broken}"
    );
    assert!(watching.is_alive());
    let kept = summary(&place);

    place.edit("geo/plate.geo", "side = 50\nside = ;", "side = 60;");
    watching.waits_for(DONE);
    let points = |summary: &Value| summary["sizes"]["material_points"].as_u64();
    assert_eq!(
        [points(&kept), points(&summary(&place))],
        [Some(1000), Some(1200)]
    );
    assert_eq!(watching.interrupt("-INT"), Some(130));
    assert_eq!(
        place.call(&["run", "plate.yaml"]).succeeded().stages(),
        [""; 0]
    );
}

/// An editor that writes a new file and renames it; and a broken pipeline with its line.
#[test]
fn a_renamed_pipeline_is_a_saved_one() {
    let place = Workplace::with_plate();
    place.edit("plate.yaml", "spacing: 1 mm", "spacing: 1 mmm");
    let mut watching = Watching::start(&place, &["plate.yaml"]);
    let broken = watching.waits_for("the next save runs it again");
    assert!(broken.contains("plate.yaml:10:66"), "{broken}");
    let text = String::from_utf8(place.read("plate.yaml")).expect("UTF-8");
    place.write("plate.yaml~", text.replace("1 mmm", "2 mm"));
    std::fs::rename(place.path("plate.yaml~"), place.path("plate.yaml")).expect("a rename");
    watching.waits_for(DONE);
    assert_eq!(summary(&place)["sizes"]["material_points"], 250);
    assert_eq!(watching.interrupt("-TERM"), Some(130));
}

/// The run that goes is stopped for a newer save; what is left is as good as after any other kill.
#[test]
fn a_save_stops_the_run_that_goes() {
    let place = Workplace::with_plate();
    // Some seconds: long enough to be caught.
    place.edit("plate.yaml", "spacing: 1 mm", "spacing: 0.4 mm");
    let mut watching = Watching::start(&place, &["plate.yaml"]);
    let end = Instant::now() + PATIENCE;
    let steps = || std::fs::read(place.path("results/plate/history.csv")).unwrap_or_default();
    while steps().iter().filter(|&&byte| byte == b'\n').count() < 3 {
        assert!(
            Instant::now() < end && watching.is_alive(),
            "{}",
            watching.said
        );
        std::thread::sleep(Duration::from_millis(2));
    }
    place.edit("plate.yaml", "spacing: 0.4 mm", "spacing: 1 mm");
    let said = watching.waits_for(DONE);
    assert!(said.contains("stopped: a newer save"), "{said}");
    assert_eq!(summary(&place)["sizes"]["material_points"], 1000);
    let files = |place: &Workplace| {
        ["solution.bin", "history.csv"].map(|file| place.read(&format!("results/plate/{file}")))
    };
    let undisturbed = Workplace::with_plate();
    undisturbed.call(&["run", "plate.yaml"]).succeeded();
    assert!(files(&place) == files(&undisturbed));
    assert!(!place.path("results/plate/.draft").exists());
    assert_eq!(watching.interrupt("-INT"), Some(130));
}

#[test]
fn an_interrupt_ends_the_run_too() {
    let place = Workplace::with_plate();
    place.edit("plate.yaml", "spacing: 1 mm", "spacing: 0.4 mm");
    let mut watching = Watching::start(&place, &["plate.yaml"]);
    watching.waits_for("mesh");
    assert_eq!(watching.interrupt("-INT"), Some(130));
    // Nobody else writes to the folder any more.
    place.edit("plate.yaml", "spacing: 0.4 mm", "spacing: 1 mm");
    place.call(&["run", "plate.yaml"]).succeeded();
}

#[test]
fn several_pipelines_are_watched_each_for_itself() {
    let place = Workplace::with_plate();
    let mut watching = Watching::start(&place, &["bar.yaml", "plate.yaml", "--threads", "1"]);
    watching.waits_for("bar.yaml: the first run");
    watching.waits_for("plate.yaml: the first run");
    watching.waits_for(DONE);
    place.edit("bar.yaml", "element: 50", "element: 25");
    let said = watching.waits_for(DONE);
    assert!(
        said.contains("bar.yaml: bar.yaml saved") && !said.contains("plate"),
        "{said}"
    );
    assert!(said.contains("tip: u_x ="), "{said}");
    place.edit("plate.yaml", "name: plate", "name: bar");
    let said = watching.waits_for("give each pipeline a `name`");
    assert!(said.contains("both write to"), "{said}");
    place.edit("plate.yaml", "name: bar", "name: plate");
    watching.waits_for(DONE);
}

#[test]
fn what_cannot_be_watched_is_told_at_once() {
    let place = Workplace::new();
    for (arguments, wanted) in [
        (&["watch", "bra.yaml"][..], "there is no pipeline file"),
        (&["watch", "bar.yaml", "--set", "nonsense"][..], "nonsense"),
    ] {
        let ended = place.call(arguments);
        assert_eq!(ended.code, Some(2), "{}", ended.err);
        assert!(ended.err.contains(wanted), "{}", ended.err);
    }
}
