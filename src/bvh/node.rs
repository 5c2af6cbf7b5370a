//! The flat tree and the primitives in leaf order.

use crate::scene::{Bounds, PrimKind};

/// What a child reference leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Child {
    /// Node at this index.
    Node(u32),
    /// `count` primitives of a kind from slot `first` on; `count` may be 0.
    Leaf {
        /// Their kind.
        kind: PrimKind,
        /// First slot.
        first: u32,
        /// How many.
        count: u32,
    },
}

/// An interior node: the boxes of both children and where they are. One cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Node {
    /// Lower and upper corner of each child's padded box.
    pub boxes: [[[f32; 3]; 2]; 2],
    /// Node index, or first slot of a leaf.
    pub first: [u32; 2],
    /// 0 for a node, else leaf flag, kind and count: see [`Node::child`].
    tag: [u16; 2],
}

const LEAF: u16 = 0x8000;
const KIND_SHIFT: u32 = 12;
/// Most primitives in a leaf.
pub const MAX_LEAF: u32 = (1 << KIND_SHIFT) - 1;

impl Node {
    /// A node from its children and their padded boxes.
    pub fn new(children: [(Child, Bounds); 2]) -> Node {
        let mut node = Node {
            boxes: children.map(|(_, b)| {
                // A child without primitives needs a box that compares like any other.
                let b = if b.is_empty() {
                    Bounds::new(glam::Vec3::ZERO, glam::Vec3::ZERO)
                } else {
                    b
                };
                [b.lo.to_array(), b.hi.to_array()]
            }),
            first: [0; 2],
            tag: [0; 2],
        };
        for (k, (child, _)) in children.into_iter().enumerate() {
            (node.first[k], node.tag[k]) = match child {
                Child::Node(index) => (index, 0),
                Child::Leaf { kind, first, count } => {
                    assert!(count <= MAX_LEAF, "a leaf of {count} primitives");
                    (first, LEAF | (kind as u16) << KIND_SHIFT | count as u16)
                }
            };
        }
        node
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
        kind: PrimKind::Triangle,
        first: 0,
        count: 0,
    };

    /// From the two words of [`Node::packed`].
    #[inline(always)]
    pub fn unpack(first: u32, tag: u16) -> Child {
        if tag == 0 {
            return Child::Node(first);
        }
        let kind = PrimKind::from_number(((tag & !LEAF) >> KIND_SHIFT) as u32);
        Child::Leaf {
            kind,
            first,
            count: (tag & MAX_LEAF as u16) as u32,
        }
    }
}

/// A triangle in leaf order. One cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct TriangleSlot {
    /// The corners.
    pub corners: [[f32; 3]; 3],
    /// The triangle's own padded box.
    pub own_box: [[f32; 3]; 2],
    /// Its number in the file.
    pub prim_id: u32,
}

/// A sphere in leaf order.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct SphereSlot {
    /// Centre.
    pub center: [f32; 3],
    /// Radius.
    pub radius: f32,
    /// The sphere's own padded box.
    pub own_box: [[f32; 3]; 2],
    /// Its number in the file.
    pub prim_id: u32,
}

/// An ellipsoid in leaf order.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct EllipsoidSlot {
    /// World to object: three columns of the matrix and the translation.
    pub to_object: [[f32; 3]; 4],
    /// The ellipsoid's own padded box.
    pub own_box: [[f32; 3]; 2],
    /// Its number in the file.
    pub prim_id: u32,
}

/// The tree of a scene. The root is node 0 and always exists.
#[derive(Clone, Debug)]
pub struct Bvh {
    pub(super) nodes: Vec<Node>,
    pub(super) triangles: Vec<TriangleSlot>,
    pub(super) spheres: Vec<SphereSlot>,
    pub(super) ellipsoids: Vec<EllipsoidSlot>,
    pub(super) depth: usize,
    pub(super) sah: f64,
}

impl Bvh {
    /// Nodes, depth first. Every node index in them is in range, every leaf's slots exist.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Triangles in leaf order.
    pub fn triangles(&self) -> &[TriangleSlot] {
        &self.triangles
    }

    /// Spheres in leaf order.
    pub fn spheres(&self) -> &[SphereSlot] {
        &self.spheres
    }

    /// Ellipsoids in leaf order.
    pub fn ellipsoids(&self) -> &[EllipsoidSlot] {
        &self.ellipsoids
    }

    /// Most nodes on a path from the root: a traversal stack of this many entries never overflows.
    pub fn depth(&self) -> usize {
        self.depth
    }

    /// Cost by the surface area heuristic: expected nodes visited plus primitives tested by a random ray that meets
    /// the root box, both at cost 1.
    pub fn sah(&self) -> f64 {
        self.sah
    }

    /// Bytes of the nodes.
    pub fn node_bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice())
    }

    /// Bytes of the primitives in leaf order.
    pub fn prim_bytes(&self) -> usize {
        size_of_val(self.triangles.as_slice())
            + size_of_val(self.spheres.as_slice())
            + size_of_val(self.ellipsoids.as_slice())
    }
}
