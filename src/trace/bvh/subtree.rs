//! Conversion of obvhs's tree: nodes depth first, leaves of one kind, objects copied into leaf
//! order.
//!
//! The result is a [`Subtree`] whose indices count from its own beginning, so that subtrees can be
//! made side by side and appended to one another afterwards.

use super::build_input::{BuildInput, PrimRef};
use super::{Child, LeafKind, LeafPrims, Node};
use obvhs::bvh2::Bvh2;
use phalanx_scene::Bounds;

/// A subtree with indices of its own.
pub(super) struct Subtree {
    /// Reference to the subtree's root, for the node above.
    pub(super) root: Child,
    pub(super) bounds: Bounds,
    pub(super) nodes: Vec<Node>,
    pub(super) slots: LeafPrims,
    /// Most nodes on a path through the subtree.
    pub(super) depth: usize,
    /// Σ area · cost over the children of its nodes.
    pub(super) weighted_cost: f64,
}

/// A tree of obvhs over a chunk.
pub(super) struct ObvhsTree<'a> {
    pub(super) tree: &'a Bvh2,
    /// Objects in the order in which they were given to obvhs.
    pub(super) chunk: &'a [PrimRef],
    pub(super) objects: &'a BuildInput<'a>,
}

/// A child that still has to be converted.
enum Pending {
    /// obvhs's node at this index.
    Obvhs(usize),
    /// Objects of a leaf, sorted by kind and number.
    Leaf(Vec<PrimRef>),
}

impl ObvhsTree<'_> {
    /// Converts the whole tree.
    pub(super) fn subtree(&self) -> Subtree {
        let whole = self.pending(0);
        let mut subtree = Subtree {
            root: Child::Node(0),
            bounds: self.bounds(&whole),
            nodes: Vec::with_capacity(self.tree.nodes.len() / 2),
            slots: LeafPrims::default(),
            depth: 0,
            weighted_cost: 0.0,
        };
        match self.leaf(&whole, &mut subtree) {
            Some(leaf) => subtree.root = leaf,
            None => self.add_nodes(whole, &mut subtree),
        }
        subtree
    }

    /// Converts nodes depth first with an explicit stack: a tree may be deeper than the thread's
    /// stack allows.
    fn add_nodes(&self, whole: Pending, subtree: &mut Subtree) {
        // (node to make, parent and child index in it, depth)
        let mut stack = vec![(whole, None, 1usize)];
        while let Some((pending, parent, depth)) = stack.pop() {
            let index = subtree.nodes.len() as u32;
            subtree.depth = subtree.depth.max(depth);
            let mut children = [(Child::EMPTY, Bounds::EMPTY); 2];
            let mut deferred = Vec::new();
            for (k, part) in self.split(pending).into_iter().enumerate() {
                let bounds = self.bounds(&part);
                let child = match self.leaf(&part, subtree) {
                    Some(leaf) => leaf,
                    None => {
                        deferred.push((part, Some((index, k)), depth + 1));
                        Child::Node(u32::MAX)
                    }
                };
                subtree.weighted_cost += weighted_cost(child, bounds);
                children[k] = (child, bounds);
            }
            subtree.nodes.push(Node::new(children));
            if let Some((parent, k)) = parent {
                let parent: &mut Node = &mut subtree.nodes[parent as usize];
                parent.set_child(k, Child::Node(index));
            }
            // The first child is popped next, so that it follows its parent in memory.
            stack.extend(deferred.into_iter().rev());
        }
    }

    /// The two parts of a subtree that is not a leaf of one kind.
    fn split(&self, pending: Pending) -> [Pending; 2] {
        match pending {
            Pending::Obvhs(index) => {
                let first = self.tree.nodes[index].first_index as usize;
                [first, first + 1].map(|child| self.pending(child))
            }
            Pending::Leaf(mut items) => {
                let kind = self.objects.kind(items[0].object);
                let same = |item: &PrimRef| self.objects.kind(item.object) == kind;
                let rest = items.split_off(items.partition_point(same));
                [Pending::Leaf(items), Pending::Leaf(rest)]
            }
        }
    }

    fn pending(&self, index: usize) -> Pending {
        let node = &self.tree.nodes[index];
        if node.prim_count == 0 {
            return Pending::Obvhs(index);
        }
        let first = node.first_index as usize;
        let theirs = &self.tree.primitive_indices[first..first + node.prim_count as usize];
        let mut items: Vec<PrimRef> = theirs.iter().map(|&i| self.chunk[i as usize]).collect();
        items.sort_by_key(|item| (self.objects.kind(item.object), item.object));
        Pending::Leaf(items)
    }

    fn bounds(&self, pending: &Pending) -> Bounds {
        match pending {
            Pending::Obvhs(index) => {
                let b = self.tree.nodes[*index].aabb();
                Bounds::new(b.min.into(), b.max.into())
            }
            Pending::Leaf(items) => {
                let boxes = items.iter().map(|item| item.bounds);
                boxes.fold(Bounds::EMPTY, Bounds::union)
            }
        }
    }

    /// Stores a leaf of one kind; `None` if the part has to be split further.
    fn leaf(&self, pending: &Pending, subtree: &mut Subtree) -> Option<Child> {
        let Pending::Leaf(items) = pending else {
            return None;
        };
        let kind = self.objects.kind(items[0].object);
        let other = |item: &PrimRef| self.objects.kind(item.object) != kind;
        if items.iter().any(other) {
            return None;
        }
        let first = subtree.slots.count(kind) as u32;
        for item in items {
            self.objects.store(item, &mut subtree.slots);
        }
        let count = items.len() as u32;
        Some(Child::Leaf { kind, first, count })
    }
}

/// Area times expected cost of entering a child.
pub(super) fn weighted_cost(child: Child, bounds: Bounds) -> f64 {
    let cost = match child {
        Child::Node(_) => 1.0,
        Child::Leaf { count, .. } => f64::from(count),
    };
    f64::from(bounds.half_area()) * cost
}

/// Offsets of the nodes and slots of a subtree in the merged arrays.
#[derive(Clone, Copy, Default)]
pub(super) struct Offsets {
    pub(super) node: u32,
    pub(super) slot: [u32; LeafKind::COUNT],
}

impl Offsets {
    /// The offsets after existing rows.
    pub(super) fn after(nodes: usize, slots: &LeafPrims) -> Offsets {
        let mut offsets = Offsets {
            node: nodes as u32,
            ..Offsets::default()
        };
        for kind in LeafKind::all() {
            offsets.slot[kind.number()] = slots.count(kind) as u32;
        }
        offsets
    }

    /// A reference within a subtree, converted to the merged arrays.
    pub(super) fn rebased(&self, child: Child) -> Child {
        match child {
            Child::Node(index) => Child::Node(self.node + index),
            Child::Leaf { count: 0, .. } => child,
            Child::Leaf { kind, first, count } => Child::Leaf {
                kind,
                first: first + self.slot[kind.number()],
                count,
            },
        }
    }

    /// The offsets after a subtree that is placed at these.
    pub(super) fn advanced_by(mut self, subtree: &Subtree) -> Offsets {
        self.node += subtree.nodes.len() as u32;
        for kind in LeafKind::all() {
            self.slot[kind.number()] += subtree.slots.count(kind) as u32;
        }
        self
    }

    /// Converts all nodes of a subtree to the merged arrays.
    pub(super) fn rebase_nodes(&self, nodes: &mut [Node]) {
        for node in nodes {
            for k in 0..2 {
                node.set_child(k, self.rebased(node.child(k)));
            }
        }
    }
}
