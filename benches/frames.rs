//! Whole frames, including shading, by both engines.
//!
//! `cargo bench --bench frames`. An element is a ray of any kind. For pass or fail, see the ratios
//! (`cargo bench --bench ratios`).

mod common;

use common::{SMALL, STANDARD, brief, standard_scene};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use phalanx::frame::{Accel, Control, Engine, Frame, Settings, render};
use phalanx::scene::Scene;
use std::hint::black_box;

fn frames(c: &mut Criterion) {
    for name in STANDARD {
        let scene = standard_scene(name);
        let packets = Accel::build(&scene, Engine::Simd);
        let oracle = Accel::build(&scene, Engine::Scalar);
        let expected = frame(&scene, &oracle, Engine::Scalar, 1);
        let mut group = brief(c, &format!("{name}, frame"));
        group.throughput(Throughput::Elements(expected.stats.rays.total()));
        for (what, prepared, engine, threads) in [
            ("packets", &packets, Engine::Simd, 1),
            ("packets, threads: 2", &packets, Engine::Simd, 2),
            ("oracle", &oracle, Engine::Scalar, 1),
        ] {
            let run = || frame(&scene, prepared, engine, threads);
            let got = run();
            assert!(got.film == expected.film, "{name}, {what}: another picture");
            assert_eq!(got.stats.rays, expected.stats.rays, "{name}, {what}");
            group.bench_function(what, |b| b.iter(|| black_box(run())));
        }
        group.finish();
    }
}

fn frame(scene: &Scene, prepared: &Accel, engine: Engine, threads: usize) -> Frame {
    let settings = Settings {
        width: SMALL[0],
        height: SMALL[1],
        threads,
        engine,
        ..Settings::of(scene)
    };
    let frame = render(scene, prepared, &settings, &Control::default());
    frame.expect("nobody interrupts a benchmark")
}

criterion_group!(benches, frames);
criterion_main!(benches);
