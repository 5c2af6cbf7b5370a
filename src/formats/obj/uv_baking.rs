//! UVs of materials that scale and move their textures, with `-s` and `-o`. The scene's textures
//! have no transform, so triangles of such materials get UVs of their own.

use super::texture_map::UvTransform;
use crate::memory::{MemoryLedger, OverLimit};
use crate::mesh::MergedMesh;
use crate::mesh::faces::{NONE, UV};
use glam::Vec2;
use std::ops::Range;

/// Bytes of a UV.
const UV_BYTES: u64 = 8;
/// Bytes of a UV of the file while transformed ones are made.
const SLOT_BYTES: u64 = 4;

/// Transforms the UVs of runs of triangles. A UV that several triangles share is made once for each
/// transform.
pub(super) fn bake(
    mesh: &mut MergedMesh,
    runs: &[(Range<usize>, UvTransform)],
    memory: &MemoryLedger,
) -> Result<(), OverLimit> {
    let count = mesh.vertex_uvs.len();
    if runs.is_empty() || mesh.faces[UV].is_empty() {
        return Ok(());
    }
    let corners: usize = runs.iter().map(|(range, _)| 3 * range.len()).sum();
    let mut runs = runs.to_vec();
    runs.sort_by_key(|(range, transform)| (transform.bits(), range.start));
    let most = corners.min(count.saturating_mul(runs.len()));
    let needed = most as u64 * UV_BYTES + count as u64 * SLOT_BYTES;
    memory.take(
        needed,
        "for the places of textures that are scaled or moved",
    )?;
    let mut slots = vec![NONE; count];
    let mut touched = Vec::new();
    for same in runs.chunk_by(|a, b| a.1.bits() == b.1.bits()) {
        for (range, transform) in same {
            for row in &mut mesh.faces[UV][range.clone()] {
                for number in row.iter_mut().filter(|number| **number != NONE) {
                    let slot = &mut slots[*number as usize];
                    if *slot == NONE {
                        touched.push(*number);
                        *slot = mesh.vertex_uvs.len() as u32;
                        let Vec2 { x, y } = mesh.vertex_uvs.get(*number as usize);
                        mesh.vertex_uvs.push(transform.apply([x, y]));
                    }
                    *number = *slot;
                }
            }
        }
        for number in touched.drain(..) {
            slots[number as usize] = NONE;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_of_a_material_get_uvs_of_their_own() {
        let twice = UvTransform {
            scale: Vec2::splat(2.0),
            ..UvTransform::IDENTITY
        };
        let moved = UvTransform {
            offset: Vec2::new(0.5, 0.0),
            ..UvTransform::IDENTITY
        };
        let mut mesh = MergedMesh::default();
        for uv in [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]] {
            mesh.vertex_uvs.push(uv.into());
        }
        mesh.faces[UV] = vec![[0, 1, 2], [0, 1, 2], [2, 1, 0], [NONE; 3], [0, 1, 2]];
        let runs = [(1..2, twice), (2..4, moved), (4..5, twice)];
        bake(&mut mesh, &runs, &MemoryLedger::of(None)).unwrap();
        let rows = &mesh.faces[UV];
        assert_eq!((rows[0], rows[3]), ([0, 1, 2], [NONE; 3]));
        assert_eq!(rows[1], rows[4], "made once");
        let uvs = |row: [u32; 3]| row.map(|number| mesh.vertex_uvs.get(number as usize));
        assert_eq!(
            uvs(rows[1]),
            [[0.0, 1.0], [2.0, 1.0], [0.0, -1.0]].map(Vec2::from)
        );
        assert_eq!(
            uvs(rows[2]),
            [[0.5, 0.0], [1.5, 1.0], [0.5, 1.0]].map(Vec2::from)
        );
        assert_eq!(mesh.vertex_uvs.len(), 9);
        let memory = MemoryLedger::of(Some(10));
        assert!(bake(&mut mesh, &runs, &memory).is_err());
    }
}
