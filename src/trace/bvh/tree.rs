//! The tree of a scene: nodes and primitives in leaf order, of the world and of every mesh.

use super::geometry_starts::GeometryStarts;
use super::tree_parts::TreeParts;
use super::{LeafKind, LeafPrims, Node, WideBvh};
use phalanx_scene::{Column, ForkSafeOnce};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// The trees of a scene, with everything that a ray can hit: built by [`Bvh::build`], queried by
/// [`Bvh::intersect`] and [`Bvh::intersect_batch`].
///
/// There is the world's tree, with a root at node 0 that always exists, and one tree per instanced
/// mesh. Instances of a mesh continue at the root of its tree. Geometries that came after the build
/// have trees of their own, which the root leads to. A `Bvh` may be shared among threads,
/// all of its queries take `&self`, and no answer depends on the trees' shape.
///
/// ```
/// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
/// use phalanx::{Bvh, Ray, Scene};
///
/// let mut scene = Scene::new();
/// scene.add_spheres(&[[0.0; 3]], &[1.0])?;
/// let bvh = Bvh::build(&scene);
/// let ray = Ray::new([0.0, 0.0, -3.0], [0.0, 0.0, 1.0]);
/// let other = std::thread::scope(|scope| scope.spawn(|| bvh.intersect(&ray)).join());
/// assert_eq!(other.expect("a result"), bvh.intersect(&ray));
/// # Ok::<(), phalanx::GeometryError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Bvh {
    pub(super) nodes: Column<Node>,
    pub(super) slots: LeafPrims,
    pub(super) depth: usize,
    pub(super) sah: f64,
    pub(super) wide: ForkSafeOnce<Box<WideBvh>>,
    pub(super) geometries: GeometryStarts,
    pub(super) rays_cast: RayCounter,
    /// Parts by which the tree follows its scene; none in trees from a cache.
    pub(super) parts: Option<Box<TreeParts>>,
}

/// Number of rays that batches have cast, by which a tree knows if it is queried again and again.
#[derive(Debug, Default)]
pub(super) struct RayCounter(AtomicU64);

impl Clone for RayCounter {
    fn clone(&self) -> RayCounter {
        RayCounter(self.0.load(Relaxed).into())
    }
}

impl Default for Bvh {
    /// The tree of a scene without primitives: a root with two empty leaves.
    fn default() -> Self {
        Bvh {
            nodes: vec![Node::EMPTY].into(),
            slots: LeafPrims::default(),
            depth: 1,
            sah: 0.0,
            wide: ForkSafeOnce::new(),
            geometries: GeometryStarts::default(),
            rays_cast: RayCounter::default(),
            parts: None,
        }
    }
}

impl Bvh {
    /// Nodes, depth first in a tree that was built. After updates there may be others, that nothing
    /// leads to. Every node index in them is in range, and every leaf's slots exist.
    #[inline]
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Number of primitives of a kind, or of instances, in leaf order.
    #[inline]
    pub fn count(&self, kind: LeafKind) -> usize {
        self.slots.count(kind)
    }

    /// Primitives and instances in leaf order, a column for each kind.
    #[inline(always)]
    pub fn leaf_prims(&self) -> &LeafPrims {
        &self.slots
    }

    /// Counts the rays of a batch; returns the number of all before.
    pub(crate) fn count_rays(&self, rays: usize) -> u64 {
        self.rays_cast.0.fetch_add(rays as u64, Relaxed)
    }

    /// The geometry of each hit. Empty for a tree made from arrays.
    #[inline]
    pub(crate) fn geometries(&self) -> &GeometryStarts {
        &self.geometries
    }

    /// Number of nodes on the longest path from the world's root, through an instance to the end of
    /// its mesh's tree. A traversal stack with this number of entries never overflows.
    #[inline]
    pub fn depth(&self) -> usize {
        self.depth
    }

    /// Cost of the world's tree by the surface area heuristic: expected nodes visited plus
    /// primitives (or instances) tested by a random ray that hits the root box, both at cost 1.
    #[inline]
    pub fn sah(&self) -> f64 {
        self.sah
    }

    /// Returns true if [`Bvh::wide`] has been built.
    #[inline]
    pub fn has_wide(&self) -> bool {
        self.wide.get().is_some()
    }

    /// Bytes of [`Bvh::wide`]; 0 if it has not been built.
    #[inline]
    pub fn wide_bytes(&self) -> usize {
        self.wide.get().map_or(0, |wide| wide.bytes())
    }

    /// Bytes of the nodes.
    #[inline]
    pub fn node_bytes(&self) -> usize {
        self.nodes.row_bytes()
    }

    /// Bytes of the primitives in leaf order.
    #[inline]
    pub fn prim_bytes(&self) -> usize {
        self.slots.bytes()
    }
}
