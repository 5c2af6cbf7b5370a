//! No ray escapes a closed mesh: a million rays from inside, or ten, aimed at vertices, edges and
//! anywhere, all hit. And no ray that leaves a surface hits it: see `leaving`.

mod leaving;
mod meshes;

use crate::common::full_or;
use crate::common::rays::{lane_bits, pack};
use crate::common::rng::Rng;
use glam::Vec3;
use meshes::{ClosedMesh, cube, geodesic, globe, torus};
use phalanx::bvh::Bvh;
use phalanx::lanes::{LANES, LaneMask, Mask8};
use phalanx::oracle::{Oracle, OracleRay, OracleSearch, TwoLevelBvh};
use phalanx::trace::PacketTracer;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// A ray from inside at a vertex, an edge, or anywhere.
fn ray(mesh: &ClosedMesh, placed: &[Vec3], scale: f32, offset: Vec3, rng: &mut Rng) -> OracleRay {
    let org = (mesh.inside)(rng) * scale + offset;
    let triangle = mesh.triangles[rng.below(mesh.triangles.len())];
    let [a, b, _] = triangle.map(|k| placed[k]);
    let dir = match rng.below(4) {
        0 => a - org,
        1 => a + (b - a) * rng.unit() - org,
        2 => (a - org) * rng.magnitude(-3.0, 3.0),
        _ => rng.direction(),
    };
    OracleRay::new(org, dir)
}

/// Traces packets of rays, one in `CHECKED` with the oracle, too; returns the number of rays.
fn shoot(mesh: &ClosedMesh, scale: f32, offset: Vec3, packets: usize, rng: &mut Rng) -> usize {
    const CHECKED: usize = 40;
    let (scene, placed) = mesh.scene(scale, offset);
    let bvh = Bvh::build(&scene);
    let tree = TwoLevelBvh::build(&scene);
    let oracle = Oracle::new(&scene, OracleSearch::Tree(&tree));
    let mut tracer = PacketTracer::new(&bvh);
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
fn millions_of_rays_stay_inside() {
    let meshes = [
        globe(40, 80),
        // Slivers.
        globe(8, 1500),
        geodesic(4),
        torus(60, 30),
        cube(),
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
    let packets = full_or(31_250, 3125);
    for mesh in &meshes {
        mesh.assert_closed();
    }
    let jobs = meshes
        .iter()
        .flat_map(|mesh| places.map(|place| (mesh, place)));
    let jobs = Mutex::new(jobs.enumerate());
    let next = || jobs.lock().unwrap().next();
    // Two threads: other tests run at the same time.
    let rays = AtomicUsize::new(0);
    let work = || {
        while let Some((k, (mesh, (scale, offset)))) = next() {
            let mut rng = Rng::new(31 + k as u64);
            rays.fetch_add(shoot(mesh, scale, offset, packets, &mut rng), Relaxed);
        }
    };
    std::thread::scope(|scope| {
        scope.spawn(work);
        work();
    });
    assert_eq!(rays.into_inner(), full_or(10_000_000, 1_000_000));
}
