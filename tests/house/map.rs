//! ARCHITECTURE.md is the map of the house: what it says of crates and files is so.

use crate::layering::{CRATES, dependencies};
use crate::source::sources;

/// Files that the recipe of a primitive makes.
const NEW: [&str; 2] = ["scene/prims/discs.rs", "trace/intersect/disc.rs"];

const MAP: &str = include_str!("../../ARCHITECTURE.md");

/// Longest line of the map, in characters: a longer row of a table is read by nobody.
const WIDTH: usize = 200;

#[test]
fn the_table_of_crates_is_that_of_the_manifests() {
    let (_, table) = MAP.split_once("| crate |").expect("a table of crates");
    let rows = table
        .lines()
        .skip(2)
        .take_while(|line| line.starts_with('|'));
    let mut crates = 0;
    for row in rows {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let name = cells[1].trim_matches('`');
        let mut listed: Vec<String> = cells[3]
            .split(", ")
            .filter(|c| !c.is_empty())
            .map(|c| c.trim_matches('`').into())
            .collect();
        listed.sort();
        assert_eq!(listed, dependencies(name), "{name}");
        crates += 1;
    }
    assert_eq!(crates, CRATES.len());
}

#[test]
fn lines_of_the_map_are_short() {
    for (line, number) in MAP.lines().zip(1..) {
        assert!(line.chars().count() < WIDTH, "ARCHITECTURE.md:{number}");
    }
}

#[test]
fn files_of_the_map_exist() {
    let sources = sources();
    let exists = |path: &str| {
        let path = path.trim_start_matches("src/");
        sources
            .iter()
            .any(|source| format!("/{}", source.path).ends_with(&format!("/{path}")))
    };
    let is_source = |span: &&str| {
        let elsewhere = span.starts_with("benches") || span.contains(['{', ' ']);
        span.ends_with(".rs") && span.contains('/') && !elsewhere
    };
    let paths = MAP.split('`').skip(1).step_by(2).filter(is_source);
    let missing: Vec<&str> = paths.filter(|path| !exists(path)).collect();
    assert_eq!(missing, NEW);
}
