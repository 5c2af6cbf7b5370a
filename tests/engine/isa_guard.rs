//! The guard of `main` on lesser CPUs, emulated by qemu-user (Debian: `apt-get install qemu-user`).
#![cfg(all(target_arch = "x86_64", target_os = "linux"))]

use std::process::{Command, Output};

/// Emulated CPUs, oldest first, with the level that the message must name, and flags for AVX, AVX2
/// and AVX-512.
const CPUS: [(&str, &str, [bool; 3]); 4] = [
    ("core2duo", "x86-64", [false; 3]),
    ("Nehalem", "x86-64-v2", [false; 3]),
    ("SandyBridge", "x86-64-v2", [true, false, false]),
    ("Haswell", "x86-64-v3", [true, true, false]),
];

/// True for each of AVX, AVX2 and AVX-512 that this build uses.
const USED: [bool; 3] = [
    cfg!(target_feature = "avx"),
    cfg!(target_feature = "avx2"),
    cfg!(target_feature = "avx512f"),
];

/// Runs the binary on an emulated CPU; `None`, with the reason printed, if there is no emulator.
fn run_on(cpu: &str, argument: &str) -> Option<Output> {
    let binary = env!("CARGO_BIN_EXE_phalanx");
    let mut command = Command::new("qemu-x86_64");
    command.args(["-cpu", cpu, binary, argument]);
    match command.output() {
        Ok(output) => Some(output),
        Err(error) => {
            eprintln!("skipped: qemu-x86_64 does not run here ({error})");
            None
        }
    }
}

/// Output of the program, without the emulator's remarks about features that it cannot emulate.
fn lines(bytes: &[u8]) -> Vec<String> {
    let text = String::from_utf8_lossy(bytes);
    let own = |line: &&str| !line.starts_with("qemu-x86_64: warning");
    text.lines().filter(own).map(str::to_owned).collect()
}

#[test]
fn a_cpu_that_lacks_what_the_build_uses_gets_one_line_and_exit_code_1() {
    if USED == [false; 3] {
        eprintln!("skipped: this build has no AVX compiled in");
        return;
    }
    for (cpu, level, has) in CPUS {
        if (0..3).all(|i| has[i] || !USED[i]) {
            continue;
        }
        let Some(output) = run_on(cpu, "--version") else {
            return;
        };
        let stderr = lines(&output.stderr);
        assert_eq!(
            output.status.code(),
            Some(1),
            "{cpu}: {:?} {stderr:?}",
            output.status
        );
        assert_eq!(stderr.len(), 1, "{cpu}: {stderr:?}");
        let advice = format!("RUSTFLAGS=\"-C target-cpu={level}\" cargo build --release");
        assert!(
            stderr[0].starts_with("phalanx: this build uses "),
            "{cpu}: {stderr:?}"
        );
        assert!(stderr[0].ends_with(&advice), "{cpu}: {stderr:?}");
        assert!(lines(&output.stdout).is_empty(), "{cpu}");
    }
}

#[test]
fn a_cpu_that_has_what_the_build_uses_runs_it() {
    if phalanx::isa::compiled_level() != "x86-64" {
        eprintln!(
            "skipped: this build is for {}",
            phalanx::isa::compiled_level()
        );
        return;
    }
    for (cpu, _, _) in CPUS {
        let Some(output) = run_on(cpu, "--version") else {
            return;
        };
        let stderr = lines(&output.stderr);
        assert!(
            output.status.success(),
            "{cpu}: {:?} {stderr:?}",
            output.status
        );
        assert_eq!(
            lines(&output.stdout),
            [format!("phalanx {} (x86-64)", env!("CARGO_PKG_VERSION"))]
        );
    }
}

/// Link-time optimisation across crates recompiles the standard library for the target CPU, and
/// then the runtime dies before `main`. The tests above cover the profile that they are built with;
/// this one checks the other.
#[test]
fn the_release_profile_leaves_the_standard_library_as_it_is() {
    let manifest = include_str!("../../Cargo.toml");
    let (_, release) = manifest
        .split_once("[profile.release]")
        .expect("a release profile");
    let release = release.split("\n[").next().unwrap_or_default();
    assert!(
        release.lines().any(|line| line.trim() == "lto = \"off\""),
        "{release}"
    );
}

/// Flags in `[build]` apply to every target, and `native` makes no sense for ARM here.
#[test]
fn builds_for_other_targets_are_not_for_this_cpu() {
    let config = include_str!("../../.cargo/config.toml");
    let mut features = Vec::new();
    let mut section = "";
    for line in config.lines() {
        if line.starts_with('[') {
            section = line;
        } else if line.starts_with("rustflags") && line.contains("native") {
            features.push(section);
        }
    }
    assert_eq!(features, ["[target.x86_64-unknown-linux-gnu]"]);
}
