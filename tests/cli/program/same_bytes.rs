//! The table of picture hashes: this build's pictures equal those of every other platform.

use super::TestFolder;
use std::io::ErrorKind;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Stdio};

/// Rows of the table: a scene, and its picture's hash on each platform.
fn rows() -> Vec<(&'static str, Vec<&'static str>)> {
    let table = include_str!("../../../docs/same-bytes.md");
    let lines = table.lines().filter_map(|line| line.strip_prefix("| "));
    let cells = lines.map(|line| line.trim_end_matches(" |").split(" | "));
    let rows = cells.map(|mut cells| (cells.next().unwrap_or_default(), cells.collect()));
    rows.collect()
}

/// The first digits of a file's hash; `None`, with the reason printed, if no program can compute
/// it.
fn hash_of(path: &Path) -> Option<String> {
    let mut program = Command::new("sha256sum");
    let output = match program.arg(path).stderr(Stdio::inherit()).output() {
        Err(error) if error.kind() == ErrorKind::NotFound => {
            eprintln!("skipped: sha256sum is not here");
            return None;
        }
        other => other.expect("sha256sum runs"),
    };
    let text = String::from_utf8(output.stdout).expect("digits");
    Some(text[..16].to_owned())
}

#[test]
fn pictures_are_those_of_every_platform() {
    let rows = rows();
    let (heads, rows) = rows.split_first().expect("a table");
    for platform in ["x86-64-v4", "aarch64", "wasm32", "wasm32-simd128"] {
        assert!(heads.1.contains(&platform), "no column for {platform}");
    }
    assert!(rows.len() > 20, "{} rows", rows.len());
    let folder = TestFolder::new();
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    symlink(scenes, folder.path().join("scenes")).unwrap();
    for (scene, hashes) in rows {
        assert_eq!(hashes.len(), heads.1.len(), "{scene}");
        assert!(hashes.iter().all(|hash| *hash == hashes[0]), "{scene}");
        folder.ok(&format!("render {scene} --size 64x48 -o picture.pfm"));
        let Some(hash) = hash_of(&folder.path().join("picture.pfm")) else {
            return;
        };
        assert_eq!(hash, hashes[0], "{scene}");
    }
}
