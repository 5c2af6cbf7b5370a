//! Spheres of equal triangles, closed to the last bit.

use super::mesh_builder::MeshBuilder;
use glam::{DVec3, dvec3};

/// The golden ratio, (1 + √5) / 2.
const GOLDEN: f64 = 1.618_033_988_749_895;

/// Corners of an icosahedron.
const CORNERS: [DVec3; 12] = [
    dvec3(-1.0, GOLDEN, 0.0),
    dvec3(1.0, GOLDEN, 0.0),
    dvec3(-1.0, -GOLDEN, 0.0),
    dvec3(1.0, -GOLDEN, 0.0),
    dvec3(0.0, -1.0, GOLDEN),
    dvec3(0.0, 1.0, GOLDEN),
    dvec3(0.0, -1.0, -GOLDEN),
    dvec3(0.0, 1.0, -GOLDEN),
    dvec3(GOLDEN, 0.0, -1.0),
    dvec3(GOLDEN, 0.0, 1.0),
    dvec3(-GOLDEN, 0.0, -1.0),
    dvec3(-GOLDEN, 0.0, 1.0),
];

/// Faces of an icosahedron, counter-clockwise from outside.
const FACES: [[usize; 3]; 20] = [
    [0, 11, 5],
    [0, 5, 1],
    [0, 1, 7],
    [0, 7, 10],
    [0, 10, 11],
    [1, 5, 9],
    [5, 11, 4],
    [11, 10, 2],
    [10, 7, 6],
    [7, 1, 8],
    [3, 9, 4],
    [3, 4, 2],
    [3, 2, 6],
    [3, 6, 8],
    [3, 8, 9],
    [4, 9, 5],
    [2, 4, 11],
    [6, 2, 10],
    [8, 6, 7],
    [9, 8, 1],
];

/// The frequency (edge divisions) that comes closest to this many triangles: 20 f².
pub(super) fn frequency(triangles: f64) -> usize {
    (triangles / 20.0).max(1.0).sqrt().round() as usize
}

/// Draws a sphere of 20 `frequency`² triangles in the current material. `position` maps its points
/// from the unit sphere to the scene.
///
/// A point on an edge is the same from both faces: its sum has two terms that are not zero, and a +
/// b = b + a.
pub(super) fn sphere(mesh: &mut MeshBuilder, frequency: usize, position: impl Fn(DVec3) -> DVec3) {
    for [a, b, c] in FACES.map(|face| face.map(|i| CORNERS[i])) {
        mesh.triangle(frequency, |i, j| {
            let (u, v, w) = (frequency - i - j, i, j);
            let sum = a * u as f64 + b * v as f64 + c * w as f64;
            position(sum / sum.length())
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modern::mesh_builder::{NONE, draw_sections};
    use crate::modern::section::SceneSection;
    use std::collections::BTreeMap;

    #[test]
    fn the_sphere_is_closed_to_the_last_bit() {
        let mut section = SceneSection::default();
        let mut finish = |drawn| {
            section = drawn;
            NONE
        };
        draw_sections(0..u64::MAX, &mut finish, |mesh| {
            sphere(mesh, 37, |p| dvec3(0.1, 0.2, 0.3) + p * 0.7);
            assert_eq!(mesh.triangles(), 20 * 37 * 37);
        });
        let strip = &section.strips[0];
        // Adding 0 turns -0 into 0, as rays do not distinguish them.
        let bits = |v: u32| {
            strip.vertices[v as usize]
                .to_array()
                .map(|x| (x + 0.0).to_bits())
        };
        // Number of times that each directed edge occurs.
        let mut edges = BTreeMap::<_, usize>::new();
        for t in &strip.triangles {
            for k in 0..3 {
                *edges.entry([bits(t[k]), bits(t[(k + 1) % 3])]).or_default() += 1;
            }
        }
        assert_eq!(edges.len(), 3 * 20 * 37 * 37);
        for ([a, b], count) in &edges {
            assert_eq!(*count, 1);
            assert_eq!(edges.get(&[*b, *a]), Some(&1));
        }
    }
}
