//! Instruction counts of the kernels, compared with `perf/instructions.json`. Unlike times, they
//! are reproducible, so a slowdown of a few percent is detected on any machine.
//!
//! ```sh
//! RUSTFLAGS="-C target-cpu=x86-64-v3" CARGO_TARGET_DIR=target/v3 cargo bench --bench instructions
//! ```
//!
//! The program runs itself under valgrind's callgrind, one workload per run, and counts only within
//! one function. `-- --bless` writes a new baseline. Exits 0 if every count is within [`TOLERANCE`]
//! or below, or no statement is possible (no valgrind, another compiler); 1 if a count is above or
//! has no baseline; 2 if this build is not suitable for counting.
//!
//! Nothing else may affect the counts. A workload is prepared before counting begins, and allocates
//! nothing afterwards. It runs on one thread, without environment, and valgrind always assigns the
//! same addresses. Its scene and tree come from a file: valgrind does not know every instruction of
//! the level, so the less code runs under it, the better.

mod common;

use bumpalo::Bump;
use common::microbench::{EngineTest, Order, Test, eight, one_by_one};
use common::traced::{TracedScene, answer, room, trace};
use phalanx::bench::{RayKind, RaySet};
use phalanx::cache;
use phalanx::isa::compiled_level;
use phalanx::peers::BenchEngine;
use phalanx::trace::Kernel;
use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// Share by which a count may exceed its baseline. The same sources and compiler give the same
/// count to the instruction. The tolerance allows for another system's linker and C library, and
/// for the effects of changes elsewhere in the crate on the compiler's choices. Slowdowns worth
/// investigating are larger.
const TOLERANCE: f64 = 0.01;

/// Instruction-set level of the counts: valgrind does not support AVX-512.
const LEVEL: &str = "x86-64-v3";

/// Option that runs the program as the counted one, with the name of the workload and the folder of
/// the scenes.
const WORKLOAD: &str = "--workload";

/// Committed counts.
#[derive(serde::Serialize, serde::Deserialize)]
struct CommittedCounts {
    schema_version: u32,
    /// `rustc --version` of the compiler that built the program.
    rustc: String,
    /// Instruction-set level, [`LEVEL`].
    level: String,
    /// Instructions by workload.
    instructions: BTreeMap<String, u64>,
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().collect();
    if let Some(offset) = arguments.iter().position(|a| a == WORKLOAD) {
        let argument = |i: usize| arguments.get(offset + i).map_or("", |text| text);
        return counted_run(argument(1), Path::new(argument(2)));
    }
    let bless = arguments.iter().any(|a| a == "--bless");
    if let Some(reason) = not_countable() {
        eprintln!("instruction counts: {reason}; count with");
        eprintln!("  {}", command(bless));
        return ExitCode::from(2);
    }
    let Some(valgrind) = valgrind() else {
        println!("skipped: instruction counts: no valgrind in the PATH");
        return ExitCode::SUCCESS;
    };
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    for scene in SCENES {
        write_scene(scene, folder.path());
    }
    let counts: BTreeMap<String, u64> = CountedWorkload::all()
        .into_iter()
        .map(|w| (w.name(), w.count(&valgrind, folder.path())))
        .collect();
    let now = CommittedCounts {
        schema_version: 1,
        rustc: env!("PHALANX_RUSTC").to_owned(),
        level: LEVEL.into(),
        instructions: counts,
    };
    if bless {
        let text = serde_json::to_string_pretty(&now).expect("plain numbers");
        std::fs::write(baseline_path(), text + "\n").expect("a place for the baseline");
        println!(
            "{} counts written to {}",
            now.instructions.len(),
            baseline_path().display()
        );
        return ExitCode::SUCCESS;
    }
    match std::fs::read_to_string(baseline_path()) {
        Ok(text) => compare(&serde_json::from_str(&text).expect("a baseline"), &now),
        Err(error) => {
            eprintln!("{}: {error}", baseline_path().display());
            eprintln!("a new baseline: {}", command(true));
            ExitCode::FAILURE
        }
    }
}

fn baseline_path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../perf/instructions.json")
}

/// Reason why counts of this build would be meaningless, if any.
fn not_countable() -> Option<String> {
    if compiled_level() != LEVEL {
        return Some(format!(
            "this is a build for {}, not {LEVEL}",
            compiled_level()
        ));
    }
    // Every CPU of the level has this feature, but the level does not include it. So this build is
    // for target-cpu=native, tuned for the host.
    if cfg!(target_feature = "pclmulqdq") {
        return Some(format!(
            "this is a build for one CPU and not for {LEVEL} at large"
        ));
    }
    let profile = |name: &str| {
        name.starts_with("CARGO_PROFILE_RELEASE_") || name.starts_with("CARGO_PROFILE_BENCH_")
    };
    let harmless = |name: &str| name.ends_with("_DEBUG");
    let set = std::env::vars().find_map(|(name, value)| {
        let changes =
            profile(&name) && !harmless(&name) || name == "CARGO_INCREMENTAL" && value != "0";
        changes.then_some(name)
    });
    set.map(|name| format!("{name} is set, so this is not the profile of Cargo.toml: unset it"))
}

fn command(bless: bool) -> String {
    let bless = if bless { " -- --bless" } else { "" };
    format!(
        "RUSTFLAGS=\"-C target-cpu={LEVEL}\" CARGO_TARGET_DIR=target/v3 cargo bench --bench instructions{bless}"
    )
}

/// Path of valgrind, found here because valgrind runs without an environment, and so without a
/// PATH.
fn valgrind() -> Option<PathBuf> {
    let folders = std::env::var_os("PATH")?;
    std::env::split_paths(&folders)
        .map(|folder| folder.join("valgrind"))
        .find(|file| file.is_file())
}

/// A fixed amount of work.
#[derive(Clone, Copy)]
enum CountedWorkload {
    /// One microbenchmark, by the packet engine or the oracle.
    Alone {
        engine: &'static str,
        trial: fn(Test, Order) -> Box<dyn EngineTest>,
        test: (&'static str, Test),
        order: (&'static str, Order),
    },
    /// The rays of a picture of 64×64 through a whole tree.
    Tree { scene: &'static str, kind: RayKind },
}

/// Small scenes: one of spheres over a floor, one of triangles only.
const SCENES: [&str; 2] = ["standard:balls:2", "standard:terrain:4k"];

/// Closest hits of coherent rays and of incoherent ones, and any hit.
const KINDS: [RayKind; 3] = [RayKind::Primary, RayKind::Diffuse, RayKind::Shadow];

impl CountedWorkload {
    fn all() -> Vec<CountedWorkload> {
        let mut all = Vec::new();
        for test in Test::ALL {
            for order in Order::ALL {
                let (engine, trial) = ("8 lanes", eight as fn(Test, Order) -> Box<dyn EngineTest>);
                all.push(CountedWorkload::Alone {
                    engine,
                    trial,
                    test,
                    order,
                });
            }
            // With one ray at a time, the order does not matter.
            let (engine, trial) = (
                "oracle",
                one_by_one as fn(Test, Order) -> Box<dyn EngineTest>,
            );
            all.push(CountedWorkload::Alone {
                engine,
                trial,
                test,
                order: Order::ALL[1],
            });
        }
        for scene in SCENES {
            for kind in KINDS {
                all.push(CountedWorkload::Tree { scene, kind });
            }
        }
        all
    }

    fn name(&self) -> String {
        match self {
            CountedWorkload::Alone {
                engine,
                test,
                order,
                ..
            } => {
                format!("{}, {}, {engine}", test.0, order.0)
            }
            CountedWorkload::Tree { scene, kind } => format!("{scene}, {}, 8 lanes", kind.name()),
        }
    }

    /// Does the work and returns a checksum of the result.
    fn run(&self, scenes: &Path) -> u64 {
        match *self {
            CountedWorkload::Alone {
                trial, test, order, ..
            } => {
                let mut trial = trial(test.1, order.1);
                counted_work(&mut || trial.run());
                trial.answer().checksum()
            }
            CountedWorkload::Tree { scene, kind } => TreeWorkload::open(scenes, scene, kind).run(),
        }
    }

    /// The checksum of the right result, from the oracle.
    fn expected(&self, scenes: &Path) -> u64 {
        match *self {
            CountedWorkload::Alone { test, order, .. } => {
                let mut oracle = one_by_one(test.1, order.1);
                oracle.run();
                oracle.answer().checksum()
            }
            CountedWorkload::Tree { scene, kind } => {
                TreeWorkload::open(scenes, scene, kind).expected()
            }
        }
    }

    /// Instructions of the work, counted after the result was found correct.
    fn count(&self, valgrind: &Path, scenes: &Path) -> u64 {
        let name = self.name();
        let expected = self.expected(scenes);
        assert_eq!(
            self.run(scenes),
            expected,
            "{name}: another answer than the oracle's"
        );
        let out = scenes.join("callgrind.out");
        let output = Command::new(valgrind)
            .args([
                "--tool=callgrind",
                "--collect-atstart=no",
                "--toggle-collect=*counted_work*",
            ])
            .arg(format!("--callgrind-out-file={}", out.display()))
            .arg(std::env::current_exe().expect("a program"))
            .args([WORKLOAD, &name])
            .arg(scenes)
            .env_clear()
            .output()
            .expect("valgrind starts");
        let stderr = String::from_utf8_lossy(&output.stdout);
        let complaint = String::from_utf8_lossy(&output.stderr);
        assert!(
            output.status.success(),
            "{name} under valgrind: {complaint}"
        );
        assert_eq!(
            stderr.trim(),
            expected.to_string(),
            "{name}: another answer under valgrind"
        );
        let text = std::fs::read_to_string(out).expect("what callgrind wrote");
        total(&text).unwrap_or_else(|| panic!("{name}: no total in callgrind's file: {complaint}"))
    }
}

/// The sum in callgrind's file.
fn total(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("totals:"))?;
    line.trim().parse().ok().filter(|&count| count > 0)
}

/// The counted function: callgrind collects between its entry and its exit. No other symbol may
/// contain its name, or counting would be toggled twice.
#[inline(never)]
fn counted_work(work: &mut dyn FnMut()) {
    work();
}

/// Runs one workload as the program under valgrind, and prints its result to stdout.
fn counted_run(name: &str, scenes: &Path) -> ExitCode {
    let workload = CountedWorkload::all()
        .into_iter()
        .find(|w| w.name() == name);
    let Some(workload) = workload else {
        eprintln!("no workload is called `{name}`");
        return ExitCode::from(2);
    };
    println!("{}", workload.run(scenes));
    ExitCode::SUCCESS
}

/// The file of a standard scene and its tree.
fn scene_file(folder: &Path, scene: &str) -> PathBuf {
    folder
        .join(scene.replace(':', "-"))
        .with_extension(cache::ENDING)
}

fn write_scene(name: &str, folder: &Path) {
    let traced = TracedScene::new(name);
    let mut file = File::create(scene_file(folder, name)).expect("a folder to write to");
    cache::write(&mut file, &traced.scene, &traced.bvh).expect("room on the disk");
}

/// Rays through a whole tree.
struct TreeWorkload {
    traced: TracedScene,
    kind: RayKind,
    arena: Bump,
}

impl TreeWorkload {
    fn open(scenes: &Path, scene: &str, kind: RayKind) -> TreeWorkload {
        let cached = cache::open(&scene_file(scenes, scene)).expect("a scene written before");
        TreeWorkload {
            traced: TracedScene::with_bvh(cached.scene, cached.bvh),
            kind,
            arena: Bump::new(),
        }
    }

    fn rays(&self) -> RaySet<'_> {
        self.traced.rays(&self.arena, self.kind, [64, 64])
    }

    fn run(&self) -> u64 {
        let set = self.rays();
        let packets = self.traced.packets(Kernel::Packet8, set.rays());
        let (mut engine_thread, mut answer) = (packets.thread(), room(&set));
        counted_work(&mut || trace(&mut *engine_thread, &mut answer));
        answer.checksum(set.queue.len()).into()
    }

    fn expected(&self) -> u64 {
        let set = self.rays();
        let answer = answer(&self.traced.oracle(set.rays()), &set);
        answer.checksum(set.queue.len()).into()
    }
}

/// Prints the changes, and returns the exit code.
fn compare(old: &CommittedCounts, new: &CommittedCounts) -> ExitCode {
    let names: Vec<&String> = old
        .instructions
        .keys()
        .chain(new.instructions.keys())
        .collect();
    let names = std::collections::BTreeSet::from_iter(names);
    let (mut worse, mut better) = (0, 0);
    println!(
        "{:<44} {:>12} {:>12} {:>9}",
        "instructions", "baseline", "now", "change"
    );
    for name in names {
        let (before, now) = (old.instructions.get(name), new.instructions.get(name));
        let (Some(&before), Some(&now)) = (before, now) else {
            let which = if now.is_some() { "not in the baseline" } else { "no longer counted" };
            println!("{name:<44} {which}");
            worse += 1;
            continue;
        };
        let change = now as f64 / before as f64 - 1.0;
        let verdict = if change > TOLERANCE {
            worse += 1;
            "  more"
        } else if change < -TOLERANCE {
            better += 1;
            "  fewer"
        } else {
            ""
        };
        println!(
            "{name:<44} {before:>12} {now:>12} {:>+8.2} %{verdict}",
            change * 100.0
        );
    }
    judge(old, new, worse, better)
}

fn judge(old: &CommittedCounts, new: &CommittedCounts, worse: usize, better: usize) -> ExitCode {
    let tolerance = TOLERANCE * 100.0;
    if (&old.rustc, &old.level) != (&new.rustc, &new.level) {
        println!(
            "the baseline is of {} and this is {}: nothing can be said",
            old.rustc, new.rustc
        );
        println!("a new baseline: {}", command(true));
        return ExitCode::SUCCESS;
    }
    if worse > 0 {
        println!("{worse} above the baseline by more than {tolerance} %, or not to be compared");
        println!("where that is meant, bless it: {}", command(true));
        return ExitCode::FAILURE;
    }
    if better > 0 {
        println!(
            "{better} below the baseline by more than {tolerance} %: bless that, so that it stays so"
        );
        println!("  {}", command(true));
    } else {
        println!("all within {tolerance} % of the baseline");
    }
    ExitCode::SUCCESS
}
