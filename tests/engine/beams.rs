//! Beams find the same hits as packets, bit for bit: rays from one origin, toward one light near
//! and far, and parallel rays, in scenes of every kind of primitive, with eyes far away, on
//! vertices, inside boxes and next to edges.

use crate::common::rng::Rng;
use crate::common::scenes;
use bumpalo::Bump;
use glam::Vec3;
use phalanx::bvh::Bvh;
use phalanx::lanes::LANES;
use phalanx::packet::{HitPacket, NO_PRIM, RayQueue};
use phalanx::scene::Scene;
use phalanx::standard;
use phalanx::trace::{CountingTraversal, Kernel, Traversal};

/// Pixels along a side: more than one beam, and not a whole number of beams.
const SIDE: usize = 41;

type Segments = Vec<(Vec3, Vec3)>;

fn queue<'a>(arena: &'a Bump, rays: &Segments) -> RayQueue<'a> {
    let mut queue = RayQueue::with_capacity(arena, rays.len());
    for (org, dir) in rays {
        queue.push_ray(org.to_array(), dir.to_array());
    }
    queue
}

/// Bits of distance, weights and number of every ray's hit.
fn closest(bvh: &Bvh, kernel: Kernel, rays: &Segments) -> Vec<[u32; 4]> {
    let arena = Bump::new();
    let queue = queue(&arena, rays);
    let mut hits = vec![HitPacket::miss(); queue.packets()];
    Traversal::new(bvh, kernel).closest(&queue, 0..queue.packets(), &mut hits);
    let bits = |ray: usize| {
        let (hit, lane) = (&hits[ray / LANES], ray % LANES);
        let id = hit.prim_id.lane(lane);
        // Weights of a miss are undefined.
        match id {
            NO_PRIM => [hit.t.lane(lane).to_bits(), 0, 0, id],
            _ => {
                let [t, u, v] = [&hit.t, &hit.u, &hit.v].map(|x| x.lane(lane).to_bits());
                [t, u, v, id]
            }
        }
    };
    (0..rays.len()).map(bits).collect()
}

fn seen(bvh: &Bvh, kernel: Kernel, rays: &Segments, tmax: f32) -> Vec<bool> {
    let arena = Bump::new();
    let queue = queue(&arena, rays);
    let mut blocked = vec![0; queue.packets()];
    Traversal::new(bvh, kernel).occluded(&queue, 0..queue.packets(), tmax, &mut blocked);
    let bit = |k: usize| blocked[k / LANES] >> (k % LANES) & 1 == 0;
    (0..rays.len()).map(bit).collect()
}

const OTHERS: [Kernel; 4] = [Kernel::Beam8, Kernel::Beam16, Kernel::Auto, Kernel::Single];

fn compare(bvh: &Bvh, rays: &Segments, tmax: Option<f32>, about: &str) -> usize {
    let mut hits = 0;
    for kernel in OTHERS {
        let name = kernel.name();
        match tmax {
            None => {
                let want = closest(bvh, Kernel::Packet8, rays);
                let actual = closest(bvh, kernel, rays);
                for (k, (want, actual)) in want.iter().zip(&actual).enumerate() {
                    assert_eq!(want, actual, "{name}, {about}: ray {k}, {:?}", rays[k]);
                }
                hits = want.iter().filter(|hit| hit[3] != NO_PRIM).count();
            }
            Some(tmax) => {
                let want = seen(bvh, Kernel::Packet8, rays, tmax);
                let actual = seen(bvh, kernel, rays, tmax);
                for (k, (want, actual)) in want.iter().zip(&actual).enumerate() {
                    assert_eq!(want, actual, "{name}, {about}: ray {k}, {:?}", rays[k]);
                }
                hits = want.iter().filter(|&&seen| !seen).count();
            }
        }
    }
    hits
}

/// A picture's rays: `width` is that of the image plane at distance 1.
fn picture(eye: Vec3, target: Vec3, width: f32) -> Segments {
    let ahead = (target - eye).normalize();
    let right = ahead.any_orthonormal_vector();
    let up = right.cross(ahead);
    let offset = |k: usize| ((k as f32 + 0.5) / SIDE as f32 - 0.5) * width;
    let ray = |k: usize| {
        (
            eye,
            ahead + right * offset(k % SIDE) + up * offset(k / SIDE),
        )
    };
    (0..SIDE * SIDE).map(ray).collect()
}

/// Points slightly before the hits of rays.
fn points(bvh: &Bvh, rays: &Segments) -> Vec<Vec3> {
    let hits = closest(bvh, Kernel::Packet8, rays);
    let hits = rays.iter().zip(hits).filter(|(_, hit)| hit[3] != NO_PRIM);
    hits.map(|((org, dir), hit)| *org + *dir * (f32::from_bits(hit[0]) * 0.9999))
        .collect()
}

/// All checks on a scene.
fn try_scene(scene: &Scene, rng: &mut Rng, about: &str) -> usize {
    let bvh = Bvh::build(scene);
    let bounds = scene.bounds();
    let (middle, size) = (
        (bounds.lo + bounds.hi) * 0.5,
        (bounds.hi - bounds.lo).length(),
    );
    let within = |rng: &mut Rng| {
        let mut share = || rng.unit();
        bounds.lo + (bounds.hi - bounds.lo) * Vec3::new(share(), share(), share())
    };
    let corner = scene
        .triangles
        .len()
        .checked_sub(1)
        .map(|k| scene.triangles.corners(k)[0]);
    let target = within(rng);
    let way = (within(rng) - middle).normalize_or(Vec3::X);
    let mut eyes = vec![
        ("near", middle + way * size, 0.9),
        ("a wide picture", middle + way * size * 0.6, 2.5),
        ("within", within(rng), 0.7),
        ("far off", middle + way * size * 300.0, 0.004),
        ("beside an axis", middle + Vec3::new(size, 0.0, 0.0), 0.5),
        ("a narrow picture", middle + way * size, 0.01),
    ];
    eyes.extend(corner.map(|corner| ("on a corner", corner, 0.9)));
    let mut hits = 0;
    for (name, eye, width) in eyes {
        let rays = picture(eye, target, width);
        hits += compare(&bvh, &rays, None, &format!("{about}, {name}"));
        compare(
            &bvh,
            &rays,
            Some(size * 0.8),
            &format!("{about}, {name}, any"),
        );
        let points = points(&bvh, &rays);
        let lights = [0.3, 1.0, 3.0, 40.0, 5e3, 2e6].map(|far| middle + way * size * far);
        for light in lights.into_iter().chain([within(rng), eye]) {
            let toward = points.iter().map(|p| (*p, light - *p)).collect();
            let about = format!("{about}, {name}, toward {light}");
            hits += compare(&bvh, &toward, Some(1.0), &about);
        }
        for dir in [way, Vec3::Y, Vec3::new(-3.0, 1e-4, 0.0)] {
            let toward = points.iter().map(|p| (*p, dir)).collect();
            let about = format!("{about}, {name}, along {dir}");
            hits += compare(&bvh, &toward, Some(f32::INFINITY), &about);
        }
    }
    hits
}

#[test]
fn random_scenes() {
    let mut hits = 0;
    for seed in 0..30 {
        let mut rng = Rng::new(seed);
        let (count, spread) = (1 + rng.below(300), [0.5, 3.0, 40.0][seed as usize % 3]);
        let scene = scenes::random(&mut rng, count, spread);
        hits += try_scene(&scene, &mut rng, &format!("seed {seed}"));
    }
    assert!(hits > 100_000, "{hits}");
}

#[test]
fn instances() {
    let mut rng = Rng::new(5);
    let mut scene = scenes::random(&mut rng, 40, 3.0);
    scenes::add_instances(&mut scene, &mut rng, 3.0, 0);
    assert!(try_scene(&scene, &mut rng, "instances") > 1000);
}

#[test]
fn standard_scenes() {
    for name in [
        "terrain:4k",
        "hair:4k",
        "street:6k",
        "menger:4k",
        "room:4k",
        "balls:3",
        "gears:1",
    ] {
        let spec = standard::parse_spec(&format!("standard:{name}")).expect("a name");
        let scene = standard::scene(spec, 0).expect("a scene");
        let hits = try_scene(&scene, &mut Rng::new(name.len() as u64), name);
        assert!(hits > 5000, "{name}: {hits}");
    }
}

/// Small objects far from the origin, and everything tiny: margins must scale with sizes.
#[test]
fn other_places_and_sizes() {
    for (position, scale) in [
        (Vec3::splat(900.0), 1.0),
        (Vec3::ZERO, 1e-6),
        (Vec3::ZERO, 1e6),
        // Products of three coordinates are below the smallest numbers here.
        (Vec3::ZERO, 3e-13),
    ] {
        let mut rng = Rng::new(11);
        let mut scene = scenes::bare();
        for _ in 0..400 {
            let mut point = || {
                let mut x = || rng.unit() - 0.5;
                Vec3::new(x(), x(), x())
            };
            let corner = point();
            let corners = [corner, corner + point() * 0.2, corner + point() * 0.05];
            scene.add_triangle(corners.map(|c| (c * 3.0 + position) * scale), None, 0);
        }
        let about = format!("at {position}, times {scale}");
        let hits = try_scene(&scene, &mut rng, &about);
        assert!(hits > 500, "{about}: {hits}");
    }
}

/// A beam visits a node once for all its rays; otherwise it is not a beam.
#[test]
fn many_rays_share_a_visit() {
    let spec = standard::parse_spec("standard:terrain:20k").expect("a name");
    let bvh = Bvh::build(&standard::scene(spec, 0).expect("a scene"));
    let rays = picture(Vec3::new(0.0, 9.0, 20.0), Vec3::ZERO, 0.03);
    let arena = Bump::new();
    let queue = queue(&arena, &rays);
    let visits = |kernel| {
        let mut hits = vec![HitPacket::miss(); queue.packets()];
        let mut traversal = CountingTraversal::new(&bvh, kernel);
        traversal.closest(&queue, 0..queue.packets(), &mut hits);
        assert_eq!(traversal.stats().active_lanes as usize, rays.len());
        traversal.stats().node_visits
    };
    let (beams, packets) = (visits(Kernel::Beam16), visits(Kernel::Packet16));
    assert!(10 * beams < packets, "{beams} of {packets}");
}

/// NaN rays hit nothing and terminate; their neighbours' hits are unchanged.
#[test]
fn no_numbers() {
    let mut rng = Rng::new(9);
    let scene = scenes::random(&mut rng, 200, 3.0);
    let bvh = Bvh::build(&scene);
    let rays = picture(Vec3::new(0.0, 0.0, 9.0), Vec3::ZERO, 0.9);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for first in [0, 5] {
            for part in 0..3 {
                let spoil = |(k, (org, dir)): (usize, &(Vec3, Vec3))| match (k + 11 - first) % 11 {
                    0 => match part {
                        0 => (Vec3::splat(bad), *dir),
                        1 => (*org, Vec3::new(bad, dir.y, dir.z)),
                        _ => (Vec3::new(org.x, bad, org.z), Vec3::splat(bad)),
                    },
                    _ => (*org, *dir),
                };
                let rays: Segments = rays.iter().enumerate().map(spoil).collect();
                let about = format!("{bad}, from {first} on, part {part}");
                assert!(compare(&bvh, &rays, None, &about) > 100);
                compare(&bvh, &rays, Some(20.0), &about);
                compare(&bvh, &rays, Some(f32::INFINITY), &about);
            }
        }
    }
}

/// Rays without a common point, or with only an approximate one.
#[test]
fn what_is_no_beam() {
    let mut rng = Rng::new(3);
    let scene = scenes::random(&mut rng, 300, 3.0);
    let bvh = Bvh::build(&scene);
    let mut point = || {
        let mut x = || rng.unit() * 8.0 - 4.0;
        Vec3::new(x(), x(), x())
    };
    let (eye, light) = (point(), point());
    let every_way: Segments = (0..2000).map(|_| (eye, point())).collect();
    let apart: Segments = (0..2000).map(|_| (point(), point())).collect();
    let nearly: Segments = (0..2000)
        .map(|_| (point(), light + point() * 1e-4))
        .collect();
    let nearly: Segments = nearly.into_iter().map(|(p, l)| (p, l - p)).collect();
    for (rays, about) in [
        (every_way, "every way"),
        (apart, "apart"),
        (nearly, "nearly"),
    ] {
        assert!(compare(&bvh, &rays, None, about) > 100);
        assert!(compare(&bvh, &rays, Some(1.0), about) > 100);
        assert!(compare(&bvh, &rays, Some(f32::INFINITY), about) > 100);
    }
}
