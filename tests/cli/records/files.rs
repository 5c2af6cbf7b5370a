//! Records written and read back, and errors about files that are not records.

use super::fixture;
use phalanx::report::{BenchRecord, RecordError, SCHEMA_VERSION, load, to_csv, to_json};

fn load_text(text: &str) -> Result<BenchRecord, RecordError> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("record.json");
    std::fs::write(&path, text).expect("a file");
    load(&path)
}

#[test]
fn a_record_survives_its_file() {
    let mut record = fixture::record(2);
    // A number whose shortest decimal form needs every digit.
    record.rows[0].samples[0] = 0.1 + 0.2;
    let text = to_json(&record);
    assert!(text.ends_with("}\n"));
    assert_eq!(load_text(&text).expect("a record"), record);
}

/// Records of before 30 November 2026 hold the machine's peak rates.
#[test]
fn an_older_record_has_limits_that_nothing_reads() {
    let record = fixture::record(1);
    let limits = "{\n  \"limits\": {\"threads\": [{\"threads\": 1, \"gflops\": 120.5}]},";
    let older = to_json(&record).replacen('{', limits, 1);
    assert_eq!(load_text(&older).expect("a record"), record);
}

/// Trees were medium before the option existed.
#[test]
fn an_older_record_is_of_medium_trees() {
    let text = to_json(&fixture::record(1));
    let older = text.replacen("\n    \"quality\": \"best\",", "", 1);
    assert_ne!(older, text);
    assert_eq!(load_text(&older).expect("a record").run.quality, "medium");
}

#[test]
fn bad_files_are_told_apart() {
    let folder = tempfile::tempdir().expect("a folder");
    let missing = load(&folder.path().join("none.json"));
    assert!(matches!(missing, Err(RecordError::Io { .. })));
    let text = to_json(&fixture::record(1));

    let error = load_text("{\n  \"schema_version\": 1,\n  ]").expect_err("not JSON");
    assert!(matches!(error, RecordError::NotJson { .. }), "{error:?}");
    assert!(
        error.to_string().contains("record.json:3:3: not JSON: "),
        "{error}"
    );
    assert_eq!(error.to_string().matches("line").count(), 0, "{error}");
    let half = &text[..text.len() / 2];
    assert!(matches!(load_text(half), Err(RecordError::NotJson { .. })));
    assert!(matches!(load_text(""), Err(RecordError::NotJson { .. })));

    let newer = text.replacen(
        &format!("\"schema_version\": {SCHEMA_VERSION}"),
        "\"schema_version\": 7",
        1,
    );
    let error = load_text(&newer).expect_err("another version");
    assert!(matches!(
        error,
        RecordError::Version {
            version: Some(7),
            ..
        }
    ));
    assert!(
        error
            .to_string()
            .contains("a record of version 7, and this"),
        "{error}"
    );
    for other in ["{}", "[1, 2]", "null", "{\"isa\": \"x86-64-v4\"}"] {
        let error = load_text(other).expect_err("no record");
        assert!(
            matches!(error, RecordError::Version { version: None, .. }),
            "{error:?}"
        );
    }

    let error = load_text(&text.replacen("\"cpu\"", "\"gpu\"", 1)).expect_err("no CPU");
    assert!(matches!(error, RecordError::Layout { .. }));
    assert!(error.to_string().contains("missing field `cpu`"), "{error}");
}

#[test]
fn samples_as_csv() {
    let mut record = fixture::record(1);
    record.rows.truncate(1);
    let row = &mut record.rows[0];
    row.scene = "a \"fine\" one.test".into();
    row.kernel = "scalar, plain".into();
    row.samples = vec![1.5, 2.5];
    record.machine.cpu = "Imaginary, 9000".into();
    let text = to_csv(&record);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 3, "a sample a line");
    assert!(lines[0].starts_with("scene,rays,engine,kernel,threads,sample,mrays_per_s,median,"));
    let columns = lines[0].split(',').count();
    for (line, sample) in lines[1..].iter().zip(["1,1.5,", "2,2.5,"]) {
        let start = "\"a \"\"fine\"\" one.test\",primary,oracle,\"scalar, plain\",1,";
        let rest = line.strip_prefix(start);
        assert!(rest.is_some_and(|rest| rest.starts_with(sample)), "{line}");
        let origin = ",1000,700,,true,,\"Imaginary, 9000\",2,x86-64-v4,0.1.0,0123abc,false,";
        assert!(line.contains(origin), "{line}");
        assert!(line.ends_with(&record.run.started), "{line}");
        // Two commas are within quotes.
        assert_eq!(line.split(',').count(), columns + 2, "{line}");
    }
}
