//! Rates of the engines on the same rays, with criterion's statistics.
//!
//! `cargo bench --bench engines`. For pass or fail see the ratios (`cargo bench --bench ratios`).

mod common;

use bumpalo::Bump;
use common::{Peer, SIZE, primary_rays, scenes};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use phalanx::bvh::Bvh;
use phalanx::frame::{Control, Engine, Prepared, Settings, render};
use phalanx::oracle::{Forest, Oracle, Ray, Search};
use phalanx::packet::{HitPacket, NO_PRIM};
use phalanx::trace::{Kernel, Traversal};
use std::hint::black_box;

fn primary(c: &mut Criterion) {
    for (name, scene) in scenes() {
        let arena = Bump::new();
        let rays = primary_rays(&arena, &scene);
        let mut group = c.benchmark_group(format!("primary/{name}"));
        group
            .sample_size(10)
            .throughput(Throughput::Elements(rays.len() as u64));
        let (bvh, tree) = (Bvh::build(&scene), Forest::build(&scene));
        let mut hits = vec![HitPacket::miss(); rays.packets()];
        for (kernel_name, kernel) in Kernel::ALL {
            group.bench_function(kernel_name, |b| {
                let mut traversal = Traversal::new(&bvh, kernel);
                b.iter(|| {
                    traversal.closest(&rays, 0..rays.packets(), &mut hits);
                    black_box(&hits);
                });
            });
        }
        let oracle = Oracle::new(&scene, Search::Tree(&tree), 0);
        group.bench_function("oracle", |b| {
            b.iter(|| {
                for i in 0..rays.len() {
                    let (org, dir) = rays.ray(i / 8, i % 8);
                    black_box(oracle.closest(&Ray::new(org.into(), dir.into())));
                }
            });
        });
        if scene.prim_count() == scene.triangles.len() {
            // A rate counts only for the same answer.
            let ours = hits
                .iter()
                .flat_map(|h| h.prim_id.to_array())
                .filter(|&id| id != NO_PRIM);
            let peer = Peer::build(&scene);
            let theirs = (0..rays.len()).filter(|i| {
                let (org, dir) = rays.ray(i / 8, i % 8);
                peer.hits(org, dir)
            });
            assert_eq!(ours.count(), theirs.count(), "hits of {name}");
            group.bench_function("obvhs", |b| {
                b.iter(|| {
                    for i in 0..rays.len() {
                        let (org, dir) = rays.ray(i / 8, i % 8);
                        black_box(peer.hits(org, dir));
                    }
                });
            });
        }
        group.finish();
    }
}

fn frames(c: &mut Criterion) {
    for (name, scene) in scenes() {
        let mut group = c.benchmark_group(format!("frame/{name}"));
        group.sample_size(10);
        for (engine_name, engine, threads) in [
            ("simd", Engine::Simd, 1),
            ("simd, 2 threads", Engine::Simd, 2),
            ("scalar", Engine::Scalar, 1),
        ] {
            let prepared = Prepared::build(&scene, engine);
            let settings = Settings {
                width: SIZE.0,
                height: SIZE.1,
                threads,
                engine,
                ..Settings::of(&scene)
            };
            group.bench_function(engine_name, |b| {
                b.iter(|| black_box(render(&scene, &prepared, &settings, &Control::default())));
            });
        }
        group.finish();
    }
}

criterion_group!(engines, primary, frames);
criterion_main!(engines);
