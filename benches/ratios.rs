//! The speed promises as ratios within one run. The compared engines run in alternation, so that
//! changes of the machine's speed affect both sides. Exits 1 if a ratio is below its floor.
//!
//! `cargo bench --bench ratios`; `-- --json` prints the record that `perf/records/` keeps.

mod common;

use bumpalo::Bump;
use common::{ObvhsPeer, SIZE, scenes};
use phalanx::bench::primary;
use phalanx::bvh::Bvh;
use phalanx::frame::{Accel, Control, Engine, Settings, render};
use phalanx::oracle::{Oracle, OracleRay, OracleSearch, TwoLevelBvh};
use phalanx::packet::{HitPacket, NO_PRIM};
use phalanx::scene::Scene;
use phalanx::trace::{Kernel, Traversal};
use std::time::Instant;

/// Number of alternating passes; the median of their ratios counts.
const PASSES: usize = 15;

/// One promised ratio: the median over the passes of `other` seconds ÷ `ours` seconds.
#[derive(serde::Serialize)]
struct RenderRatio {
    scene: String,
    what: &'static str,
    median: f64,
    floor: f64,
    /// Medians of millions of rays per second, here and in `other_mrays`.
    ours_mrays: f64,
    other_mrays: f64,
}

/// Rate of camera rays only, by one kernel.
#[derive(serde::Serialize)]
struct Rate {
    scene: String,
    kernel: &'static str,
    mrays: f64,
    hits: usize,
}

fn main() {
    let mut ratios = Vec::new();
    let mut primary = Vec::new();
    for (name, scene) in scenes() {
        primary.extend(primary_rates(&name, &scene));
        if scene.prim_count() == scene.triangles.len() {
            ratios.push(oracle_against_obvhs(&name, &scene));
        }
        let frame = |engine, threads| TimedFrame::new(&scene, engine, threads);
        let simd = frame(Engine::Simd, 1);
        ratios.push(compare(
            &name,
            "SIMD frame over oracle frame",
            3.5,
            &simd,
            &frame(Engine::Scalar, 1),
        ));
        ratios.push(compare(
            &name,
            "two threads over one",
            1.9,
            &frame(Engine::Simd, 2),
            &simd,
        ));
    }
    let json = std::env::args().any(|a| a == "--json");
    if json {
        let record = serde_json::json!({ "schema_version": 1, "size": SIZE, "passes": PASSES, "isa": phalanx::isa::compiled_level(), "machine": cpu(), "primary": primary, "ratios": ratios });
        println!("{record:#}");
    } else {
        for r in &primary {
            println!(
                "{:>10}  primary rays, {:<16} {:7.2} Mrays/s, {} hits",
                r.scene, r.kernel, r.mrays, r.hits
            );
        }
        for r in &ratios {
            println!(
                "{:>10}  {:<30} {:5.2} (floor {:.1})  {:7.2} against {:7.2} Mrays/s",
                r.scene, r.what, r.median, r.floor, r.ours_mrays, r.other_mrays
            );
        }
    }
    if ratios.iter().any(|r| r.median < r.floor) {
        std::process::exit(1);
    }
}

/// A frame of one engine, ready to be rendered repeatedly.
struct TimedFrame<'a> {
    scene: &'a Scene,
    prepared: Accel,
    settings: Settings,
}

impl<'a> TimedFrame<'a> {
    fn new(scene: &'a Scene, engine: Engine, threads: usize) -> TimedFrame<'a> {
        TimedFrame {
            scene,
            prepared: Accel::build(scene, engine),
            settings: Settings {
                width: SIZE[0],
                height: SIZE[1],
                threads,
                engine,
                ..Settings::of(scene)
            },
        }
    }

    /// Seconds and rays of one frame.
    fn run(&self) -> (f64, u64) {
        let frame = render(
            self.scene,
            &self.prepared,
            &self.settings,
            &Control::default(),
        );
        let frame = frame.expect("nobody interrupts a benchmark");
        (frame.seconds, frame.stats.rays.total())
    }
}

fn compare(
    scene: &str,
    what: &'static str,
    floor: f64,
    ours: &TimedFrame,
    other: &TimedFrame,
) -> RenderRatio {
    alternate(scene, what, floor, || ours.run(), || other.run())
}

fn alternate(
    scene: &str,
    what: &'static str,
    floor: f64,
    mut ours: impl FnMut() -> (f64, u64),
    mut other: impl FnMut() -> (f64, u64),
) -> RenderRatio {
    // One unmeasured run: caches, arenas, page tables.
    let (a, b) = (ours(), other());
    assert_eq!(a.1, b.1, "both sides trace the same rays");
    let passes: Vec<(f64, f64)> = (0..PASSES).map(|_| (ours().0, other().0)).collect();
    let rays = a.1 as f64 / 1e6;
    RenderRatio {
        scene: scene.to_string(),
        what,
        median: median(passes.iter().map(|(a, b)| b / a)),
        floor,
        ours_mrays: rays / median(passes.iter().map(|p| p.0)),
        other_mrays: rays / median(passes.iter().map(|p| p.1)),
    }
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Rates of camera rays by every kernel; their hits must agree.
fn primary_rates(name: &str, scene: &Scene) -> Vec<Rate> {
    let arena = Bump::new();
    let rays = primary(&arena, scene, SIZE).expect("a valid scene").queue;
    let bvh = Bvh::build(scene);
    let mut hits = vec![HitPacket::miss(); rays.packets()];
    let rates = Kernel::ALL.map(|(kernel_name, kernel)| {
        let mut traversal = Traversal::new(&bvh, kernel);
        let mut pass = || {
            let start = Instant::now();
            traversal.closest(&rays, 0..rays.packets(), &mut hits);
            start.elapsed().as_secs_f64()
        };
        pass();
        let seconds = median((0..PASSES).map(|_| pass()));
        let actual = hits.iter().flat_map(|h| h.prim_id.to_array());
        Rate {
            scene: name.to_string(),
            kernel: kernel_name,
            mrays: rays.len() as f64 / 1e6 / seconds,
            hits: actual.filter(|&id| id != NO_PRIM).count(),
        }
    });
    assert!(
        rates.iter().all(|r| r.hits == rates[0].hits),
        "kernels differ on {name}"
    );
    rates.into()
}

/// Model name of the first CPU, if the system reports it.
fn cpu() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find(|l| l.starts_with("model name"));
    let name = line
        .and_then(|l| l.split_once(':'))
        .map_or("unknown", |(_, name)| name.trim());
    format!(
        "{name}, {} cores",
        std::thread::available_parallelism().map_or(1, |n| n.get())
    )
}

/// Ratio of the oracle to obvhs's own `ray_traverse` on primary rays. It shows that the oracle is a
/// fair reference.
fn oracle_against_obvhs(name: &str, scene: &Scene) -> RenderRatio {
    let arena = Bump::new();
    let rays = primary(&arena, scene, SIZE).expect("a valid scene").queue;
    let (tree, peer) = (TwoLevelBvh::build(scene), ObvhsPeer::build(scene));
    let oracle = Oracle::new(scene, OracleSearch::Tree(&tree));
    let ray = |i: usize| rays.ray(i / 8, i % 8);
    let ours = || {
        timed(rays.len(), || {
            (0..rays.len())
                .filter(|&i| {
                    let (org, dir) = ray(i);
                    oracle
                        .closest(&OracleRay::new(org.into(), dir.into()))
                        .is_some()
                })
                .count()
        })
    };
    let other = || {
        timed(rays.len(), || {
            (0..rays.len())
                .filter(|&i| {
                    let (org, dir) = ray(i);
                    peer.hits(org, dir)
                })
                .count()
        })
    };
    alternate(name, "oracle over obvhs, primary rays", 0.5, ours, other)
}

/// Seconds of `count`, and its number of rays. `black_box` uses the count, so the work is done.
fn timed(rays: usize, count: impl FnOnce() -> usize) -> (f64, u64) {
    let start = Instant::now();
    std::hint::black_box(count());
    (start.elapsed().as_secs_f64(), rays as u64)
}
