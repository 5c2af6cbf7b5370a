//! Statuses, and the words of the last error of each thread.

use phalanx::{GeometryError, UpdateError, isa};
use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};

/// `phx_status`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PhxStatus {
    Ok,
    Argument,
    Handle,
    Geometry,
    Busy,
    File,
    Version,
    Internal,
    Refit,
}

/// Why a call is refused.
#[derive(Clone, Debug)]
pub struct ApiError(pub PhxStatus, pub String);

impl ApiError {
    pub fn argument(words: impl Into<String>) -> ApiError {
        ApiError(PhxStatus::Argument, words.into())
    }
}

impl From<GeometryError> for ApiError {
    fn from(error: GeometryError) -> ApiError {
        ApiError(PhxStatus::Geometry, error.to_string())
    }
}

impl From<UpdateError> for ApiError {
    fn from(error: UpdateError) -> ApiError {
        ApiError(PhxStatus::Refit, error.to_string())
    }
}

/// True once a call has found that this CPU lacks what the library is built for. There are no words
/// of its own: they would be made with the instructions that it lacks.
static IS_FOREIGN_CPU: AtomicBool = AtomicBool::new(false);

thread_local! {
    static LAST: RefCell<CString> = RefCell::default();
}

/// Runs a call. A refusal or a panic becomes a status, and its words are kept for this thread.
#[inline(always)]
pub fn guarded(call: impl FnOnce() -> Result<(), ApiError>) -> PhxStatus {
    match catch_unwind(AssertUnwindSafe(call)) {
        Ok(Ok(())) => PhxStatus::Ok,
        Ok(Err(refusal)) => keep(refusal),
        Err(panic) => keep(fault(&*panic)),
    }
}

/// Runs a call that writes its answer at its end, to a place of the caller's.
///
/// # Safety
/// As [`place`].
pub unsafe fn answer<T: Copy>(
    what: &str,
    pointer: *mut T,
    call: impl FnOnce() -> Result<T, ApiError>,
) -> PhxStatus {
    guarded(|| {
        // SAFETY: the caller's.
        let place = unsafe { place(what, pointer) }?;
        *place = call()?;
        Ok(())
    })
}

/// The same, for a place that may be null.
///
/// # Safety
/// As [`place`].
pub unsafe fn answer_if_wanted<T: Copy + Default>(
    what: &str,
    pointer: *mut T,
    call: impl FnOnce() -> Result<T, ApiError>,
) -> PhxStatus {
    let mut unwanted = T::default();
    let pointer = if pointer.is_null() { &raw mut unwanted } else { pointer };
    // SAFETY: the caller's, or this function's.
    unsafe { answer(what, pointer, call) }
}

/// A place of the caller's.
///
/// # Safety
/// Null, misaligned, or memory of a `T`, of which any bits are valid.
#[inline(always)]
pub unsafe fn place<'r, T>(what: &str, pointer: *mut T) -> Result<&'r mut T, ApiError> {
    if !pointer.is_aligned() {
        return Err(misplaced(what));
    }
    // SAFETY: the caller's.
    unsafe { pointer.as_mut() }.ok_or_else(|| misplaced(what))
}

#[cold]
pub fn misplaced(what: &str) -> ApiError {
    ApiError::argument(format!("{what} is null or misaligned"))
}

/// As [`answer`], for the first call of a program.
///
/// # Safety
/// As [`place`].
pub unsafe fn first_answer<T: Copy>(
    what: &str,
    pointer: *mut T,
    call: impl FnOnce() -> Result<T, ApiError>,
) -> PhxStatus {
    if !isa::runs_here() {
        IS_FOREIGN_CPU.store(true, Ordering::Relaxed);
        return PhxStatus::Version;
    }
    // SAFETY: the caller's.
    unsafe { answer(what, pointer, call) }
}

#[cold]
fn keep(ApiError(status, words): ApiError) -> PhxStatus {
    let words = CString::new(words.replace('\0', " ")).unwrap_or_default();
    // The thread's words are gone while it ends.
    let _ = LAST.try_with(|last| last.replace(words));
    status
}

fn fault(panic: &(dyn Any + Send)) -> ApiError {
    let words = panic.downcast_ref::<String>().map(String::as_str);
    let words = words.or(panic.downcast_ref::<&str>().copied());
    let words = format!("a fault in the library: {}", words.unwrap_or("of no words"));
    ApiError(PhxStatus::Internal, words)
}

#[unsafe(no_mangle)]
pub extern "C" fn phx_error_message() -> *const c_char {
    if IS_FOREIGN_CPU.load(Ordering::Relaxed) {
        return c"this CPU lacks what the library is built for: see phx_instruction_set".as_ptr();
    }
    let words = LAST.try_with(|last| last.borrow().as_ptr());
    words.unwrap_or(c"the thread is ending".as_ptr())
}
