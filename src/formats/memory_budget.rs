//! Budget of the memory that a scene file takes beyond itself: files that it names, decoded
//! pictures, copied meshes. Memory is requested before it is used.

use std::cell::{Cell, RefCell};
use std::sync::atomic::{AtomicU64, Ordering};

/// Limit of the bytes that may be used, and number of those in use.
#[derive(Debug)]
pub(super) struct MemoryBudget {
    max: u64,
    used: Cell<u64>,
    refused: RefCell<Option<OutOfBudget>>,
}

/// A request for which there was not enough memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct OutOfBudget {
    /// Its purpose, as in "to decode the texture `a.png`".
    pub(super) what: String,
    /// Bytes in use with the request.
    pub(super) needed: u64,
    /// Bytes that may be used.
    pub(super) allowed: u64,
}

impl MemoryBudget {
    /// A budget of this many bytes; without a limit if none is given.
    pub(super) fn of(most: Option<u64>) -> MemoryBudget {
        MemoryBudget {
            max: most.unwrap_or(u64::MAX),
            used: Cell::new(0),
            refused: RefCell::new(None),
        }
    }

    /// Takes bytes for as long as the scene exists. The error is for a message that states their
    /// purpose.
    pub(super) fn take(&self, bytes: u64, what: impl FnOnce() -> String) -> Result<(), String> {
        self.lend(bytes, what)?;
        self.used.set(self.used.get().saturating_add(bytes));
        Ok(())
    }

    /// Checks that bytes are available for temporary use. Otherwise as [`MemoryBudget::take`].
    pub(super) fn lend(&self, bytes: u64, what: impl FnOnce() -> String) -> Result<(), String> {
        let needed = self.used.get().saturating_add(bytes);
        if needed <= self.max {
            return Ok(());
        }
        let mut refused = self.refused.borrow_mut();
        let refusal = refused.get_or_insert_with(|| OutOfBudget {
            what: what(),
            needed,
            allowed: self.max,
        });
        Err(refusal.message())
    }

    /// The bytes that are left, as a counter that several threads take from.
    pub(super) fn shared(&self) -> SharedBudget {
        SharedBudget {
            max: self.max.saturating_sub(self.used.get()),
            used: AtomicU64::new(0),
        }
    }

    /// The first request that was refused.
    pub(super) fn refusal(&self) -> Option<OutOfBudget> {
        self.refused.borrow().clone()
    }
}

/// Bytes that several threads take at once. A thread that has been refused continues to count
/// without making anything, so that in the end the full demand is known.
#[derive(Debug)]
pub(super) struct SharedBudget {
    max: u64,
    used: AtomicU64,
}

impl SharedBudget {
    /// A thread's share.
    pub(super) fn share(&self) -> BudgetShare<'_> {
        BudgetShare {
            of: self,
            taken: 0,
            refused: false,
        }
    }

    /// Returns true if the threads requested more than there is.
    pub(super) fn is_over(&self) -> bool {
        self.used() > self.max
    }

    /// Forgets what was taken beyond this many bytes, because it has been dropped.
    pub(super) fn reset(&self, used: u64) {
        self.used.store(used, Ordering::Relaxed);
    }

    /// Bytes that all threads have taken, or would have taken.
    pub(super) fn used(&self) -> u64 {
        self.used.load(Ordering::Relaxed)
    }
}

/// Bytes that one thread has taken.
#[derive(Debug)]
pub(super) struct BudgetShare<'a> {
    of: &'a SharedBudget,
    /// Bytes not yet added to the shared counter.
    taken: u64,
    refused: bool,
}

/// Bytes after which a thread updates the shared counter, so that threads seldom contend for it.
const STEP: u64 = 1 << 16;

impl BudgetShare<'_> {
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
        let taken = std::mem::take(&mut self.taken);
        let before = self.of.used.fetch_add(taken, Ordering::Relaxed);
        self.refused |= before.saturating_add(taken) > self.of.max;
    }
}

impl Drop for BudgetShare<'_> {
    fn drop(&mut self) {
        self.flush();
    }
}

impl OutOfBudget {
    fn message(&self) -> String {
        let (needed, what, allowed) = (self.needed, &self.what, self.allowed);
        format!("about {needed} bytes would be needed {what}, and {allowed} are allowed")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_taken_counts_and_what_is_lent_does_not() {
        let budget = MemoryBudget::of(Some(100));
        let what = || String::from("for a test");
        assert_eq!(budget.lend(100, what), Ok(()));
        assert_eq!(budget.take(60, what), Ok(()));
        assert!(budget.lend(41, what).is_err());
        assert_eq!(budget.take(40, what), Ok(()));
        let refused = budget.refusal().expect("one");
        assert_eq!((refused.needed, refused.allowed), (101, 100));
        assert_eq!(MemoryBudget::of(None).take(u64::MAX, what), Ok(()));
    }

    #[test]
    fn threads_are_refused_together_and_all_is_counted() {
        let budget = MemoryBudget::of(Some(4 * STEP));
        let shared = budget.shared();
        let (mut one, mut other) = (shared.share(), shared.share());
        assert!(one.take(3 * STEP) && other.take(STEP / 2) && one.take(7));
        assert!(!other.take(STEP) && !other.take(1));
        drop((one, other));
        assert_eq!(shared.used(), 4 * STEP + STEP / 2 + 8);
        assert!(budget.lend(shared.used(), || "for a test".into()).is_err());
    }
}
