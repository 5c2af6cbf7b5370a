//! Open files by number, as in `/dev/stdout`, `/dev/fd/3` and `/proc/self/fd/3`. This is the only
//! file of `files` with `unsafe`.

use std::fs::File;
use std::io;
use std::path::Path;

/// The number of this process's open file that a path names. Links in its last part are not
/// followed.
#[cfg(unix)]
pub(super) fn number_of(path: &Path) -> Option<i32> {
    let number = number(path)?;
    let folder = folder(path)?;
    let same = |other: &str| {
        Path::new(other)
            .canonicalize()
            .is_ok_and(|real| real == folder)
    };
    // A thread's files are those of its process.
    let process = Path::new("/proc/self").canonicalize();
    let is_own = process.is_ok_and(|process| folder.starts_with(process) && folder.ends_with("fd"));
    (is_own || same("/dev/fd")).then_some(number)
}

/// Returns true if a path names an open file of another process. The text of its link is not always
/// a path.
#[cfg(unix)]
pub(super) fn of_another_process(path: &Path) -> bool {
    let folder = number(path).and_then(|_| folder(path));
    folder.is_some_and(|folder| folder.starts_with("/proc") && folder.ends_with("fd"))
}

#[cfg(unix)]
fn number(path: &Path) -> Option<i32> {
    let name = path.file_name()?.to_str()?;
    let digits = name.bytes().all(|b| b.is_ascii_digit());
    digits.then(|| name.parse().ok())?
}

#[cfg(unix)]
fn folder(path: &Path) -> Option<std::path::PathBuf> {
    super::folder::folder_of(path).canonicalize().ok()
}

/// A second handle of an open file; both share one position.
///
/// # Errors
/// The system's reason, most likely that there is no open file of this number.
#[cfg(unix)]
pub(super) fn duplicate(number: i32) -> io::Result<File> {
    use std::os::fd::BorrowedFd;
    if number < 0 {
        return Err(io::ErrorKind::InvalidInput.into());
    }
    // SAFETY: the number is not -1, which `BorrowedFd` forbids. It is borrowed for this one call,
    // which asks the system to duplicate it. If the number is not open the system says so, and
    // nothing is read, written or closed through it. The user gives the file's path, so the number
    // is not a guess at a handle of another part of the program.
    let borrowed = unsafe { BorrowedFd::borrow_raw(number) };
    borrowed.try_clone_to_owned().map(File::from)
}

#[cfg(not(unix))]
pub(super) fn number_of(_: &Path) -> Option<i32> {
    None
}

#[cfg(not(unix))]
pub(super) fn of_another_process(_: &Path) -> bool {
    false
}

#[cfg(not(unix))]
pub(super) fn duplicate(_: i32) -> io::Result<File> {
    Err(io::ErrorKind::Unsupported.into())
}
