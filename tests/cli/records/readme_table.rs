//! The tables of rates in the README and in `perf/rates.md` are those of a record in `perf/`.
//!
//! Between `<!-- rates: perf/records/NAME.json -->` and `<!-- /rates -->` stands what
//! [`readme_table`] and [`scene_table`] make of that record.
//! `PHALANX_BLESS=1 cargo test --release --test cli records::` writes it there.

use super::fixture;
use phalanx::report::{BenchRecord, load, readme_table, scene_table};
use std::fs;
use std::path::Path;

const START: &str = "<!-- rates: ";
const END: &str = "<!-- /rates -->";

/// A function that makes a table of a record, as Markdown.
type TableWriter = fn(&BenchRecord) -> String;

/// Files that hold a table, and the functions that make it.
const TABLES: [(&str, TableWriter); 2] =
    [("README.md", readme_table), ("perf/rates.md", scene_table)];

/// The name in the marker and what stands below it; the text around the latter.
struct Marked<'a> {
    name: &'a str,
    before: &'a str,
    table: &'a str,
    after: &'a str,
}

fn marked(text: &str) -> Option<Marked<'_>> {
    let start = text.find(START)? + START.len();
    let name_end = start + text[start..].find(" -->")?;
    let table = name_end + text[name_end..].find('\n')? + 1;
    let end = table + text[table..].find(END)?;
    Some(Marked {
        name: &text[start..name_end],
        before: &text[..table],
        table: &text[table..end],
        after: &text[end..],
    })
}

#[test]
fn tables_are_those_of_one_record() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    if !root.join("perf/records").is_dir() {
        println!("skipped: the published package has no perf/records");
        return;
    }
    let mut names = Vec::new();
    for (file, table_of) in TABLES {
        let path = root.join(file);
        let text = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{file}: {e}"));
        let marked = marked(&text).unwrap_or_else(|| panic!("no markers in {file}"));
        let record = load(&root.join(marked.name)).unwrap_or_else(|e| panic!("{e}"));
        let table = table_of(&record);
        if std::env::var_os("PHALANX_BLESS").is_some() {
            let blessed = [marked.before, &table, marked.after].concat();
            fs::write(&path, blessed).expect("a file that can be written");
        } else {
            assert!(
                marked.table == table,
                "the table of {file} is not that of {}; PHALANX_BLESS=1 puts this there:\n{table}",
                marked.name
            );
        }
        names.push(marked.name.to_owned());
    }
    assert_eq!(names[0], names[1], "two records");
}

#[test]
fn markers_are_found() {
    let text = "# x\n<!-- rates: perf/records/a.json -->\n| a |\n<!-- /rates -->\nend\n";
    let found = marked(text).expect("markers");
    assert_eq!(
        (found.name, found.table),
        ("perf/records/a.json", "| a |\n")
    );
    assert_eq!([found.before, found.table, found.after].concat(), text);
    assert!(marked("<!-- rates: a.json -->\n").is_none());
    assert!(marked("none").is_none());
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
    // A mode that is wrong does not count, however fast; nor does a peer that cannot take a scene.
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
        let of = |row: &&phalanx::report::RateRow| {
            (&*row.engine, &*row.kernel, &*row.rays, row.threads) == (engine, kernel, rays, 1)
        };
        record
            .rows
            .iter()
            .find(of)
            .expect("a row")
            .mrays_per_s
            .median
    };
    let (readme, each) = (readme_table(&record), scene_table(&record));
    let table = format!("{readme}{each}");
    let line = |start: &str| {
        let found = table.lines().find(|line| line.starts_with(start));
        found.unwrap_or_else(|| panic!("no line {start} in\n{table}"))
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
    // The one scene that the peer took.
    assert_eq!(table.matches("\n| embree").count(), 1, "{table}");
    let source = "Imaginary 9000, 2 hardware threads, virtualised (KVM); phalanx 0.1.0 (0123abc) for x86-64-v4, embree 4.4.0; 2026-11-21";
    assert!(readme.ends_with(&format!("{source}.\n")), "{readme}");
    let command = ", `phalanx bench --against embree`.\n";
    assert!(each.ends_with(&format!("{source}{command}")), "{each}");
}

#[test]
fn a_record_without_rates_says_so() {
    let mut empty = fixture::record(1);
    empty.rows.clear();
    for (_, table_of) in TABLES {
        assert_eq!(table_of(&empty), "The record has no rates.\n");
    }
}
