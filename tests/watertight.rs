//! No ray escapes a closed mesh: ten million rays from inside, aimed at vertices, edges and anywhere, all hit.

mod common;

use common::rays::{lane_bits, pack};
use common::rng::Rng;
use common::scenes;
use glam::Vec3;
use phalanx::bvh::Bvh;
use phalanx::lanes::{LANES, LaneMask, Mask8};
use phalanx::oracle::{Forest, Oracle, Ray, Search};
use phalanx::scene::Scene;
use phalanx::trace::Tracer;
use std::collections::HashMap;
use std::f32::consts::{PI, TAU};

/// A closed mesh: shared vertices, triangles, and how to find a point inside.
struct Mesh {
    vertices: Vec<Vec3>,
    triangles: Vec<[usize; 3]>,
    inside: fn(&mut Rng) -> Vec3,
}

impl Mesh {
    /// Every edge belongs to two triangles, which run along it in opposite directions.
    fn assert_closed(&self) {
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
    fn scene(&self, scale: f32, offset: Vec3) -> (Scene, Vec<Vec3>) {
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

/// By latitude and longitude, with slivers at the poles: at latitude steps of π/`rings`.
fn globe(rings: usize, segments: usize) -> Mesh {
    let mut vertices = vec![Vec3::Z, -Vec3::Z];
    for ring in 1..rings {
        let polar = PI * ring as f32 / rings as f32;
        for k in 0..segments {
            let around = TAU * k as f32 / segments as f32;
            let (sin, cos) = (polar.sin(), polar.cos());
            vertices.push(Vec3::new(sin * around.cos(), sin * around.sin(), cos));
        }
    }
    let at = |ring: usize, k: usize| 2 + (ring - 1) * segments + k % segments;
    let mut triangles = Vec::new();
    for k in 0..segments {
        triangles.push([0, at(1, k), at(1, k + 1)]);
        triangles.push([1, at(rings - 1, k + 1), at(rings - 1, k)]);
        for ring in 1..rings - 1 {
            let (a, b) = (at(ring, k), at(ring, k + 1));
            let (c, d) = (at(ring + 1, k), at(ring + 1, k + 1));
            triangles.push([a, c, d]);
            triangles.push([a, d, b]);
        }
    }
    Mesh {
        vertices,
        triangles,
        inside: in_ball,
    }
}

/// An octahedron whose triangles are quartered `times` times and pushed onto the sphere.
fn geodesic(times: usize) -> Mesh {
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
    Mesh {
        vertices,
        triangles,
        inside: in_ball,
    }
}

/// A torus of radii 1 and 0.4.
fn torus(around: usize, across: usize) -> Mesh {
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
            let at = |i: usize, k: usize| i % around * across + k % across;
            let (a, b) = (at(i, k), at(i + 1, k));
            let (c, d) = (at(i, k + 1), at(i + 1, k + 1));
            triangles.push([a, b, d]);
            triangles.push([a, d, c]);
        }
    }
    Mesh {
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
fn cube() -> Mesh {
    let vertices = (0..8)
        .map(|k| Vec3::from_array([0, 1, 2].map(|bit| if k >> bit & 1 == 1 { 1.0 } else { -1.0 })))
        .collect();
    let faces = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let halves = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]];
    Mesh {
        vertices,
        triangles: faces.into_iter().flat_map(halves).collect(),
        inside: |rng| rng.point(0.9),
    }
}

/// A ray from inside at a vertex, an edge, or anywhere.
fn ray(mesh: &Mesh, placed: &[Vec3], scale: f32, offset: Vec3, rng: &mut Rng) -> Ray {
    let org = (mesh.inside)(rng) * scale + offset;
    let triangle = mesh.triangles[rng.below(mesh.triangles.len())];
    let [a, b, _] = triangle.map(|k| placed[k]);
    let dir = match rng.below(4) {
        0 => a - org,
        1 => a + (b - a) * rng.unit() - org,
        2 => (a - org) * rng.magnitude(-3.0, 3.0),
        _ => rng.direction(),
    };
    Ray::new(org, dir)
}

/// Shoots packets of rays, one in `CHECKED` packets through the oracle, too; returns how many were shot.
fn shoot(mesh: &Mesh, scale: f32, offset: Vec3, packets: usize, rng: &mut Rng) -> usize {
    const CHECKED: usize = 40;
    let (scene, placed) = mesh.scene(scale, offset);
    let bvh = Bvh::build(&scene);
    let tree = Forest::build(&scene);
    let oracle = Oracle::new(&scene, Search::Tree(&tree), 0);
    let mut tracer = Tracer::new(&bvh);
    for n in 0..packets {
        let rays = [0; LANES].map(|_| ray(mesh, &placed, scale, offset, rng));
        let packet = pack(&rays, |_| f32::INFINITY);
        let hits = tracer.closest(&packet, Mask8::from_bits(0xff));
        let blocked = tracer.occluded(&packet, Mask8::from_bits(0xff));
        for (lane, ray) in rays.iter().enumerate() {
            let hit = lane_bits(&hits, lane);
            assert!(hit.is_some(), "{ray:?} escapes, scale {scale}, at {offset}");
            if n % CHECKED == 0 {
                let alone = oracle.closest(ray).map(|hit| hit.prim_id);
                assert_eq!(alone, hit.map(|hit| hit.3), "{ray:?}");
            }
        }
        assert_eq!(
            blocked.bits(),
            0xff,
            "{rays:?} pass, scale {scale}, at {offset}"
        );
    }
    packets * LANES
}

#[test]
fn ten_million_rays_stay_inside() {
    let meshes = [
        ("globe", globe(40, 80)),
        ("globe of slivers", globe(8, 1500)),
        ("geodesic sphere", geodesic(4)),
        ("torus", torus(60, 30)),
        ("cube", cube()),
    ];
    let near = Vec3::ZERO;
    let places = [
        (1.0, near),
        (1e-3, near),
        (1e6, near),
        (1.0, Vec3::new(100.0, -70.0, 30.0)),
        (1e-3, Vec3::new(0.3, 0.2, -0.5)),
        (1e6, Vec3::new(1e7, 1e7, -1e7)),
        (1e3, Vec3::new(-5e5, 0.0, 1e5)),
        (1.0, Vec3::new(0.0, 2000.0, 0.0)),
    ];
    const PACKETS: usize = 31_250;
    let mut rng = Rng::new(31);
    let mut rays = 0;
    for (name, mesh) in &meshes {
        mesh.assert_closed();
        for (scale, offset) in places {
            let start = std::time::Instant::now();
            rays += shoot(mesh, scale, offset, PACKETS, &mut rng);
            let seconds = start.elapsed().as_secs_f64();
            println!("{name}, scale {scale}, at {offset}: {seconds:.2} s");
        }
    }
    assert_eq!(rays, 10_000_000);
}
