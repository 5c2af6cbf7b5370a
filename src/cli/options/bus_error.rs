//! SIGBUS. The system sends it when a mapped file is read beyond its current end: another program
//! has truncated the file, or its disk has failed. This can neither be prevented nor detected in
//! advance. So a handler ends the process with a message and an exit code, like other file errors.
//!
//! The handler replaces the default action for this case only. Any other cause of SIGBUS is left to
//! the handler that was there before.

#[cfg(target_os = "linux")]
pub use linux::watch;

/// Does nothing: on other systems the reported addresses cannot be distinguished from those of a
/// stack overflow.
#[cfg(not(target_os = "linux"))]
pub fn watch(_: &std::path::Path) {}

#[cfg(target_os = "linux")]
mod linux {
    use phalanx::files::shown_path;
    use std::ffi::c_int;
    use std::mem::MaybeUninit;
    use std::path::Path;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::sync::{Mutex, OnceLock, PoisonError};

    /// Exit code of file errors.
    const CODE: c_int = 1;

    /// Messages for one mapped file, for two, and so on; the last one set names them all. The
    /// handler reads them without a lock.
    static MESSAGES: [OnceLock<String>; 16] = [const { OnceLock::new() }; 16];

    /// The action for SIGBUS that was there before.
    static BEFORE: OnceLock<libc::sigaction> = OnceLock::new();

    /// True once a thread has begun to write the message, which is written only once.
    static REPORTING: AtomicBool = AtomicBool::new(false);

    /// Registers a file that is about to be mapped.
    pub fn watch(path: &Path) {
        static NAMES: Mutex<Vec<String>> = Mutex::new(Vec::new());
        let mut names = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
        let name = shown_path(path);
        if names.contains(&name) {
            return;
        }
        names.push(name);
        if let Some(message) = MESSAGES.get(names.len() - 1) {
            message.get_or_init(|| {
                format!(
                    "error: cannot read {} any more: it was truncated while in use, or its disk failed\n",
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
            // Stored before it is replaced, so that the handler finds it. If a call fails, the
            // process dies of the signal as it would have.
            if libc::sigaction(libc::SIGBUS, std::ptr::null(), &mut before) == 0 {
                BEFORE.get_or_init(|| before);
                libc::sigaction(libc::SIGBUS, &action, std::ptr::null_mut());
            }
        }
    }

    /// Ends the process if a mapped file has no bytes. Otherwise it restores the old action; the
    /// fault repeats as soon as this returns, and the old action handles it.
    ///
    /// It may interrupt anything, so it calls only functions that POSIX lists as safe in a handler
    /// (write, _exit, sigaction, pause), and reads atomics: `OnceLock::get` is one load.
    extern "C" fn on_bus_error(
        signal: c_int,
        info: *mut libc::siginfo_t,
        _context: *mut libc::c_void,
    ) {
        let message = MESSAGES.iter().rev().find_map(OnceLock::get);
        // SAFETY: the system hands a handler with SA_SIGINFO a valid siginfo.
        let missing = unsafe { (*info).si_code } == libc::BUS_ADRERR;
        if let (true, Some(message)) = (missing, message) {
            if REPORTING.swap(true, Ordering::SeqCst) {
                loop {
                    // SAFETY: it has no arguments; the thread that writes the message ends this
                    // one, too.
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
            // SAFETY: the action comes from the system itself.
            unsafe { libc::sigaction(signal, before, std::ptr::null_mut()) };
        }
    }
}
