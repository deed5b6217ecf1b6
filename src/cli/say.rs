//! Output of the commands. `std`'s own macros panic where nobody reads any more or the disk is full; these
//! let the work go on, and the end of the command tells what was lost.

use std::fmt;
use std::io::{self, ErrorKind, Write};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

static LOST: AtomicBool = AtomicBool::new(false);

/// To standard output. A reader that has read enough, such as `head`, is no error.
pub fn out(text: fmt::Arguments) {
    note(io::stdout().write_fmt(text));
}

/// To standard error: where that cannot be written to, nobody can be told.
pub fn err(text: fmt::Arguments) {
    let _ = io::stderr().write_fmt(text);
}

fn note(written: io::Result<()>) {
    if written.is_err_and(|error| error.kind() != ErrorKind::BrokenPipe) {
        LOST.store(true, Ordering::Relaxed);
    }
}

/// The exit code, or 1 where something could not be printed.
pub fn end(code: ExitCode) -> ExitCode {
    note(io::stdout().flush());
    if !LOST.load(Ordering::Relaxed) {
        return code;
    }
    let text = "standard output could not be written to: is the disk full? Results are kept";
    err(format_args!("  × {text}\n"));
    ExitCode::FAILURE
}

macro_rules! println {
    () => { $crate::cli::say::out(format_args!("\n")) };
    ($($text:tt)*) => { $crate::cli::say::out(format_args!("{}\n", format_args!($($text)*))) };
}

macro_rules! print {
    ($($text:tt)*) => { $crate::cli::say::out(format_args!($($text)*)) };
}

macro_rules! eprintln {
    () => { $crate::cli::say::err(format_args!("\n")) };
    ($($text:tt)*) => { $crate::cli::say::err(format_args!("{}\n", format_args!($($text)*))) };
}

macro_rules! eprint {
    ($($text:tt)*) => { $crate::cli::say::err(format_args!($($text)*)) };
}
