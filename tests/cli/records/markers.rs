//! Tables in Markdown files that are generated from a record.
//!
//! Between `<!-- NAME: perf/records/FILE.json -->` and `<!-- /NAME -->` is a table of that record.
//! `PHALANX_BLESS=1 cargo test --release --test cli records::` writes it there.

use std::fs;
use std::path::Path;

/// The record named in the marker, the table below it, and the text around the table.
struct Marked<'a> {
    record: &'a str,
    before: &'a str,
    table: &'a str,
    after: &'a str,
}

fn marked<'a>(text: &'a str, name: &str) -> Option<Marked<'a>> {
    let (start, end) = (format!("<!-- {name}: "), format!("<!-- /{name} -->"));
    let start = text.find(&start)? + start.len();
    let record_end = start + text[start..].find(" -->")?;
    let table = record_end + text[record_end..].find('\n')? + 1;
    let end = table + text[table..].find(&end)?;
    Some(Marked {
        record: &text[start..record_end],
        before: &text[..table],
        table: &text[table..end],
        after: &text[end..],
    })
}

/// Compares the table between a file's markers with the one that `table_of` makes from the named
/// record; returns the record's name. None in the published package, which has no records.
pub fn held(file: &str, name: &str, table_of: impl Fn(&Path) -> String) -> Option<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    if !root.join("perf/records").is_dir() {
        println!("skipped: the published package has no perf/records");
        return None;
    }
    let path = root.join(file);
    let text = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{file}: {e}"));
    let marked = marked(&text, name).unwrap_or_else(|| panic!("no markers in {file}"));
    let table = table_of(&root.join(marked.record));
    if std::env::var_os("PHALANX_BLESS").is_some() {
        let blessed = [marked.before, &table, marked.after].concat();
        fs::write(&path, blessed).expect("a file that can be written");
    } else {
        assert!(
            marked.table == table,
            "the table of {file} is not that of {}; PHALANX_BLESS=1 puts this there:\n{table}",
            marked.record
        );
    }
    Some(marked.record.to_owned())
}

#[test]
fn markers_are_found() {
    let text = "# x\n<!-- rates: perf/records/a.json -->\n| a |\n<!-- /rates -->\nend\n";
    let parts = marked(text, "rates").expect("markers");
    assert_eq!(
        (parts.record, parts.table),
        ("perf/records/a.json", "| a |\n")
    );
    assert_eq!([parts.before, parts.table, parts.after].concat(), text);
    assert!(marked("<!-- rates: a.json -->\n", "rates").is_none());
    assert!(marked(text, "time to picture").is_none());
    assert!(marked("none", "rates").is_none());
}
