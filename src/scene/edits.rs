//! Stamps of a scene's parts, by which a tree knows what it has to follow.

use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Number that no other scene or edit has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Stamp(u64);

impl Stamp {
    fn new() -> Stamp {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        Stamp(NEXT.fetch_add(1, Relaxed))
    }
}

/// Stamps of a scene's parts. Two scenes with equal stamps of a part have the same part, unless
/// columns were changed by hand.
#[derive(Clone, PartialEq, Eq)]
pub struct Edits {
    /// Which primitives there are, in the world and in meshes, and which of them are hidden.
    topology: (Stamp, usize),
    /// Vertices of the world's own meshes.
    world: Stamp,
    /// Vertices of the meshes that instances show.
    meshes: Vec<Stamp>,
    /// Maps of the instances, which there are, and which of them are hidden.
    instances: Stamp,
}

/// Stamps say nothing to a reader, and differ from run to run.
impl fmt::Debug for Edits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Edits")
    }
}

impl Default for Edits {
    /// The edits of a new scene, which no other equals.
    fn default() -> Self {
        let stamp = Stamp::new();
        Edits {
            topology: (stamp, 0),
            world: stamp,
            meshes: Vec::new(),
            instances: stamp,
        }
    }
}

/// Differences between the scene that a tree was made for and another one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneChanges {
    /// True if primitives are others, or in other meshes; nothing else is known then.
    pub topology: bool,
    /// True if vertices of the world's own meshes have moved.
    pub world: bool,
    /// Meshes of instances whose vertices have moved.
    pub meshes: Vec<usize>,
    /// True if instances are others, or have moved.
    pub instances: bool,
}

impl Edits {
    pub(crate) fn mark_topology(&mut self) {
        self.topology.0 = Stamp::new();
    }

    pub(crate) fn mark_instances(&mut self) {
        self.instances = Stamp::new();
    }

    pub(crate) fn mark_world(&mut self) {
        self.world = Stamp::new();
    }

    pub(crate) fn mark_mesh(&mut self, mesh: usize) {
        if self.meshes.len() <= mesh {
            // Meshes without a stamp of their own have never moved.
            self.meshes.resize(mesh + 1, Stamp(0));
        }
        self.meshes[mesh] = Stamp::new();
    }

    /// The stamps with the number of all primitives: those that were added by hand have no stamp.
    pub(crate) fn with_prims(&self, prims: usize) -> Edits {
        let mut edits = self.clone();
        edits.topology.1 = prims;
        edits
    }

    /// Compares the stamps of a scene with `meshes` meshes with earlier ones.
    pub(crate) fn changes_since(&self, before: &Edits, meshes: usize) -> SceneChanges {
        let moved = |mesh: &usize| self.mesh(*mesh) != before.mesh(*mesh);
        SceneChanges {
            topology: self.topology != before.topology,
            world: self.world != before.world,
            meshes: (0..meshes).filter(moved).collect(),
            instances: self.instances != before.instances,
        }
    }

    fn mesh(&self, mesh: usize) -> Stamp {
        self.meshes.get(mesh).copied().unwrap_or(Stamp(0))
    }
}
