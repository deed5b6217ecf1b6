//! VTU parts and pictures of a run that still goes, drafted on a thread of its own.
//!
//! The solve never waits for it: a frame that comes while others wait is passed over, and the output
//! stage makes its files from `frames/`, as it does those that could not be written here (and then
//! reports it, if they cannot be written there either). It works on one thread, outside of the pool on
//! which the solve is parallel.

use super::damage_picture::damage_picture;
use super::deformed::Deformed;
use super::mesh_picture::mesh_picture;
use super::parts::Parts;
use super::pictures::{Sheet, put};
use crate::fracture::state::State;
use crate::output::picture::PictureError;
use crate::phases::Phases;
use crate::pipeline::account::made::Made;
use crate::pipeline::error::ResultsError;
use crate::pipeline::read::spec::{Format, PictureKind};
use crate::pipeline::record::frames::Frame;
use crate::pipeline::record::sparse_integrity::SparseIntegrity;
use crate::trace::Trace;
use rayon::ThreadPoolBuilder;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{Builder, Scope, ScopedJoinHandle};
use std::time::{Duration, Instant};

/// Frames that may wait.
const MOST_WAITING: usize = 2;

/// How often the picture of a run that goes is drawn again: seldom enough to cost under a hundredth
/// of the run's time.
const LATEST_EVERY: Duration = Duration::from_secs(5);

enum Order {
    Frame(Arc<Frame>),
    /// `damage.png` while a run goes: from the first break on, of a state a few seconds old at most.
    /// What it shows depends on the clock, so it is no result: it is taken away when the solve stage
    /// ends, and the output stage draws the last state.
    Latest(Latest),
}

/// A state to be drawn.
struct Latest {
    step: usize,
    displacement: Vec<[f64; 2]>,
    integrity: SparseIntegrity,
}

/// The end of the queue at which orders are given; idle if there is no thread to be had.
pub(crate) struct Drafter<'scope> {
    orders: SyncSender<Order>,
    thread: Option<ScopedJoinHandle<'scope, Drafts>>,
    stop: Arc<AtomicBool>,
    drafts_frames: bool,
    /// When the latest state was last drawn.
    drawn: Option<Instant>,
}

/// What has been drafted, and what it took.
#[derive(Default)]
pub(crate) struct Drafts {
    pub made: Vec<Made>,
    pub phases: Phases,
}

impl<'scope> Drafter<'scope> {
    /// `folder`: where drafts go; without one, the latest picture is all that is drawn.
    pub fn start<'env: 'scope>(
        scope: &'scope Scope<'scope, 'env>,
        parts: Parts<'env>,
        folder: Option<PathBuf>,
        trace: Trace,
    ) -> Drafter<'scope> {
        let (orders, queue) = sync_channel(MOST_WAITING);
        let stop = Arc::new(AtomicBool::new(false));
        let drafts_frames = folder.is_some();
        let desk = Desk {
            parts,
            folder,
            stop: stop.clone(),
            drafts: Drafts {
                made: Vec::new(),
                phases: Phases::traced(trace),
            },
        };
        let work = move || {
            let pool = ThreadPoolBuilder::new().num_threads(1);
            let pool = pool.thread_name(|_| "drafter".to_owned()).build();
            pool.map_or_else(
                |_| Drafts::default(),
                |pool| pool.install(|| desk.work(queue)),
            )
        };
        Drafter {
            orders,
            thread: Builder::new().spawn_scoped(scope, work).ok(),
            stop,
            drafts_frames,
            drawn: None,
        }
    }

    pub fn frame(&self, frame: &Arc<Frame>) {
        if self.drafts_frames {
            let _ = self.orders.try_send(Order::Frame(frame.clone()));
        }
    }

    /// Draws the latest state if bonds have broken and the last picture is old.
    pub fn latest(&mut self, parts: Parts, state: &State) {
        let is_new = (self.drawn).is_some_and(|drawn| drawn.elapsed() < LATEST_EVERY);
        let is_whole = state.integrity == parts.model.integrity;
        let output = &parts.plan.output;
        let is_wanted =
            output.pictures.wants(PictureKind::Damage) && output.formats.contains(&Format::Png);
        if is_new || is_whole || !is_wanted {
            return;
        }
        let latest = Latest {
            step: state.step,
            displacement: state.displacement.clone(),
            integrity: SparseIntegrity::new(&state.integrity),
        };
        if self.orders.try_send(Order::Latest(latest)).is_ok() {
            self.drawn = Some(Instant::now());
        }
    }

    /// Ends after what is being drafted now.
    pub fn finish(self) -> Drafts {
        self.stop.store(true, Ordering::Relaxed);
        drop(self.orders);
        match self.thread.map(ScopedJoinHandle::join) {
            Some(Ok(drafts)) => drafts,
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            None => Drafts::default(),
        }
    }
}

/// The thread's own.
struct Desk<'a> {
    parts: Parts<'a>,
    folder: Option<PathBuf>,
    stop: Arc<AtomicBool>,
    drafts: Drafts,
}

impl Desk<'_> {
    fn work(mut self, queue: Receiver<Order>) -> Drafts {
        if let Some(folder) = &self.folder
            && is_drafted(&self.parts, PictureKind::Mesh)
        {
            let file = Sheet::Mesh.file(Format::Png);
            let path = folder.join(&file);
            self.picture(file, |parts| {
                let mesh = mesh_picture(parts.plan, parts.model).compose()?;
                put(&mesh, Format::Png, &path)
            });
        }
        for order in queue {
            if self.stop.load(Ordering::Relaxed) {
                break;
            }
            match order {
                Order::Frame(frame) => self.frame(&frame),
                Order::Latest(latest) => {
                    let folder = self.parts.plan.folder.clone();
                    let made = self.drafts.made.len();
                    let file = Sheet::Damage.file(Format::Png);
                    let Latest {
                        step,
                        displacement,
                        integrity,
                    } = latest;
                    self.damage(file, &folder, step, &displacement, &integrity);
                    // Of no state in particular.
                    self.drafts.made.truncate(made);
                }
            }
        }
        self.drafts
    }

    fn frame(&mut self, frame: &Frame) {
        let Some(folder) = self.folder.clone() else {
            return;
        };
        let Desk { parts, drafts, .. } = self;
        let trace = drafts.phases.trace().clone();
        let write = |kind| parts.write(kind, frame, Some(frame.step), &folder, &trace);
        let written: Vec<Result<Made, ResultsError>> =
            (drafts.phases).measure("vtu", || parts.kinds().into_iter().map(write).collect());
        drafts.made.extend(written.into_iter().flatten());
        let is_pictured = parts.plan.output.pictures_at.contains(&frame.step);
        if is_pictured && is_drafted(parts, PictureKind::Damage) {
            let file = Sheet::DamageAt(frame.step).file(Format::Png);
            let Frame {
                displacement,
                integrity,
                ..
            } = frame;
            self.damage(file, &folder, frame.step, displacement, integrity);
        }
    }

    fn damage(
        &mut self,
        file: String,
        folder: &Path,
        step: usize,
        displacement: &[[f64; 2]],
        integrity: &SparseIntegrity,
    ) {
        let path = folder.join(&file);
        self.picture(file, |parts| {
            let body = Deformed::new(parts.model, displacement);
            let picture = damage_picture(parts.plan, &body, Some(step), &integrity.to_vec());
            put(&picture.compose()?, Format::Png, &path)
        });
    }

    fn picture(
        &mut self,
        file: String,
        draw: impl FnOnce(&Parts) -> Result<[u64; 2], PictureError>,
    ) {
        let Desk { parts, drafts, .. } = self;
        let trace = drafts.phases.trace().clone();
        let draw = || Made::measured(file, &trace, |_| draw(parts));
        drafts
            .made
            .extend(drafts.phases.measure("pictures", draw).ok());
    }
}

/// Whether a picture is drafted: other formats are left to the output stage.
fn is_drafted(parts: &Parts, kind: PictureKind) -> bool {
    let output = &parts.plan.output;
    output.pictures.wants(kind) && output.formats() == [Format::Png]
}
