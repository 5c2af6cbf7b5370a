//! Number of crates that each feature of the library adds, as stated in its documentation.

use std::collections::BTreeSet;
use std::process::Command;

/// Names and versions of all crates in a build for this machine, including the library itself.
fn crates(feature: &str) -> usize {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args("tree --locked --offline --edges normal --prefix none --no-dedupe".split(' '));
    cargo.args(["--package", "phalanx", "--no-default-features"]);
    if feature != "none" {
        cargo.args(["--features", feature]);
    }
    let output = cargo.output().expect("cargo runs");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let lines = String::from_utf8(output.stdout).expect("names");
    let crates = lines.lines().map(|line| {
        let mut words = line.split(' ');
        (
            words.next().map(str::to_owned),
            words.next().map(str::to_owned),
        )
    });
    crates.collect::<BTreeSet<_>>().len()
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
