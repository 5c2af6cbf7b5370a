//! State that all connections share: how far the scene is, and the queue of the pages.

use super::guard::Guard;
use super::queue::Queue;
use serde_json::{Value, json};
use std::collections::VecDeque;
use std::net::{Shutdown, TcpStream};
use std::sync::atomic::{AtomicU64, Ordering::SeqCst};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Instant;

/// State that all connections share.
pub(super) struct ServedScene {
    pub(super) guard: Guard,
    pub(super) queue: Queue,
    /// Bytes of answers that may still be made before others have been read.
    answer_bytes: Arc<AtomicU64>,
    /// Connections that have not shown the token yet, the oldest first.
    strangers: Mutex<VecDeque<Weak<TcpStream>>>,
    /// The step on the way to a picture, as pages are told, and its beginning.
    stage: Mutex<(Value, Instant)>,
}

/// Memory of an answer, which is given back when it has been sent.
pub(super) struct AnswerMemory {
    free: Arc<AtomicU64>,
    bytes: u64,
}

impl Drop for AnswerMemory {
    fn drop(&mut self) {
        self.free.fetch_add(self.bytes, SeqCst);
    }
}

impl ServedScene {
    /// A scene that is being read.
    pub(super) fn new(guard: Guard) -> ServedScene {
        ServedScene {
            guard,
            queue: Queue::default(),
            answer_bytes: Arc::default(),
            strangers: Mutex::default(),
            stage: Mutex::new((json!({ "stage": "reading" }), Instant::now())),
        }
    }

    /// Sets the bytes that answers may take until they have been read.
    pub(super) fn set_answer_bytes(&self, bytes: u64) {
        self.answer_bytes.store(bytes, SeqCst);
    }

    /// Takes memory for an answer; `None` if too many wait to be read.
    pub(super) fn reserve(&self, bytes: u64) -> Option<AnswerMemory> {
        let take = |free: u64| free.checked_sub(bytes);
        let taken = self.answer_bytes.fetch_update(SeqCst, SeqCst, take);
        let free = Arc::clone(&self.answer_bytes);
        taken.is_ok().then_some(AnswerMemory { free, bytes })
    }

    fn strangers(&self) -> MutexGuard<'_, VecDeque<Weak<TcpStream>>> {
        let strangers = self.strangers.lock();
        let mut strangers = strangers.unwrap_or_else(PoisonError::into_inner);
        strangers.retain(|stranger| stranger.strong_count() > 0);
        strangers
    }

    /// Adds a connection. The oldest of more than `most` makes room, so that a flood of them does
    /// not keep those out that are about to show the token.
    pub(super) fn add_stranger(&self, stream: &Arc<TcpStream>, most: usize) {
        let mut strangers = self.strangers();
        strangers.push_back(Arc::downgrade(stream));
        if strangers.len() > most
            && let Some(oldest) = strangers.pop_front().and_then(|oldest| oldest.upgrade())
        {
            // It may have been closed since.
            let _ = oldest.shutdown(Shutdown::Both);
        }
    }

    /// Removes a connection that has shown the token. Returns the number of those that have not.
    pub(super) fn remove_stranger(&self, stream: &Arc<TcpStream>) -> usize {
        let mut strangers = self.strangers();
        strangers.retain(|stranger| stranger.as_ptr() != Arc::as_ptr(stream));
        strangers.len()
    }

    fn stage(&self) -> MutexGuard<'_, (Value, Instant)> {
        self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn set(&self, told: Value) {
        *self.stage() = (told, Instant::now());
    }

    pub(super) fn is_ready(&self) -> bool {
        self.stage().0["stage"] == "ready"
    }

    pub(super) fn state(&self) -> Value {
        let (mut told, since) = self.stage().clone();
        told["seconds"] = json!(since.elapsed().as_secs_f64());
        told
    }
}
