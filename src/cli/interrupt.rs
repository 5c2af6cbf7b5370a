//! SIGINT and SIGTERM.
//!
//! While a render runs, a signal asks it to stop, so that workers leave in order; a second one, or one while nothing
//! stoppable runs (a scene is loading, a tree is being built), ends the process at once. While a file is being written
//! no signal does, because an exit there would leave a temporary file behind: the signal waits, or asks the writing to
//! stop. The exit code is 130 in every case.

use super::failure::Failure;
use phalanx::frame::Control;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

const EXIT_AT_ONCE: u8 = 0;
const STOP: u8 = 1;
const WAIT: u8 = 2;
/// A signal came while a file was being written.
const CAME: u8 = 3;
/// Stop what writes a file, which then takes its temporary file away.
const STOP_WRITING: u8 = 4;

static ANSWER: AtomicU8 = AtomicU8::new(EXIT_AT_ONCE);
static RUNNING: Mutex<Option<Arc<Control>>> = Mutex::new(None);

/// Takes over SIGINT and SIGTERM.
pub fn listen() -> Result<(), Failure> {
    ctrlc::set_handler(|| match ANSWER.load(Ordering::SeqCst) {
        answer @ (STOP | STOP_WRITING) => {
            let next = if answer == STOP { EXIT_AT_ONCE } else { CAME };
            ANSWER.store(next, Ordering::SeqCst);
            let running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(control) = &*running {
                control.stop.store(true, Ordering::SeqCst);
            }
        }
        WAIT | CAME => ANSWER.store(CAME, Ordering::SeqCst),
        _ => {
            super::output::note("interrupted");
            std::process::exit(130);
        }
    })
    .map_err(|e| Failure::Runtime(format!("cannot listen for signals: {e}")))
}

/// Runs `work`, which heeds the control's `stop`.
pub fn stoppable<T>(work: impl FnOnce(&Control) -> T) -> T {
    heeding(STOP, work)
}

/// Runs `work`, which writes a file and heeds the control's `stop`; further signals wait until it has.
pub fn stoppable_writing<T>(work: impl FnOnce(&Control) -> T) -> T {
    heeding(STOP_WRITING, work)
}

fn heeding<T>(answer: u8, work: impl FnOnce(&Control) -> T) -> T {
    let control = Arc::new(Control::default());
    *RUNNING.lock().unwrap_or_else(PoisonError::into_inner) = Some(Arc::clone(&control));
    ANSWER.store(answer, Ordering::SeqCst);
    let result = work(&control);
    ANSWER.store(EXIT_AT_ONCE, Ordering::SeqCst);
    result
}

/// Runs `work`, which writes a file, to its end whatever signal comes.
pub fn undisturbed<T>(work: impl FnOnce() -> T) -> Result<T, Failure> {
    ANSWER.store(WAIT, Ordering::SeqCst);
    let result = work();
    match ANSWER.swap(EXIT_AT_ONCE, Ordering::SeqCst) {
        CAME => Err(Failure::Interrupted),
        _ => Ok(result),
    }
}
