//! The tables of rates in the README and in `perf/rates.md` match a record in `perf/`.
//!
//! Both are made by [`readme_table`] and [`scene_table`].

use super::rate_tables::{readme_table, scene_table};
use super::{fixture, markers};
use phalanx::report::{BenchRecord, load};

/// A function that makes a table of a record, as Markdown.
type TableWriter = fn(&BenchRecord) -> String;

/// Files that contain a table, and the functions that make it.
const TABLES: [(&str, TableWriter); 2] =
    [("README.md", readme_table), ("perf/rates.md", scene_table)];

#[test]
fn tables_are_those_of_one_record() {
    let [readme, each] = TABLES.map(|(file, table_of)| {
        markers::held(file, "rates", |path| {
            table_of(&load(path).unwrap_or_else(|e| panic!("{e}")))
        })
    });
    assert_eq!(readme, each, "two records");
}

#[test]
fn a_table_of_few_scenes() {
    let mut record = fixture::record(2);
    record.scenes[1].name = "odd|scene_1".into();
    for row in record.rows.iter_mut() {
        if row.scene == "standard:scene1:small" {
            row.scene = "odd|scene_1".into();
        }
    }
    // An inexact mode does not count, however fast; nor does a peer that cannot load a scene.
    for row in record
        .rows
        .iter_mut()
        .filter(|row| row.kernel == "packet8 coherent")
    {
        row.exact = row.rays != "shadow";
    }
    record
        .rows
        .retain(|row| row.engine != "embree" || row.scene != "odd|scene_1");
    let median = |engine: &str, kernel: &str, rays: &str| {
        let is_chosen = |row: &&phalanx::report::RateRow| {
            (&*row.engine, &*row.kernel, &*row.rays, row.threads) == (engine, kernel, rays, 1)
        };
        record
            .rows
            .iter()
            .find(is_chosen)
            .expect("a row")
            .mrays_per_s
            .median
    };
    let (readme, each) = (readme_table(&record), scene_table(&record));
    let table = format!("{readme}{each}");
    let line = |start: &str| {
        let line = table.lines().find(|line| line.starts_with(start));
        line.unwrap_or_else(|| panic!("no line {start} in\n{table}"))
    };
    assert!(table.starts_with("| Mrays/s, geometric means of 2 scenes, 1 thread | primary | shadow | diffuse |\n|---|---:|---:|---:|\n"), "{table}");
    let (auto, coherent) = (
        median("phalanx", "auto", "primary"),
        median("embree", "packet8 coherent", "primary"),
    );
    let (shadow, single) = (
        median("phalanx", "auto", "shadow"),
        median("embree", "single", "shadow"),
    );
    let ratios = format!(
        "| phalanx ÷ embree, best exact mode | × {:.2} (of 1) | × {:.2} (of 1) |",
        auto / coherent,
        shadow / single
    );
    assert!(
        line("| phalanx ÷ embree").starts_with(&ratios),
        "{ratios} in\n{table}"
    );
    assert!(
        line("| phalanx, 2 threads |").matches('|').count() == 5,
        "{table}"
    );
    let of_scene =
        format!("| **standard:scene0:small**, 1 k primitives: phalanx | **{auto:.1}** |");
    assert!(
        line("| **standard:scene0").starts_with(&of_scene),
        "{table}"
    );
    let theirs = format!(
        "| embree, best exact mode | {coherent:.1} (× {:.2}) |",
        auto / coherent
    );
    assert!(line("| embree").starts_with(&theirs), "{table}");
    assert!(table.contains("**odd\\|scene\\_1**"), "{table}");
    // The only scene that the peer supports.
    assert_eq!(table.matches("\n| embree").count(), 1, "{table}");
    let source = "Imaginary 9000, 2 hardware threads, virtualised (KVM); phalanx 0.1.0 (0123abc) for x86-64-v4, kernel auto, best trees, embree 4.4.0; 2026-11-21";
    assert!(readme.ends_with(&format!("{source}.\n")), "{readme}");
    let command = ", `phalanx bench --against embree`.\n";
    assert!(each.ends_with(&format!("{source}{command}")), "{each}");
}

#[test]
fn spheres_are_in_no_mean() {
    let mut record = fixture::record(3);
    let mean = readme_table(&record);
    assert!(
        mean.starts_with("| Mrays/s, geometric means of 3 scenes, "),
        "{mean}"
    );
    record.scenes[2].primitives = [("spheres".to_owned(), 998), ("triangles".to_owned(), 2)].into();
    let two = readme_table(&fixture::record(2));
    let row = |table: &str, start: &str| {
        let line = table.lines().find(|line| line.starts_with(start));
        line.unwrap_or_else(|| panic!("no line {start} in\n{table}"))
            .to_owned()
    };
    let table = readme_table(&record);
    assert!(
        table.starts_with("| Mrays/s, geometric means of 2 scenes of triangles, "),
        "{table}"
    );
    for start in [
        "| **phalanx** |",
        "| phalanx ÷ embree",
        "| phalanx ÷ scalar oracle",
        "| phalanx, 2 threads |",
    ] {
        assert_eq!(row(&table, start), row(&two, start));
    }
    row(&table, "| standard:scene2:small (÷ best peer) | ");
    assert_eq!(table.matches("\n| phalanx ÷ embree").count(), 1, "{table}");
}

#[test]
fn a_record_without_rates_says_so() {
    let mut empty = fixture::record(1);
    empty.rows.clear();
    for (_, table_of) in TABLES {
        assert_eq!(table_of(&empty), "The record has no rates.\n");
    }
}
