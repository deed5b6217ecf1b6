//! A run's profile in Chrome's trace-event format, which `chrome://tracing` and <https://ui.perfetto.dev>
//! open: complete events (`"ph": "X"`, times in µs) that nest by their times, one process for each
//! pipeline, one row for each thread.

use crate::output::{WriteError, write_whole};
use crate::trace::{Kind, Span, Trace};
use serde_json::{Value, json};
use std::path::Path;
use std::time::Duration;

/// Writes the profile of pipelines, each with its name.
///
/// # Errors
/// A file that cannot be written.
pub fn write(path: &Path, pipelines: &[(String, Trace)]) -> Result<(), WriteError> {
    write_whole(path, format!("{:#}\n", to_json(pipelines)).as_bytes())
}

/// The profile's content.
pub fn to_json(pipelines: &[(String, Trace)]) -> Value {
    let numbered = (1..).zip(pipelines);
    let events: Vec<Value> = numbered
        .flat_map(|(process, (name, trace))| process_events(process, name, trace))
        .collect();
    json!({ "displayTimeUnit": "ms", "traceEvents": events })
}

fn process_events(process: usize, name: &str, trace: &Trace) -> Vec<Value> {
    let named = |what: &str, thread: usize, name: &str| json!({ "ph": "M", "name": what, "pid": process, "tid": thread, "args": { "name": name } });
    let mut events = vec![named("process_name", 0, name)];
    for (thread, name) in trace.threads().iter().enumerate() {
        events.push(named("thread_name", thread, name));
    }
    events.extend(trace.spans().iter().map(|span| event(process, span)));
    events
}

fn event(process: usize, span: &Span) -> Value {
    let microseconds = |time: Duration| time.as_nanos() as f64 / 1e3;
    let name = match (span.kind, span.step) {
        (Kind::Step, Some(step)) => format!("step {step}"),
        _ => span.name.to_string(),
    };
    let category = match span.kind {
        Kind::Run => "run",
        Kind::Stage => "stage",
        Kind::Step => "step",
        Kind::Phase => "phase",
        Kind::File => "file",
    };
    let arguments = match span.step {
        Some(step) => json!({ "step": step }),
        None => json!({}),
    };
    json!({
        "ph": "X",
        "name": name,
        "cat": category,
        "pid": process,
        "tid": span.thread,
        "ts": microseconds(span.start),
        "dur": microseconds(span.time),
        "args": arguments,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Instant;

    #[test]
    fn a_profile_has_names_and_complete_events() {
        let begin = Instant::now();
        let trace = Trace::since(begin);
        trace.set_step(Some(3));
        let at = |microseconds| begin + Duration::from_micros(microseconds);
        let long = Duration::from_micros(40);
        trace.record(Kind::Step, "step", at(10), long);
        let profile = to_json(&[("plate".to_owned(), trace)]);
        let events = profile["traceEvents"].as_array().expect("events");
        assert_eq!(events[0]["args"]["name"], "plate");
        assert_eq!(events[1]["name"], "thread_name");
        let step = &events[2];
        assert_eq!([&step["ph"], &step["name"]], ["X", "step 3"]);
        assert_eq!([&step["ts"], &step["dur"]], [10.0, 40.0]);
        assert_eq!(
            [&step["pid"], &step["tid"], &step["args"]["step"]],
            [1, 0, 3]
        );
    }
}
