//! History, frames and checkpoints are written on a thread of their own, in the order in which the solve
//! hands them over: a killed run leaves the files that it would have left if the solve had waited for every
//! write, up to some step.

use super::checkpoint::{Checkpoint, RecordHash};
use super::folder::{file_error, remove};
use super::format::{with_format, without_format};
use super::frames::{Frame, encode, frame_file};
use super::history::HistoryLine;
use super::stamp;
use crate::output::{partial_name, write_whole};
use crate::phases::{Phases, collect, measure};
use crate::pipeline::account::written_file::WrittenFile;
use crate::pipeline::error::RunError;
use crate::trace::Trace;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{Builder, Scope, ScopedJoinHandle};

pub const HISTORY_FILE: &str = "history.csv";
pub(crate) const CHECKPOINT_FILE: &str = ".stamps/checkpoint.bin";
pub(crate) const JOURNAL_FILE: &str = ".stamps/journal.bin";

/// So many steps may wait to be written before the solve waits for them: a slow disk holds the solve
/// up, and does not fill the memory.
const MOST_WAITING: usize = 4;

/// The record of a step.
#[derive(Default)]
pub(crate) struct StepRecord {
    /// The line as it stands in the history, and for the journal.
    pub line: Option<(String, HistoryLine)>,
    pub frame: Option<Arc<Frame>>,
    pub checkpoint: Option<Box<Checkpoint>>,
}

/// Hands the records of steps to the thread that writes them.
pub(crate) struct RecordWriter<'scope> {
    records: SyncSender<StepRecord>,
    thread: ScopedJoinHandle<'scope, Result<WrittenRecord, RunError>>,
}

/// The files that a run has written on the way.
pub(crate) struct WrittenRecord {
    pub frames: Vec<WrittenFile>,
    pub phases: Phases,
}

impl<'scope> RecordWriter<'scope> {
    /// Appends to the files, of which `record_hash` is the hash so far.
    pub fn start(
        scope: &'scope Scope<'scope, '_>,
        folder: &Path,
        record_hash: RecordHash,
        trace: Trace,
    ) -> Result<RecordWriter<'scope>, RunError> {
        let data = WriterThread {
            folder: folder.to_owned(),
            record_hash,
            history: Appended::open(folder.join(HISTORY_FILE))?,
            journal: Appended::open(folder.join(JOURNAL_FILE))?,
            frames: Vec::new(),
            trace,
        };
        let (records, queue) = sync_channel(MOST_WAITING);
        let thread = Builder::new().name("writer".to_owned());
        let thread = thread.spawn_scoped(scope, move || data.work(&queue));
        let thread = thread.map_err(|source| file_error("write to", folder, source))?;
        Ok(RecordWriter { records, thread })
    }

    /// Hands a record over. `false`: the thread has met an error, which [`RecordWriter::finish`] returns.
    #[must_use]
    pub fn give(&self, record: StepRecord) -> bool {
        self.records.send(record).is_ok()
    }

    /// Waits until everything is on the disk.
    ///
    /// # Errors
    /// The first file that could not be written; nothing after it has been.
    pub fn finish(self) -> Result<WrittenRecord, RunError> {
        drop(self.records);
        match self.thread.join() {
            Ok(written) => written,
            Err(panic) => std::panic::resume_unwind(panic),
        }
    }
}

/// Data of the writing thread.
struct WriterThread {
    folder: PathBuf,
    record_hash: RecordHash,
    history: Appended,
    journal: Appended,
    frames: Vec<WrittenFile>,
    trace: Trace,
}

impl WriterThread {
    fn work(mut self, queue: &Receiver<StepRecord>) -> Result<WrittenRecord, RunError> {
        let trace = self.trace.clone();
        let (done, phases) = collect(&trace, || {
            queue.iter().try_for_each(|record| self.write(record))
        });
        done?;
        Ok(WrittenRecord {
            frames: self.frames,
            phases,
        })
    }

    /// A checkpoint comes last: it counts on the lines and the frames before it.
    fn write(&mut self, record: StepRecord) -> Result<(), RunError> {
        let WriterThread {
            folder,
            record_hash,
            history,
            journal,
            frames,
            trace,
        } = self;
        if let Some((text, line)) = &record.line {
            measure("history", || {
                history.add(format!("{text}\n").as_bytes())?;
                let bytes = encode(line);
                record_hash.add_line(&bytes);
                journal.add(&bytes)
            })?;
        }
        if let Some(frame) = &record.frame {
            let write = || {
                WrittenFile::measured(frame_file(frame.step), trace, |name| {
                    let bytes = with_format(&encode(&**frame));
                    record_hash.add_frame(&stamp::hash(&bytes));
                    write_whole(&folder.join(name), &bytes)?;
                    Ok::<_, RunError>([frame.raw_bytes(), bytes.len() as u64])
                })
            };
            frames.push(measure("frames", write)?);
        }
        if let Some(mut checkpoint) = record.checkpoint {
            checkpoint.record_hash = record_hash.close();
            let path = folder.join(CHECKPOINT_FILE);
            measure("checkpoints", || {
                write_whole(&path, &with_format(&sealed(&encode(&*checkpoint))))
            })?;
        }
        Ok(())
    }
}

/// A file that only grows.
struct Appended {
    path: PathBuf,
    file: File,
}

impl Appended {
    fn open(path: PathBuf) -> Result<Appended, RunError> {
        match File::options().append(true).open(&path) {
            Ok(file) => Ok(Appended { path, file }),
            Err(source) => Err(file_error("write", &path, source)),
        }
    }

    fn add(&mut self, bytes: &[u8]) -> Result<(), RunError> {
        let Appended { path, file } = self;
        let added = file.write_all(bytes);
        added.map_err(|source| file_error("write", path, source))
    }
}

/// The first lines of the journal, the history as it is in memory, where there are as many.
pub(crate) fn read_journal(folder: &Path, count: usize) -> Option<Vec<HistoryLine>> {
    let bytes = fs::read(folder.join(JOURNAL_FILE)).unwrap_or_default();
    let mut rest = bytes.as_slice();
    let mut line = || {
        let (line, after) = postcard::take_from_bytes(rest).ok()?;
        rest = after;
        Some(line)
    };
    (0..count).map(|_| line()).collect()
}

/// Lets both begin with these lines.
pub(crate) fn begin_history(
    folder: &Path,
    text: &str,
    lines: &[HistoryLine],
) -> Result<(), RunError> {
    write_whole(&folder.join(HISTORY_FILE), text.as_bytes())?;
    let bytes: Vec<u8> = lines.iter().flat_map(encode).collect();
    Ok(write_whole(&folder.join(JOURNAL_FILE), &bytes)?)
}

/// An interrupted run cannot go on from here.
pub(crate) fn forget_checkpoint(folder: &Path) -> Result<(), RunError> {
    for file in [CHECKPOINT_FILE, JOURNAL_FILE] {
        let path = folder.join(file);
        remove(&partial_name(&path))?;
        remove(&path)?;
    }
    Ok(())
}

/// The checkpoint that an interrupted run has left; none where it is damaged.
///
/// # Errors
/// The number of another version's format.
pub(crate) fn read_checkpoint(folder: &Path) -> Result<Option<Checkpoint>, u8> {
    let Ok(bytes) = fs::read(folder.join(CHECKPOINT_FILE)) else {
        return Ok(None);
    };
    let content = unsealed(without_format(&bytes)?);
    Ok(content.and_then(|content| postcard::from_bytes(content).ok()))
}

/// The hash of a text before it: what a loss of power or a bad disk leaves of it is not taken for a state.
fn sealed(bytes: &[u8]) -> Vec<u8> {
    [blake3::hash(bytes).as_bytes(), bytes].concat()
}

pub(crate) fn unsealed(sealed: &[u8]) -> Option<&[u8]> {
    let (hash, bytes) = sealed.split_first_chunk()?;
    (blake3::hash(bytes).as_bytes() == hash).then_some(bytes)
}
