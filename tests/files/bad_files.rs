//! Folders of bad files, with what is said about each in a file beside it.

use phalanx::formats::{Diagnostic, LoadError, Loaded, Options, load};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A folder of the repository.
pub fn folder(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

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

/// Listing of the warnings or errors about a file. Places of a diagnostic lie in the text; in
/// `binary` formats one may have no line, and then no place.
fn said_about(path: &Path, binary: bool) -> String {
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

/// Compares what is said about each file of these endings with the file that `expected` names, of
/// more than `least` files; `PHALANX_BLESS` writes that file anew.
pub fn assert_messages(
    folder: &Path,
    endings: &[&str],
    expected: impl Fn(&Path) -> PathBuf,
    least: usize,
) {
    let mut failures = String::new();
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let ending = path.extension().and_then(|e| e.to_str());
        let Some(ending) = ending.filter(|e| endings.contains(e)) else {
            continue;
        };
        count += 1;
        let said = said_about(&path, !["test", "nff"].contains(&ending));
        let expected_path = expected(&path);
        if std::env::var_os("PHALANX_BLESS").is_some() {
            std::fs::write(&expected_path, &said).unwrap();
        }
        let expected = std::fs::read_to_string(&expected_path).unwrap_or_default();
        if said.is_empty() || said != expected.replace("\r\n", "\n") {
            let name = path.file_name().unwrap();
            writeln!(failures, "{name:?}\n-- expected\n{expected}-- said\n{said}").unwrap();
        }
    }
    assert!(count > least, "only {count} bad files found");
    assert!(failures.is_empty(), "{failures}");
}
