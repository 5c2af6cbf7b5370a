//! Crates that each feature of the library adds: as many as its documentation says, and for the
//! program those of a list.

use std::collections::BTreeSet;
use std::process::Command;

/// Crates in a build for this machine: the lines of `cargo tree`.
fn tree(arguments: &str) -> BTreeSet<String> {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args("tree --locked --offline --prefix none --no-dedupe".split(' '));
    let output = cargo.args(arguments.split(' ')).output();
    let output = output.expect("cargo runs");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let lines = String::from_utf8(output.stdout).expect("names");
    lines.lines().map(str::to_owned).collect()
}

/// Number of crates of a feature, including the library itself.
fn crates(feature: &str) -> usize {
    let library = "--edges normal --package phalanx --no-default-features".to_owned();
    let features = format!("{library} --features {feature}");
    tree(if feature == "none" { &library } else { &features }).len()
}

#[test]
fn features_bring_as_many_crates_as_the_documentation_says() {
    let documentation = include_str!("../../src/lib.rs");
    let (_, features) = documentation.split_once("//! # Features").expect("a table");
    let rows = features
        .lines()
        .filter_map(|line| line.strip_prefix("//! | "));
    let cells = rows.map(|row| row.split('|').map(str::trim).collect::<Vec<_>>());
    let counted = cells.filter_map(|cells| {
        let count = cells.get(2)?.parse::<usize>().ok()?;
        let feature = cells[0].split(' ').next()?.trim_matches('`').to_owned();
        Some((feature, count))
    });
    let counted: Vec<_> = counted.collect();
    assert_eq!(counted.len(), 5, "{counted:?}");
    for (feature, count) in counted {
        assert_eq!(crates(&feature), count, "crates of the feature {feature}");
    }
}

/// Crates of others in the first command: names, seconds, reasons.
const LISTED: &str = include_str!("crates.txt");

#[test]
fn every_crate_of_others_is_listed_with_its_seconds() {
    let rows = LISTED.lines().filter(|line| !line.starts_with('#'));
    let listed = rows.map(|row| {
        let words: Vec<&str> = row.split_whitespace().collect();
        assert!(words.len() > 2 && words[1].parse::<f64>().is_ok(), "{row}");
        words[0].to_owned()
    });
    let listed: BTreeSet<String> = listed.collect();
    let mut compiled = tree("--edges normal,build --package phalanx");
    compiled.retain(|line| !line.starts_with("phalanx"));
    let names = compiled.iter().filter_map(|line| line.split(' ').next());
    let names: BTreeSet<String> = names.map(str::to_owned).collect();
    let unlisted: Vec<_> = names.difference(&listed).collect();
    assert!(
        unlisted.is_empty(),
        "not in tests/house/crates.txt: {unlisted:?}"
    );
    let gone: Vec<_> = listed.difference(&names).collect();
    assert!(gone.is_empty(), "only in tests/house/crates.txt: {gone:?}");
    assert_eq!(
        names.len(),
        compiled.len(),
        "two versions of a crate: {compiled:?}"
    );
}

/// Otherwise the crate, and all that depends on it, would be compiled once more for the tests.
#[test]
fn tests_ask_for_no_features_that_a_build_lacks() {
    let others = ["benches", "python", "wasm"].map(|name| format!(" --exclude phalanx-{name}"));
    let members = format!(
        "--workspace{} --format {{p}}:{{f}} --edges",
        others.concat()
    );
    let built = tree(&format!("{members} normal,build"));
    let tested = tree(&format!("{members} normal,build,dev"));
    let changed: Vec<_> = built.difference(&tested).collect();
    assert!(changed.is_empty(), "{changed:?}");
}
