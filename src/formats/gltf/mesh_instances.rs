//! Geometry that a file shows several times: the same primitives in several meshes, or several
//! times in one. If the copies amount to many triangles, they are stored once and instanced, like a
//! mesh of several nodes.

use super::document::{GltfAccessor, GltfDocument, GltfMesh, Primitive, Sparse};
use super::placements::PlacedMesh;
use std::collections::HashMap;
use std::hash::Hash;

/// Maximum number of triangles in copies that are stored as separate triangles. Beyond it, the
/// copies become instances.
pub(super) const MAX_COPIED_TRIANGLES: u64 = 1 << 18;

/// Numbers that are equal for equal primitives.
pub(super) struct MeshInstances<'a> {
    document: &'a GltfDocument,
    /// For each mesh, its primitives' numbers.
    meshes: Vec<Vec<usize>>,
}

/// Numbers of keys, equal for equal keys.
struct Numbering<K>(HashMap<K, usize>);

impl<K: Eq + Hash> Numbering<K> {
    fn number(&mut self, key: K) -> usize {
        let next = self.0.len();
        *self.0.entry(key).or_insert(next)
    }
}

/// Primitives of a mesh, by their indices in it, and how often it has them.
pub(super) struct MeshPart {
    pub(super) primitives: Vec<usize>,
    pub(super) times: usize,
}

impl<'a> MeshInstances<'a> {
    pub(super) fn of(document: &'a GltfDocument) -> MeshInstances<'a> {
        let mut numbers = Numbering(HashMap::new());
        let accessors = document.accessors.iter();
        let accessors: Vec<usize> = accessors
            .map(|row| numbers.number(accessor_key(row)))
            .collect();
        // A missing accessor is not equal to any other.
        let accessor = |row: usize| accessors.get(row).map_or(Err(row), |&number| Ok(number));
        let mut numbers = Numbering(HashMap::new());
        let mut number = |primitive: &'a Primitive| {
            let attributes = primitive.attributes.iter();
            let attributes: Vec<_> = attributes
                .map(|(name, &row)| (name, accessor(row)))
                .collect();
            let indices = primitive.indices.map(accessor);
            numbers.number((attributes, indices, primitive.mode, primitive.material))
        };
        let meshes = document.meshes.iter();
        let meshes = meshes.map(|mesh| mesh.primitives.iter().map(&mut number).collect());
        MeshInstances {
            document,
            meshes: meshes.collect(),
        }
    }

    /// Merges the placements of meshes of the same primitives, if more triangles than
    /// [`MAX_COPIED_TRIANGLES`] would be copied otherwise. Poses are left as they are.
    pub(super) fn joined<'b>(&self, shown: Vec<PlacedMesh<'b>>) -> Vec<PlacedMesh<'b>> {
        let mut first: HashMap<&[usize], usize> = HashMap::new();
        let mut copied = 0u64;
        for placed in shown.iter().filter(|placed| placed.pose.is_rest()) {
            let mesh = placed.mesh;
            if *first.entry(&self.meshes[mesh]).or_insert(mesh) != mesh {
                let times = placed.maps.len() as u64;
                copied = copied.saturating_add(self.triangles(mesh).saturating_mul(times));
            }
        }
        if copied <= MAX_COPIED_TRIANGLES {
            return shown;
        }
        let mut joined: Vec<PlacedMesh> = Vec::new();
        let mut rows = HashMap::new();
        for placed in shown {
            let next = joined.len();
            let row = if placed.pose.is_rest() {
                *rows
                    .entry(first[&self.meshes[placed.mesh][..]])
                    .or_insert(next)
            } else {
                next
            };
            match joined.get_mut(row) {
                Some(all) => all.maps.extend(placed.maps),
                None => joined.push(placed),
            }
        }
        joined
    }

    /// Splits the primitives of a mesh that is shown `placements` times. They stay together unless
    /// the mesh would copy more than [`MAX_COPIED_TRIANGLES`] triangles; then there is a part for
    /// each number of repetitions. Copies in a mesh with many placements are stored regardless: as
    /// instances, their number would be the product. A mesh in a pose is not split.
    pub(super) fn parts(&self, placed: &PlacedMesh) -> Vec<MeshPart> {
        let (mesh, placements) = (placed.mesh, placed.maps.len());
        let numbers = &self.meshes[mesh];
        let same_mesh = || {
            vec![MeshPart {
                primitives: (0..numbers.len()).collect(),
                times: 1,
            }]
        };
        if !placed.pose.is_rest() {
            return same_mesh();
        }
        let mut times: HashMap<usize, (usize, usize)> = HashMap::new();
        for (k, &number) in numbers.iter().enumerate() {
            times.entry(number).or_insert((k, 0)).1 += 1;
        }
        let distinct = times
            .values()
            .map(|&(first, _)| self.triangles_of(mesh, first));
        let copied = self.triangles(mesh).saturating_sub(distinct.sum());
        let instances = (numbers.len() - times.len()).saturating_mul(placements) as u64;
        if copied <= MAX_COPIED_TRIANGLES || instances > MAX_COPIED_TRIANGLES {
            return same_mesh();
        }
        let mut times: Vec<(usize, usize)> = times.into_values().map(|(k, n)| (n, k)).collect();
        times.sort_unstable();
        let parts = times.chunk_by(|a, b| a.0 == b.0).map(|part| MeshPart {
            primitives: part.iter().map(|&(_, primitive)| primitive).collect(),
            times: part[0].0,
        });
        parts.collect()
    }

    /// Number of triangles of a mesh, by its accessors.
    pub(super) fn triangles(&self, mesh: usize) -> u64 {
        let GltfMesh { primitives, .. } = &self.document.meshes[mesh];
        let each = (0..primitives.len()).map(|k| self.triangles_of(mesh, k));
        each.fold(0, u64::saturating_add)
    }

    fn triangles_of(&self, mesh: usize, primitive: usize) -> u64 {
        let primitive = &self.document.meshes[mesh].primitives[primitive];
        let positions = primitive.attributes.get("POSITION").copied();
        let row = primitive.indices.or(positions);
        let row = row.and_then(|row| self.document.accessors.get(row));
        row.map_or(0, |row| match primitive.mode {
            4 => row.count / 3,
            _ => row.count,
        })
    }
}

/// A key of all that distinguishes the rows of accessors.
fn accessor_key(row: &GltfAccessor) -> impl Eq + Hash + use<> {
    let sparse = |sparse: &Sparse| {
        let (indices, values) = (&sparse.indices, &sparse.values);
        let rows = [indices.buffer_view, values.buffer_view];
        let offsets = [indices.byte_offset, values.byte_offset];
        (sparse.count, indices.component_type, rows, offsets)
    };
    (
        (row.buffer_view, row.byte_offset, row.count),
        (row.component_type, row.normalized, row.kind.clone()),
        row.sparse.as_ref().map(sparse),
    )
}
