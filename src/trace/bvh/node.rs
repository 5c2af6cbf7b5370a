//! Flat nodes of the binary tree.

use bytemuck::{Pod, Zeroable};
use phalanx_scene::{Bounds, PrimKind};

/// Contents of a leaf: one kind of primitive, or instances.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LeafKind {
    /// Primitives.
    Prim(PrimKind),
    /// Instances of meshes.
    Instance,
}

impl LeafKind {
    /// Triangles.
    pub const TRIANGLE: LeafKind = LeafKind::Prim(PrimKind::Triangle);
    /// Spheres.
    pub const SPHERE: LeafKind = LeafKind::Prim(PrimKind::Sphere);
    /// Number of kinds.
    pub const COUNT: usize = PrimKind::COUNT + 1;

    /// Every kind, in the order of their numbers.
    pub fn all() -> impl Iterator<Item = LeafKind> {
        let prims = PrimKind::ALL.into_iter().map(LeafKind::Prim);
        prims.chain([LeafKind::Instance])
    }

    /// The kind's number in packed words and in arrays by kind: that of the primitives; instances
    /// come last.
    #[inline(always)]
    pub const fn number(self) -> usize {
        match self {
            LeafKind::Prim(kind) => kind as usize,
            LeafKind::Instance => PrimKind::COUNT,
        }
    }

    #[inline(always)]
    pub(super) fn from_number(number: usize) -> LeafKind {
        if number < PrimKind::COUNT {
            LeafKind::Prim(PrimKind::from_number(number as u32))
        } else {
            LeafKind::Instance
        }
    }
}

/// Target of a child reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Child {
    /// The node at this index.
    Node(u32),
    /// `count` primitives of a kind from slot `first` on; `count` may be 0.
    Leaf {
        /// Kind of the primitives.
        kind: LeafKind,
        /// First slot.
        first: u32,
        /// Number of primitives.
        count: u32,
    },
}

/// An interior node: the boxes and the references of both children. One cache line.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Node {
    /// Lower and upper corner of each child's padded box.
    pub boxes: [[[f32; 3]; 2]; 2],
    /// Node index, or first slot of a leaf.
    pub first: [u32; 2],
    /// 0 for a node, else leaf flag, kind and count: see [`Node::child`].
    tag: [u16; 2],
    /// Padding of the cache line, so that every byte of a stored node has a value.
    spare: u32,
}

const LEAF: u16 = 0x8000;
const KIND_SHIFT: u32 = 12;
const _: () = assert!(
    LeafKind::COUNT <= (LEAF >> KIND_SHIFT) as usize,
    "no room for another kind below the leaf flag"
);
/// Maximum number of primitives in a leaf.
pub const MAX_LEAF: u32 = (1 << KIND_SHIFT) - 1;

impl Node {
    /// A node from its children and their padded boxes.
    pub fn new(children: [(Child, Bounds); 2]) -> Node {
        let mut node = Node {
            boxes: [[[0.0; 3]; 2]; 2],
            first: [0; 2],
            tag: [0; 2],
            spare: 0,
        };
        for (k, (child, bounds)) in children.into_iter().enumerate() {
            node.set_child(k, child);
            node.set_box(k, bounds);
        }
        node
    }

    /// A node without primitives.
    pub(super) const EMPTY: Node = {
        let (first, tag) = Child::EMPTY.packed();
        Node {
            boxes: [[[0.0; 3]; 2]; 2],
            first: [first; 2],
            tag: [tag; 2],
            spare: 0,
        }
    };

    /// The padded box of child `k`.
    #[inline]
    pub(super) fn bounds(&self, k: usize) -> Bounds {
        let [lo, hi] = self.boxes[k];
        Bounds::new(lo.into(), hi.into())
    }

    /// Replaces child `k`.
    pub(super) fn set_child(&mut self, k: usize, child: Child) {
        (self.first[k], self.tag[k]) = child.packed();
    }

    /// Replaces the padded box of child `k`.
    pub(super) fn set_box(&mut self, k: usize, bounds: Bounds) {
        // A child without primitives still needs a box that compares like any other.
        let b = if bounds.is_empty() {
            Bounds::new(glam::Vec3::ZERO, glam::Vec3::ZERO)
        } else {
            bounds
        };
        self.boxes[k] = [b.lo.to_array(), b.hi.to_array()];
    }

    /// Child `k` (0 or 1).
    #[inline(always)]
    pub fn child(&self, k: usize) -> Child {
        Child::unpack(self.first[k], self.tag[k])
    }

    /// The child's reference as two words, for a traversal stack.
    #[inline(always)]
    pub fn packed(&self, k: usize) -> (u32, u16) {
        (self.first[k], self.tag[k])
    }
}

impl Child {
    /// A leaf without primitives.
    pub const EMPTY: Child = Child::Leaf {
        kind: LeafKind::TRIANGLE,
        first: 0,
        count: 0,
    };

    /// The reference as two words, see [`Node::packed`].
    pub(super) const fn packed(self) -> (u32, u16) {
        match self {
            Child::Node(index) => (index, 0),
            Child::Leaf { kind, first, count } => {
                assert!(count <= MAX_LEAF, "too many primitives in a leaf");
                (
                    first,
                    LEAF | (kind.number() as u16) << KIND_SHIFT | count as u16,
                )
            }
        }
    }

    /// The reference from the two words of [`Node::packed`].
    #[inline(always)]
    pub fn unpack(first: u32, tag: u16) -> Child {
        if tag == 0 {
            return Child::Node(first);
        }
        let kind = LeafKind::from_number(usize::from((tag & !LEAF) >> KIND_SHIFT));
        Child::Leaf {
            kind,
            first,
            count: (tag & MAX_LEAF as u16) as u32,
        }
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
