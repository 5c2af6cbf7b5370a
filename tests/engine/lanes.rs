//! The packet tracer, lane by lane, against the oracle, ray by ray: the same bits, whatever is in
//! the other lanes.

use crate::common::rays::{hit_bits, lane_bits, pack};
use crate::common::rng::Rng;
use crate::common::scenes;
use glam::Vec3;
use phalanx::bvh::Bvh;
use phalanx::lanes::{F32x8, F32x16, LANES, LaneMask, Lanes, Mask8, Mask16, Vec3Lanes};
use phalanx::oracle::{Oracle, OracleRay, OracleSearch, TwoLevelBvh};
use phalanx::packet::RayPacket;
use phalanx::sampling;
use phalanx::scene::Scene;
use phalanx::shade;
use phalanx::trace::PacketTracer;

/// Compares each lane of a packet's hits and occlusion with the oracle.
fn compare(
    oracle: &Oracle,
    tracer: &mut PacketTracer,
    rays: &[OracleRay; LANES],
    tmax: [f32; LANES],
    on: u32,
) {
    let packet = pack(rays, |k| tmax[k]);
    let active = Mask8::from_bits(on);
    let hits = tracer.closest(&packet, active);
    let blocked = tracer.occluded(&packet, active).bits();
    compare_pair(tracer.bvh(), rays, tmax, on);
    for lane in 0..LANES {
        let (ray, tmax) = (&rays[lane], tmax[lane]);
        let alive = on >> lane & 1 == 1;
        let want = oracle.closest(ray).filter(|hit| alive && hit.t < tmax);
        assert_eq!(
            lane_bits(&hits, lane),
            want.as_ref().map(hit_bits),
            "lane {lane} of {on:08b}, tmax {tmax:e}, {ray:?}\nof {rays:?}"
        );
        if want.is_none() {
            let [t, u, v] = [hits.t, hits.u, hits.v].map(|c| c.to_array()[lane].to_bits());
            assert_eq!((t, u, v), (tmax.to_bits(), 0, 0), "a miss in lane {lane}");
        }
        let want = alive && oracle.occluded(ray, tmax);
        assert_eq!(
            blocked >> lane & 1 == 1,
            want,
            "occlusion of lane {lane} of {on:08b}, tmax {tmax:e}, {ray:?}\nof {rays:?}"
        );
    }
}

/// Two packets side by side, mirror images of each other, against each alone.
fn compare_pair(bvh: &Bvh, rays: &[OracleRay; LANES], tmax: [f32; LANES], on: u32) {
    let mut mirrored = *rays;
    mirrored.reverse();
    let halves = [
        pack(rays, |k| tmax[k]),
        pack(&mirrored, |k| tmax[LANES - 1 - k]),
    ];
    let both =
        |column: fn(&RayPacket) -> F32x8| F32x16::from_octets(|k| column(&halves[k]).to_array());
    let pair = RayPacket {
        org: Vec3Lanes::new(both(|r| r.org.x), both(|r| r.org.y), both(|r| r.org.z)),
        dir: Vec3Lanes::new(both(|r| r.dir.x), both(|r| r.dir.y), both(|r| r.dir.z)),
        tmax: both(|r| r.tmax),
    };
    let mirrored_on = (on as u8).reverse_bits() as u32;
    let active = Mask16::from_bits(on | mirrored_on << LANES);
    let mut sixteen = PacketTracer::<F32x16>::new(bvh);
    let hits = sixteen.closest(&pair, active);
    let blocked = sixteen.occluded(&pair, active).bits();
    for (k, (half, on)) in halves.iter().zip([on, mirrored_on]).enumerate() {
        let mut eight = PacketTracer::new(bvh);
        let alone = eight.closest(half, Mask8::from_bits(on));
        for lane in 0..LANES {
            assert_eq!(
                lane_bits(&hits.octet(k), lane),
                lane_bits(&alone, lane),
                "half {k}, {rays:?}"
            );
        }
        let alone = eight.occluded(half, Mask8::from_bits(on)).bits();
        assert_eq!(
            blocked >> (k * LANES) & 0xff,
            alone,
            "half {k} of {on:08b}, {rays:?}"
        );
    }
}

/// Runs `each` over scenes of different size and scale.
fn over_scenes(seed: u64, mut each: impl FnMut(&Scene, &Oracle, &mut PacketTracer, &mut Rng, f32)) {
    let mut rng = Rng::new(seed);
    for (count, scale) in [(1, 1.0), (5, 1e-3), (60, 1.0), (300, 100.0), (60, 1e6)] {
        let scene = scenes::random(&mut rng, count, scale);
        let (tree, bvh) = (TwoLevelBvh::build(&scene), Bvh::build(&scene));
        let oracle = Oracle::new(&scene, OracleSearch::Tree(&tree));
        let mut tracer = PacketTracer::new(&bvh);
        each(&scene, &oracle, &mut tracer, &mut rng, scale);
    }
}

const FAR: [f32; LANES] = [f32::INFINITY; LANES];

#[test]
fn coherent_packets() {
    over_scenes(1, |scene, oracle, tracer, rng, scale| {
        for _ in 0..2000 {
            let eye = rng.point(3.0 * scale);
            let position = scenes::point_on(scene, rng);
            let spread = scale * rng.magnitude(-5.0, -1.0);
            let rays = [0; LANES].map(|_| OracleRay::new(eye, position + rng.point(spread) - eye));
            compare(oracle, tracer, &rays, FAR, 0xff);
        }
    });
}

#[test]
fn incoherent_packets() {
    over_scenes(2, |scene, oracle, tracer, rng, scale| {
        for _ in 0..2000 {
            let rays = [0; LANES].map(|_| {
                let org = rng.point(2.0 * scale);
                let dir = if rng.once_in(3) {
                    rng.direction() * rng.magnitude(-3.0, 3.0)
                } else {
                    scenes::point_on(scene, rng) - org
                };
                OracleRay::new(org, dir)
            });
            compare(oracle, tracer, &rays, FAR, 0xff);
        }
    });
}

#[test]
fn mixed_signs_and_dominant_axes() {
    over_scenes(3, |scene, oracle, tracer, rng, scale| {
        for _ in 0..1000 {
            let base = rng.direction();
            let rays = std::array::from_fn(|k| {
                let signs = Vec3::new(
                    1.0 - 2.0 * (k & 1) as f32,
                    1.0 - 2.0 * (k >> 1 & 1) as f32,
                    1.0 - 2.0 * (k >> 2 & 1) as f32,
                );
                let turned = match k % 3 {
                    0 => base,
                    1 => Vec3::new(base.y, base.z, base.x),
                    _ => Vec3::new(base.z, base.x, base.y),
                };
                let dir = turned * signs;
                let back = rng.range(0.0, 2.0) * scale;
                OracleRay::new(scenes::point_on(scene, rng) - dir * back, dir)
            });
            compare(oracle, tracer, &rays, FAR, 0xff);
        }
    });
}

#[test]
fn every_subset_of_lanes() {
    over_scenes(4, |scene, oracle, tracer, rng, scale| {
        for _ in 0..4 {
            let agree = rng.direction();
            let rays = std::array::from_fn(|k| {
                let org = rng.point(2.0 * scale);
                // Half of the lanes would agree in sign and axis, were it not for the others.
                let dir = if k % 2 == 0 {
                    agree + rng.point(0.01)
                } else {
                    scenes::point_on(scene, rng) - org
                };
                OracleRay::new(org, dir)
            });
            for on in 0..=0xff {
                compare(oracle, tracer, &rays, FAR, on);
            }
        }
    });
}

#[test]
fn distance_limits() {
    over_scenes(5, |scene, oracle, tracer, rng, scale| {
        for _ in 0..500 {
            let rays = [0; LANES].map(|_| {
                let org = rng.point(2.0 * scale);
                OracleRay::new(org, scenes::point_on(scene, rng) - org)
            });
            let tmax = std::array::from_fn(|k| {
                let t = oracle.closest(&rays[k]).map_or(1.0, |hit| hit.t);
                match rng.below(8) {
                    // The hit itself is the limit: not below it, so it does not count.
                    0 => t,
                    1 => t.next_up(),
                    2 => t.next_down(),
                    3 => 0.0,
                    4 => -1.0,
                    5 => f32::NAN,
                    6 => t * rng.range(0.0, 2.0),
                    _ => f32::MAX,
                }
            });
            compare(oracle, tracer, &rays, tmax, (rng.bits() & 0xff) as u32);
        }
    });
}

/// Numbers that arithmetic treats specially, and some that overflow or vanish in products.
const ODD: [f32; 16] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    0.0,
    -0.0,
    1e-45,
    -1e-40,
    f32::MIN_POSITIVE,
    f32::MAX,
    -f32::MAX,
    1e30,
    -1e-30,
    1e-20,
    1.0,
    -1.0,
    0.5,
];

/// Replaces some components by special values.
fn spoil(rng: &mut Rng, v: Vec3) -> Vec3 {
    Vec3::from_array(
        v.to_array()
            .map(|c| if rng.once_in(3) { rng.pick(&ODD) } else { c }),
    )
}

#[test]
fn rays_that_are_not_numbers() {
    over_scenes(6, |scene, oracle, tracer, rng, scale| {
        for _ in 0..4000 {
            let rays = [0; LANES].map(|_| {
                let org = rng.point(2.0 * scale);
                let dir = scenes::point_on(scene, rng) - org;
                match rng.below(5) {
                    0 => OracleRay::new(spoil(rng, org), dir),
                    1 => OracleRay::new(org, spoil(rng, dir)),
                    2 => OracleRay::new(org, Vec3::ZERO),
                    3 => OracleRay::new(spoil(rng, org), spoil(rng, dir)),
                    _ => OracleRay::new(org, dir),
                }
            });
            let on = if rng.once_in(2) { 0xff } else { (rng.bits() & 0xff) as u32 };
            compare(oracle, tracer, &rays, FAR, on);
        }
    });
}

/// Values in inactive lanes, even garbage, do not affect the active ones.
#[test]
fn inactive_lanes_do_not_matter() {
    over_scenes(7, |scene, _, tracer, rng, scale| {
        for _ in 0..500 {
            let on = (rng.bits() & 0xff) as u32;
            let active = Mask8::from_bits(on);
            let rays = [0; LANES].map(|_| {
                let org = rng.point(2.0 * scale);
                OracleRay::new(org, scenes::point_on(scene, rng) - org)
            });
            let ask = |tracer: &mut PacketTracer, packet: &RayPacket| {
                let hits = tracer.closest(packet, active);
                let blocked = tracer.occluded(packet, active).bits();
                let lanes: Vec<_> = (0..LANES)
                    .filter(|k| on >> k & 1 == 1)
                    .map(|k| lane_bits(&hits, k))
                    .collect();
                (lanes, blocked)
            };
            let before = ask(tracer, &pack(&rays, |_| f32::INFINITY));
            let other = std::array::from_fn::<_, LANES, _>(|k| {
                if on >> k & 1 == 1 {
                    rays[k]
                } else {
                    let (org, dir) = (rng.point(scale), rng.direction());
                    OracleRay::new(spoil(rng, org), spoil(rng, dir))
                }
            });
            let packet = pack(&other, |k| {
                if on >> k & 1 == 1 { f32::INFINITY } else { ODD[k % ODD.len()] }
            });
            assert_eq!(ask(tracer, &packet), before, "{on:08b} of {rays:?}");
        }
    });
}

fn compare_pow(x: [f32; LANES], s: f32) {
    let wide = shade::pow(F32x8::new(x), F32x8::splat(s)).to_array();
    for (x, wide) in x.into_iter().zip(wide) {
        let scalar = sampling::pow(x, s);
        assert_eq!(wide.to_bits(), scalar.to_bits(), "pow({x:e}, {s:e})");
    }
}

#[test]
fn powers() {
    let corners = [
        0.0,
        -0.0,
        1e-45,
        f32::MIN_POSITIVE,
        f32::MIN_POSITIVE.next_down(),
        f32::from_bits(sampling::SQRT_HALF_BITS),
        f32::from_bits(sampling::SQRT_HALF_BITS - 1),
        0.5,
        1.0f32.next_down(),
        1.0,
        1.0f32.next_up(),
        2.0,
        f32::INFINITY,
        -1.0,
        f32::NAN,
        1e-30,
    ];
    let exponents = [
        0.0,
        1e-45,
        1e-20,
        0.5,
        1.0,
        20.0,
        126.5,
        1000.0,
        1e5,
        1e30,
        f32::MAX,
    ];
    for s in exponents {
        for pair in corners.chunks(LANES) {
            compare_pow(std::array::from_fn(|k| pair[k]), s);
        }
    }
    let mut rng = Rng::new(8);
    for _ in 0..200_000 {
        let x = [0; LANES].map(|_| match rng.below(3) {
            0 => rng.unit(),
            1 => 1.0 - rng.magnitude(-8.0, 0.0),
            _ => f32::from_bits((rng.bits() as u32) % 0x3f80_0001),
        });
        let s = rng.magnitude(-3.0, 6.0);
        compare_pow(x, s);
    }
}
