//! Smoothing groups: common normals of the faces of a group that have none of their own.
//!
//! The normal of a vertex in a group is the sum of the unit normals of the group's triangles around
//! it, each weighted by its angle there (Thürmer and Wüthrich, "Computing Vertex Normals from
//! Polygonal Facets", 1998). So it does not depend on how polygons are cut.

use super::runs;
use crate::memory::{MemoryLedger, OverLimit};
use crate::mesh::MergedMesh;
use crate::mesh::faces::{NONE, NORMAL, VERTEX};
use glam::{DVec3, Vec3};
use std::ops::Range;

/// Bytes of a triangle's references to normals, and of its number in its group.
const ROW_BYTES: u64 = 12 + 8;
/// Bytes of a normal, and of its sum while it is computed.
const NORMAL_BYTES: u64 = 12 + 24;
/// Bytes of a vertex while normals are computed.
const VERTEX_BYTES: u64 = 4;

/// Gives normals to triangles of smoothing groups without any. Groups change at `runs`, ascending;
/// group 0 is none.
pub(super) fn smooth(
    mesh: &mut MergedMesh,
    runs: &[(usize, u32)],
    memory: &MemoryLedger,
) -> Result<(), OverLimit> {
    let triangles = mesh.faces[VERTEX].len();
    let mut groups = groups(runs, triangles);
    let flat = |k: usize| mesh.faces[NORMAL].get(k).is_none_or(|row| row[0] == NONE);
    groups.retain(|(_, range)| range.clone().any(flat));
    if groups.is_empty() {
        return Ok(());
    }
    let smoothed: usize = groups.iter().map(|(_, range)| range.len()).sum();
    let normals = smoothed
        .saturating_mul(3)
        .min(mesh.vertices.len().saturating_mul(groups.len()));
    let rows = triangles as u64 * ROW_BYTES + mesh.vertices.len() as u64 * VERTEX_BYTES;
    let needed = rows + normals as u64 * NORMAL_BYTES;
    memory.take(needed, "for the normals of smoothing groups")?;
    mesh.faces[NORMAL].resize(triangles, [NONE; 3]);
    let mut smoother = Smoother {
        slots: vec![NONE; mesh.vertices.len()],
        sums: Vec::new(),
        touched: Vec::new(),
    };
    for same in groups.chunk_by(|a, b| a.0 == b.0) {
        smoother.smooth_group(mesh, same);
    }
    Ok(())
}

/// Runs of triangles that are in a group, ordered by the groups' numbers.
fn groups(runs: &[(usize, u32)], triangles: usize) -> Vec<(u32, Range<usize>)> {
    let ranges = runs::ranges(runs, triangles).map(|(range, &group)| (group, range));
    let mut groups: Vec<_> = ranges
        .filter(|(group, range)| *group != 0 && !range.is_empty())
        .collect();
    groups.sort_by_key(|(group, range)| (*group, range.start));
    groups
}

/// Sums of normals for the vertices of a group.
struct Smoother {
    /// Number of the sum of each vertex, or [`NONE`].
    slots: Vec<u32>,
    sums: Vec<DVec3>,
    /// Vertices that have a sum.
    touched: Vec<u32>,
}

impl Smoother {
    fn smooth_group(&mut self, mesh: &mut MergedMesh, ranges: &[(u32, Range<usize>)]) {
        let [corners, _, rows] = &mut mesh.faces;
        let all = ranges.iter().flat_map(|(_, range)| range.clone());
        let flat: Vec<usize> = all.filter(|&k| rows[k][0] == NONE).collect();
        for &k in &flat {
            let vertices = corners[k].map(|v| mesh.vertices.get(v as usize).as_dvec3());
            let normal = (vertices[1] - vertices[0]).cross(vertices[2] - vertices[0]);
            let unit = normal.normalize_or_zero();
            for (corner, &vertex) in corners[k].iter().enumerate() {
                let sum = self.slot(vertex);
                self.sums[sum] += unit * angle(vertices, corner);
            }
        }
        let first = mesh.vertex_normals.len() as u32;
        for &k in &flat {
            let slots = corners[k].map(|vertex| self.slots[vertex as usize]);
            // If the sum is zero, triangles of opposite orientation meet: they stay flat.
            if slots
                .iter()
                .all(|&slot| unit(self.sums[slot as usize]).is_some())
            {
                rows[k] = slots.map(|slot| first + slot);
            }
        }
        for sum in self.sums.drain(..) {
            mesh.vertex_normals.push(unit(sum).unwrap_or(Vec3::Z));
        }
        for vertex in self.touched.drain(..) {
            self.slots[vertex as usize] = NONE;
        }
    }

    /// Number of the sum of a vertex.
    fn slot(&mut self, vertex: u32) -> usize {
        let slot = &mut self.slots[vertex as usize];
        if *slot == NONE {
            *slot = self.sums.len() as u32;
            self.sums.push(DVec3::ZERO);
            self.touched.push(vertex);
        }
        *slot as usize
    }
}

/// The angle of a triangle at one of its corners.
fn angle(vertices: [DVec3; 3], corner: usize) -> f64 {
    let [a, b, c] = [0, 1, 2].map(|k| vertices[(corner + k) % 3]);
    let (left, right) = (b - a, c - a);
    libm::atan2(left.cross(right).length(), left.dot(right))
}

fn unit(sum: DVec3) -> Option<Vec3> {
    // Sums of unit vectors: if they cancel out, the remainder is rounding.
    const LEAST: f64 = 1e-9;
    (sum.length() > LEAST).then(|| sum.normalize().as_vec3())
}

#[cfg(test)]
mod tests {
    use super::*;
    use phalanx_scene::Vec3s;

    fn mesh(points: &[[f32; 3]], corners: &[[u32; 3]]) -> MergedMesh {
        let mut vertices = Vec3s::default();
        points.iter().for_each(|&p| vertices.push(p.into()));
        MergedMesh {
            vertices,
            faces: [corners.to_vec(), Vec::new(), Vec::new()],
            ..MergedMesh::default()
        }
    }

    /// A roof of two quads over the ridge 0, 1, cut in different ways.
    fn roof() -> MergedMesh {
        let points = [
            [0.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [-1.0, 0.0, -1.0],
            [-1.0, 1.0, -1.0],
            [1.0, 0.0, -1.0],
            [1.0, 1.0, -1.0],
        ];
        mesh(&points, &[[0, 1, 3], [0, 3, 2], [0, 4, 1], [4, 5, 1]])
    }

    fn normals(mesh: &MergedMesh, k: usize) -> Option<[Vec3; 3]> {
        let row = mesh.faces[NORMAL].get(k).filter(|row| row[0] != NONE)?;
        Some(row.map(|n| mesh.vertex_normals.get(n as usize)))
    }

    fn smoothed(runs: &[(usize, u32)]) -> MergedMesh {
        let mut mesh = roof();
        smooth(&mut mesh, runs, &MemoryLedger::of(None)).unwrap();
        mesh
    }

    #[test]
    fn a_ridge_is_smooth_within_a_group_whatever_the_cut() {
        let mesh = smoothed(&[(0, 1)]);
        for (k, corner) in [(0, 0), (0, 1), (1, 0), (2, 0), (2, 2), (3, 2)] {
            let normal = normals(&mesh, k).unwrap()[corner];
            assert!((normal - Vec3::Z).length() < 1e-6, "{k}.{corner}: {normal}");
        }
        assert_eq!(mesh.vertex_normals.len(), 6);
    }

    #[test]
    fn groups_do_not_mix_and_none_is_flat() {
        let mesh = smoothed(&[(0, 2), (2, 1), (3, 0)]);
        let left = normals(&mesh, 0).unwrap();
        assert!(left.iter().all(|n| (*n - left[0]).length() < 1e-6) && left[0].x < -0.7);
        assert!(normals(&mesh, 2).unwrap()[0].x > 0.7);
        assert_eq!(normals(&mesh, 3), None);
        // A group that is taken up again is the same one.
        let again = smoothed(&[(0, 1), (1, 2), (2, 1)]);
        assert!((normals(&again, 0).unwrap()[0] - Vec3::Z).length() < 0.5);
        for runs in [&[][..], &[(0, 0)], &[(4, 1)]] {
            assert!(smoothed(runs).faces[NORMAL].is_empty());
        }
    }

    #[test]
    fn triangles_that_cancel_out_stay_flat_and_own_normals_stay() {
        let mut both = mesh(
            &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            &[[0, 1, 2], [0, 2, 1], [0, 0, 1]],
        );
        smooth(&mut both, &[(0, 1)], &MemoryLedger::of(None)).unwrap();
        assert!((0..3).all(|k| normals(&both, k).is_none()));
        let mut mesh_with_normal = roof();
        mesh_with_normal.vertex_normals.push(Vec3::X);
        mesh_with_normal.faces[NORMAL] = vec![[0; 3], [NONE; 3], [NONE; 3], [NONE; 3]];
        smooth(&mut mesh_with_normal, &[(0, 1)], &MemoryLedger::of(None)).unwrap();
        assert_eq!(normals(&mesh_with_normal, 0), Some([Vec3::X; 3]));
        assert!(normals(&mesh_with_normal, 1).is_some());
    }

    #[test]
    fn normals_count_before_they_are_made() {
        let memory = MemoryLedger::of(Some(100));
        let refusal = smooth(&mut roof(), &[(0, 1)], &memory).unwrap_err();
        assert!(refusal.what.contains("smoothing groups"), "{refusal}");
    }
}
