//! Closed meshes.

use crate::common::rng::Rng;
use crate::common::scenes;
use glam::Vec3;
use phalanx::scene::Scene;
use std::collections::HashMap;
use std::f32::consts::{PI, TAU};

/// A closed mesh: shared vertices, triangles, and a way to find a point inside.
pub struct ClosedMesh {
    pub vertices: Vec<Vec3>,
    pub triangles: Vec<[usize; 3]>,
    pub inside: fn(&mut Rng) -> Vec3,
}

impl ClosedMesh {
    /// Every edge belongs to two triangles, which run along it in opposite directions.
    pub fn assert_closed(&self) {
        let mut edges = HashMap::new();
        for t in &self.triangles {
            for k in 0..3 {
                *edges.entry((t[k], t[(k + 1) % 3])).or_insert(0) += 1;
            }
        }
        for (&(from, to), &count) in &edges {
            assert_eq!(count, 1, "edge {from} to {to}");
            assert!(
                edges.contains_key(&(to, from)),
                "edge {from} to {to} is open"
            );
        }
    }

    /// The mesh scaled, then moved.
    pub fn scene(&self, scale: f32, offset: Vec3) -> (Scene, Vec<Vec3>) {
        let mut scene = scenes::bare();
        let placed: Vec<Vec3> = self.vertices.iter().map(|v| *v * scale + offset).collect();
        for t in &self.triangles {
            scene.add_triangle(t.map(|k| placed[k]), None, 0);
        }
        scene.validate().expect("a valid mesh");
        (scene, placed)
    }
}

fn in_ball(rng: &mut Rng) -> Vec3 {
    rng.direction() * rng.range(0.0, 0.7)
}

/// A globe by latitude and longitude, with slivers at the poles: at latitude steps of π/`rings`.
pub fn globe(rings: usize, segments: usize) -> ClosedMesh {
    let mut vertices = vec![Vec3::Z, -Vec3::Z];
    for ring in 1..rings {
        let polar = PI * ring as f32 / rings as f32;
        for k in 0..segments {
            let around = TAU * k as f32 / segments as f32;
            let (sin, cos) = (polar.sin(), polar.cos());
            vertices.push(Vec3::new(sin * around.cos(), sin * around.sin(), cos));
        }
    }
    let vertex = |ring: usize, k: usize| 2 + (ring - 1) * segments + k % segments;
    let mut triangles = Vec::new();
    for k in 0..segments {
        triangles.push([0, vertex(1, k), vertex(1, k + 1)]);
        triangles.push([1, vertex(rings - 1, k + 1), vertex(rings - 1, k)]);
        for ring in 1..rings - 1 {
            let (a, b) = (vertex(ring, k), vertex(ring, k + 1));
            let (c, d) = (vertex(ring + 1, k), vertex(ring + 1, k + 1));
            triangles.push([a, c, d]);
            triangles.push([a, d, b]);
        }
    }
    ClosedMesh {
        vertices,
        triangles,
        inside: in_ball,
    }
}

/// An octahedron with its triangles quartered `times` times and projected onto the sphere.
pub fn geodesic(times: usize) -> ClosedMesh {
    let axes = [Vec3::X, Vec3::Y, -Vec3::X, -Vec3::Y];
    let mut vertices = vec![Vec3::Z, -Vec3::Z];
    vertices.extend(axes);
    let mut triangles = Vec::new();
    for k in 0..4 {
        let (a, b) = (2 + k, 2 + (k + 1) % 4);
        triangles.push([0, a, b]);
        triangles.push([1, b, a]);
    }
    for _ in 0..times {
        let mut middles: HashMap<(usize, usize), usize> = HashMap::new();
        let mut quarters = Vec::new();
        for &[a, b, c] in &triangles {
            let mut middle = |p: usize, q: usize| {
                *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
                    vertices.push((vertices[p] + vertices[q]).normalize());
                    vertices.len() - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            quarters.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = quarters;
    }
    ClosedMesh {
        vertices,
        triangles,
        inside: in_ball,
    }
}

/// A torus of radii 1 and 0.4.
pub fn torus(around: usize, across: usize) -> ClosedMesh {
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..around {
        for k in 0..across {
            let (u, v) = (
                TAU * i as f32 / around as f32,
                TAU * k as f32 / across as f32,
            );
            let out = 1.0 + 0.4 * v.cos();
            vertices.push(Vec3::new(out * u.cos(), out * u.sin(), 0.4 * v.sin()));
            let vertex = |i: usize, k: usize| i % around * across + k % across;
            let (a, b) = (vertex(i, k), vertex(i + 1, k));
            let (c, d) = (vertex(i, k + 1), vertex(i + 1, k + 1));
            triangles.push([a, b, d]);
            triangles.push([a, d, c]);
        }
    }
    ClosedMesh {
        vertices,
        triangles,
        inside: |rng| {
            let u = rng.range(0.0, TAU);
            let ring = Vec3::new(u.cos(), u.sin(), 0.0);
            ring + in_ball(rng) * 0.3
        },
    }
}

/// A cube of twelve triangles.
pub fn cube() -> ClosedMesh {
    ClosedMesh {
        vertices: (0..8).map(scenes::cube_corner).collect(),
        triangles: scenes::cube_triangles().collect(),
        inside: |rng| rng.point(0.9),
    }
}
