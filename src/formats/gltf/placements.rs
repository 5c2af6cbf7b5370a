//! Meshes that the nodes show: where, how often (EXT_mesh_gpu_instancing), and in which pose.

use super::accessor::Accessor;
use super::document::GpuInstancing;
use super::morph;
use super::nodes::{self, NO_ROTATION, NO_SCALE, PlacedNode};
use super::source::GltfSource;
use crate::diagnostics::DiagnosticSink;
use crate::memory::MemoryLedger;
use glam::DAffine3;
use std::collections::HashMap;

/// A mesh in a pose, and the maps of its placements.
pub(super) struct PlacedMesh<'a> {
    pub(super) mesh: usize,
    pub(super) pose: Pose<'a>,
    /// Its placements: the node, and the map.
    pub(super) maps: Vec<(usize, DAffine3)>,
}

/// Pose of a mesh: weights of its morph targets, and the skin that moves its vertices.
#[derive(Clone, Copy, Default)]
pub(super) struct Pose<'a> {
    pub(super) weights: &'a [f64],
    pub(super) skin: Option<usize>,
}

impl Pose<'_> {
    /// Returns true if vertices stay where the mesh has them.
    pub(super) fn is_rest(&self) -> bool {
        self.weights.is_empty() && self.skin.is_none()
    }
}

/// Equal for placements that share their triangles.
#[derive(PartialEq, Eq, Hash)]
enum PlacementKey {
    Rest(usize),
    /// A pose of the mesh's own weights.
    OfMesh(usize),
    /// A pose of weights of nodes, by their bits.
    OfNodes(usize, Vec<u64>),
    /// A node with a skin does not share its triangles.
    Skinned(usize),
}

/// Number of copies that EXT_mesh_gpu_instancing may make in a file of any size; beyond it, at most
/// one per byte of the file.
const FREE_COPIES: u64 = 1 << 20;
/// Number of openings that poses may make in a file of any size, and more of them for its text.
const FREE_OPENINGS: u64 = 1 << 22;
/// Bytes of a copy while a file is read, and in the scene.
const COPY_BYTES: u64 = 512;

/// Finds the placements of meshes.
pub(super) struct Placements<'a> {
    source: &'a GltfSource<'a>,
    memory: &'a MemoryLedger,
    copies_left: u64,
    /// Number of primitives, each times its morph targets, that poses may still open. Any number of
    /// nodes may show a mesh in poses of their own.
    openings_left: u64,
    /// True for meshes whose own weights are all zero.
    at_rest: HashMap<usize, bool>,
    rows: HashMap<PlacementKey, usize>,
    placed: Vec<PlacedMesh<'a>>,
}

impl<'a> Placements<'a> {
    /// Every mesh that is shown, once for each pose, in the order of its first node.
    pub(super) fn of(
        source: &'a GltfSource<'a>,
        memory: &'a MemoryLedger,
        nodes: &[PlacedNode],
        report: &mut DiagnosticSink,
    ) -> Vec<PlacedMesh<'a>> {
        let mut placements = Placements {
            source,
            memory,
            copies_left: FREE_COPIES + source.buffer_bytes(),
            openings_left: FREE_OPENINGS + source.document_bytes(),
            at_rest: HashMap::new(),
            rows: HashMap::new(),
            placed: Vec::new(),
        };
        for placed in nodes.iter().filter(|placed| placed.visible) {
            if let Err(message) = placements.add(placed) {
                source.error(report, "nodes", placed.node, &message);
            }
        }
        placements.placed
    }

    fn add(&mut self, placed: &PlacedNode) -> Result<(), String> {
        let document = &self.source.document;
        let node = &document.nodes[placed.node];
        let Some(row) = node.mesh else {
            return Ok(());
        };
        let mesh = document.meshes.get(row);
        let mesh = mesh.ok_or_else(|| format!("there is no meshes[{row}]"))?;
        let weights = node.weights.as_deref();
        let at_rest = match weights {
            Some(own) => morph::is_rest(own),
            None => *self
                .at_rest
                .entry(row)
                .or_insert_with(|| morph::is_rest(&mesh.weights)),
        };
        let key = match (node.skin, weights) {
            (Some(_), _) => PlacementKey::Skinned(placed.node),
            (None, _) if at_rest => PlacementKey::Rest(row),
            (None, None) => PlacementKey::OfMesh(row),
            (None, Some(own)) => {
                let bytes = 8 * own.len() as u64;
                self.memory
                    .take(bytes, "for the weights of morph targets")?;
                PlacementKey::OfNodes(row, own.iter().map(|weight| weight.to_bits()).collect())
            }
        };
        let maps = match &node.extensions.instancing {
            // Joints determine the position of a skinned mesh.
            Some(copies) if node.skin.is_none() => self.copies(copies, placed.to_world)?,
            _ => vec![placed.to_world],
        };
        let next = self.placed.len();
        let index = *self.rows.entry(key).or_insert(next);
        if index == next {
            let pose = Pose {
                weights: if at_rest { &[] } else { weights.unwrap_or(&mesh.weights) },
                skin: node.skin,
            };
            if !pose.is_rest() {
                let targets = 1 + pose.weights.len() as u64;
                let openings = targets.saturating_mul(mesh.primitives.len() as u64);
                let left = self.openings_left.checked_sub(openings);
                self.openings_left = left.ok_or("poses are too many for a file of this size")?;
            }
            self.placed.push(PlacedMesh {
                mesh: row,
                pose,
                maps: Vec::new(),
            });
        }
        let maps = maps.into_iter().map(|map| (placed.node, map));
        self.placed[index].maps.extend(maps);
        Ok(())
    }

    /// The maps of a node's copies: one for each row that all of its attributes have.
    fn copies(
        &mut self,
        instancing: &GpuInstancing,
        to_world: DAffine3,
    ) -> Result<Vec<DAffine3>, String> {
        let rows = |name: &str, width: usize| {
            Accessor::of_attribute(self.source, &instancing.attributes, name, width)
        };
        let translations = rows("TRANSLATION", 3)?;
        let rotations = rows("ROTATION", 4)?;
        let scales = rows("SCALE", 3)?;
        let counts = [translations, rotations, scales].into_iter().flatten();
        let count = counts.map(|accessor| accessor.count).min();
        let Some(count) = count else {
            return Ok(vec![to_world]);
        };
        let left = self.copies_left.checked_sub(count as u64);
        self.copies_left = left
            .ok_or_else(|| format!("{count} more copies are too many for a file of this size"))?;
        let bytes = (count as u64).saturating_mul(COPY_BYTES);
        self.memory
            .take(bytes, format_args!("for {count} copies of a mesh"))?;
        let copy = |k: usize| {
            let translation = row_or(translations, k, [0.0; 3]);
            let rotation = row_or(rotations, k, NO_ROTATION);
            to_world * nodes::transform(translation, rotation, row_or(scales, k, NO_SCALE))
        };
        Ok((0..count).map(copy).collect())
    }
}

/// A row of an accessor; `none` if there is no accessor.
fn row_or<const N: usize>(rows: Option<Accessor>, k: usize, none: [f64; N]) -> [f64; N] {
    rows.map_or(none, |rows| rows.get(k).map(f64::from))
}
