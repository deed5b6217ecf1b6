//! When each phase of a run took place, on which thread and in which step: what a profile shows.

use std::borrow::Cow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, ThreadId};
use std::time::{Duration, Instant};

/// Kind of a span, from the outermost to the innermost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// One pipeline.
    Run,
    /// Mesh, solve, output.
    Stage,
    /// A load step or an event.
    Step,
    /// A phase, as [`crate::phases::Phases`] sums them.
    Phase,
    /// One file.
    File,
}

/// A stretch of time on one thread.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    pub name: Cow<'static, str>,
    pub kind: Kind,
    /// Index in [`Trace::threads`].
    pub thread: usize,
    /// Since the trace began.
    pub start: Duration,
    pub time: Duration,
    /// The load step or event it belongs to, on the first thread.
    pub step: Option<usize>,
}

/// Collects spans from all threads that have a copy of it; off by default, and then free of cost.
#[derive(Clone, Debug, Default)]
pub struct Trace(Option<Arc<Recorder>>);

#[derive(Debug)]
struct Recorder {
    begin: Instant,
    /// The current step of the run and one more; 0 outside of steps.
    step: AtomicUsize,
    spans: Mutex<Vec<Span>>,
    threads: Mutex<Vec<(ThreadId, String)>>,
}

impl Trace {
    /// A trace whose times count from `begin`.
    pub fn since(begin: Instant) -> Trace {
        let trace = Trace(Some(Arc::new(Recorder {
            begin,
            step: AtomicUsize::new(0),
            spans: Mutex::default(),
            threads: Mutex::default(),
        })));
        // The first thread is the one that runs.
        trace.0.iter().for_each(|recorder| {
            recorder.thread();
        });
        trace
    }

    pub fn is_on(&self) -> bool {
        self.0.is_some()
    }

    /// Sets the step to which the following spans belong.
    pub fn set_step(&self, step: Option<usize>) {
        if let Some(recorder) = &self.0 {
            let step = step.map_or(0, |step| step + 1);
            recorder.step.store(step, Ordering::Relaxed);
        }
    }

    /// A span that began at `start`, took `time` and has just ended on this thread.
    pub fn record(
        &self,
        kind: Kind,
        name: impl Into<Cow<'static, str>>,
        start: Instant,
        time: Duration,
    ) {
        if let Some(recorder) = &self.0 {
            recorder.record(kind, name.into(), start, time);
        }
    }

    /// A span that ends when the guard is dropped, however that comes about.
    #[must_use]
    pub fn span(&self, kind: Kind, name: impl Into<Cow<'static, str>>) -> Guard {
        Guard {
            trace: self.clone(),
            kind,
            name: name.into(),
            start: Instant::now(),
        }
    }

    /// All spans, thread by thread, each before what it encloses.
    pub fn spans(&self) -> Vec<Span> {
        let Some(recorder) = &self.0 else {
            return Vec::new();
        };
        let mut spans = lock(&recorder.spans).clone();
        spans.sort_by_key(|span| (span.thread, span.start, std::cmp::Reverse(span.time)));
        spans
    }

    /// Names of the threads.
    pub fn threads(&self) -> Vec<String> {
        let recorder = self.0.iter();
        recorder
            .flat_map(|recorder| lock(&recorder.threads).clone())
            .map(|(_, name)| name)
            .collect()
    }
}

impl Recorder {
    fn record(&self, kind: Kind, name: Cow<'static, str>, start: Instant, time: Duration) {
        let thread = self.thread();
        let step = self.step.load(Ordering::Relaxed).checked_sub(1);
        let span = Span {
            name,
            kind,
            thread,
            start: start.saturating_duration_since(self.begin),
            time,
            // What goes on behind the solve is of earlier steps.
            step: step.filter(|_| thread == 0),
        };
        lock(&self.spans).push(span);
    }

    /// The index of the current thread, which gets one when it is first seen.
    fn thread(&self) -> usize {
        let id = thread::current().id();
        let mut threads = lock(&self.threads);
        if let Some(index) = threads.iter().position(|(known, _)| *known == id) {
            return index;
        }
        let name = match (thread::current().name(), rayon::current_thread_index()) {
            (Some(name), _) => name.to_owned(),
            (None, Some(index)) => format!("worker {index}"),
            (None, None) => format!("thread {}", threads.len()),
        };
        threads.push((id, name));
        threads.len() - 1
    }
}

/// A span that is still going on.
pub struct Guard {
    trace: Trace,
    kind: Kind,
    name: Cow<'static, str>,
    start: Instant,
}

impl Drop for Guard {
    fn drop(&mut self) {
        if let Some(recorder) = &self.trace.0 {
            let name = std::mem::take(&mut self.name);
            recorder.record(self.kind, name, self.start, self.start.elapsed());
        }
    }
}

/// A panic elsewhere leaves the list as good as it was.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trace_that_is_off_keeps_nothing() {
        let trace = Trace::default();
        drop(trace.span(Kind::Stage, "solve"));
        assert!(!trace.is_on() && trace.spans().is_empty() && trace.threads().is_empty());
    }

    #[test]
    fn spans_know_their_thread_and_their_step_and_enclose_each_other() {
        let trace = Trace::since(Instant::now());
        trace.set_step(Some(7));
        let outer = trace.span(Kind::Step, "step");
        drop(trace.span(Kind::Phase, "assembly"));
        drop(outer);
        trace.set_step(None);
        let other = trace.clone();
        let named = thread::Builder::new().name("writer".to_owned());
        let handle = named.spawn(move || drop(other.span(Kind::Phase, "frames")));
        handle.expect("a thread").join().expect("no panic");

        let spans = trace.spans();
        let told: Vec<_> = (spans.iter())
            .map(|span| (span.name.as_ref(), span.thread, span.step))
            .collect();
        assert_eq!(
            told,
            [
                ("step", 0, Some(7)),
                ("assembly", 0, Some(7)),
                ("frames", 1, None)
            ]
        );
        let end = |span: &Span| span.start + span.time;
        assert!(spans[0].start <= spans[1].start && end(&spans[1]) <= end(&spans[0]));
        assert_eq!(trace.threads()[1], "writer");
    }
}
