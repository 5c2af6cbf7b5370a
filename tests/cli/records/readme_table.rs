//! The README's table of rates is that of a record in `perf/`.
//!
//! Between `<!-- rates: perf/records/NAME.json -->` and `<!-- /rates -->` stands what
//! [`readme_table`] makes of that record.
//! `PHALANX_BLESS=1 cargo test --release --test cli records::` writes it there.

use super::fixture;
use phalanx::report::{load, readme_table};
use std::fs;
use std::path::Path;

const START: &str = "<!-- rates: ";
const END: &str = "<!-- /rates -->";
/// Text in the README's marker as long as no record of a whole run is kept.
const NONE_YET: &str = "filled from perf/";

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
fn the_readme_has_the_table_of_its_record() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let readme = root.join("README.md");
    let text = fs::read_to_string(&readme).expect("the README");
    let marked = marked(&text).expect("a table of rates between its markers in the README");
    if marked.name == NONE_YET {
        println!("skipped: the README names no record yet");
        return;
    }
    if !root.join("perf/records").is_dir() {
        println!("skipped: the published package has no perf/records");
        return;
    }
    let record = load(&root.join(marked.name)).unwrap_or_else(|e| panic!("{e}"));
    let table = readme_table(&record);
    if std::env::var_os("PHALANX_BLESS").is_some() {
        let blessed = [marked.before, &table, marked.after].concat();
        fs::write(&readme, blessed).expect("a README that can be written");
        return;
    }
    assert!(
        marked.table == table,
        "the README's table is not that of {}; PHALANX_BLESS=1 puts this there:\n{table}",
        marked.name
    );
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
    let table = readme_table(&record);
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
    assert!(!table.contains("<details>"));
    let source = "Imaginary 9000, 2 hardware threads, virtualised (KVM); phalanx 0.1.0 (0123abc) for x86-64-v4, embree 4.4.0; 2026-11-21, `phalanx bench --against embree`.\n";
    assert!(table.ends_with(source), "{table}");
}

#[test]
fn many_scenes_are_folded_away() {
    let table = readme_table(&fixture::record(7));
    assert!(
        table.contains("\n<details><summary>Each scene</summary>\n\n| Mrays/s, 1 thread |"),
        "{table}"
    );
    assert_eq!(table.matches("\n</details>\n").count(), 1);
    let mut empty = fixture::record(1);
    empty.rows.clear();
    assert_eq!(readme_table(&empty), "The record has no rates.\n");
}
