//! `bin/phalanx` of a release: starts the build for the highest x86-64 level that this CPU has.
//!
//! The builds lie beside it, in `../lib/phalanx/phalanx-LEVEL`. `PHALANX_LEVEL` names another one. Compiled by `.ci/release` for plain
//! x86-64, where `is_x86_feature_detected!` asks the CPU and the system. A release for 64-bit ARM has one build and no launcher.

use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Command, ExitCode};

/// Highest first; what the psABI asks of them beyond the one below.
const LEVELS: [(&str, fn() -> bool); 4] = [
    ("x86-64-v4", has_v4),
    ("x86-64-v3", has_v3),
    ("x86-64-v2", has_v2),
    ("x86-64", || true),
];

fn has_v2() -> bool {
    is_x86_feature_detected!("cmpxchg16b")
        && is_x86_feature_detected!("popcnt")
        && is_x86_feature_detected!("sse3")
        && is_x86_feature_detected!("sse4.1")
        && is_x86_feature_detected!("sse4.2")
        && is_x86_feature_detected!("ssse3")
}

fn has_v3() -> bool {
    has_v2()
        && is_x86_feature_detected!("avx")
        && is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("f16c")
        && is_x86_feature_detected!("fma")
        && is_x86_feature_detected!("lzcnt")
        && is_x86_feature_detected!("movbe")
}

fn has_v4() -> bool {
    has_v3()
        && is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("avx512cd")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl")
}

fn main() -> ExitCode {
    match start() {
        Err(why) => {
            eprintln!("phalanx: {why}");
            ExitCode::FAILURE
        }
        Ok(never) => match never {},
    }
}

fn start() -> Result<std::convert::Infallible, String> {
    let own = std::env::current_exe().map_err(|e| format!("cannot tell where it is: {e}"))?;
    let folder = own.ancestors().nth(2).unwrap_or(&own).join("lib/phalanx");
    let build = build_in(&folder)?;
    let mut program = Command::new(&build);
    program.args(std::env::args_os().skip(1));
    // For scripts that start the program on other machines.
    program.env("PHALANX_LAUNCHER", &own);
    Err(format!(
        "cannot start {}: {}",
        build.display(),
        program.exec()
    ))
}

/// The build that `PHALANX_LEVEL` names, or the best one that this CPU runs.
fn build_in(folder: &std::path::Path) -> Result<PathBuf, String> {
    let build = |level: &str| folder.join(format!("phalanx-{level}"));
    let there = || {
        LEVELS
            .into_iter()
            .filter(|(level, _)| build(level).is_file())
    };
    let Some(level) = std::env::var_os("PHALANX_LEVEL").filter(|level| !level.is_empty()) else {
        let best = there().find(|(_, has)| has());
        let none = || {
            format!(
                "there is no build for this CPU in {}; unpack the release again",
                folder.display()
            )
        };
        return best.map(|(level, _)| build(level)).ok_or_else(none);
    };
    let requested = level.to_string_lossy();
    let entry = there().find(|(level, _)| *level == requested);
    entry.map(|(level, _)| build(level)).ok_or_else(|| {
        let names: Vec<&str> = there().map(|(level, _)| level).collect();
        format!(
            "PHALANX_LEVEL is {requested}, but there are builds for {} only",
            names.join(", ")
        )
    })
}
