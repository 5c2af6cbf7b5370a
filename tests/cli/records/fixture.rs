//! Artificial records.

use phalanx::report::*;
use std::collections::BTreeMap;

pub const KINDS: [&str; 3] = ["primary", "shadow", "diffuse"];
const ENGINES: [(&str, &str, f64); 5] = [
    ("oracle", "scalar", 4.0),
    ("phalanx", "packet8", 20.0),
    ("phalanx", "packet16", 25.0),
    ("embree", "packet8 coherent", 18.0),
    ("embree", "single", 9.0),
];

/// A record of several scenes on one and two threads, nine rounds: every rate is different and
/// drifts from round to round.
pub fn record(scenes: usize) -> BenchRecord {
    let names: Vec<String> = (0..scenes)
        .map(|i| format!("standard:scene{i}:small"))
        .collect();
    let mut record = BenchRecord {
        schema_version: SCHEMA_VERSION,
        program: program(),
        machine: machine(),
        run: run(),
        scenes: names.iter().map(|name| scene(name)).collect(),
        rows: Vec::new(),
        counters: Vec::new(),
    };
    for (i, name) in names.iter().enumerate() {
        for rays in KINDS {
            for threads in [1, 2] {
                for (engine, kernel, rate) in ENGINES {
                    let rate = rate * f64::from(threads) * (1.0 + i as f64 / 10.0);
                    record
                        .rows
                        .push(row(name, rays, (engine, kernel), threads, rate));
                }
                let auto = record
                    .rows
                    .iter()
                    .rfind(|row| row.kernel == "packet16")
                    .cloned();
                record.rows.extend(auto.map(|row| RateRow {
                    kernel: "auto".into(),
                    same_as: Some("packet16".into()),
                    ..row
                }));
            }
            record.counters.push(CounterRow {
                scene: name.clone(),
                rays: rays.into(),
                kernel: "packet8".into(),
                ray_count: 1000,
                work: CountedWork {
                    packets: 125,
                    active_lanes: 1000,
                    node_visits: 4000 + i as u64,
                    box_tests: 64_000,
                    leaf_visits: 300,
                    prim_tests: 5000,
                    bytes: 270_000,
                },
            });
        }
    }
    record
}

fn row(
    scene: &str,
    rays: &str,
    (engine, kernel): (&str, &str),
    threads: u32,
    rate: f64,
) -> RateRow {
    // Drift that affects both engines, and separate jitter of a per mille.
    let jitter = |round: usize| ((round * 7 + kernel.len() * 3) % 5) as f64 / 1000.0;
    let sample = |round: usize| rate * (1.0 + 0.003 * round as f64) * (1.0 + jitter(round));
    let samples: Vec<f64> = (0..9).map(sample).collect();
    RateRow {
        scene: scene.into(),
        rays: rays.into(),
        engine: engine.into(),
        kernel: kernel.into(),
        threads,
        mrays_per_s: estimate(&samples),
        rays_timed: 1000,
        hits: 700,
        difference: (engine == "embree").then_some(0.0),
        exact: true,
        same_as: None,
        samples,
    }
}

/// Estimate from rounds of a single piece.
pub fn estimate(samples: &[f64]) -> Estimate {
    let rounds: Vec<Vec<f64>> = samples.iter().map(|rate| vec![1.0 / rate]).collect();
    Estimate::of_fastest(&rounds, 1.0)
}

/// Multiplies the rates of selected rows.
pub fn scale(record: &mut BenchRecord, share: f64, is_scaled: impl Fn(&RateRow) -> bool) {
    for row in record.rows.iter_mut().filter(|row| is_scaled(row)) {
        row.samples.iter_mut().for_each(|sample| *sample *= share);
        row.mrays_per_s = estimate(&row.samples);
    }
}

fn program() -> Program {
    Program {
        version: "0.1.0".into(),
        git_revision: Some("0123abc".into()),
        git_dirty: Some(false),
        rustc: None,
        profile: "release".into(),
        isa_compiled: "x86-64-v4".into(),
        isa_available: "x86-64-v4".into(),
    }
}

fn machine() -> Machine {
    Machine {
        cpu: "Imaginary 9000".into(),
        cores: Some(2),
        threads: 2,
        smt: Some(false),
        caches: vec![Cache {
            level: 1,
            kind: "data".into(),
            bytes: 32 << 10,
            shared_by: 1,
        }],
        governor: None,
        hypervisor: Some("KVM".into()),
        memory_bytes: Some(8 << 30),
        kernel: Some("Linux 6.1".into()),
    }
}

fn run() -> RunInfo {
    RunInfo {
        started: "2026-11-21T12:00:00Z".into(),
        arguments: ["bench", "--against", "embree"].map(str::to_owned).to_vec(),
        seconds: 600.0,
        partial: false,
        size: [1280, 960],
        repeat: 9,
        spp: 1,
        min_time: 0.5,
        pinned: false,
        quality: "best".into(),
        peers: vec!["embree 4.4.0".into()],
    }
}

fn scene(name: &str) -> SceneRecord {
    let answer = |kind: &&str| {
        let set = RaySetRecord {
            rays: 1000,
            hits: 700,
            checksum: "0badcafe".into(),
        };
        (kind.to_string(), set)
    };
    SceneRecord {
        name: name.into(),
        family: Some("scene".into()),
        step: None,
        hash: "12345678".into(),
        origin: Some([500_000.0, 0.0, -4_012_344.0]),
        primitives: BTreeMap::from([("triangles".into(), 1000)]),
        primitive_count: 1000,
        size: [1280, 960],
        load_seconds: 0.1,
        build_seconds: BTreeMap::from([("phalanx".into(), 0.2)]),
        tree_bytes: 100_000,
        rays: KINDS.iter().map(answer).collect(),
    }
}
