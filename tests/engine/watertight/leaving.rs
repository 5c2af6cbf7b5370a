//! Rays that leave a face on its lit side do not hit it: shadow, mirror and ambient occlusion rays,
//! at any coordinates. `PHALANX_LEAVING_RAYS=100000000` for more rays than usual, `-- --nocapture`
//! for the table.

use super::meshes::{ClosedMesh, cube, geodesic, globe};
use crate::common::full_or;
use crate::common::rays::pack;
use crate::common::rng::Rng;
use crate::common::scenes;
use glam::Vec3;
use phalanx::bvh::Bvh;
use phalanx::lanes::{LANES, LaneMask, Mask8};
use phalanx::oracle::{Oracle, OracleRay, OracleSearch, OracleSurface, TwoLevelBvh};
use phalanx::packet::NO_PRIM;
use phalanx::scene::{Cone, PrimKind, Scene};
use phalanx::trace::PacketTracer;

/// Destinations of rays: their own face, another one, or none.
#[derive(Default, Debug, PartialEq)]
struct Ends {
    own: usize,
    other: usize,
    none: usize,
}

fn rays_given() -> usize {
    let given = std::env::var("PHALANX_LEAVING_RAYS").ok();
    given.map_or(full_or(1_000_000, 250_000), |n| {
        n.parse().expect("a number of rays")
    })
}

/// The surface seen near a position from outside, at any angle, from near or far.
fn seen(oracle: &Oracle, point: Vec3, size: f32, rng: &mut Rng) -> Option<(u32, OracleSurface)> {
    let from = point + rng.direction() * size * rng.magnitude(-2.0, 3.0);
    let ray = OracleRay::new(from, (point - from).normalize_or(Vec3::X));
    let hit = oracle.closest(&ray)?;
    let (surface, _, _) = oracle.surface_at(&ray, &hit);
    surface.entering.then_some((hit.prim_id, surface))
}

/// A ray that leaves a surface on the side from which it was seen, occasionally almost along it.
fn leaving(surface: &OracleSurface, rng: &mut Rng) -> OracleRay {
    let up = surface.ng.as_dvec3();
    loop {
        let dir = rng.direction();
        let along = dir - surface.ng * dir.dot(surface.ng);
        let dir = match rng.below(3) {
            0 => along + surface.ng * rng.magnitude(-7.0, -1.0),
            _ => dir,
        };
        let dir = if dir.dot(surface.ng) < 0.0 { -dir } else { dir };
        if dir.as_dvec3().dot(up) > 1e-7 {
            return surface.offset_origin(dir * rng.magnitude(-2.0, 2.0));
        }
    }
}

/// Sends rays off a scene's surfaces near the points given by `point_on`.
fn leave(
    scene: &Scene,
    size: f32,
    mut point_on: impl FnMut(&mut Rng) -> Vec3,
    rays: usize,
) -> Ends {
    let (bvh, tree) = (Bvh::build(scene), TwoLevelBvh::build(scene));
    let oracle = Oracle::new(scene, OracleSearch::Tree(&tree));
    let mut tracer = PacketTracer::new(&bvh);
    let mut rng = Rng::new(37);
    let mut ends = Ends::default();
    let mut left = 0;
    while left < rays {
        let position = point_on(&mut rng);
        let Some((own, surface)) = seen(&oracle, position, size, &mut rng) else {
            continue;
        };
        let eight = [0; LANES].map(|_| leaving(&surface, &mut rng));
        let packet = pack(&eight, |_| f32::INFINITY);
        let hits = tracer.closest(&packet, Mask8::from_bits(0xff));
        for (ray, id) in eight.iter().zip(hits.prim_id.to_array()) {
            match id {
                NO_PRIM => ends.none += 1,
                id if id == own => {
                    ends.own += 1;
                    println!("{ray:?} hits {own}, which it left");
                }
                _ => ends.other += 1,
            }
        }
        left += LANES;
    }
    ends
}

/// The mesh, rotated so that its edges are not along the axes.
fn turned(mesh: ClosedMesh) -> ClosedMesh {
    let turn = glam::Quat::from_euler(glam::EulerRot::XYZ, 0.3, 0.7, 1.1);
    ClosedMesh {
        vertices: mesh.vertices.iter().map(|v| turn * *v).collect(),
        ..mesh
    }
}

#[test]
fn rays_that_leave_a_face_do_not_hit_it() {
    let meshes = [
        ("globe", globe(40, 80)),
        ("globe of slivers", globe(8, 300)),
        ("geodesic sphere", geodesic(4)),
        ("cube", cube()),
        ("turned cube", turned(cube())),
    ];
    let places = [
        (1.0, Vec3::ZERO),
        (1e6, Vec3::ZERO),
        (1.0, Vec3::new(100.0, -70.0, 30.0)),
        (1.0, Vec3::new(3e4, 1.0, -2e4)),
        (1.0, Vec3::new(5e5, 4e6, 12.0)),
        (1e3, Vec3::new(-5e5, 0.0, 1e5)),
    ];
    let each = rays_given() / (meshes.len() * places.len());
    for (name, mesh) in &meshes {
        for (scale, offset) in places {
            let (scene, placed) = mesh.scene(scale, offset);
            let point_on = |rng: &mut Rng| {
                let [a, b, c] = rng.pick(&mesh.triangles).map(|k| placed[k]);
                let (v, w) = (rng.unit(), rng.unit());
                a + (b - a) * v + (c - a) * (w * (1.0 - v))
            };
            let ends = leave(&scene, scale, point_on, each);
            println!("{name}, scale {scale}, at {offset}: {ends:?}");
            assert_eq!(ends.own, 0, "{name}, scale {scale}, at {offset}");
        }
    }
}

/// A floor of size ten million, seen and left near its centre, with its plane through or near the
/// origin.
#[test]
fn rays_that_leave_a_large_floor_do_not_hit_it() {
    for (slope, height) in [(0.0, 0.0), (0.0, 3.0), (0.25, 0.0), (-0.31, 0.7)] {
        let mut scene = scenes::bare();
        let corner = |x: f32, z: f32| Vec3::new(x * 1e7, x * 1e7 * slope + height, z * 1e7);
        let [a, b, c, d] =
            [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(x, z)| corner(x, z));
        scene.add_triangle([a, b, c], None, 0);
        scene.add_triangle([a, c, d], None, 0);
        scene.validate().expect("a valid scene");
        let point_on = |rng: &mut Rng| {
            let position = rng.direction() * rng.magnitude(-2.0, 6.0);
            Vec3::new(position.x, position.x * slope + height, position.z)
        };
        let ends = leave(&scene, 10.0, point_on, rays_given() / 4);
        println!("floor, slope {slope}, height {height}: {ends:?}");
        assert_eq!(
            (ends.own, ends.other),
            (0, 0),
            "slope {slope}, height {height}"
        );
    }
}

/// Spheres, ellipsoids and cones are convex: a ray that leaves outward does not return.
#[test]
fn rays_that_leave_a_bulge_do_not_hit_it() {
    for kind in [PrimKind::Sphere, PrimKind::Ellipsoid, PrimKind::Cone] {
        for (size, center) in [
            (1.0, Vec3::ZERO),
            (1e3, Vec3::new(1.0, 2.0, 3.0)),
            (1.0, Vec3::new(3e4, 1.0, -2e4)),
            (10.0, Vec3::new(-5e5, 70.0, 1e5)),
        ] {
            let mut scene = scenes::bare();
            match kind {
                PrimKind::Sphere => {
                    scene.add_sphere(center, size, 0);
                }
                PrimKind::Ellipsoid => {
                    let (axes, turn) = (Vec3::new(1.0, 0.5, 2.0), Vec3::new(0.3, 0.2, 0.9));
                    scenes::add_ellipsoid(&mut scene, center, axes * size, turn, 0);
                }
                _ => {
                    let cone = Cone {
                        base: center,
                        apex: center + Vec3::new(1.0, 2.0, 0.5) * size,
                        base_radius: size,
                        apex_radius: 0.3 * size,
                        inside: false,
                    };
                    scene.add_cone(cone, 0);
                }
            }
            scene.validate().expect("a valid scene");
            let point_on = |rng: &mut Rng| center + rng.point(size);
            let ends = leave(&scene, size, point_on, rays_given() / 12);
            println!("{kind:?} of {size} at {center}: {ends:?}");
            assert_eq!(ends.own, 0, "{kind:?} of {size} at {center}");
        }
    }
}
