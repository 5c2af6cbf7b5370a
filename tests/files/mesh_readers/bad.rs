//! Bad meshes and what is said about them: `tests/files/bad_meshes/x.obj` (or another ending) and
//! beside it `x.obj.expected`.
//!
//! After a change of wording, `PHALANX_BLESS=1 cargo test --test files mesh_readers::bad::` writes
//! what is said now: read the difference before committing it.

use phalanx::formats::{Diagnostic, LoadError, Loaded, Options, load};
use std::fmt::Write;
use std::path::Path;

fn listing(kind: &str, diagnostics: &[Diagnostic]) -> String {
    let mut out = String::new();
    for d in diagnostics {
        writeln!(out, "{}:{}: {kind}{}", d.line, d.column, d.message).unwrap();
        if let Some(help) = &d.help {
            writeln!(out, "    help: {help}").unwrap();
        }
    }
    out
}

fn said_about(path: &Path) -> String {
    match load(path, &Options::default()) {
        Ok(Loaded { warnings, .. }) => listing("warning: ", &warnings),
        Err(LoadError::Scene {
            diagnostics, text, ..
        }) => {
            for d in diagnostics.iter().filter(|d| d.line > 0) {
                let end = d.offset + d.length;
                assert!(text.get(d.offset..end).is_some(), "{path:?}: {d:?}");
            }
            listing("", &diagnostics)
        }
        Err(other) => format!("{other}\n"),
    }
}

#[test]
fn every_bad_file_gets_its_message() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files/bad_meshes");
    let mut failures = String::new();
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let ending = path.extension().and_then(|e| e.to_str());
        if !ending.is_some_and(|e| ["obj", "ply", "stl"].contains(&e)) {
            continue;
        }
        count += 1;
        let said = said_about(&path);
        let expected_path = format!("{}.expected", path.display());
        if std::env::var_os("PHALANX_BLESS").is_some() {
            std::fs::write(&expected_path, &said).unwrap();
        }
        let expected = std::fs::read_to_string(&expected_path).unwrap_or_default();
        if said != expected.replace("\r\n", "\n") {
            let name = path.file_name().unwrap();
            writeln!(failures, "{name:?}\n-- expected\n{expected}-- said\n{said}").unwrap();
        }
    }
    assert!(count > 20, "only {count} bad files found");
    assert!(failures.is_empty(), "{failures}");
}
