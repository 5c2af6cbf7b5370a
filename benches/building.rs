//! Building trees: the packet engine's by quality and threads, and the oracle's.
//!
//! `cargo bench --bench building`. An element is a primitive.

mod common;

use bumpalo::Bump;
use common::{SMALL, STANDARD, brief, standard_scene};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use phalanx::bench::primary;
use phalanx::bvh::{BuildSettings, Bvh, Quality};
use phalanx::oracle::TwoLevelBvh;
use phalanx::packet::{HitPacket, NO_PRIM};
use phalanx::scene::Scene;
use phalanx::trace::{Kernel, Traversal};
use std::hint::black_box;

fn building(c: &mut Criterion) {
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    let mut thread_counts = vec![1, threads];
    thread_counts.dedup();
    for name in STANDARD {
        let scene = standard_scene(name);
        let want = seen(&scene, &Bvh::build(&scene));
        let mut group = brief(c, &format!("{name}, building"));
        group.throughput(Throughput::Elements(scene.prim_count() as u64));
        for (quality_name, quality) in Quality::ALL {
            for &threads in &thread_counts {
                let settings = BuildSettings { quality, threads };
                let got = seen(&scene, &Bvh::build_with(&scene, &settings));
                assert!(got == want, "{name}, {quality_name}: other hits");
                let what = format!("{quality_name}, threads: {threads}");
                group.bench_function(what, |b| {
                    b.iter(|| black_box(Bvh::build_with(&scene, &settings)));
                });
            }
        }
        group.bench_function("oracle", |b| {
            b.iter(|| black_box(TwoLevelBvh::build(&scene)))
        });
        group.finish();
    }
}

/// Primitives hit by the camera rays through a tree, which must be the same for any tree.
fn seen(scene: &Scene, bvh: &Bvh) -> Vec<u32> {
    let arena = Bump::new();
    let rays = primary(&arena, scene, SMALL).expect("a valid scene").queue;
    let mut hits = vec![HitPacket::miss(); rays.packets()];
    let mut traversal: Traversal = Traversal::new(bvh, Kernel::Auto);
    traversal.closest(&rays, 0..rays.packets(), &mut hits);
    let ids: Vec<u32> = hits.iter().flat_map(|h| h.prim_id.to_array()).collect();
    assert!(ids.iter().any(|&id| id != NO_PRIM), "nothing is seen");
    ids
}

criterion_group!(benches, building);
criterion_main!(benches);
