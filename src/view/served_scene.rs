//! State that all connections share: how far the scene is, and the queue of the pages.

use super::guard::Guard;
use super::queue::Queue;
use serde_json::{Value, json};
use std::sync::atomic::AtomicUsize;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// State that all connections share.
pub(super) struct ServedScene {
    pub(super) guard: Guard,
    pub(super) queue: Queue,
    stage: Mutex<SceneStage>,
    pub(super) connections: AtomicUsize,
}

/// A step on the way to a picture.
struct SceneStage {
    name: &'static str,
    since: Instant,
    told: Value,
}

impl SceneStage {
    fn new(name: &'static str, told: Value) -> SceneStage {
        let since = Instant::now();
        SceneStage { name, since, told }
    }
}

impl ServedScene {
    /// A scene that is being read.
    pub(super) fn new(guard: Guard) -> ServedScene {
        ServedScene {
            guard,
            queue: Queue::default(),
            stage: Mutex::new(SceneStage::new("reading", json!({}))),
            connections: AtomicUsize::new(0),
        }
    }

    fn stage(&self) -> MutexGuard<'_, SceneStage> {
        self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn set(&self, name: &'static str, told: Value) {
        *self.stage() = SceneStage::new(name, told);
    }

    pub(super) fn is_ready(&self) -> bool {
        self.stage().name == "ready"
    }

    pub(super) fn state(&self) -> Value {
        let stage = self.stage();
        let mut told = stage.told.clone();
        told["stage"] = json!(stage.name);
        told["seconds"] = json!(stage.since.elapsed().as_secs_f64());
        told
    }
}
