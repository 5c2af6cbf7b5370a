//! Test binaries: few, because each links the whole library.

use std::path::Path;

/// Maximum number of binaries that `cargo test` links.
const MOST: usize = 17;

/// Runs the unit tests of crates whose own manifests say that they have none.
const UNITS: &str = include_str!("../units/Cargo.toml");

/// Manifests of the workspace's crates, and the location of their sources.
const CRATES: [(&str, &str); 14] = [
    ("Cargo.toml", "src/lib.rs"),
    ("src/scene/Cargo.toml", "src/scene"),
    ("src/trace/Cargo.toml", "src/trace"),
    ("src/oracle/Cargo.toml", "src/oracle"),
    ("src/files/Cargo.toml", "src/files"),
    ("src/image/Cargo.toml", "src/image"),
    ("src/look/Cargo.toml", "src/look"),
    ("src/formats/Cargo.toml", "src/formats"),
    ("src/standard/Cargo.toml", "src/standard"),
    ("src/io/Cargo.toml", "src/io"),
    ("src/render/Cargo.toml", "src/render"),
    ("src/jobs/Cargo.toml", "src/jobs"),
    ("src/report/Cargo.toml", "src/report"),
    ("src/bench/Cargo.toml", "src/bench"),
];

#[test]
fn there_are_few_test_binaries() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let entries = std::fs::read_dir(root.join("tests")).expect("tests");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let of_tests = paths.filter(|path| {
        path.extension().is_some_and(|e| e == "rs") || path.join("main.rs").exists()
    });
    // One belongs to the program itself.
    let mut binaries = 1 + of_tests.count();
    for (manifest, sources) in CRATES {
        let text = std::fs::read_to_string(root.join(manifest)).expect("a manifest");
        let (_, library) = text.split_once("[lib]").expect("a library");
        let library = library.split("\n[").next().unwrap_or_default();
        if library.lines().any(|line| line == "test = false") {
            let elsewhere = UNITS.contains(&format!("path = \"../../{sources}/lib.rs\""));
            assert!(
                elsewhere || !has_unit_tests(sources),
                "{sources}: its tests are never run"
            );
            binaries += usize::from(elsewhere)
        } else {
            binaries += 1
        }
    }
    assert!(binaries <= MOST, "{binaries} test binaries");
}

fn has_unit_tests(sources: &str) -> bool {
    let path = |source: &crate::source::SourceFile| format!("src/{}", source.path);
    let all = crate::source::sources();
    let mut own = all.iter().filter(|s| path(s).starts_with(sources));
    own.any(|source| source.code.contains("#[test]"))
}
