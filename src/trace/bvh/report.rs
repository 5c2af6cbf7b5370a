//! Updates: how far they may go, what they did, and why they are refused.

#[cfg(doc)]
use super::Bvh;
use phalanx_scene::GeomId;

/// How far [`Bvh::update_with`] may go.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpdateMode {
    /// As [`Bvh::update`] does.
    #[default]
    Auto,
    /// Boxes follow what has moved, and what was removed or hidden goes; no tree is built over
    /// primitives. A frame takes about as long as the one before, and rays may take longer with
    /// each: see [`Bvh::cost_growth`].
    RefitOnly,
    /// Everything is built: the tree is that of [`Bvh::build`].
    Rebuild,
}

/// Kind of work that an update did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpdateWork {
    /// The scene was as the tree was, but for masks.
    #[default]
    Nothing,
    /// The tree has followed, in what the report lists.
    Refitted,
    /// Everything was built anew.
    Rebuilt,
}

/// The work of [`Bvh::update`], and its objects. All lists are ascending, and empty where
/// everything was built.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct UpdateReport {
    /// Kind of the work.
    pub work: UpdateWork,
    /// Geometries whose boxes were refitted, and instances that were added, moved or shown.
    pub refitted: Vec<GeomId>,
    /// Geometries that were added, shown or moved, and got a tree of their own.
    pub built: Vec<GeomId>,
    /// Geometries that no ray hits any more.
    pub removed: Vec<GeomId>,
    /// Prototypes whose boxes were refitted.
    pub refitted_prototypes: Vec<u32>,
    /// Prototypes whose trees were built.
    pub built_prototypes: Vec<u32>,
}

/// Errors of [`UpdateMode::RefitOnly`]. The tree is as it was, and so are its answers.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UpdateError {
    /// The tree is of another scene or from a cache, or primitives were added by hand.
    #[error("the tree knows nothing of this scene: it has to be built")]
    OtherScene,
    /// Something was added or shown.
    #[error("geometries {geometries:?} and prototypes {prototypes:?} have to be built")]
    NotRefittable {
        /// Geometries that need a tree.
        geometries: Vec<GeomId>,
        /// Prototypes that need one.
        prototypes: Vec<u32>,
    },
}

impl UpdateReport {
    pub(super) fn sort(&mut self) {
        self.refitted.sort_unstable();
        self.built.sort_unstable();
        self.removed.sort_unstable();
    }

    /// Returns true if trees are built.
    pub(super) fn has_built(&self) -> bool {
        !(self.built.is_empty() && self.built_prototypes.is_empty())
    }
}
