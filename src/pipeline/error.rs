//! Why a run ended early.

use crate::gmsh::GmshError;
use crate::meshio::MeshioError;
use crate::output::WriteError;
use crate::output::animation::AnimationError;
use crate::output::picture::PictureError;
use crate::output::pvd::PvdError;
use crate::output::vtu::VtuError;
use crate::pipeline::read::source::InputError;
use crate::statics::StaticsError;
use std::io;
use std::path::PathBuf;
use thiserror::Error;

/// Why a run ended early.
#[derive(Debug, Error)]
pub enum RunError {
    /// Exit code 2.
    #[error(transparent)]
    Input(Box<InputError>),
    /// Exit code 1, like all that follow.
    #[error(transparent)]
    Gmsh(Box<GmshError>),
    #[error(transparent)]
    Meshio(Box<MeshioError>),
    #[error(transparent)]
    Statics(#[from] StaticsError),
    #[error(transparent)]
    Results(#[from] ResultsError),
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error("cannot {action} {}: {source}", .path.display())]
    File {
        action: &'static str,
        path: PathBuf,
        source: io::Error,
    },
    /// The results up to this step have been written.
    #[error("the run stopped after step {step}: {reason}")]
    Stopped {
        step: usize,
        reason: String,
        folder: PathBuf,
    },
    /// `holder`: who writes there, if that is known.
    #[error("another run is writing to {}{}", .folder.display(), by(.holder))]
    Busy { folder: PathBuf, holder: String },
    #[error("{message}")]
    Viewer { message: String, help: String },
}

fn by(holder: &str) -> String {
    match holder {
        "" => String::new(),
        holder => format!(": {holder}"),
    }
}

impl RunError {
    /// The advice that follows the message.
    pub fn help(&self) -> Option<String> {
        match self {
            RunError::Stopped { folder, .. } => Some(format!(
                "the last good state is in {}: look at the damage there. Smaller load steps, \
                 `control: event-driven` or a support that holds what comes loose may help",
                folder.display()
            )),
            RunError::Busy { .. } => Some(
                "wait until it has ended, or end it: what it has done is kept, and the next run goes on"
                    .to_owned(),
            ),
            RunError::Viewer { help, .. } => Some(help.clone()),
            RunError::Statics(StaticsError::Memory { .. }) => Some(
                "choose a larger `spacing` or a smaller `horizon`, finite elements where no crack will go, \
                 or a machine with more memory"
                    .to_owned(),
            ),
            RunError::File { .. } | RunError::Write(_) => Some(
                "is there space, and may you write there? `--results FOLDER` chooses another place"
                    .to_owned(),
            ),
            _ => None,
        }
    }
}

impl From<InputError> for RunError {
    fn from(error: InputError) -> RunError {
        RunError::Input(Box::new(error))
    }
}

/// An error of writing the results.
#[derive(Debug, Error)]
pub enum ResultsError {
    #[error(transparent)]
    Vtu(#[from] VtuError),
    #[error(transparent)]
    Pvd(#[from] PvdError),
    #[error(transparent)]
    Picture(#[from] PictureError),
    #[error(transparent)]
    Animation(#[from] AnimationError),
    #[error(transparent)]
    Write(#[from] WriteError),
}
