//! Facts about the build for records of the program, and of the benchmarks, whose build script this
//! is, too: compiler, profile, revision. For static builds also a library that their C library has
//! no file for.

use std::env;
use std::path::Path;
use std::process::Command;

/// Sources that the program is built from. A change to anything else does not change the program.
const SOURCES: [&str; 5] = ["src", "build.rs", "Cargo.toml", "Cargo.lock", ".cargo"];

fn main() {
    for source in SOURCES
        .into_iter()
        .filter(|source| Path::new(source).exists())
    {
        println!("cargo::rerun-if-changed={source}");
    }
    link_without_libdl();
    // For a custom profile, this is the profile that it inherits from.
    tell("PROFILE", &env::var("PROFILE").unwrap_or_default());
    if let Some(version) =
        env::var_os("RUSTC").and_then(|rustc| said(Command::new(rustc).arg("--version")))
    {
        tell("RUSTC", &version);
    }
    // Only the package's own repository counts, not one that the package may have been unpacked in.
    if Path::new(".git").exists() {
        from_git();
    } else if let Ok(info) = std::fs::read_to_string(".cargo_vcs_info.json") {
        from_package(&info);
    }
}

/// Makes an empty `libdl`: `libloading` asks for one. With musl its functions are in the C library
/// itself, and Rust's copy of that comes without the empty archive that C compilers have.
fn link_without_libdl() {
    let musl = env::var("CARGO_CFG_TARGET_ENV").is_ok_and(|env| env == "musl");
    let Some(folder) = env::var_os("OUT_DIR").filter(|_| musl) else {
        return;
    };
    let folder = Path::new(&folder);
    match std::fs::write(folder.join("libdl.a"), "!<arch>\n") {
        Ok(()) => println!("cargo::rustc-link-search=native={}", folder.display()),
        Err(error) => println!("cargo::warning=no libdl.a for musl: {error}"),
    }
}

fn tell(name: &str, value: &str) {
    println!("cargo::rustc-env=PHALANX_{name}={value}");
}

/// Output of a command, or `None` where it fails or does not exist.
fn said(command: &mut Command) -> Option<String> {
    let output = command
        .output()
        .ok()
        .filter(|output| output.status.success())?;
    let text = String::from_utf8(output.stdout).ok()?;
    Some(text.trim().to_owned())
}

fn git(arguments: &[&str]) -> Option<String> {
    let mut command = Command::new("git");
    // A hook sets these variables for the repository that it runs in. The query must not lock the
    // index.
    for name in ["GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE"] {
        command.env_remove(name);
    }
    said(command.arg("--no-optional-locks").args(arguments))
}

fn from_git() {
    let Some(revision) = git(&["rev-parse", "HEAD"]) else {
        return;
    };
    tell("GIT_REVISION", &revision);
    let changes = ["status", "--porcelain", "--untracked-files=normal", "--"];
    if let Some(changes) = git(&[&changes[..], &SOURCES].concat()) {
        tell("GIT_DIRTY", &(!changes.is_empty()).to_string());
    }
    // HEAD, the branch that it names, and the file that the branch may be packed into. A file that
    // does not exist would make Cargo run this every time.
    let branch = git(&["symbolic-ref", "--quiet", "HEAD"]);
    for name in ["HEAD", "logs/HEAD", "packed-refs"]
        .into_iter()
        .chain(branch.as_deref())
    {
        if let Some(path) = git(&["rev-parse", "--git-path", name])
            && Path::new(&path).exists()
        {
            println!("cargo::rerun-if-changed={path}");
        }
    }
}

/// The revision that `cargo package` put into the package. Two fields of a format that does not
/// change are not worth a JSON reader for every build.
fn from_package(info: &str) {
    let mut words = info.split('"').skip_while(|word| *word != "sha1").skip(2);
    if let Some(revision) = words.next() {
        tell("GIT_REVISION", revision);
        let dirty = info.contains("\"dirty\": true");
        tell("GIT_DIRTY", &dirty.to_string());
    }
}
