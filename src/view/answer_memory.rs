//! Memory of answers from their order until they have been sent, so that unread ones do not add up.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::SeqCst};

/// Memory of an answer, which is given back when it has been sent.
pub(super) struct AnswerMemory {
    free: Arc<AtomicU64>,
    bytes: u64,
}

impl AnswerMemory {
    /// Takes this many of the free bytes; `None` if too many answers wait to be read.
    pub(super) fn take(free: &Arc<AtomicU64>, bytes: u64) -> Option<AnswerMemory> {
        let taken = free.fetch_update(SeqCst, SeqCst, |free| free.checked_sub(bytes));
        let free = Arc::clone(free);
        taken.is_ok().then_some(AnswerMemory { free, bytes })
    }
}

impl Drop for AnswerMemory {
    fn drop(&mut self) {
        self.free.fetch_add(self.bytes, SeqCst);
    }
}
