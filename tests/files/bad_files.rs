//! Folders of bad files, and of awkward ones, which are read: each has a file of expected messages
//! next to it.
//!
//! After a change of wording, `PHALANX_BLESS=1 cargo test --test files bad_files::` writes the
//! current messages: review the difference before committing it.

use crate::folders::folder;
use phalanx::formats::{Diagnostic, LoadError, Loaded, Options, load};
use std::fmt::Write;
use std::path::{Path, PathBuf};

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

/// Listing of the warnings or errors about a file. Spans are within the text; in `binary` formats a
/// diagnostic may have no line, and then no span.
fn messages_about(path: &Path, binary: bool) -> String {
    match load(path, &Options::default()) {
        Ok(Loaded { warnings, .. }) => listing("warning: ", &warnings),
        Err(LoadError::Scene {
            diagnostics, text, ..
        }) => {
            for d in diagnostics.iter().filter(|d| !binary || d.line > 0) {
                let end = d.offset + d.length;
                assert!(text.get(d.offset..end).is_some(), "{path:?}: {d:?}");
            }
            listing("", &diagnostics)
        }
        Err(other) => format!("{other}\n"),
    }
}

/// Compares the messages about each file with these extensions with the file named by `expected`,
/// which `PHALANX_BLESS` rewrites. There must be more than `least` files.
fn assert_messages(files: &str, endings: &[&str], expected: fn(&Path) -> PathBuf, least: usize) {
    let mut failures = String::new();
    let mut count = 0;
    for entry in std::fs::read_dir(folder(files)).unwrap() {
        let path = entry.unwrap().path();
        let ending = path.extension().and_then(|e| e.to_str());
        let Some(ending) = ending.filter(|e| endings.contains(e)) else {
            continue;
        };
        count += 1;
        let message = messages_about(&path, !["test", "nff"].contains(&ending));
        let expected_path = expected(&path);
        if std::env::var_os("PHALANX_BLESS").is_some() {
            std::fs::write(&expected_path, &message).unwrap();
        }
        let expected = std::fs::read_to_string(&expected_path).unwrap_or_default();
        if message.is_empty() || message != expected.replace("\r\n", "\n") {
            let name = path.file_name().unwrap();
            writeln!(
                failures,
                "{name:?}\n-- expected\n{expected}-- told\n{message}"
            )
            .unwrap();
        }
    }
    assert!(count > least, "only {count} bad files found");
    assert!(failures.is_empty(), "{failures}");
}

#[test]
fn every_bad_file_gets_its_message() {
    let replaced = |path: &Path| path.with_extension("expected");
    let appended = |path: &Path| PathBuf::from(format!("{}.expected", path.display()));
    assert_messages("tests/files/bad", &["test"], replaced, 40);
    assert_messages("tests/files/bad/nff", &["nff"], replaced, 30);
    let meshes = ["obj", "ply", "stl"];
    assert_messages("tests/files/bad_meshes", &meshes, appended, 20);
    assert_messages("tests/files/awkward", &meshes, appended, 3);
}
