//! Answers through C's interface: those of the library, to the last bit, from and to any rows.

use crate::full_or::full_or;
use crate::rng::Rng;
use crate::world::{World, check};
use phalanx::{HitBuffer, NO_GEOM, NO_PRIM, Ray, RayBuffer};
use phalanx_c::batch::*;
use phalanx_c::ray::*;
use phalanx_c::rows::{PhxColumn, PhxRows};
use std::ffi::{c_int, c_void};
use std::ptr::{null, null_mut};

/// A structure of a caller's, with all that a batch reads and writes.
#[repr(C)]
#[derive(Clone, Copy)]
struct Probe {
    origin: [f32; 3],
    tmax: f32,
    direction: [f32; 3],
    before: u32,
    t: f32,
    weights: [f32; 2],
    prim_id: u32,
    geom_id: u32,
    local: u32,
    instance: u32,
    normal: [f32; 3],
    blocked: u8,
    count: u32,
}

/// What stays where nothing is to be written.
const UNTOUCHED: u32 = 0xdead_beef;

fn probes(count: usize, seed: u64) -> Vec<Probe> {
    let mut rng = Rng::new(seed);
    let probe = |_| {
        let tmax = if rng.once_in(4) { rng.range(0.0, 8.0) } else { f32::INFINITY };
        let origin = if rng.once_in(1000) { [f32::NAN; 3] } else { rng.point(9.0).into() };
        Probe {
            origin,
            tmax,
            direction: rng.direction().into(),
            before: UNTOUCHED,
            t: f32::from_bits(UNTOUCHED),
            weights: [f32::from_bits(UNTOUCHED); 2],
            prim_id: UNTOUCHED,
            geom_id: UNTOUCHED,
            local: UNTOUCHED,
            instance: UNTOUCHED,
            normal: [f32::from_bits(UNTOUCHED); 3],
            blocked: 7,
            count: UNTOUCHED,
        }
    };
    (0..count).map(probe).collect()
}

const NO_ROWS: PhxRows = PhxRows {
    data: null(),
    stride: 0,
};
const STRIDE: usize = size_of::<Probe>();

fn rays(probes: &[Probe]) -> PhxRays {
    let first = probes.as_ptr();
    // SAFETY: fields of the first structure.
    unsafe {
        PhxRays {
            size: size_of::<PhxRays>(),
            count: probes.len(),
            origin: PhxRows {
                data: (&raw const (*first).origin).cast(),
                stride: STRIDE,
            },
            direction: PhxRows {
                data: (&raw const (*first).direction).cast(),
                stride: STRIDE,
            },
            tmax: PhxRows {
                data: (&raw const (*first).tmax).cast(),
                stride: STRIDE,
            },
        }
    }
}

fn column<T>(field: *mut T, miss: i32) -> PhxColumn {
    PhxColumn {
        data: field.cast(),
        stride: STRIDE,
        miss,
        reserved: 0,
    }
}

fn buffer(probes: &[Probe]) -> RayBuffer {
    let ray = |p: &Probe| Ray {
        origin: p.origin,
        direction: p.direction,
        tmax: p.tmax,
    };
    probes.iter().map(ray).collect()
}

/// In place, in structures of the caller's own.
#[test]
fn a_batch_in_place_is_the_librarys_to_the_last_bit() {
    let world = World::new(1);
    let mut probes = probes(full_or(10_000_000, 200_000), 2);
    let expected = buffer(&probes);
    let mut hits = HitBuffer::new(probes.len());
    world
        .bvh
        .intersect_batch(&expected.columns(), &mut hits.columns(), 0)
        .unwrap();
    let (input, first) = (rays(&probes), probes.as_mut_ptr());
    // SAFETY: fields of the structures, which are this test's.
    unsafe {
        let outputs = PhxHits {
            size: size_of::<PhxHits>(),
            t: column(&raw mut (*first).t, 0),
            u: column(&raw mut (*first).weights, 0),
            v: column((&raw mut (*first).weights[1]).cast::<f32>(), 2),
            prim_id: column(&raw mut (*first).prim_id, 0),
            geom_id: column(&raw mut (*first).geom_id, 1),
            local_prim_id: column(&raw mut (*first).local, 0),
            inst_id: column(&raw mut (*first).instance, 0),
            normal: column(&raw mut (*first).normal, 1),
            scene: world.scene,
        };
        check(phx_intersect_batch(world.tree, &input, null(), &outputs));
    }
    for (k, (probe, hit)) in probes.iter().zip(hits.iter()).enumerate() {
        let miss = (f32::INFINITY, 0.0, -1.0, NO_PRIM, UNTOUCHED);
        let (t, u, v, prim, geom) = hit.map_or(miss, |h| (h.t, h.u, h.v, h.prim_id, h.geom_id));
        let floats = [t, u, v].map(f32::to_bits);
        let written = [probe.t, probe.weights[0], probe.weights[1]].map(f32::to_bits);
        assert_eq!(written, floats, "ray {k}");
        assert_eq!((probe.prim_id, probe.geom_id), (prim, geom), "ray {k}");
        assert_eq!((probe.before, probe.blocked), (UNTOUCHED, 7), "ray {k}");
        match hit {
            None => {
                assert_eq!((probe.local, probe.instance), (NO_PRIM, NO_GEOM));
                assert_eq!(probe.normal[0].to_bits(), UNTOUCHED);
            }
            Some(hit) => {
                let start = world.bvh.first_prim(hit.geom_id).unwrap();
                assert_eq!(probe.local, hit.prim_id - start);
                assert_eq!(
                    probe.instance,
                    if hit.geom_id > 1 { hit.geom_id } else { NO_GEOM }
                );
                assert!(probe.normal.iter().all(|c| c.is_finite()));
            }
        }
    }
}

#[test]
fn shadows_counts_and_lists_are_the_librarys() {
    let world = World::new(3);
    let mut probes = probes(50_000, 4);
    let expected = buffer(&probes);
    let (mut dark, mut counts) = (vec![false; 50_000], vec![0; 50_000]);
    world
        .bvh
        .occluded_batch(&expected.columns(), &mut dark, 1)
        .unwrap();
    world
        .bvh
        .count_batch(&expected.columns(), &mut counts, 1)
        .unwrap();
    let lists = world.bvh.all_hits_batch(&expected.columns(), 1).unwrap();
    let (input, first) = (rays(&probes), probes.as_mut_ptr());
    let mut out = PhxHitLists {
        size: size_of::<PhxHitLists>(),
        ray_count: 0,
        hit_count: 0,
        starts: null(),
        hits: null(),
        memory: null_mut(),
    };
    // SAFETY: as above; lists are the library's until they are freed.
    unsafe {
        check(phx_occluded_batch(
            world.tree,
            &input,
            null(),
            column(&raw mut (*first).blocked, 0),
        ));
        check(phx_count_batch(
            world.tree,
            &input,
            null(),
            column(&raw mut (*first).count, 0),
        ));
        check(phx_all_hits_batch(world.tree, &input, null(), &mut out));
        let starts = std::slice::from_raw_parts(out.starts, out.ray_count + 1);
        let hits = std::slice::from_raw_parts(out.hits, out.hit_count);
        assert_eq!(starts, lists.starts);
        let of_hits: Vec<[u32; 3]> = hits
            .iter()
            .map(|h| [h.t.to_bits(), h.prim_id, h.geom_id])
            .collect();
        let rows =
            (0..lists.t.len()).map(|k| [lists.t[k].to_bits(), lists.prim_id[k], lists.geom_id[k]]);
        assert_eq!(of_hits, rows.collect::<Vec<_>>());
        check(phx_hit_lists_free(&mut out));
        assert_eq!((out.hit_count, out.starts.is_null()), (0, true));
    }
    for (k, probe) in probes.iter().enumerate() {
        assert_eq!(
            (probe.blocked == 1, probe.count),
            (dark[k], counts[k]),
            "ray {k}"
        );
    }
}

extern "C" fn is_odd(user: *mut c_void, _: usize, hit: *const PhxHit) -> c_int {
    // SAFETY: a hit of the library's, and the number that the test has passed.
    let (hit, divisor) = unsafe { ((*hit), *user.cast::<u32>()) };
    c_int::from(hit.prim_id % divisor == 1)
}

/// Single rays, without and with a filter, and a batch with the same filter.
#[test]
fn single_rays_and_filters_are_the_librarys() {
    let world = World::new(5);
    let mut probes = probes(20_000, 6);
    let mut divisor = 2u32;
    let user = (&raw mut divisor).cast::<c_void>();
    let filter = PhxFilter {
        size: size_of::<PhxFilter>(),
        tnear: 0.5,
        mask: u32::MAX,
        ignore: 77,
        reserved: 0,
        accept: Some(is_odd),
        user,
    };
    let accept = |hit: &phalanx::Hit| hit.prim_id % 2 == 1;
    let same = phalanx::RayFilter {
        tnear: 0.5,
        mask: u32::MAX,
        ignore: 77,
        accept: &accept,
    };
    let (input, first) = (rays(&probes), probes.as_mut_ptr());
    let (tnear, ignore) = (0.5f32, 77u32);
    // SAFETY: all is this test's.
    unsafe {
        let batch = PhxBatch {
            size: size_of::<PhxBatch>(),
            tnear: PhxRows {
                data: (&raw const tnear).cast(),
                stride: 0,
            },
            mask: NO_ROWS,
            ignore: PhxRows {
                data: (&raw const ignore).cast(),
                stride: 0,
            },
            accept: Some(is_odd),
            user,
            threads: 2,
            reserved: 0,
        };
        let none = PhxColumn {
            data: null_mut(),
            stride: 0,
            miss: 0,
            reserved: 0,
        };
        let outputs = PhxHits {
            size: size_of::<PhxHits>(),
            t: column(&raw mut (*first).t, 0),
            prim_id: column(&raw mut (*first).prim_id, 0),
            u: none,
            v: none,
            geom_id: none,
            local_prim_id: none,
            inst_id: none,
            normal: none,
            scene: null(),
        };
        check(phx_intersect_batch(world.tree, &input, &batch, &outputs));
    }
    for (k, probe) in probes.iter().enumerate() {
        let ray = Ray {
            origin: probe.origin,
            direction: probe.direction,
            tmax: probe.tmax,
        };
        let given = PhxRay {
            origin: ray.origin,
            tmax: ray.tmax,
            direction: ray.direction,
        };
        let (mut hit, mut dark) = (MISS, 9);
        let parts = |hit: Option<phalanx::Hit>| {
            hit.map_or((f32::INFINITY.to_bits(), NO_PRIM), |h| {
                (h.t.to_bits(), h.prim_id)
            })
        };
        // SAFETY: all is this test's.
        unsafe {
            check(phx_intersect(world.tree, &given, null(), &mut hit));
            assert_eq!(
                (hit.t.to_bits(), hit.prim_id),
                parts(world.bvh.intersect(&ray)),
                "ray {k}"
            );
            check(phx_occluded(world.tree, &given, null(), &mut dark));
            assert_eq!(dark, c_int::from(world.bvh.occluded(&ray)));
            check(phx_intersect(world.tree, &given, &filter, &mut hit));
            let filtered = parts(world.bvh.intersect_filtered(&ray, &same));
            assert_eq!((hit.t.to_bits(), hit.prim_id), filtered, "ray {k}");
            assert_eq!(
                (probe.t.to_bits(), probe.prim_id),
                filtered,
                "ray {k} of the batch"
            );
            let (mut all, mut count) = ([MISS; 3], 0);
            check(phx_all_hits(
                world.tree,
                &given,
                &filter,
                all.as_mut_ptr(),
                3,
                &mut count,
            ));
            let lists = world.bvh.all_hits_filtered(&ray, &same);
            assert_eq!(count, lists.len());
            for (hit, expected) in all.iter().zip(&lists) {
                assert_eq!((hit.t.to_bits(), hit.prim_id), parts(Some(*expected)));
            }
        }
    }
}
