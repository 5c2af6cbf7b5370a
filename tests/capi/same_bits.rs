//! Answers through C's interface: those of the library, to the last bit, from and to any rows.

use crate::full_or::full_or;
use crate::rng::Rng;
use crate::world::{NO_COLUMN, NO_HITS, NO_ROWS, TwinScenes, check, no_lists};
use phalanx::{HitBuffer, HitColumns, NO_GEOM, NO_PRIM, Ray, RayBuffer};
use phalanx_c::batch::*;
use phalanx_c::columns::PhxColumn;
use phalanx_c::hits::PhxHits;
use phalanx_c::ray::*;
use phalanx_c::rows::PhxRows;
use std::ffi::{c_int, c_void};
use std::ptr::null;

/// A structure of a caller's, with all that a batch reads and writes.
#[repr(C)]
#[derive(Clone, Copy)]
struct RayRecord {
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

/// Value that stays where nothing is to be written.
const UNTOUCHED: u32 = 0xdead_beef;

fn records(count: usize, seed: u64) -> Vec<RayRecord> {
    let mut rng = Rng::new(seed);
    let record = |_| {
        let tmax = if rng.once_in(4) { rng.range(0.0, 8.0) } else { f32::INFINITY };
        let origin = if rng.once_in(1000) { [f32::NAN; 3] } else { rng.point(9.0).into() };
        RayRecord {
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
    (0..count).map(record).collect()
}

const STRIDE: usize = size_of::<RayRecord>();

fn rays(records: &[RayRecord]) -> PhxRays {
    let first = records.as_ptr();
    // SAFETY: fields of the first structure.
    unsafe {
        PhxRays {
            size: size_of::<PhxRays>(),
            count: records.len(),
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

fn buffer(records: &[RayRecord]) -> RayBuffer {
    let ray = |p: &RayRecord| Ray {
        origin: p.origin,
        direction: p.direction,
        tmax: p.tmax,
    };
    records.iter().map(ray).collect()
}

/// In place, in structures of the caller's own.
#[test]
fn a_batch_in_place_is_the_librarys_to_the_last_bit() {
    let world = TwinScenes::new(1);
    let mut records = records(full_or(1_000_000, 100_000), 2);
    let expected = buffer(&records);
    let mut hits = HitBuffer::new(records.len());
    world
        .bvh
        .intersect_batch(&expected.columns(), &mut hits.columns(), 0)
        .unwrap();
    let (input, first) = (rays(&records), records.as_mut_ptr());
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
    for (k, (record, hit)) in records.iter().zip(hits.iter()).enumerate() {
        let miss = (f32::INFINITY, 0.0, -1.0, NO_PRIM, UNTOUCHED);
        let (t, u, v, prim, geom) = hit.map_or(miss, |h| (h.t, h.u, h.v, h.prim_id, h.geom_id));
        let floats = [t, u, v].map(f32::to_bits);
        let written = [record.t, record.weights[0], record.weights[1]].map(f32::to_bits);
        assert_eq!(written, floats, "ray {k}");
        assert_eq!((record.prim_id, record.geom_id), (prim, geom), "ray {k}");
        assert_eq!((record.before, record.blocked), (UNTOUCHED, 7), "ray {k}");
        match hit {
            None => {
                assert_eq!((record.local, record.instance), (NO_PRIM, NO_GEOM));
                assert_eq!(record.normal[0].to_bits(), UNTOUCHED);
            }
            Some(hit) => {
                let start = world.bvh.first_prim(hit.geom_id).unwrap();
                assert_eq!(record.local, hit.prim_id - start);
                assert_eq!(
                    record.instance,
                    if hit.geom_id > 1 { hit.geom_id } else { NO_GEOM }
                );
                assert!(record.normal.iter().all(|c| c.is_finite()));
            }
        }
    }
}

/// To and from arrays, which the library is given as they lie.
#[test]
fn a_batch_of_arrays_is_the_librarys_to_the_last_bit() {
    let world = TwinScenes::new(12);
    let records = records(30_000, 13);
    let expected = buffer(&records);
    let (mut hits, mut dark) = (HitBuffer::new(30_000), vec![false; 30_000]);
    (world
        .bvh
        .intersect_batch(&expected.columns(), &mut hits.columns(), 0))
    .unwrap();
    (world.bvh.occluded_batch(&expected.columns(), &mut dark, 0)).unwrap();
    let (mut numbers, mut ids) = (
        [(); 3].map(|()| vec![9.0; 30_000]),
        [(); 2].map(|()| vec![9; 30_000]),
    );
    let mut blocked = vec![9u8; 30_000];
    let plain = |data: *mut c_void, stride| PhxColumn {
        data,
        stride,
        ..NO_COLUMN
    };
    let [t, u, v] = numbers
        .each_mut()
        .map(|column: &mut Vec<f32>| plain(column.as_mut_ptr().cast(), 4));
    let [prim_id, geom_id] = ids
        .each_mut()
        .map(|column: &mut Vec<u32>| plain(column.as_mut_ptr().cast(), 4));
    let outputs = PhxHits {
        t,
        u,
        v,
        prim_id,
        geom_id,
        ..NO_HITS
    };
    let input = rays(&records);
    // SAFETY: all is this test's.
    unsafe {
        check(phx_intersect_batch(world.tree, &input, null(), &outputs));
        check(phx_occluded_batch(
            world.tree,
            &input,
            null(),
            plain(blocked.as_mut_ptr().cast(), 1),
        ));
    }
    let HitColumns {
        t,
        u,
        v,
        prim_id,
        geom_id,
    } = hits.columns();
    assert_eq!(
        numbers.map(bits),
        [t, u, v].map(|column| bits(column.to_vec()))
    );
    assert_eq!(ids, [prim_id.to_vec(), geom_id.to_vec()]);
    assert_eq!(blocked, dark.into_iter().map(u8::from).collect::<Vec<_>>());
}

fn bits(numbers: Vec<f32>) -> Vec<u32> {
    numbers.into_iter().map(f32::to_bits).collect()
}

#[test]
fn shadows_counts_and_lists_are_the_librarys() {
    let world = TwinScenes::new(3);
    let mut records = records(50_000, 4);
    let expected = buffer(&records);
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
    let (input, first) = (rays(&records), records.as_mut_ptr());
    let mut out = no_lists();
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
        assert_eq!(starts, lists.starts);
        let count = out.hit_count;
        for (c, expected) in [(out.t, &lists.t), (out.u, &lists.u), (out.v, &lists.v)] {
            assert_eq!(std::slice::from_raw_parts(c, count), expected);
        }
        for (c, expected) in [(out.prim_id, &lists.prim_id), (out.geom_id, &lists.geom_id)] {
            assert_eq!(std::slice::from_raw_parts(c, count), expected);
        }
        check(phx_hit_lists_free(&mut out));
        assert_eq!((out.hit_count, out.starts.is_null()), (0, true));
    }
    for (k, record) in records.iter().enumerate() {
        assert_eq!(
            (record.blocked == 1, record.count),
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
    let world = TwinScenes::new(5);
    let mut records = records(20_000, 6);
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
    let (input, first) = (rays(&records), records.as_mut_ptr());
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
        let outputs = PhxHits {
            t: column(&raw mut (*first).t, 0),
            prim_id: column(&raw mut (*first).prim_id, 0),
            ..NO_HITS
        };
        check(phx_intersect_batch(world.tree, &input, &batch, &outputs));
    }
    for (k, record) in records.iter().enumerate() {
        let ray = Ray {
            origin: record.origin,
            direction: record.direction,
            tmax: record.tmax,
        };
        let (mut hit, mut dark) = (MISS, 9);
        let parts = |hit: Option<phalanx::Hit>| {
            hit.map_or((f32::INFINITY.to_bits(), NO_PRIM), |h| {
                (h.t.to_bits(), h.prim_id)
            })
        };
        // SAFETY: all is this test's.
        unsafe {
            check(phx_intersect(world.tree, &ray, null(), &mut hit));
            assert_eq!(
                (hit.t.to_bits(), hit.prim_id),
                parts(world.bvh.intersect(&ray)),
                "ray {k}"
            );
            check(phx_occluded(world.tree, &ray, null(), &mut dark));
            assert_eq!(dark, c_int::from(world.bvh.occluded(&ray)));
            check(phx_intersect(world.tree, &ray, &filter, &mut hit));
            let filtered = parts(world.bvh.intersect_filtered(&ray, &same));
            assert_eq!((hit.t.to_bits(), hit.prim_id), filtered, "ray {k}");
            assert_eq!(
                (record.t.to_bits(), record.prim_id),
                filtered,
                "ray {k} of the batch"
            );
            let (mut all, mut count) = ([MISS; 3], 0);
            check(phx_all_hits(
                world.tree,
                &ray,
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
