//! Ledger of the memory that a scene file takes beyond itself: files that it names, decoded
//! pictures, copied meshes. Memory is requested before it is used.

use std::fmt::Display;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Limit of the bytes that may be used, and number of those in use. Threads share it.
#[derive(Debug)]
pub(super) struct MemoryLedger {
    max: u64,
    used: AtomicU64,
    refused: OnceLock<OverLimit>,
}

/// A request for which there was not enough memory.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("about {needed} bytes would be needed {what}, and {allowed} are allowed")]
pub(super) struct OverLimit {
    /// Its purpose, as in "to decode the texture `a.png`".
    pub(super) what: String,
    /// Bytes in use with the request.
    pub(super) needed: u64,
    /// Bytes that may be used.
    pub(super) allowed: u64,
}

impl From<OverLimit> for String {
    fn from(refusal: OverLimit) -> String {
        refusal.to_string()
    }
}

impl MemoryLedger {
    /// A ledger of this many bytes; without a limit if none is given.
    pub(super) fn of(most: Option<u64>) -> MemoryLedger {
        MemoryLedger {
            max: most.unwrap_or(u64::MAX),
            used: AtomicU64::new(0),
            refused: OnceLock::new(),
        }
    }

    /// Takes bytes for as long as the scene exists. The error is for a message that states their
    /// purpose.
    pub(super) fn take(&self, bytes: u64, what: impl Display) -> Result<(), OverLimit> {
        self.lend(bytes, what)?;
        self.used.store(self.used().saturating_add(bytes), Relaxed);
        Ok(())
    }

    /// Checks that bytes are available for temporary use. Otherwise as [`MemoryLedger::take`].
    pub(super) fn lend(&self, bytes: u64, what: impl Display) -> Result<(), OverLimit> {
        let needed = self.used().saturating_add(bytes);
        if needed <= self.max {
            return Ok(());
        }
        let refusal = self.refused.get_or_init(|| OverLimit {
            what: what.to_string(),
            needed,
            allowed: self.max,
        });
        Err(refusal.clone())
    }

    /// The share of a thread, which takes bytes while others do.
    pub(super) fn share(&self) -> LedgerShare<'_> {
        LedgerShare {
            ledger: self,
            taken: 0,
            refused: false,
        }
    }

    /// Returns true if threads have requested more than there is.
    pub(super) fn is_over(&self) -> bool {
        self.used() > self.max
    }

    /// Bytes in use, with those that threads were refused.
    pub(super) fn used(&self) -> u64 {
        self.used.load(Relaxed)
    }

    /// Forgets what was taken beyond this many bytes, because it has been dropped.
    pub(super) fn reset(&self, used: u64) {
        self.used.store(used, Relaxed);
    }

    /// The first request that was refused.
    pub(super) fn refusal(&self) -> Option<OverLimit> {
        self.refused.get().cloned()
    }
}

/// Bytes that one thread has taken. A thread that has been refused continues to count without
/// making anything, so that in the end the full demand is known.
#[derive(Debug)]
pub(super) struct LedgerShare<'a> {
    ledger: &'a MemoryLedger,
    /// Bytes not yet added to the ledger.
    taken: u64,
    refused: bool,
}

/// Bytes after which a thread updates the ledger, so that threads seldom contend for it.
const STEP: u64 = 1 << 16;

impl LedgerShare<'_> {
    /// Takes bytes; returns false, from then on, if there were none left.
    #[inline]
    pub(super) fn take(&mut self, bytes: u64) -> bool {
        self.taken = self.taken.saturating_add(bytes);
        if self.taken >= STEP {
            self.flush();
        }
        !self.refused
    }

    #[cold]
    fn flush(&mut self) {
        let bytes = std::mem::take(&mut self.taken);
        let before = self.ledger.used.fetch_add(bytes, Relaxed);
        self.refused |= before.saturating_add(bytes) > self.ledger.max;
    }
}

impl Drop for LedgerShare<'_> {
    fn drop(&mut self) {
        self.flush();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_taken_counts_and_what_is_lent_does_not() {
        let memory = MemoryLedger::of(Some(100));
        let what = "for a test";
        assert_eq!(memory.lend(100, what), Ok(()));
        assert_eq!(memory.take(60, what), Ok(()));
        assert!(memory.lend(41, what).is_err());
        assert_eq!(memory.take(40, what), Ok(()));
        let refused = memory.refusal().expect("one");
        assert_eq!((refused.needed, refused.allowed), (101, 100));
        assert_eq!(MemoryLedger::of(None).take(u64::MAX, what), Ok(()));
    }

    #[test]
    fn threads_are_refused_together_and_all_is_counted() {
        let memory = MemoryLedger::of(Some(4 * STEP));
        let (mut one, mut other) = (memory.share(), memory.share());
        assert!(one.take(3 * STEP) && other.take(STEP / 2) && one.take(7));
        assert!(!other.take(STEP) && !other.take(1));
        drop((one, other));
        assert_eq!(memory.used(), 4 * STEP + STEP / 2 + 8);
        assert!(memory.is_over() && memory.lend(0, "for a test").is_err());
    }
}
