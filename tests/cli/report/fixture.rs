//! Records like those of a real run: a full suite, a single row, and unusual ones.

use phalanx::image::{Picture, png_bytes};
use phalanx::report::html::ScenePictures;
use phalanx::report::*;
use std::collections::BTreeMap;

pub const FAMILIES: [&str; 18] = [
    "balls", "gears", "jacks", "lattice", "mount", "rings", "shells", "sombrero", "teapot",
    "tetra", "tree", "cornell", "terrain", "menger", "street", "hair", "room", "atrium",
];
const STEPS: [(&str, u64); 3] = [("small", 2_000), ("medium", 60_000), ("large", 1_500_000)];

/// Kind, and the rate of `auto` on an average scene.
const KINDS: [(&str, f64); 7] = [
    ("primary", 28.0),
    ("shadow", 24.0),
    ("reflection", 9.0),
    ("refraction", 8.0),
    ("diffuse", 4.2),
    ("ao", 7.5),
    ("frame", 6.0),
];

/// Engine, kernel, its rate against `auto` for coherent and for scattered rays, and whether it is
/// exact.
const MODES: [(&str, &str, [f64; 2], bool); 12] = [
    ("phalanx", "auto", [1.0, 1.0], true),
    ("phalanx", "packet8", [0.72, 0.95], true),
    ("phalanx", "packet16", [1.0, 1.0], true),
    ("phalanx", "beam", [1.08, 0.4], true),
    ("oracle", "scalar", [0.055, 0.16], true),
    ("embree", "single", [0.4, 1.35], true),
    ("embree", "packet8 coherent", [0.86, 0.8], true),
    ("embree", "packet16 coherent", [1.04, 0.82], false),
    ("embree", "packet8 incoherent", [0.7, 0.77], true),
    ("embree", "packet16 incoherent", [0.93, 0.8], true),
    ("obvhs", "bvh2", [0.2, 0.6], true),
    ("obvhs", "cwbvh", [0.31, 0.8], true),
];

/// Numbers that look measured, but are reproducible.
struct Noise(u64);

impl Noise {
    /// A number from −1 to 1.
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 33) as f64 / f64::from(1u32 << 30) - 1.0
    }
}

/// A full suite: 17 families in three sizes, two thread counts, two peers.
pub fn suite() -> BenchRecord {
    let mut noise = Noise(4);
    let mut record = BenchRecord {
        scenes: Vec::new(),
        rows: Vec::new(),
        counters: Vec::new(),
        ..minimal()
    };
    for (f, family) in FAMILIES.iter().enumerate() {
        // Some families are several times as expensive as others.
        let ease = 0.35 * 1.13_f64.powi((f * 7 % 17) as i32);
        for (step, primitives) in STEPS {
            let primitives = primitives + (f as u64 * 977) % (primitives / 3);
            let name = format!("standard:{family}:{step}");
            let scene = scene_record(&name, Some((family, step)), primitives);
            let rate = ease * (2000.0 / primitives as f64).powf(0.16 + 0.03 * noise.next());
            for (k, (kind, usual)) in KINDS.iter().enumerate() {
                add_rows(
                    &mut record,
                    (&name, kind),
                    (usual * rate, k > 1),
                    &mut noise,
                );
                record
                    .counters
                    .push(counter_row(&name, kind, primitives, k > 1, &mut noise));
            }
            record.scenes.push(scene);
        }
    }
    record.machine = machine();
    record.run.peers = vec!["embree 4.4.0".to_owned(), "obvhs 0.4.0".to_owned()];
    record.program.git_dirty = Some(true);
    record
}

/// All modes on one and two threads.
fn add_rows(
    record: &mut BenchRecord,
    (scene, kind): (&str, &str),
    (auto, scattered): (f64, bool),
    noise: &mut Noise,
) {
    for threads in [1, 2] {
        for (engine, kernel, shares, exact) in MODES {
            if kind == "frame" && !["phalanx", "oracle"].contains(&engine) {
                continue;
            }
            let share = shares[usize::from(scattered)]
                * (1.0 + 0.25 * noise.next() * f64::from(kernel != "auto"));
            let scaled = if threads == 2 { 1.86 + 0.1 * noise.next() } else { 1.0 };
            let mut row = row(
                (scene, kind),
                (engine, kernel),
                threads,
                auto * share * scaled,
                noise,
            );
            row.exact = exact || noise.next() > 0.0;
            let peer = ["embree", "obvhs"].contains(&engine);
            row.difference = peer.then_some(if row.exact { 0.000_002 } else { 0.003_7 });
            row.same_as = (kernel == "auto").then(|| "packet16".to_owned());
            record.rows.push(row);
        }
    }
}

fn row(
    (scene, kind): (&str, &str),
    (engine, kernel): (&str, &str),
    threads: u32,
    median: f64,
    noise: &mut Noise,
) -> RateRow {
    let spread = median * (0.012 + 0.01 * noise.next().abs());
    RateRow {
        scene: scene.to_owned(),
        rays: kind.to_owned(),
        engine: engine.to_owned(),
        kernel: kernel.to_owned(),
        threads,
        mrays_per_s: Estimate {
            median,
            mad: 0.5 * spread,
            low: median - spread,
            high: median + spread,
        },
        rays_timed: 1_048_576,
        hits: 734_003,
        difference: None,
        exact: true,
        same_as: None,
        samples: (0..7).map(|_| median + spread * noise.next()).collect(),
    }
}

fn scene_record(name: &str, family: Option<(&str, &str)>, primitives: u64) -> SceneRecord {
    let parts = [
        ("triangles", primitives - primitives / 5),
        ("spheres", primitives / 5),
    ];
    let set = RaySetRecord {
        rays: 1_048_576,
        hits: 734_003,
        checksum: "9f3c21aa".to_owned(),
    };
    SceneRecord {
        name: name.to_owned(),
        family: family.map(|f| f.0.to_owned()),
        step: family.map(|f| f.1.to_owned()),
        hash: "0badf00d".to_owned(),
        origin: None,
        primitives: parts.map(|(kind, count)| (kind.to_owned(), count)).into(),
        primitive_count: primitives,
        size: [1024, 1024],
        load_seconds: primitives as f64 * 2.1e-7,
        build_seconds: [("phalanx", 1.1e-6), ("embree", 6e-7)]
            .map(|(engine, each)| (engine.to_owned(), each * primitives as f64))
            .into(),
        tree_bytes: primitives * 93,
        rays: KINDS.map(|(kind, _)| (kind.to_owned(), set.clone())).into(),
    }
}

fn counter_row(
    scene: &str,
    kind: &str,
    primitives: u64,
    scattered: bool,
    noise: &mut Noise,
) -> CounterRow {
    let rays = 1_048_576;
    let packets = rays / 8;
    let depth =
        (primitives as f64).log2() * if scattered { 4.0 } else { 1.8 } * (1.0 + 0.3 * noise.next());
    let visits = (packets as f64 * depth) as u64;
    let blocks = (visits as f64 * (0.5 + 0.45 * noise.next())) as u64;
    CounterRow {
        scene: scene.to_owned(),
        rays: kind.to_owned(),
        kernel: "packet16".to_owned(),
        ray_count: rays,
        work: CountedWork {
            packets,
            active_lanes: rays,
            node_visits: visits,
            box_tests: visits * 16,
            leaf_visits: visits / 6,
            prim_tests: blocks * 8,
            bytes: visits * 64 + blocks * (48 + if scattered { 64 } else { 0 }),
        },
    }
}

fn machine() -> Machine {
    let cache = |level, kind: &str, bytes, shared_by| Cache {
        level,
        kind: kind.to_owned(),
        bytes,
        shared_by,
    };
    Machine {
        cpu: "AMD EPYC 9B45 96-Core Processor".to_owned(),
        cores: Some(2),
        threads: 2,
        smt: Some(false),
        caches: vec![
            cache(1, "data", 48 << 10, 1),
            cache(1, "instruction", 32 << 10, 1),
            cache(2, "unified", 1 << 20, 1),
            cache(3, "unified", 32 << 20, 2),
        ],
        governor: Some("powersave".to_owned()),
        hypervisor: Some("KVM".to_owned()),
        memory_bytes: Some(16 << 30),
        kernel: Some("Linux 6.1.0".to_owned()),
    }
}

/// One scene, one row, and no optional fields.
pub fn minimal() -> BenchRecord {
    let mut noise = Noise(1);
    BenchRecord {
        schema_version: SCHEMA_VERSION,
        program: Program {
            version: "0.1.0".to_owned(),
            git_revision: Some("9cca50f".to_owned()),
            git_dirty: Some(false),
            rustc: Some("rustc 1.95.0".to_owned()),
            profile: "release".to_owned(),
            isa_compiled: "x86-64-v4".to_owned(),
            isa_available: "x86-64-v4".to_owned(),
        },
        machine: Machine {
            cpu: "A CPU".to_owned(),
            threads: 1,
            ..Machine::default()
        },
        run: RunInfo {
            started: "2026-11-21T17:30:04.272635803Z".to_owned(),
            arguments: vec![
                "bench".to_owned(),
                "--html".to_owned(),
                "report.html".to_owned(),
            ],
            seconds: 712.0,
            partial: false,
            size: [1024, 1024],
            repeat: 7,
            spp: 1,
            min_time: 0.5,
            pinned: true,
            quality: "best".to_owned(),
            peers: Vec::new(),
        },
        scenes: vec![scene_record("one.test", None, 12)],
        rows: vec![row(
            ("one.test", "primary"),
            ("phalanx", "auto"),
            1,
            12.5,
            &mut noise,
        )],
        counters: Vec::new(),
    }
}

/// One family in three sizes: fewer scenes than kinds of rays.
pub fn few() -> BenchRecord {
    let mut record = suite();
    let is_kept = |scene: &str| scene.starts_with("standard:terrain:");
    record.scenes.retain(|s| is_kept(&s.name));
    record.rows.retain(|r| is_kept(&r.scene));
    record.counters.retain(|c| is_kept(&c.scene));
    record
}

/// A shorter suite, then the same on two other machines, one of them twice as fast at some rays.
pub fn machines() -> Vec<(&'static str, BenchRecord)> {
    let mut first = suite();
    let is_kept = |scene: &str| !scene.ends_with("medium") && scene < "standard:mount";
    first.scenes.retain(|s| is_kept(&s.name));
    first.rows.retain(|r| is_kept(&r.scene));
    let scaled = |cpu: &str, share: &dyn Fn(&RateRow) -> f64| {
        let mut record = first.clone();
        record.machine.cpu = cpu.to_owned();
        record.run.started = "2026-11-23T08:00:00Z".to_owned();
        for row in &mut record.rows {
            let share = share(row);
            let rate = &mut row.mrays_per_s;
            for figure in [&mut rate.median, &mut rate.low, &mut rate.high] {
                *figure *= share;
            }
        }
        record
    };
    let faster = |row: &RateRow| match (&*row.engine, &*row.rays) {
        ("phalanx", "primary" | "shadow") => 2.0,
        _ => 1.01,
    };
    let second = scaled("Intel(R) Xeon(R) Platinum 8481C CPU @ 2.70GHz", &faster);
    let third = scaled("Neoverse-N1", &|_| 0.6);
    vec![
        ("perf/records/2026-11-21-epyc-2core.json", first),
        ("b.json", second),
        ("c.json", third),
    ]
}

/// The comparison of some records.
pub fn compare(records: &[(&str, &BenchRecord)]) -> RecordComparison {
    let options = ComparisonOptions {
        threshold: 0.03,
        all: false,
        any_machine: false,
    };
    RecordComparison::new(records, options)
}

/// An empty record.
pub fn empty() -> BenchRecord {
    BenchRecord {
        scenes: Vec::new(),
        rows: Vec::new(),
        ..minimal()
    }
}

/// The suite with unusual values of every kind, and names that contain markup.
pub fn odd() -> BenchRecord {
    let mut record = suite();
    let strange = [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        0.0,
        -1.0,
        1e-300,
        1e300,
    ];
    for (i, row) in record.rows.iter_mut().enumerate() {
        let pick = |k: usize| strange[(i / 3 + k * 5) % strange.len()];
        let mad = pick(1);
        row.mrays_per_s = Estimate {
            median: pick(0),
            mad,
            low: pick(2),
            high: pick(3),
        };
        row.difference = Some(pick(4));
        row.threads = [0, 1, u32::MAX][i % 3];
    }
    for (i, scene) in record.scenes.iter_mut().enumerate() {
        let pick = |k: usize| strange[(i + k) % strange.len()];
        scene.load_seconds = pick(0);
        scene.build_seconds = BTreeMap::from([("phalanx".to_owned(), pick(1))]);
        scene.primitive_count = [0, 1, u64::MAX][i % 3];
        scene.primitives = BTreeMap::from([("triangles".to_owned(), [0, u64::MAX][i % 2])]);
    }
    for counter in &mut record.counters {
        counter.ray_count = 0;
    }
    record
}

/// Pictures for every scene of a record: hills, and their cost, which is higher by the scale below.
pub fn pictures(record: &BenchRecord) -> Vec<ScenePictures> {
    let of_scene = |(i, scene): (usize, &SceneRecord)| ScenePictures {
        scene: scene.name.clone(),
        thumbnail_png: png((i as u32, 135), |v| [v, v / 2 + 60, 150 - v / 3]),
        heat_png: (i % 5 != 4)
            .then(|| png((i as u32, 155), |v| [v, v.saturating_sub(120), 255 - v])),
        heat_legend: "node visits a ray: 0 (dark) to 64 (bright)".to_owned(),
    };
    record.scenes.iter().enumerate().map(of_scene).collect()
}

fn png((seed, height): (u32, u32), color: impl Fn(u8) -> [u8; 3]) -> Vec<u8> {
    let hill = |x: u32, y: u32| {
        let wave = f64::from(x * (3 + seed % 5)) * 0.01 + f64::from(y * (2 + seed % 7)) * 0.015;
        (127.0 + 120.0 * wave.sin()) as u8
    };
    let pixels = (0..height).flat_map(|y| (0..180).map(move |x| (x, y)));
    png_bytes(&Picture {
        width: 180,
        height,
        rgb: pixels.flat_map(|(x, y)| color(hill(x, y))).collect(),
    })
}
