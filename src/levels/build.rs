//! Compiles the tracer for the levels of x86-64 above the program's, each as a library that the
//! program contains. A level that cannot be compiled is a warning: rays then run on the next one.

use std::env::{var, var_os};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// Best first.
const LEVELS: [&str; 2] = ["x86-64-v4", "x86-64-v3"];

fn main() {
    let own = PathBuf::from(set("CARGO_MANIFEST_DIR"));
    let out = PathBuf::from(set("OUT_DIR"));
    println!("cargo::rerun-if-env-changed=PHALANX_LEVELS");
    for source in ["build.rs", "level.rs", "tree.rs", "../trace", "../scene"] {
        if own.join(source).exists() {
            println!("cargo::rerun-if-changed={source}");
        }
    }
    let wanted = var("PHALANX_LEVELS");
    let wanted = |level: &&str| {
        let named = |wanted: &String| wanted.split_whitespace().any(|name| name == *level);
        gains_by_levels() && wanted.as_ref().map_or(true, named)
    };
    // All at once: the tracer is one unit, which takes most of the time on one thread.
    let started = LEVELS.into_iter().filter(wanted).map(|level| {
        let folder = out.join(level);
        (level, start(level, &own, &folder), folder)
    });
    let mut rows = String::new();
    for (level, cargo, folder) in started.collect::<Vec<_>>() {
        match cargo.and_then(|cargo| finish(cargo, &folder)) {
            Ok(library) => rows += &format!("({level:?}, include_bytes!({library:?})), "),
            Err(why) => println!("cargo::warning=phalanx has no {level} in this program: {why}"),
        }
    }
    let table = format!("const LIBRARIES: &[(&str, &[u8])] = &[{rows}];\n");
    fs::write(out.join("levels.rs"), table).expect("a file in OUT_DIR");
}

fn set(name: &str) -> String {
    var(name).unwrap_or_else(|_| panic!("Cargo sets {name}"))
}

/// Returns true if the program may load libraries, and is optimized, and for plain x86-64.
fn gains_by_levels() -> bool {
    let is = |name: &str, value: &str| var(name).is_ok_and(|set| set == value);
    let features = var("CARGO_CFG_TARGET_FEATURE").unwrap_or_default();
    let has = |name| features.split(',').any(|feature| feature == name);
    is("CARGO_CFG_TARGET_ARCH", "x86_64")
        && is("CARGO_CFG_TARGET_OS", "linux")
        && is("CARGO_CFG_TARGET_ENV", "gnu")
        && !(is("OPT_LEVEL", "0") || has("avx2") || has("crt-static"))
}

/// Folder of an inner crate: in the repository, or beside this one as Cargo unpacks and vendors.
fn source_of(own: &Path, name: &str) -> Option<PathBuf> {
    let versioned = format!("../phalanx-{name}-{}", set("CARGO_PKG_VERSION"));
    let places = [
        format!("../{name}"),
        versioned,
        format!("../phalanx-{name}"),
    ];
    let mut folders = places.iter().map(|place| own.join(place));
    folders.find(|folder| folder.join("cast").exists() || folder.join("prims").exists())
}

/// Folder of the program's lock file: above its target folder, else above where Cargo was started.
fn program_of(folder: &Path) -> Option<PathBuf> {
    let started = PathBuf::from(var_os("PWD").unwrap_or_default());
    let mut above = folder.ancestors().skip(1).chain(started.ancestors());
    let program = above.find(|above| {
        let lock = fs::read_to_string(above.join("Cargo.lock"));
        lock.is_ok_and(|lock| lock.contains("\nname = \"phalanx-levels\"\n"))
    });
    program.map(Path::to_owned)
}

/// Starts Cargo for a level, offline and by the versions of the program's lock file.
fn start(level: &str, own: &Path, folder: &Path) -> Result<Child, String> {
    let [scene, trace] = ["scene", "trace"].map(|name| source_of(own, name));
    let (Some(scene), Some(trace)) = (scene, trace) else {
        return Err("the sources of the tracer are not beside it".to_owned());
    };
    let manifest = format!(
        "[package]\nname = \"phalanx-level\"\nedition = \"2024\"\n[lib]\ncrate-type = [\"cdylib\"]\npath = {:?}\n\
         [dependencies]\nphalanx-scene = {{ path = {scene:?} }}\nphalanx-trace = {{ path = {trace:?} }}\n\
         [patch.crates-io]\nphalanx-scene = {{ path = {scene:?} }}\n\
         [profile.release]\ncodegen-units = 1\npanic = \"unwind\"\nstrip = true\n[workspace]\n",
        own.join("level.rs"),
    );
    let message = |error: std::io::Error| error.to_string();
    fs::create_dir_all(folder).map_err(message)?;
    fs::write(folder.join("Cargo.toml"), manifest).map_err(message)?;
    let program = program_of(folder);
    if let Some(program) = &program {
        fs::copy(program.join("Cargo.lock"), folder.join("Cargo.lock")).map_err(message)?;
    }
    let flags = var("CARGO_ENCODED_RUSTFLAGS").unwrap_or_default();
    let flags = flags.split('\x1f').filter(|flag| !flag.is_empty());
    let cpu = format!("-Ctarget-cpu={level}");
    let flags: Vec<&str> = flags.chain([&*cpu]).collect();
    Command::new(var_os("CARGO").unwrap_or_else(|| "cargo".into()))
        // Cargo reads the settings of the folders above, such as where crates are vendored.
        .current_dir(program.as_deref().unwrap_or(folder))
        .args([
            "build",
            "--release",
            "--quiet",
            "--offline",
            "--target",
            &set("TARGET"),
        ])
        .arg("--manifest-path")
        .arg(folder.join("Cargo.toml"))
        .arg("--target-dir")
        .arg(folder.join("target"))
        .env("CARGO_ENCODED_RUSTFLAGS", flags.join("\x1f"))
        // Clippy is one, and its output is no library.
        .env_remove("RUSTC_WORKSPACE_WRAPPER")
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(message)
}

/// Waits for Cargo; returns the library, or why there is none.
fn finish(cargo: Child, folder: &Path) -> Result<PathBuf, String> {
    let output = cargo
        .wait_with_output()
        .map_err(|error| error.to_string())?;
    let target = folder.join("target").join(set("TARGET"));
    let library = target.join("release/libphalanx_level.so");
    if output.status.success() && library.exists() {
        return Ok(library);
    }
    let messages = String::from_utf8_lossy(&output.stderr);
    let mut lines = messages.lines().filter(|line| line.starts_with("error"));
    Err(lines.next().unwrap_or("Cargo failed").to_owned())
}
