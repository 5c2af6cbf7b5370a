//! Acceleration structures: each engine needs one in addition to the scene.

use super::settings::{Engine, Settings};
use phalanx_oracle::TwoLevelBvh;
use phalanx_scene::Scene;
use phalanx_trace::Kernel;
use phalanx_trace::bvh::{BuildSettings, Bvh};

/// The acceleration structure of an engine.
pub struct Accel(AccelKind);

enum AccelKind {
    Packets(Box<Bvh>),
    Oracle(TwoLevelBvh),
}

/// An engine with its tree, which must be the scene's.
#[derive(Clone, Copy)]
pub enum AccelRef<'a> {
    /// The packet engine with its tree.
    Packets(&'a Bvh),
    /// The oracle with its tree.
    Oracle(&'a TwoLevelBvh),
}

/// Figures of a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeStats {
    /// Number of nodes. The packet engine's hold two boxes each, and its leaves do not count; the
    /// oracle's leaves do.
    pub nodes: usize,
    /// Longest path from the root, the root counting 1.
    pub depth: usize,
    /// Surface area heuristic cost: expected node visits plus primitive tests of a random ray
    /// through the root box.
    pub sah: f64,
    /// Bytes held by the nodes.
    pub node_bytes: usize,
    /// Bytes held by the primitives in leaf order.
    pub prim_bytes: usize,
    /// Bytes of the same tree with more children per node; 0 if it has not been built.
    pub wide_bytes: usize,
}

impl TreeStats {
    /// Figures of the packet engine's tree.
    pub fn of(bvh: &Bvh) -> TreeStats {
        TreeStats {
            nodes: bvh.nodes().len(),
            depth: bvh.depth(),
            sah: bvh.sah(),
            node_bytes: bvh.node_bytes(),
            prim_bytes: bvh.prim_bytes(),
            wide_bytes: bvh.wide_bytes(),
        }
    }
}

impl Accel {
    /// Builds the tree of an engine with the default settings. The scene must have passed
    /// [`Scene::validate`].
    pub fn build(scene: &Scene, engine: Engine) -> Accel {
        Accel::build_with(scene, engine, &BuildSettings::default())
    }

    /// Builds the tree of an engine. The settings apply to the packet engine: the oracle always
    /// builds in the same way, on one thread.
    pub fn build_with(scene: &Scene, engine: Engine, settings: &BuildSettings) -> Accel {
        Accel(match engine {
            Engine::Simd => AccelKind::Packets(Box::new(Bvh::build_with(scene, settings))),
            Engine::Scalar => AccelKind::Oracle(TwoLevelBvh::build(scene)),
        })
    }

    /// The packet engine with a tree built elsewhere, which must be the scene's.
    pub fn with_tree(bvh: Bvh) -> Accel {
        Accel(AccelKind::Packets(Box::new(bvh)))
    }

    /// The engine and its tree.
    pub fn accel(&self) -> AccelRef<'_> {
        match &self.0 {
            AccelKind::Packets(bvh) => AccelRef::Packets(bvh),
            AccelKind::Oracle(bvh) => AccelRef::Oracle(bvh),
        }
    }

    /// Returns true if [`Accel::build_wide_bvh`] has nothing left to build for a frame.
    pub fn is_ready(&self, settings: &Settings) -> bool {
        match &self.0 {
            AccelKind::Packets(bvh) => {
                let kernel = settings.kernel.for_frame(bvh, settings.camera_rays());
                bvh.has_wide() || !kernel.is_wide()
            }
            AccelKind::Oracle(_) => true,
        }
    }

    /// Builds the structures that the kernel of a frame needs in addition to the binary tree.
    /// Otherwise a render does so itself, and the time counts toward the frame's.
    pub fn build_wide_bvh(&self, settings: &Settings) {
        if let AccelKind::Packets(bvh) = &self.0 {
            build_wide_bvh(bvh, settings);
        }
    }

    /// Figures of the tree.
    pub fn tree_stats(&self) -> TreeStats {
        match &self.0 {
            AccelKind::Packets(bvh) => TreeStats::of(bvh),
            AccelKind::Oracle(bvh) => TreeStats {
                nodes: bvh.world().node_count(),
                depth: bvh.world().depth(),
                sah: bvh.world().sah(),
                node_bytes: bvh.memory_bytes(),
                prim_bytes: 0,
                wide_bytes: 0,
            },
        }
    }
}

/// Selects the kernel for a frame, and builds the structures that it needs.
pub(super) fn build_wide_bvh(bvh: &Bvh, settings: &Settings) -> Kernel {
    let kernel = settings.kernel.for_frame(bvh, settings.camera_rays());
    if kernel.is_wide() {
        bvh.build_wide(settings.threads.max(1));
    }
    kernel
}
