//! State that all connections share: how far the scene is, and the queue of the pages.

use super::guard::Guard;
use super::queue::Queue;
use serde_json::{Value, json};
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// State that all connections share.
pub(super) struct ServedScene {
    pub(super) guard: Guard,
    pub(super) queue: Queue,
    /// Bytes of answers that may still be made before others have been read.
    pub(super) answer_bytes: Arc<AtomicU64>,
    /// The step on the way to a picture, as pages are told, and its beginning.
    stage: Mutex<(Value, Instant)>,
}

impl ServedScene {
    /// A scene that is being read.
    pub(super) fn new(guard: Guard) -> ServedScene {
        ServedScene {
            guard,
            queue: Queue::default(),
            answer_bytes: Arc::default(),
            stage: Mutex::new((json!({ "stage": "reading" }), Instant::now())),
        }
    }

    fn stage(&self) -> MutexGuard<'_, (Value, Instant)> {
        self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn set(&self, state: Value) {
        *self.stage() = (state, Instant::now());
    }

    pub(super) fn is_ready(&self) -> bool {
        self.stage().0["stage"] == "ready"
    }

    pub(super) fn state(&self) -> Value {
        let (mut state, since) = self.stage().clone();
        state["seconds"] = json!(since.elapsed().as_secs_f64());
        state
    }
}
