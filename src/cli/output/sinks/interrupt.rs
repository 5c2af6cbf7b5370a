//! SIGINT, SIGTERM and SIGHUP.
//!
//! During a render, a signal requests an orderly stop of the threads. While a file is written in
//! other work, a signal waits until the file is complete. A second signal ends the process at once,
//! as does any signal while neither is the case (a scene is loading, a BVH is being built). It may
//! leave a temporary file behind, which the next run that writes there removes. (Output
//! to a pipe or a device has no temporary file.) The exit code is 130 for SIGINT, 143 for SIGTERM
//! and 129 for SIGHUP, by the convention of shells and schedulers. A SIGHUP disabled by `nohup`
//! stays disabled.

use super::destination::is_replaced;
use super::stderr::message;
use super::stdout::is_dash;
use crate::cli::output::error::{CliError, record_signal, signal_exit_code};
#[cfg(unix)]
use crate::cli::output::summary::process_status;
use phalanx::files::replace_file;
use phalanx::frame::Control;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

const EXIT_AT_ONCE: u8 = 0;
const STOP: u8 = 1;
const WAIT: u8 = 2;
/// A signal arrived while a file was being written.
const SIGNALLED: u8 = 3;

static ANSWER: AtomicU8 = AtomicU8::new(EXIT_AT_ONCE);
static RUNNING: Mutex<Option<Arc<Control>>> = Mutex::new(None);
static SHORTCUT: Mutex<Option<PathBuf>> = Mutex::new(None);

/// Installs handlers for the signals that ask a process to end.
pub fn listen() -> Result<(), CliError> {
    watch_signals().map_err(|e| CliError::Runtime(format!("cannot listen for signals: {e}")))
}

#[cfg(unix)]
fn watch_signals() -> std::io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let mut signals = vec![SIGINT, SIGTERM];
    if ignores(SIGHUP) == Some(false) {
        signals.push(SIGHUP);
    }
    let mut signals = signal_hook::iterator::Signals::new(signals)?;
    let watch = move || signals.forever().for_each(|number| on_signal(number as u8));
    std::thread::Builder::new().spawn(watch).map(drop)
}

/// Returns true if a signal was ignored when the process began; `None` if that is unknown.
#[cfg(unix)]
fn ignores(signal: i32) -> Option<bool> {
    let mask = u64::from_str_radix(&process_status("SigIgn")?, 16).ok()?;
    Some(mask >> (signal - 1) & 1 == 1)
}

#[cfg(not(unix))]
fn watch_signals() -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(|| on_signal(2))
}

/// Handles the signal with this number.
fn on_signal(number: u8) {
    record_signal(number);
    let before = ANSWER.load(Ordering::SeqCst);
    ANSWER.store(after_signal(before), Ordering::SeqCst);
    let running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
    match (before, &*running) {
        (STOP, Some(control)) => control.stop.store(true, Ordering::SeqCst),
        (WAIT, _) => {}
        _ => {
            message("interrupted");
            remove_shortcut();
            std::process::exit(signal_exit_code().into());
        }
    }
}

/// The answer to the next signal: only the first one may wait.
fn after_signal(answer: u8) -> u8 {
    if answer == WAIT { SIGNALLED } else { EXIT_AT_ONCE }
}

/// Keeps a file that leads a browser to a page until the process is interrupted.
#[cfg(feature = "view")]
pub fn keep_shortcut(path: PathBuf) {
    *SHORTCUT.lock().unwrap_or_else(PoisonError::into_inner) = Some(path);
}

/// Removes that file, if there is one.
pub fn remove_shortcut() {
    let mut shortcut = SHORTCUT.lock().unwrap_or_else(PoisonError::into_inner);
    // The user may have removed it.
    let _ = shortcut.take().map(std::fs::remove_file);
}

/// Runs `work`, which stops when the control's `stop` is set.
pub fn interruptible<T>(work: impl FnOnce(&Control) -> T) -> T {
    let control = Arc::new(Control::default());
    *RUNNING.lock().unwrap_or_else(PoisonError::into_inner) = Some(Arc::clone(&control));
    ANSWER.store(STOP, Ordering::SeqCst);
    let result = work(&control);
    ANSWER.store(EXIT_AT_ONCE, Ordering::SeqCst);
    result
}

/// Runs `work`, which writes to `path`. A regular file is written to its end despite signals. A
/// pipe may wait forever for its reader, and leaves no temporary file behind, so a signal ends the
/// process at once.
pub fn block_signals<T>(path: &Path, work: impl FnOnce() -> T) -> Result<T, CliError> {
    if !is_replaced(path) {
        return Ok(work());
    }
    ANSWER.store(WAIT, Ordering::SeqCst);
    let result = work();
    match ANSWER.swap(EXIT_AT_ONCE, Ordering::SeqCst) {
        SIGNALLED => Err(CliError::Interrupted),
        _ => Ok(result),
    }
}

/// Writes a file, whole or not at all, despite signals; `-` is stdout, whose reader may disappear.
pub fn write_file(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), CliError> {
    if is_dash(path) {
        let mut out = BufWriter::new(io::stdout().lock());
        return match fill(&mut out).and_then(|()| out.flush()) {
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
                Err(CliError::cannot_write(path, error))
            }
            _ => Ok(()),
        };
    }
    block_signals(path, || replace_file(path, fill))?.map_err(|e| CliError::cannot_write(path, e))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_signal_never_waits() {
        for first in [STOP, WAIT] {
            let second = after_signal(first);
            assert!(second != STOP && second != WAIT, "{first}");
        }
    }
}
