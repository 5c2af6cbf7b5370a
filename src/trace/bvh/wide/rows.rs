//! Rows of the wide tree: nodes, and blocks of primitives.

use crate::bvh::free_rows::FreeRows;
use crate::bvh::leaf::{LeafSphere, LeafTriangle};
use crate::bvh::node::LeafKind;
use crate::simd::NATIVE;
use std::collections::BTreeMap;
use std::ops::Range;

/// A node of up to [`NATIVE`] children: half as many cache lines.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct WideNode {
    /// Lower corners by axis, then upper corners: a column for each child. A missing child has an
    /// empty box, from +∞ to −∞.
    pub boxes: [[[f32; NATIVE]; 3]; 2],
    /// References to the children: [`ChildRef`] codes. A missing child is [`ChildRef::NOTHING`],
    /// because a ray with a NaN passes every box, and must terminate.
    pub children: [u32; NATIVE],
    /// Order of the children by the middles of their boxes, one row per axis; missing children come
    /// last.
    pub order: [[u8; NATIVE]; 3],
    /// Axis along which the children are stored in order, those with the lowest middle of a box
    /// first: 0 to 2.
    pub axis: u8,
}

/// One triangle per lane, as columns. Unused lanes are NaN, which no ray hits.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct TriangleBlock {
    /// The vertices: by vertex, by axis.
    pub vertices: [[[f32; NATIVE]; 3]; 3],
    /// `prim_id` of the stored primitives.
    pub prim_id: [u32; NATIVE],
}

/// One sphere per lane, as columns. Unused lanes are NaN, which no ray hits.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct SphereBlock {
    /// Centres, one row per axis.
    pub center: [[f32; NATIVE]; 3],
    /// Radii.
    pub radius: [f32; NATIVE],
    /// The spheres' own padded boxes.
    pub prim_aabb: [[[f32; NATIVE]; 3]; 2],
    /// `prim_id` of the stored primitives.
    pub prim_id: [u32; NATIVE],
}

/// Target of a child of a wide node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChildRef {
    /// A wide node.
    Node(u32),
    /// A block of triangles.
    Triangles(u32),
    /// A block of spheres.
    Spheres(u32),
    /// A leaf of another kind.
    Other(u32),
}

const KIND_SHIFT: u32 = 30;
const INDEX: u32 = (1 << KIND_SHIFT) - 1;

impl WideNode {
    /// A node without children.
    pub const EMPTY: WideNode = WideNode {
        boxes: [
            [[f32::INFINITY; NATIVE]; 3],
            [[f32::NEG_INFINITY; NATIVE]; 3],
        ],
        children: [ChildRef::NOTHING.code(); NATIVE],
        order: [[0; NATIVE]; 3],
        axis: 0,
    };
}

impl ChildRef {
    /// An empty leaf.
    pub const NOTHING: ChildRef = ChildRef::Other(0);

    /// A code that belongs to no row of the tree, for a node stored elsewhere.
    pub const ELSEWHERE: u32 = INDEX;

    /// The reference as one word.
    pub(super) const fn code(self) -> u32 {
        let (kind, index) = match self {
            ChildRef::Node(index) => (0, index),
            ChildRef::Triangles(index) => (1, index),
            ChildRef::Spheres(index) => (2, index),
            ChildRef::Other(index) => (3, index),
        };
        assert!(
            index < ChildRef::ELSEWHERE,
            "2^30 rows or more of a wide tree"
        );
        kind << KIND_SHIFT | index
    }

    /// Splits a word into the kind, 0 to 3 in the order above, and the row.
    #[inline(always)]
    pub fn parts(code: u32) -> (usize, usize) {
        ((code >> KIND_SHIFT) as usize, (code & INDEX) as usize)
    }

    /// The reference from its word.
    #[inline(always)]
    pub fn of_code(code: u32) -> ChildRef {
        let index = code & INDEX;
        match code >> KIND_SHIFT {
            0 => ChildRef::Node(index),
            1 => ChildRef::Triangles(index),
            2 => ChildRef::Spheres(index),
            _ => ChildRef::Other(index),
        }
    }
}

/// A leaf of ellipsoids, cones or instances, as in the binary tree.
#[derive(Clone, Copy, Debug)]
pub struct OtherLeaf {
    /// Kind of the primitives.
    pub kind: LeafKind,
    /// First slot.
    pub first: u32,
    /// Number of primitives.
    pub count: u32,
}

/// The wide tree of the world. Instances lead back to the binary trees of their meshes.
#[derive(Clone, Debug, Default)]
pub struct WideBvh {
    pub(super) nodes: Vec<WideNode>,
    pub(super) triangles: Vec<TriangleBlock>,
    pub(super) spheres: Vec<SphereBlock>,
    pub(super) others: Vec<OtherLeaf>,
    pub(super) depth: usize,
    /// The tree over everything that the binary tree was built of. Its root is node 0, or the first
    /// one of the top.
    pub(super) world: WidePart,
    /// Trees of geometries, by the roots of their binary trees.
    pub(super) own: BTreeMap<u32, WidePart>,
    /// First rows of the top, which joins all trees.
    pub(super) top: Option<TopRows>,
    pub(super) free: FreeWideRows,
}

/// Rows of a tree among others.
#[derive(Clone, Debug, Default)]
pub(super) struct WidePart {
    pub(super) nodes: Range<usize>,
    pub(super) triangles: Range<usize>,
    pub(super) spheres: Range<usize>,
    pub(super) others: Range<usize>,
    pub(super) depth: usize,
    /// Rows of the binary tree's triangles, by block and lane; empty until the first refit.
    pub(super) slots: Vec<[u32; NATIVE]>,
}

/// First rows of the top.
#[derive(Clone, Copy, Debug)]
pub(super) struct TopRows {
    pub(super) nodes: usize,
    pub(super) others: usize,
}

/// Rows of parts that are gone.
#[derive(Clone, Debug, Default)]
pub(super) struct FreeWideRows {
    pub(super) nodes: FreeRows,
    pub(super) triangles: FreeRows,
    pub(super) spheres: FreeRows,
    pub(super) others: FreeRows,
}

impl OtherLeaf {
    pub(super) const EMPTY: OtherLeaf = OtherLeaf {
        kind: LeafKind::TRIANGLE,
        first: 0,
        count: 0,
    };
}

impl WideBvh {
    /// Nodes; the root is the first. Every code in them refers to an existing row.
    pub fn nodes(&self) -> &[WideNode] {
        &self.nodes
    }

    /// Blocks of triangles.
    pub fn triangles(&self) -> &[TriangleBlock] {
        &self.triangles
    }

    /// Blocks of spheres.
    pub fn spheres(&self) -> &[SphereBlock] {
        &self.spheres
    }

    /// Leaves of other kinds; the first is empty.
    pub fn others(&self) -> &[OtherLeaf] {
        &self.others
    }

    /// The largest absolute coordinate of any box.
    pub fn extent(&self) -> f32 {
        let root = self.nodes.first();
        let planes = root
            .iter()
            .flat_map(|node| node.boxes.as_flattened().as_flattened());
        let finite = planes.filter(|x| x.is_finite());
        finite.fold(0.0, |most: f32, x| most.max(x.abs()))
    }

    /// Returns true if the tree contains only triangles.
    pub fn has_triangles_only(&self) -> bool {
        self.others.len() <= 1 && self.spheres.is_empty()
    }

    /// Number of nodes on the longest path from the root.
    pub fn depth(&self) -> usize {
        self.depth
    }

    /// Bytes of all rows.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..])
            + size_of_val(&self.triangles[..])
            + size_of_val(&self.spheres[..])
    }
}

impl TriangleBlock {
    pub(super) fn of<'a>(slots: impl Iterator<Item = &'a LeafTriangle>) -> TriangleBlock {
        let mut block = TriangleBlock {
            vertices: [[[f32::NAN; NATIVE]; 3]; 3],
            prim_id: [u32::MAX; NATIVE],
        };
        for (lane, slot) in slots.enumerate() {
            block.put(lane, slot);
        }
        block
    }

    /// Places a triangle in a lane.
    #[inline(always)]
    pub(super) fn put(&mut self, lane: usize, slot: &LeafTriangle) {
        for (corner, position) in self.vertices.iter_mut().zip(&slot.vertices) {
            for (column, x) in corner.iter_mut().zip(position) {
                column[lane] = *x;
            }
        }
        self.prim_id[lane] = slot.prim_id;
    }
}

impl SphereBlock {
    pub(super) fn of<'a>(slots: impl Iterator<Item = &'a LeafSphere>) -> SphereBlock {
        let mut block = SphereBlock {
            center: [[f32::NAN; NATIVE]; 3],
            radius: [f32::NAN; NATIVE],
            prim_aabb: [[[f32::NAN; NATIVE]; 3]; 2],
            prim_id: [u32::MAX; NATIVE],
        };
        for (lane, slot) in slots.enumerate() {
            for axis in 0..3 {
                block.center[axis][lane] = slot.center[axis];
                for side in 0..2 {
                    block.prim_aabb[side][axis][lane] = slot.prim_aabb[side][axis];
                }
            }
            block.radius[lane] = slot.radius;
            block.prim_id[lane] = slot.prim_id;
        }
        block
    }
}
