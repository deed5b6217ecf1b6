//! `run --trace FILE`: the profile is what Chrome's viewer reads, its spans nest, and they are the times of
//! `summary.json`. `summary.json` keeps them when the stages are fresh.

mod workplace;

use serde_json::Value;
use std::collections::BTreeMap;
use workplace::Workplace;

fn json(place: &Workplace, file: &str) -> Value {
    serde_json::from_slice(&place.read(file)).expect("JSON")
}

fn text<'a>(event: &'a Value, key: &str) -> &'a str {
    event[key]
        .as_str()
        .unwrap_or_else(|| panic!("{key} in {event}"))
}

fn number(event: &Value, key: &str) -> f64 {
    event[key]
        .as_f64()
        .unwrap_or_else(|| panic!("{key} in {event}"))
}

/// Name → seconds and count of phases in a list of the summary.
fn phases(list: &Value) -> BTreeMap<String, (f64, u64)> {
    let list = list.as_array().expect("phases").iter();
    list.map(|phase| {
        let count = phase["count"].as_u64().expect("a count");
        (
            text(phase, "phase").to_owned(),
            (number(phase, "seconds"), count),
        )
    })
    .collect()
}

fn profiled(arguments: &[&str]) -> (Workplace, Vec<Value>) {
    let place = Workplace::with_plate();
    let run = ["run", "plate.yaml", "--trace", "trace.json"];
    place.call(&[&run, arguments].concat()).succeeded();
    let events = json(&place, "trace.json")["traceEvents"].take();
    let Value::Array(events) = events else {
        panic!("traceEvents is a list");
    };
    (place, events)
}

fn complete<'a>(events: &'a [Value], category: &str) -> Vec<&'a Value> {
    let is = |event: &&Value| event["ph"] == "X" && event["cat"] == category;
    events.iter().filter(is).collect()
}

#[test]
fn events_are_complete_and_nest() {
    let (_place, events) = profiled(&["--threads", "2"]);
    let mut rows: BTreeMap<(u64, u64), Vec<&Value>> = BTreeMap::new();
    let mut names = BTreeMap::new();
    for event in &events {
        let [process, thread] = ["pid", "tid"].map(|key| event[key].as_u64().expect("an id"));
        match text(event, "ph") {
            "X" => {
                assert!(number(event, "ts") >= 0.0 && number(event, "dur") >= 0.0);
                assert!(!text(event, "name").is_empty() && event["args"].is_object());
                rows.entry((process, thread)).or_default().push(event);
            }
            "M" if event["name"] == "thread_name" => {
                names.insert((process, thread), text(&event["args"], "name").to_owned());
            }
            "M" => assert_eq!(event["args"]["name"], "plate"),
            other => panic!("{other}"),
        }
    }
    assert!(
        rows.keys().eq(names.keys()),
        "every row has a name: {names:?}"
    );
    for name in ["main", "writer"] {
        assert!(names.values().any(|known| known == name), "{names:?}");
    }
    for row in rows.values() {
        let mut open: Vec<f64> = Vec::new();
        for event in row {
            let [start, end] = [
                number(event, "ts"),
                number(event, "ts") + number(event, "dur"),
            ];
            // Times are whole nanoseconds; the sum of two may round.
            let rounding = 1e-3;
            while open.last().is_some_and(|&outer| outer <= start + rounding) {
                open.pop();
            }
            let fits = open.last().is_none_or(|&outer| end <= outer + rounding);
            assert!(fits, "{event} overlaps");
            open.push(end);
        }
    }
    let stages: Vec<&str> = (complete(&events, "stage").iter())
        .map(|event| text(event, "name"))
        .collect();
    assert_eq!(stages, ["mesh", "solve", "output"]);
}

#[test]
fn steps_are_numbered_and_hold_their_phases() {
    let (place, events) = profiled(&[]);
    let summary = json(&place, "results/plate/summary.json");
    let last = summary["fracture"]["end"]["step"].as_u64().expect("a step");
    let steps: Vec<u64> = (complete(&events, "step").iter())
        .map(|event| event["args"]["step"].as_u64().expect("a step"))
        .collect();
    assert_eq!(steps, (1..=last).collect::<Vec<_>>());
    let first = summary["fracture"]["first_break"]["step"]
        .as_u64()
        .expect("a step");
    // Bonds have broken: the step that follows solves anew.
    let of_step = |event: &&&Value| event["args"]["step"].as_u64() == Some(first + 1);
    let phases = complete(&events, "phase");
    let names: Vec<&str> = (phases.iter().filter(of_step))
        .map(|event| text(event, "name"))
        .collect();
    assert!(
        names.contains(&"solution") && names.contains(&"stretches"),
        "{names:?}"
    );
}

/// Spans are whole nanoseconds in µs with fractions, seconds of the summary are doubles.
#[test]
fn spans_sum_to_the_summary() {
    for control in ["one-pass", "event-driven"] {
        let (place, events) = profiled(&["--set", &format!("loading.control={control}")]);
        let summary = json(&place, "results/plate/summary.json");
        let mut sums: BTreeMap<String, (f64, u64)> = BTreeMap::new();
        for event in complete(&events, "phase") {
            let sum = sums.entry(text(event, "name").to_owned()).or_default();
            sum.0 += number(event, "dur") / 1e6;
            sum.1 += 1;
        }
        let mut told = phases(&summary["phases"]);
        assert!(told.remove("other").is_some());
        // The writer has its own.
        for (name, (seconds, count)) in phases(&summary["behind"]) {
            let told = told.entry(name).or_default();
            *told = (told.0 + seconds, told.1 + count);
        }
        assert!(
            sums.keys().eq(told.keys()),
            "{:?} {:?}",
            sums.keys(),
            told.keys()
        );
        for (name, (seconds, count)) in &told {
            let (sum, spans) = sums[name];
            assert!(
                (sum - seconds).abs() < 1e-9 * *count as f64,
                "{name}: {sum} {seconds}"
            );
            assert_eq!(spans, *count, "{name}");
        }
    }
}

/// All phases of the solve are there again when only the output stage runs, whatever they are called.
#[test]
fn a_fresh_stage_keeps_its_phases() {
    let (place, _) = profiled(&["--set", "loading.control=event-driven"]);
    let before = json(&place, "results/plate/summary.json");
    assert!(phases(&before["phases"]).contains_key("active zone"));
    let control = ["--set", "loading.control=event-driven"];
    let again = [
        &["run", "plate.yaml", "--set", "output.bonds=true"],
        &control[..],
    ]
    .concat();
    let ended = place.call(&again).succeeded();
    assert_eq!(ended.stages(), ["output"]);
    let after = json(&place, "results/plate/summary.json");
    let kept = |summary: &Value| {
        let mut kept = phases(&summary["phases"]);
        // Those are measured again in every run.
        for name in ["discretisation", "vtu", "pictures", "other"] {
            kept.remove(name);
        }
        kept
    };
    assert_eq!(kept(&after), kept(&before));
    assert_eq!(after["written"]["frames"], before["written"]["frames"]);
    let shares = after["phases"].as_array().expect("phases").iter();
    let sum: f64 = shares.map(|phase| number(phase, "share")).sum();
    // A dozen roundings.
    assert!((sum - 1.0).abs() < 1e-12);
    let peak = |summary: &Value| summary["memory"]["peak_bytes"].as_u64();
    assert!(peak(&after) >= peak(&before).map(|peak| peak / 2));
}

/// The profile of what ran is there although the run failed, and one of several pipelines holds all.
#[test]
fn a_profile_is_written_whatever_comes() {
    let place = Workplace::with_plate();
    place
        .call(&["run", "bar.yaml", "plate.yaml", "--trace", "t.json"])
        .succeeded();
    let events = json(&place, "t.json");
    let named = |event: &&Value| event["name"] == "process_name";
    let events = events["traceEvents"].as_array().expect("events");
    let names: Vec<&str> = (events.iter().filter(named))
        .map(|event| text(&event["args"], "name"))
        .collect();
    assert_eq!(names, ["bar", "plate"]);
    place.edit("geo/plate.geo", "side = 50;", "side = ;");
    let ended = place.call(&["run", "plate.yaml", "--trace", "u.json"]);
    assert_eq!(ended.code, Some(2));
    assert!(
        !json(&place, "u.json")["traceEvents"]
            .as_array()
            .expect("events")
            .is_empty()
    );

    let ended = place.call(&["run", "bar.yaml", "--trace", "none/t.json", "--force"]);
    assert_eq!(ended.code, Some(2));
    assert!(
        ended.err.contains("there is no folder none"),
        "{}",
        ended.err
    );
    let ended = place.call(&["run", "bar.yaml", "--trace", "geo"]);
    assert_eq!(ended.code, Some(2));
    assert!(ended.err.contains("geo is a folder"), "{}", ended.err);
}
