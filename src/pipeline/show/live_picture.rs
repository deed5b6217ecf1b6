//! `damage.png` while a run goes: of a state a few seconds old at most, from the first break on. Its content
//! depends on the clock, so it is no result: the solve stage removes it when it ends, and the output stage
//! draws the last state.

use super::damage_picture::{DAMAGE_PICTURE, damage_picture};
use super::deformed::Deformed;
use super::pictures::put;
use crate::fracture::state::State;
use crate::model::Model;
use crate::output::picture::PictureError;
use crate::pipeline::read::plan::Plan;
use crate::pipeline::read::spec::{Format, PictureKind};
use rayon::ThreadPoolBuilder;
use std::thread::{Builder, Scope, ScopedJoinHandle};
use std::time::{Duration, Instant};

/// Time between two pictures: long enough that they cost under a hundredth of the run's time.
const PERIOD: Duration = Duration::from_secs(5);

/// Draws the states of a run, each on a thread of its own, for which the solve does not wait.
pub(crate) struct LivePicture<'scope, 'env> {
    scope: &'scope Scope<'scope, 'env>,
    plan: &'env Plan,
    model: &'env Model,
    thread: Option<ScopedJoinHandle<'scope, ()>>,
    last: Option<Instant>,
}

impl<'scope, 'env> LivePicture<'scope, 'env> {
    pub fn new(
        scope: &'scope Scope<'scope, 'env>,
        plan: &'env Plan,
        model: &'env Model,
    ) -> LivePicture<'scope, 'env> {
        LivePicture {
            scope,
            plan,
            model,
            thread: None,
            last: None,
        }
    }

    /// Draws a state in which bonds have broken, if the last picture is old and finished.
    pub fn update(&mut self, state: &State) {
        let (plan, model) = (self.plan, self.model);
        let is_wanted = plan.output.pictures.wants(PictureKind::Damage)
            && plan.output.formats.contains(&Format::Png);
        let is_recent = self.last.is_some_and(|last| last.elapsed() < PERIOD);
        let is_drawing = (self.thread.as_ref()).is_some_and(|thread| !thread.is_finished());
        if !is_wanted || is_recent || is_drawing || state.changes.is_empty() {
            return;
        }
        let step = state.step;
        let (displacement, integrity) = (state.displacement.clone(), state.integrity.clone());
        let draw = move || {
            let body = Deformed::new(plan, model, &displacement);
            let picture = damage_picture(plan, &body, Some(step), &integrity).compose()?;
            put(&picture, Format::Png, &plan.folder.join(DAMAGE_PICTURE))
        };
        let draw = move || {
            // The threads of the solve wait for the end of this one: it needs a pool of its own.
            if let Ok(pool) = ThreadPoolBuilder::new().num_threads(1).build() {
                // The run does not fail for a picture that is no result.
                let _: Result<_, PictureError> = pool.install(draw);
            }
        };
        let thread = Builder::new().name("damage picture".to_owned());
        self.thread = thread.spawn_scoped(self.scope, draw).ok();
        self.last = Some(Instant::now());
    }
}
