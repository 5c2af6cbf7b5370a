//! `perf/record.schema.json` describes a record completely and exactly.

use super::fixture;
use phalanx::bench::RayKind;
use phalanx::report::to_json;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// The project's measurements, which are not part of the published package.
fn perf() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("perf");
    let here = folder.is_dir();
    if !here {
        println!("skipped: {} is not here", folder.display());
    }
    here.then_some(folder)
}

fn json(path: &Path) -> Value {
    let text = fs::read_to_string(path).expect("a readable file");
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Schema violations.
fn errors(perf: &Path, document: &Value) -> Vec<String> {
    let schema = json(&perf.join("record.schema.json"));
    jsonschema::meta::validate(&schema).expect("a schema");
    let validator = jsonschema::draft202012::new(&schema).expect("a schema of 2020-12");
    let errors = validator.iter_errors(document);
    errors
        .map(|e| format!("{}: {e}", e.instance_path()))
        .collect()
}

fn value() -> Value {
    serde_json::from_str(&to_json(&fixture::record(2))).expect("JSON")
}

#[test]
fn what_is_written_validates() {
    let Some(perf) = perf() else { return };
    assert_eq!(errors(&perf, &value()), Vec::<String>::new());
}

#[test]
fn kept_records_validate() {
    let Some(perf) = perf() else { return };
    for entry in fs::read_dir(perf.join("records")).expect("a folder of records") {
        let path = entry.expect("an entry").path();
        if path.extension().is_none_or(|ending| ending != "json") {
            continue;
        }
        let document = json(&path);
        let text = document.to_string();
        assert!(
            !text.contains("\"/"),
            "{}: a path of a machine",
            path.display()
        );
        // Those of `cargo bench --bench ratios` and of the scripts in `perf` are of other kinds.
        if document.get("ratios").is_none() && document.get("kind").is_none() {
            let wrong = errors(&perf, &document);
            assert!(wrong.is_empty(), "{}: {wrong:?}", path.display());
        }
    }
}

#[test]
fn broken_records_do_not() {
    let Some(perf) = perf() else { return };
    let breaks: [(&str, Value); 8] = [
        ("/schema_version", 1.into()),
        ("/machine/threads", Value::Null),
        ("/machine/caches/0/kind", "trace".into()),
        ("/run/size", Value::from(vec![1280])),
        ("/scenes/0/hash", "0x123456".into()),
        ("/rows/0/mrays_per_s/median", Value::Null),
        ("/rows/0/samples/3", (-1.0).into()),
        ("/rows/0/engine", "povray".into()),
    ];
    for (place, broken) in breaks {
        let mut document = value();
        *document.pointer_mut(place).expect(place) = broken;
        assert!(!errors(&perf, &document).is_empty(), "{place}");
    }
    for place in ["", "/program", "/rows/0", "/counters/0/work"] {
        let mut document = value();
        let object = document.pointer_mut(place).and_then(Value::as_object_mut);
        object.expect(place).insert("surplus".into(), 1.into());
        assert!(
            !errors(&perf, &document).is_empty(),
            "{place}: a surplus field"
        );
    }
}

/// The schema's list is the program's own.
#[test]
fn kinds_of_rays_are_the_benchmarks() {
    let Some(perf) = perf() else { return };
    let schema = json(&perf.join("record.schema.json"));
    let names: Vec<&str> = RayKind::names().collect();
    assert_eq!(schema["$defs"]["ray_kind"]["enum"], Value::from(names));
}

/// Optional fields.
const OPTIONAL: [(&str, &str); 4] = [
    ("", "limits"),
    ("scene", "origin"),
    ("run", "partial"),
    ("run", "spp"),
];

/// Checks that every field is described and, apart from the optional ones, required, and that no
/// object accepts others. Maps describe their values.
#[test]
fn the_schema_is_complete() {
    fn check(schema: &Value, place: &str) {
        let described = schema.get("description").is_some() || schema.get("$ref").is_some();
        assert!(described, "{place} has no description");
        if let Some(properties) = schema.get("properties").and_then(Value::as_object) {
            assert_eq!(schema["additionalProperties"], false, "{place}");
            let names = properties.keys().map(String::as_str);
            let always = |name: &&str| !OPTIONAL.contains(&(place, *name));
            let mut names: Vec<&str> = names.filter(always).collect();
            let mut required: Vec<&str> = schema["required"]
                .as_array()
                .into_iter()
                .flatten()
                .filter_map(Value::as_str)
                .collect();
            names.sort_unstable();
            required.sort_unstable();
            assert_eq!(names, required, "{place}");
            for (name, property) in properties {
                assert!(property.get("description").is_some(), "{place}/{name}");
                check(property, &format!("{place}/{name}"));
            }
        }
        for inner in ["items", "additionalProperties"] {
            if let Some(inner) = schema.get(inner).filter(|value| value.is_object()) {
                check(inner, &format!("{place}/*"));
            }
        }
    }
    let Some(perf) = perf() else { return };
    let schema = json(&perf.join("record.schema.json"));
    check(&schema, "");
    for (name, part) in schema["$defs"].as_object().expect("definitions") {
        check(part, name);
    }
}
