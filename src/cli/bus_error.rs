//! SIGBUS: the system's answer to a read of a mapped file where the file has no bytes any more,
//! because somebody has shortened it since, or because its disk fails. Nobody can prevent that, and
//! no check can see it coming; so a handler ends the process with a message and an exit code, as
//! other errors of files do.
//!
//! It stands in for the default action alone: whatever else raises SIGBUS is left to the handler
//! that was there before.

#[cfg(target_os = "linux")]
use super::output::printable;
#[cfg(target_os = "linux")]
pub use linux::watch;

/// Nothing is done: the addresses that other systems report are not told apart from those of a
/// stack that has overflown.
#[cfg(not(target_os = "linux"))]
pub fn watch(_: &std::path::Path) {}

#[cfg(target_os = "linux")]
mod linux {
    use super::printable;
    use std::ffi::c_int;
    use std::mem::MaybeUninit;
    use std::path::Path;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::sync::{Mutex, OnceLock, PoisonError};

    /// Exit code of what is wrong with files.
    const CODE: c_int = 1;

    /// Messages for one mapped file, two, and so on; the last that is set names them all. Read by
    /// the handler, which takes no lock.
    static MESSAGES: [OnceLock<String>; 16] = [const { OnceLock::new() }; 16];

    /// The action for SIGBUS before.
    static BEFORE: OnceLock<libc::sigaction> = OnceLock::new();

    /// The first thread tells.
    static TELLING: AtomicBool = AtomicBool::new(false);

    /// Expects that a file is about to be mapped.
    pub fn watch(path: &Path) {
        static NAMES: Mutex<Vec<String>> = Mutex::new(Vec::new());
        let mut names = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
        let name = printable(&path.display().to_string()).into_owned();
        if names.contains(&name) {
            return;
        }
        names.push(name);
        if let Some(message) = MESSAGES.get(names.len() - 1) {
            message.get_or_init(|| {
                format!(
                    "error: cannot read {} any more: it has been shortened while it was in use, or its disk fails\n",
                    names.join(" or ")
                )
            });
        }
        if BEFORE.get().is_none() {
            install();
        }
    }

    fn install() {
        // SAFETY: all pointers are to actions of this frame. All zeros is an action (the default,
        // no flags, nothing blocked), and the handler has the signature that SA_SIGINFO asks for.
        // It only does what a handler may do: see `on_bus_error`. SA_ONSTACK, because a thread that
        // faults may have no room on its own stack; where it has no other, nothing changes.
        unsafe {
            let mut before = MaybeUninit::<libc::sigaction>::zeroed().assume_init();
            let mut action = before;
            let handler: extern "C" fn(c_int, *mut libc::siginfo_t, *mut libc::c_void) =
                on_bus_error;
            action.sa_sigaction = handler as libc::sighandler_t;
            action.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK;
            // Kept before it is replaced, so that the handler finds it. Where a call fails, the
            // process dies of the signal as it would have.
            if libc::sigaction(libc::SIGBUS, std::ptr::null(), &mut before) == 0 {
                BEFORE.get_or_init(|| before);
                libc::sigaction(libc::SIGBUS, &action, std::ptr::null_mut());
            }
        }
    }

    /// Ends the process where a mapped file has no bytes; otherwise puts the old action back, to
    /// which the fault, which is repeated as soon as this returns, then goes.
    ///
    /// It may interrupt anything, so it calls only what POSIX lists as safe in a handler (write,
    /// _exit, sigaction, pause), and reads atomics: `OnceLock::get` is one load.
    extern "C" fn on_bus_error(
        signal: c_int,
        info: *mut libc::siginfo_t,
        _context: *mut libc::c_void,
    ) {
        let message = MESSAGES.iter().rev().find_map(OnceLock::get);
        // SAFETY: the system hands a handler with SA_SIGINFO a valid siginfo.
        let missing = unsafe { (*info).si_code } == libc::BUS_ADRERR;
        if let (true, Some(message)) = (missing, message) {
            if TELLING.swap(true, Ordering::SeqCst) {
                loop {
                    // SAFETY: it has no arguments; the thread that tells ends this one, too.
                    unsafe { libc::pause() };
                }
            }
            // SAFETY: the bytes of the message live as long as the process; a short write shortens
            // the message.
            unsafe {
                libc::write(libc::STDERR_FILENO, message.as_ptr().cast(), message.len());
                libc::_exit(CODE)
            }
        }
        if let Some(before) = BEFORE.get() {
            // SAFETY: an action that the system itself gave out.
            unsafe { libc::sigaction(signal, before, std::ptr::null_mut()) };
        }
    }
}
