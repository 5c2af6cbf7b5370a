//! Verification that arrays from a file are a tree. It checks everything that a builder guarantees,
//! so that kernels without bounds checks may traverse them.
//!
//! The proof is divided into blocks that can be verified in any order on any thread. Each block
//! covers a range of rows of one array. A level for every node, stored with the nodes, makes that
//! possible:
//!
//! - Children have larger levels than their parents, so no path comes back, and none is longer than
//!   the largest level.
//! - Levels in the trees of meshes carry a mark. The mark is inherited, instances lead to marked
//!   nodes, and no marked node has instances. So trees nest only once.
//! - A count shows that no node has two parents.
//! - Slots are counted as a whole. Two leaves may still share a slot while another slot has none.
//!   That gives a wrong picture, but never an unsafe or endless traversal.

use super::geometry_starts::GeometryStarts;
use super::{Bvh, Child, LeafKind, LeafPrims, Node};
use phalanx_scene::{Column, Scene};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU16, AtomicU64, Ordering::Relaxed};

/// Set in the levels of nodes of meshes.
const IN_MESH: u16 = 0x8000;

/// Reasons why arrays are not a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BvhError {
    /// A path is too long for a level to be stored for each of its nodes.
    #[error("a path of the tree is longer than 32,767 nodes")]
    TooDeep,
    /// The number of levels differs from the number of nodes, or there are no nodes.
    #[error("nodes and levels differ in number, or there are none")]
    Lengths,
    /// A row was not verified, or no builder would have made it.
    #[error("a row of the tree is out of range")]
    Row,
    /// A node has two parents, or there are more or fewer slots than leaves refer to, or than the
    /// scene has.
    #[error("the tree's branches meet")]
    Branches,
    /// An instance does not lead to its own mesh.
    #[error("an instance leads to another mesh than its own")]
    Instance,
}

/// An array of a tree, as bytes.
#[derive(Clone, Copy, Debug)]
pub struct Array<'a> {
    /// Name of its rows.
    pub name: &'static str,
    /// Bytes of a row.
    pub row_bytes: usize,
    /// All rows.
    pub bytes: &'a [u8],
}

/// Number of arrays: the nodes, and one for each kind of row that leaves refer to.
const ARRAYS: usize = 1 + LeafKind::COUNT;

fn arrays<'a>(nodes: &'a [Node], slots: &'a LeafPrims) -> [Array<'a>; ARRAYS] {
    let nodes = Array {
        name: "nodes of the tree",
        row_bytes: size_of::<Node>(),
        bytes: bytemuck::cast_slice(nodes),
    };
    let mut all = [nodes; ARRAYS];
    for (place, kind) in all[1..].iter_mut().zip(LeafPrims::FILE_ORDER) {
        let column = slots.column(kind);
        *place = Array {
            name: column.name(),
            row_bytes: column.row_size(),
            bytes: column.bytes(),
        };
    }
    all
}

impl Bvh {
    /// All arrays: the nodes, then the slots of each kind.
    pub fn arrays(&self) -> [Array<'_>; ARRAYS] {
        arrays(&self.nodes, &self.slots)
    }

    /// The level of every node, for [`UnverifiedBvh`].
    ///
    /// # Errors
    /// [`BvhError::TooDeep`].
    pub fn depths(&self) -> Result<Vec<u16>, BvhError> {
        let mut levels = vec![0; self.nodes.len()];
        levels[0] = 1;
        for (i, node) in self.nodes.iter().enumerate() {
            // Parents precede their children: a node without a level by now is the root of a mesh.
            if levels[i] == 0 {
                levels[i] = IN_MESH | 1;
            }
            if levels[i] & !IN_MESH == !IN_MESH {
                return Err(BvhError::TooDeep);
            }
            for k in 0..2 {
                if let Child::Node(child) = node.child(k) {
                    levels[child as usize] = levels[i] + 1;
                }
            }
        }
        Ok(levels)
    }
}

/// The arrays of a tree, from any source.
#[derive(Debug, Default)]
pub struct BvhArrays {
    /// Nodes.
    pub nodes: Column<Node>,
    /// The level of each node: see [`Bvh::depths`].
    pub depths: Column<u16>,
    /// Primitives in leaf order.
    pub slots: LeafPrims,
    /// Value of [`Bvh::sah`]. Nothing depends on it.
    pub sah: f64,
}

/// Maximum number of bytes of a block.
const BLOCK: usize = 1 << 18;

/// Arrays whose verification as a tree is in progress.
#[derive(Debug)]
pub struct UnverifiedBvh {
    arrays: BvhArrays,
    prims: u32,
    blocks: Vec<RowBlock>,
    /// Marks of verified blocks.
    verified: Vec<AtomicBool>,
    /// Marks of nodes that are a child.
    children: Vec<AtomicU8>,
    /// Numbers of references to nodes, and to slots.
    references: AtomicU64,
    slot_references: AtomicU64,
    /// Largest level in the world, and in the meshes.
    deepest: [AtomicU16; 2],
}

#[derive(Clone, Debug)]
struct RowBlock {
    array: usize,
    rows: Range<usize>,
}

impl UnverifiedBvh {
    /// Begins the verification of arrays as the tree of a scene.
    pub fn new(parts: BvhArrays, scene: &Scene) -> UnverifiedBvh {
        let mut blocks = Vec::new();
        for (array, all) in arrays(&parts.nodes, &parts.slots).iter().enumerate() {
            let (rows, step) = (all.bytes.len() / all.row_bytes, BLOCK / all.row_bytes);
            blocks.extend((0..rows).step_by(step).map(|first| RowBlock {
                array,
                rows: first..(first + step).min(rows),
            }));
        }
        UnverifiedBvh {
            prims: scene.prim_count() as u32,
            verified: blocks.iter().map(|_| AtomicBool::new(false)).collect(),
            children: parts.nodes.iter().map(|_| AtomicU8::new(0)).collect(),
            references: AtomicU64::new(0),
            slot_references: AtomicU64::new(0),
            deepest: Default::default(),
            arrays: parts,
            blocks,
        }
    }

    /// Number of blocks of the proof.
    pub fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// A block: the number of its array among [`Bvh::arrays`], and its bytes. The blocks of an
    /// array follow one another and cover it.
    pub fn block(&self, k: usize) -> (usize, &[u8]) {
        let block = &self.blocks[k];
        let array = arrays(&self.arrays.nodes, &self.arrays.slots)[block.array];
        let row = array.row_bytes;
        let bytes = &array.bytes[block.rows.start * row..block.rows.end * row];
        (block.array, bytes)
    }

    /// Verifies a block of the proof, once; returns true if its rows are valid.
    pub fn verify(&self, k: usize) -> bool {
        let RowBlock { array, rows } = self.blocks[k].clone();
        let slots = &self.arrays.slots;
        let kind = array.checked_sub(1).map(|k| LeafPrims::FILE_ORDER[k]);
        let holds = match kind {
            None => self.verify_nodes(rows),
            Some(kind @ LeafKind::Prim(_)) => slots.column(kind).are_prims_below(rows, self.prims),
            Some(LeafKind::Instance) => slots.instances[rows]
                .iter()
                .all(|s| self.is_mesh_node(s.root)),
        };
        // Counting twice would make the counts meaningless.
        holds && !self.verified[k].swap(true, Relaxed)
    }

    fn is_mesh_node(&self, node: u32) -> bool {
        let level = self.arrays.depths.get(node as usize);
        level.is_some_and(|level| level & IN_MESH != 0)
    }

    fn verify_nodes(&self, rows: Range<usize>) -> bool {
        let (nodes, levels) = (&self.arrays.nodes, &self.arrays.depths);
        if levels.len() != nodes.len() {
            return false;
        }
        let counts = self.arrays.slots.counts();
        let mut deepest = [0; 2];
        let (mut references, mut slot_references) = (0, 0);
        for (node, &level) in nodes[rows.clone()].iter().zip(&levels[rows]) {
            let in_mesh = level & IN_MESH != 0;
            // Levels count from 1: so the largest one is no less than the number of nodes on any
            // path.
            if level & !IN_MESH == 0 {
                return false;
            }
            let most = &mut deepest[usize::from(in_mesh)];
            *most = (level & !IN_MESH).max(*most);
            for k in 0..2 {
                match node.child(k) {
                    Child::Node(child) => {
                        let below = levels.get(child as usize);
                        // The mark is the highest bit. The child's level must be larger, and of the
                        // same tree.
                        if !below.is_some_and(|&b| b > level && b & IN_MESH == level & IN_MESH) {
                            return false;
                        }
                        self.children[child as usize].store(1, Relaxed);
                        references += 1;
                    }
                    leaf @ Child::Leaf { kind, first, count } => {
                        let end = u64::from(first) + u64::from(count);
                        let nested = in_mesh && kind == LeafKind::Instance && count > 0;
                        let exists = end <= counts[kind.number()] as u64;
                        if !exists || nested || leaf.packed() != node.packed(k) {
                            return false;
                        }
                        slot_references += u64::from(count);
                    }
                }
            }
        }
        self.references.fetch_add(references, Relaxed);
        self.slot_references.fetch_add(slot_references, Relaxed);
        for (all, deepest) in self.deepest.iter().zip(deepest) {
            all.fetch_max(deepest, Relaxed);
        }
        true
    }

    /// The tree, if every block has been verified.
    ///
    /// # Errors
    /// [`BvhError`]: a block was not verified, or the counts do not fit.
    pub fn accept(self, scene: &Scene) -> Result<Bvh, BvhError> {
        let parts = &self.arrays;
        if parts.nodes.is_empty() || parts.nodes.len() != parts.depths.len() {
            return Err(BvhError::Lengths);
        }
        let proven = self.verified.iter().all(|proven| proven.load(Relaxed));
        // Stacks are sized for paths that begin at the world's root.
        if !proven || self.prims as usize != scene.prim_count() || self.is_mesh_node(0) {
            return Err(BvhError::Row);
        }
        let children = self.children.iter().filter(|c| c.load(Relaxed) != 0);
        let slots = parts.slots.counts().iter().sum::<usize>() as u64;
        let instances = parts.slots.instances.len();
        // Every object has at most one slot, so more cannot be a tree of this scene.
        let surplus =
            instances > scene.instances.len() || slots - instances as u64 > u64::from(self.prims);
        if surplus
            || children.count() as u64 != self.references.load(Relaxed)
            || slots != self.slot_references.load(Relaxed)
        {
            return Err(BvhError::Branches);
        }
        self.check_instances(scene)?;
        let [world, meshes] = self.deepest.map(|level| usize::from(level.into_inner()));
        Ok(Bvh {
            nodes: self.arrays.nodes,
            slots: self.arrays.slots,
            depth: world + meshes,
            sah: self.arrays.sah,
            geometries: GeometryStarts::of(scene),
            ..Bvh::default()
        })
    }

    /// Checks that every instance leads to its own mesh, so that the numbers of its hits exist in
    /// the scene.
    fn check_instances(&self, scene: &Scene) -> Result<(), BvhError> {
        let slots = &self.arrays.slots.instances;
        // The same arithmetic as the builder's.
        let number = |k: usize| {
            let mesh = scene.instances.mesh[k];
            let first = scene.meshes.first[mesh as usize];
            (scene.instance_first_id(k).wrapping_sub(first), mesh)
        };
        let mut known: Vec<(u32, u32)> = (0..scene.instances.len()).map(number).collect();
        known.sort_unstable();
        let mut roots: Vec<u32> = slots.iter().map(|slot| slot.root).collect();
        roots.sort_unstable();
        roots.dedup();
        let mut seen = vec![false; if roots.is_empty() { 0 } else { self.children.len() }];
        let meshes = roots
            .iter()
            .map(|&root| self.mesh_of(root, scene, &mut seen));
        let meshes: Vec<u32> = meshes.collect::<Result<_, _>>()?;
        let fits = slots.iter().all(|slot| {
            let mesh = roots.binary_search(&slot.root).map(|row| meshes[row]);
            mesh.is_ok_and(|mesh| known.binary_search(&(slot.id_offset, mesh)).is_ok())
        });
        if fits { Ok(()) } else { Err(BvhError::Instance) }
    }

    /// The mesh that owns all primitives below a node.
    fn mesh_of(&self, root: u32, scene: &Scene, seen: &mut [bool]) -> Result<u32, BvhError> {
        let mut mesh = None;
        let mut stack = vec![root];
        while let Some(index) = stack.pop() {
            // Two roots in one tree would be visited endlessly.
            if std::mem::replace(&mut seen[index as usize], true) {
                return Err(BvhError::Instance);
            }
            for k in 0..2 {
                match self.arrays.nodes[index as usize].child(k) {
                    Child::Node(child) => stack.push(child),
                    Child::Leaf { kind, first, count } => {
                        let rows = first as usize..(first + count) as usize;
                        for prim in self.arrays.slots.stored_prims(kind, rows) {
                            let after = scene.meshes.first.partition_point(|&f| f <= prim);
                            let this = after.checked_sub(1).ok_or(BvhError::Instance)?;
                            let within = scene.meshes.prims(this).contains(&prim);
                            if !within || *mesh.get_or_insert(this) != this {
                                return Err(BvhError::Instance);
                            }
                        }
                    }
                }
            }
        }
        mesh.map(|mesh| mesh as u32).ok_or(BvhError::Instance)
    }
}
