//! Locks on files that one process at a time may add to.

use std::fs::{File, TryLockError};

/// Locks a file for this process until it is closed. Returns false if another process has the lock.
///
/// Some network file systems have no locks: there nothing is refused, because what two processes
/// add to one file is still sound.
pub(super) fn lock_exclusive(file: &File) -> bool {
    !matches!(file.try_lock(), Err(TryLockError::WouldBlock))
}
