//! Whole traversals by kind of ray: every kernel, the oracle and obvhs on the same rays.
//!
//! `cargo bench --bench traversal`. An element is a ray. For pass or fail, see the ratios (`cargo
//! bench --bench ratios`); for more scenes, threads and peers, `phalanx bench`.

mod common;

use bumpalo::Bump;
use common::traced::{TracedScene, answer, room, same, trace};
use common::{SMALL, STANDARD, brief};
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use phalanx::Quality;
use phalanx::bench::{Answer, MAX_DIFFERING_SHARE, RayKind, RaySet};
use phalanx::peers::{BenchEngine, obvhs};
use phalanx::trace::Kernel;

fn traversal(c: &mut Criterion) {
    for name in STANDARD {
        let traced = TracedScene::new(name);
        let peer = obvhs::build(&traced.scene, Quality::Best);
        if let Err(reason) = &peer {
            println!("skipped on {name}: {reason}");
        }
        for kind in RayKind::ALL {
            let arena = Bump::new();
            let set = traced.rays(&arena, kind, SMALL);
            let expected = answer(&traced.oracle(set.rays()), &set);
            let what = format!("{name}, {}", kind.name());
            let mut group = brief(c, &what);
            group.throughput(Throughput::Elements(set.queue.len() as u64));
            for (kernel_name, kernel) in Kernel::ALL {
                let packets = traced.packets(kernel, set.rays());
                let right = |ours: &Answer| same(ours, &expected, &set);
                time(&mut group, kernel_name, &packets, &set, right);
            }
            let right = |ours: &Answer| same(ours, &expected, &set);
            time(
                &mut group,
                "oracle",
                &traced.oracle(set.rays()),
                &set,
                right,
            );
            let modes = peer.as_ref().map(|build| build(set.rays()));
            for (mode, engine) in modes.into_iter().flatten() {
                // A peer may round differently; one whose results differ more is not timed.
                let theirs = answer(&*engine, &set);
                let differs = expected.share_of_differences(&theirs, set.queue.len());
                if differs > MAX_DIFFERING_SHARE {
                    let percent = differs * 100.0;
                    println!("left out of {what}: obvhs {mode}, {percent:.3} % other answers");
                    continue;
                }
                time(&mut group, &format!("obvhs {mode}"), &*engine, &set, |_| {
                    true
                });
            }
            group.finish();
        }
    }
}

/// Times an engine whose results are `right`.
fn time(
    group: &mut BenchmarkGroup<WallTime>,
    who: &str,
    engine: &dyn BenchEngine,
    set: &RaySet,
    right: impl Fn(&Answer) -> bool,
) {
    let (mut engine_thread, mut answer) = (engine.thread(), room(set));
    trace(&mut *engine_thread, &mut answer);
    assert!(
        right(&answer),
        "{who}: another answer to {} rays",
        set.kind.name()
    );
    group.bench_function(who, |b| b.iter(|| trace(&mut *engine_thread, &mut answer)));
}

criterion_group!(benches, traversal);
criterion_main!(benches);
