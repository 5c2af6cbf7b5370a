//! Conversion of a chunk's merges to nodes, depth first, and to objects in leaf order.

use super::clusters::ClusterRef;
use super::merge::Merges;
use crate::bvh::prim_ref::{PrimIndex, PrimRef};
use crate::bvh::{Child, LeafKind, Node};
use bumpalo::Bump;
use phalanx_scene::Bounds;

/// A tree over a chunk. Its nodes are stored depth first, so that a node is followed by everything
/// below it; nodes and slots are numbered from the chunk's start.
pub(in crate::bvh) struct ChunkTree<'a> {
    pub(in crate::bvh) root: Child,
    pub(in crate::bvh) bounds: Bounds,
    pub(in crate::bvh) nodes: &'a [Node],
    pub(in crate::bvh) leaves: LeafObjects,
}

/// The objects of a chunk in leaf order.
pub(in crate::bvh) struct LeafObjects {
    pub(in crate::bvh) objects: Vec<PrimIndex>,
    /// Number of objects by kind.
    pub(in crate::bvh) slots: [u32; LeafKind::COUNT],
}

impl LeafObjects {
    pub(in crate::bvh) fn with_room(objects: usize) -> LeafObjects {
        LeafObjects {
            objects: Vec::with_capacity(objects),
            slots: [0; LeafKind::COUNT],
        }
    }

    /// The leaf of the objects from `start` on, which are of one kind.
    pub(in crate::bvh) fn leaf_from(&mut self, start: usize, kind: LeafKind) -> Child {
        let count = (self.objects.len() - start) as u32;
        let slot = &mut self.slots[kind.number()];
        let first = *slot;
        *slot += count;
        Child::Leaf { kind, first, count }
    }
}

/// Reusable memory for the nodes of a chunk.
#[derive(Default)]
pub(super) struct EmittedNodes {
    nodes: Vec<Node>,
    /// Clusters of a leaf whose objects are still to be placed.
    waiting: Vec<ClusterRef>,
    /// Clusters that become nodes, with their parent and their index in it.
    stack: Vec<(ClusterRef, Option<(u32, usize)>)>,
}

impl EmittedNodes {
    /// The nodes and the objects below a cluster. Merges refer to objects in `sorted`.
    pub(super) fn run<'a>(
        &mut self,
        merges: &Merges,
        root: ClusterRef,
        sorted: &[PrimRef],
        arena: &'a Bump,
    ) -> ChunkTree<'a> {
        self.nodes.clear();
        let mut emission = Emission {
            merges,
            sorted,
            memory: self,
            leaves: LeafObjects::with_room(sorted.len()),
        };
        let bounds = emission.bounds(root);
        let root = if emission.is_leaf(root) { emission.leaf(root) } else { emission.nodes(root) };
        ChunkTree {
            root,
            bounds,
            leaves: emission.leaves,
            nodes: arena.alloc_slice_copy(&self.nodes),
        }
    }
}

struct Emission<'a> {
    merges: &'a Merges,
    sorted: &'a [PrimRef],
    memory: &'a mut EmittedNodes,
    leaves: LeafObjects,
}

impl Emission<'_> {
    fn bounds(&self, cluster: ClusterRef) -> Bounds {
        match cluster.index() {
            Ok(merge) => {
                let [x0, y0, z0, x1, y1, z1] = self.merges.get(merge).planes;
                Bounds::new([x0, y0, z0].into(), [x1, y1, z1].into())
            }
            Err(object) => self.sorted[object].bounds(),
        }
    }

    fn is_leaf(&self, cluster: ClusterRef) -> bool {
        cluster
            .index()
            .map_or(true, |merge| self.merges.get(merge).is_leaf)
    }

    /// Places the objects of a leaf, which are of one kind.
    fn leaf(&mut self, cluster: ClusterRef) -> Child {
        let start = self.leaves.objects.len();
        let mut kind = LeafKind::TRIANGLE;
        self.memory.waiting.push(cluster);
        while let Some(cluster) = self.memory.waiting.pop() {
            match cluster.index() {
                Ok(merge) => {
                    let [first, second] = self.merges.get(merge).parts;
                    self.memory.waiting.extend([second, first]);
                }
                Err(object) => {
                    kind = self.sorted[object].kind();
                    self.leaves.objects.push(self.sorted[object].object);
                }
            }
        }
        self.leaves.leaf_from(start, kind)
    }

    /// Writes nodes depth first with an explicit stack: a tree may be deeper than the thread's
    /// stack allows.
    fn nodes(&mut self, root: ClusterRef) -> Child {
        self.memory.stack.push((root, None));
        while let Some((cluster, parent)) = self.memory.stack.pop() {
            let Ok(merge) = cluster.index() else {
                continue;
            };
            let index = self.memory.nodes.len() as u32;
            let mut parts = self.merges.get(merge).parts;
            let [first, second] = parts.map(|part| self.bounds(part).half_area());
            if first < second {
                parts.reverse();
            }
            let mut children = [(Child::EMPTY, Bounds::EMPTY); 2];
            for (child, part) in children.iter_mut().zip(parts) {
                let content = if self.is_leaf(part) {
                    self.leaf(part)
                } else {
                    // The index is set when the node is written.
                    Child::Node(0)
                };
                *child = (content, self.bounds(part));
            }
            self.memory.nodes.push(Node::new(children));
            if let Some((parent, k)) = parent {
                let parent: &mut Node = &mut self.memory.nodes[parent as usize];
                parent.set_child(k, Child::Node(index));
            }
            // The first child is popped next, so that it follows its parent in memory.
            for k in [1, 0] {
                if !self.is_leaf(parts[k]) {
                    self.memory.stack.push((parts[k], Some((index, k))));
                }
            }
        }
        Child::Node(0)
    }
}
