//! The trees that a [`Bvh`](super::Bvh) consists of, which change on their own.

use super::free_rows::FreeRows;
use super::leaf::LeafInstance;
use super::leaving::RowKey;
use super::node::LeafKind;
use super::offsets::Offsets;
use super::settings::BuildSettings;
use super::subtree::{Subtree, relative_cost};
use super::upper::ChunkRows;
use super::{LeafPrims, Node};
use phalanx_scene::{Column, Edits, GeomId, Geometry, PrimPlace, Scene};
use std::ops::Range;

/// The tree of the world, of a mesh or of a geometry, among all.
#[derive(Clone, Debug, Default)]
pub(super) struct TreePart {
    pub(super) nodes: Range<usize>,
    /// Rows of primitives by kind.
    pub(super) slots: [Range<usize>; LeafKind::COUNT],
    /// Chunks, whose rows are counted from the first node and the first triangle.
    pub(super) chunks: Vec<ChunkRows>,
    /// Rows of the scene's vertices, by triangle; empty until the part is first refitted.
    pub(super) corners: Vec<[u32; 3]>,
    pub(super) depth: usize,
    /// Σ area · cost over the children of all nodes.
    pub(super) weighted_cost: f64,
    /// That by the area of the whole, when the part was built.
    pub(super) built_cost: f64,
}

/// Where a geometry is in a tree.
#[derive(Clone, Debug, Default)]
pub(super) enum TreePlace {
    /// Hidden, removed or without primitives.
    #[default]
    Nowhere,
    /// Among everything that the tree was built of: primitives of this place, and their number.
    World(PrimPlace, u32),
    /// Among everything that the tree was built of: an instance.
    WorldInstance(InstanceRow),
    /// In a tree of its own, since it was added, shown or moved.
    Own(Box<TreePart>),
    /// Among the instances that were added, shown or moved.
    Top,
}

/// An instance of the world's tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct InstanceRow {
    pub(super) mesh: u32,
    /// Offset of the primitives' numbers, beside the number of all stored ones.
    pub(super) offset: u32,
}

/// Parts of a tree that change on their own, and the edits that it has followed.
#[derive(Clone, Debug)]
pub(super) struct TreeParts {
    pub(super) settings: BuildSettings,
    pub(super) edits: Edits,
    /// Number of the scene's primitives.
    pub(super) prims: usize,
    /// Everything that the tree was built of, and that has not changed on its own since. Its root
    /// is node 0, or the first one of the top.
    pub(super) world: TreePart,
    /// True until anything comes, goes or is built.
    pub(super) is_whole: bool,
    pub(super) prototypes: Vec<TreePart>,
    pub(super) geometries: Vec<TreePlace>,
    /// First node behind all parts: a copy of the world's root, and then the tree that joins them.
    pub(super) top: Option<usize>,
    /// Root of the tree over the instances in the top, and its Σ area · cost.
    pub(super) instances: Option<(u32, f64)>,
    pub(super) free_nodes: FreeRows,
    pub(super) free_slots: [FreeRows; LeafKind::COUNT],
}

impl TreeParts {
    /// The parts of a tree that has just been built of everything that is visible.
    pub(super) fn of(scene: &Scene, settings: &BuildSettings, world: &Subtree) -> TreeParts {
        let place = |id| match scene.geometries.visible(id) {
            Some(Geometry::Prims { first, count }) if count > 0 => {
                let place = scene.geometries.prim_place(first);
                place.map_or(TreePlace::Nowhere, |place| TreePlace::World(place, count))
            }
            Some(Geometry::Instance(k)) => {
                let mesh = scene.instances.mesh[k as usize];
                let before = scene.instances.first[k as usize];
                let offset = before.wrapping_sub(scene.meshes.first[mesh as usize]);
                TreePlace::WorldInstance(InstanceRow { mesh, offset })
            }
            _ => TreePlace::Nowhere,
        };
        TreeParts {
            settings: *settings,
            edits: scene.edits(),
            prims: scene.prim_count(),
            world: TreePart::at(Offsets::default(), world),
            is_whole: true,
            prototypes: Vec::new(),
            geometries: (0..scene.geometries.len() as GeomId).map(place).collect(),
            top: None,
            instances: None,
            free_nodes: FreeRows::default(),
            free_slots: Default::default(),
        }
    }

    /// The trees of geometries.
    pub(super) fn own(&self) -> impl Iterator<Item = &TreePart> {
        self.geometries.iter().filter_map(|place| match place {
            TreePlace::Own(part) => Some(&**part),
            _ => None,
        })
    }

    /// Number of primitives in the world's tree, with those that have left it.
    pub(super) fn world_prims(&self) -> usize {
        let rows = &self.world.slots[..LeafKind::Instance.number()];
        rows.iter().map(|rows| rows.len()).sum()
    }

    /// Where a geometry is, to be changed.
    pub(super) fn place_of(&mut self, id: GeomId) -> &mut TreePlace {
        let row = id as usize;
        if self.geometries.len() <= row {
            self.geometries.resize_with(row + 1, TreePlace::default);
        }
        &mut self.geometries[row]
    }

    /// The key of an instance's row in the world's tree.
    pub(super) fn row_key(&self, row: &InstanceRow) -> RowKey {
        let root = self.prototypes[row.mesh as usize].nodes.start as u32;
        RowKey::Instance(root, row.offset.wrapping_add(self.prims as u32))
    }

    /// Replaces the meshes in rows of instances, which are numbers, by the roots of their trees.
    pub(super) fn lead_to_prototypes(&self, rows: &mut [LeafInstance]) {
        for row in rows {
            row.root = self.prototypes[row.root as usize].nodes.start as u32;
        }
    }

    /// The node from which everything of the world is reached.
    pub(super) fn world_root(&self) -> u32 {
        self.top.unwrap_or(0) as u32
    }

    /// Puts a tree among the others, into rows that are free.
    pub(super) fn place(
        &mut self,
        (nodes, slots): (&mut Column<Node>, &mut LeafPrims),
        mut built: Subtree,
    ) -> TreePart {
        let own = &mut built.tree.nodes;
        let mut offsets = Offsets::of_nodes(self.free_nodes.run(own.len(), nodes.len()).start);
        for kind in LeafKind::all() {
            let (rows, count) = (slots.count(kind), built.slots.count(kind));
            let first = self.free_slots[kind.number()].run(count, rows).start;
            offsets.slot[kind.number()] = first as u32;
            slots.write(kind, first, &built.slots);
        }
        offsets.rebase_nodes(own);
        nodes.write(offsets.node as usize, own);
        TreePart::at(offsets, &built)
    }

    /// Gives the rows of a part back.
    pub(super) fn free(&mut self, part: TreePart) {
        self.free_nodes.give(part.nodes);
        for (free, rows) in self.free_slots.iter_mut().zip(part.slots) {
            free.give(rows);
        }
    }
}

impl TreePart {
    /// A tree whose nodes and primitives begin at these rows.
    pub(super) fn at(offsets: Offsets, built: &Subtree) -> TreePart {
        let node = offsets.node as usize;
        let counts = built.slots.counts();
        let slots = std::array::from_fn(|kind| {
            let first = offsets.slot[kind] as usize;
            first..first + counts[kind]
        });
        TreePart {
            nodes: node..node + built.tree.nodes.len(),
            slots,
            chunks: built.tree.chunks.clone(),
            corners: Vec::new(),
            depth: built.tree.depth,
            weighted_cost: built.tree.weighted_cost,
            built_cost: relative_cost(built.tree.weighted_cost, built.tree.bounds),
        }
    }

    /// Rows of triangles.
    pub(super) fn triangles(&self) -> Range<usize> {
        self.slots[LeafKind::TRIANGLE.number()].clone()
    }
}
