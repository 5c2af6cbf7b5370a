//! Isolated tests, by the packet engine at both widths and by the oracle: boxes, triangles,
//! spheres, ellipsoids and cones; closest hit and any hit; coherent rays and incoherent ones.
//!
//! `cargo bench --bench kernels`. An element is a ray, tested against [`TARGETS`] boxes or
//! primitives.

mod common;

use common::brief;
use common::microbench::{Order, RAYS, TARGETS, Test, trials};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

fn kernels(c: &mut Criterion) {
    for (test_name, test) in Test::ALL {
        for (order_name, order) in Order::ALL {
            let mut trials = trials(test, order);
            let answers = trials.each_mut().map(|(_, trial)| {
                trial.run();
                trial.answer()
            });
            let what = format!("{test_name} x{TARGETS}, {order_name}");
            // A rate counts only for the same result, and only if some rays hit.
            assert!(answers[0].met() > RAYS / 20, "{what}: {}", answers[0].met());
            assert!(answers.iter().all(|a| *a == answers[0]), "{what}");
            let mut group = brief(c, &what);
            group.throughput(Throughput::Elements(RAYS as u64));
            for (engine, trial) in &mut trials {
                group.bench_function(*engine, |b| b.iter(|| trial.run()));
            }
            group.finish();
        }
    }
}

criterion_group!(benches, kernels);
criterion_main!(benches);
