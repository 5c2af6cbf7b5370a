//! The stages of a wave between its traversals, in isolation: hits grouped by material into
//! surfaces, lights sampled into queues of shadow rays, bounces queued; and the queue's compaction.
//!
//! `cargo bench --bench stages`. An element is a primary ray; for compaction, a pushed ray.

mod common;

use bumpalo::Bump;
use common::rng::Rng;
use common::{SMALL, STANDARD, brief, standard_scene};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use phalanx::bench::primary;
use phalanx::bvh::Bvh;
use phalanx::frame::{Accel, Control, DEFAULT_TILE, Engine, Settings, render};
use phalanx::lanes::{F32x8, LANES, LaneMask, Lanes, Mask8, Vec3x8};
use phalanx::packet::{HitPacket, NO_PRIM, RayQueue};
use phalanx::render::{RayCounts, microbench};
use phalanx::scene::Scene;
use phalanx::shade::{MaterialRow, ShadeLight, ShadeMaterial, Surface, bounces};
use phalanx::trace::{Kernel, Traversal};
use std::hint::black_box;
use std::ops::Range;

/// Number of packets in a wave of a tile's primary rays.
const WAVE: usize = (DEFAULT_TILE * DEFAULT_TILE) as usize / LANES;

/// Primary rays of a picture and their hits.
struct PrimaryHits<'a> {
    scene: &'a Scene,
    rays: RayQueue<'a>,
    hits: Vec<HitPacket>,
}

impl<'a> PrimaryHits<'a> {
    fn of(scene: &'a Scene, arena: &'a Bump) -> PrimaryHits<'a> {
        let rays = primary(arena, scene, SMALL).expect("a valid scene").queue;
        let mut hits = vec![HitPacket::miss(); rays.packets()];
        let bvh = Bvh::build(scene);
        let mut traversal: Traversal = Traversal::new(&bvh, Kernel::Auto);
        traversal.closest(&rays, 0..rays.packets(), &mut hits);
        PrimaryHits { scene, rays, hits }
    }

    fn waves(&self) -> impl Iterator<Item = Range<usize>> {
        let packets = self.rays.packets();
        let wave = move |first: usize| first..packets.min(first + WAVE);
        (0..packets).step_by(WAVE).map(wave)
    }

    fn group<'b>(&self, arena: &'b Bump, wave: Range<usize>) -> &'b [Surface] {
        microbench::group_queue_hits(
            arena,
            self.scene,
            &self.rays,
            wave.clone(),
            &self.hits[wave],
        )
    }
}

fn stages(c: &mut Criterion) {
    for name in STANDARD {
        let scene = standard_scene(name);
        let (ray_arena, surface_arena) = (Bump::new(), Bump::new());
        let hits = PrimaryHits::of(&scene, &ray_arena);
        let of_wave = |wave| hits.group(&surface_arena, wave);
        let surfaces: Vec<&[Surface]> = hits.waves().map(of_wave).collect();
        let ids = hits.hits.iter().flat_map(|h| h.prim_id.to_array());
        let met = ids.filter(|&id| id != NO_PRIM).count();
        let all = surfaces.iter().copied().flatten();
        let active = all.map(|points| points.active.bits().count_ones() as usize);
        assert_eq!(active.sum::<usize>(), met, "{name}: surfaces");

        let mut group = brief(c, &format!("{name}, stages"));
        group.throughput(Throughput::Elements(hits.rays.len() as u64));
        let mut arena = Bump::new();
        group.bench_function("group", |b| {
            b.iter(|| {
                for wave in hits.waves() {
                    arena.reset();
                    black_box(hits.group(&arena, wave));
                }
            });
        });
        let room = 2 * WAVE * LANES;
        let queue_arena = Bump::new();
        let mut queue = RayQueue::with_capacity(&queue_arena, room);
        let mut lights = || -> u64 {
            surfaces
                .iter()
                .map(|s| shadow_rays(&scene, s, &mut queue))
                .sum()
        };
        assert_eq!(lights(), counts(&scene, 0).shadow, "{name}: shadow rays");
        group.bench_function("lights", |b| b.iter(&mut lights));
        let mut queue = RayQueue::with_capacity(&queue_arena, room);
        let mut bounced = || -> u64 {
            surfaces
                .iter()
                .map(|s| bounced_rays(&scene, s, &mut queue))
                .sum()
        };
        let RayCounts {
            reflection,
            refraction,
            ..
        } = counts(&scene, 1);
        assert_eq!(bounced(), reflection + refraction, "{name}: bounces");
        group.bench_function("bounces", |b| b.iter(&mut bounced));
        group.finish();
    }
}

/// Queues the shadow rays of a wave, light by light, and returns their number.
fn shadow_rays(scene: &Scene, surfaces: &[Surface], queue: &mut RayQueue) -> u64 {
    let mut rays = 0;
    for light in 0..scene.lights.len() {
        queue.clear();
        let light = ShadeLight::of(scene, light);
        let position = light.sample_position([0; LANES], 0);
        for point in surfaces {
            let row = &MaterialRow::of(scene, point.material);
            let material = ShadeMaterial { row, varied: None };
            let s = light.sample(position, &material, point, None);
            queue.push(s.needed, s.org, s.dir, s.radiance, &point.ray);
        }
        rays += black_box(&*queue).len() as u64;
    }
    rays
}

/// Queues the mirror and refracted rays of a wave, and returns their number.
fn bounced_rays(scene: &Scene, surfaces: &[Surface], queue: &mut RayQueue) -> u64 {
    queue.clear();
    for point in surfaces {
        let row = &MaterialRow::of(scene, point.material);
        let material = ShadeMaterial { row, varied: None };
        let out = bounces(&material, point);
        for out in [out.mirror, out.refracted] {
            queue.push(out.active, out.org, out.dir, out.weight, &point.ray);
        }
    }
    black_box(&*queue).len() as u64
}

/// The rays traced by a render with this depth.
fn counts(scene: &Scene, max_depth: u32) -> RayCounts {
    let prepared = Accel::build(scene, Engine::Simd);
    let settings = Settings {
        width: SMALL[0],
        height: SMALL[1],
        max_depth,
        ..Settings::of(scene)
    };
    let frame = render(scene, &prepared, &settings, &Control::default());
    frame.expect("nobody interrupts a benchmark").stats.rays
}

/// Benchmarks the push of packets with all, most or few of their lanes into a queue.
fn compaction(c: &mut Criterion) {
    let mut rng = Rng::new(11);
    let arena = Bump::new();
    let mut group = brief(c, "compaction");
    for (what, of_eight) in [("all lanes", 8), ("most lanes", 6), ("few lanes", 1)] {
        let mut wanted = |lane: usize| u32::from(rng.below(8) < of_eight) << lane;
        let mut mask = || Mask8::from_bits((0..LANES).fold(0, |bits, lane| bits | wanted(lane)));
        let masks: Vec<Mask8> = (0..WAVE).map(|_| mask()).collect();
        let mut queue = RayQueue::with_capacity(&arena, WAVE * LANES);
        let rays = compact(&mut queue, &masks);
        let lanes = |(packet, mask): (usize, &Mask8)| -> Vec<usize> {
            mask.lanes().map(|lane| packet * LANES + lane).collect()
        };
        let want: Vec<usize> = masks.iter().enumerate().flat_map(lanes).collect();
        let parent = |i: usize| queue.payload(i / LANES).1[i % LANES] as usize;
        assert!((0..rays).map(parent).eq(want.iter().copied()), "{what}");
        let x = |i: usize| queue.ray(i / LANES, i % LANES).0[0] as usize;
        assert!(
            (0..rays).map(x).eq(want.iter().map(|k| k % LANES)),
            "{what}"
        );
        group.throughput(Throughput::Elements(rays as u64));
        group.bench_function(what, |b| b.iter(|| compact(&mut queue, &masks)));
    }
    group.finish();
}

/// Queues the lanes of a wave that are set in `masks`. Their parents are their indices, and their
/// first coordinates their lanes.
fn compact(queue: &mut RayQueue, masks: &[Mask8]) -> usize {
    let x = F32x8::new(std::array::from_fn(|lane| lane as f32));
    let org = Vec3x8::new(x, F32x8::ZERO, F32x8::ONE);
    queue.clear();
    for (packet, &mask) in masks.iter().enumerate() {
        let parent = std::array::from_fn(|lane| (packet * LANES + lane) as u32);
        queue.push(mask, org, org, org, &parent);
    }
    black_box(&*queue).len()
}

criterion_group!(benches, stages, compaction);
criterion_main!(benches);
