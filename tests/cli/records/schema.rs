//! `perf/record.schema.json` describes a record completely and exactly.

use super::fixture;
use phalanx::bench::RayKind;
use phalanx::report::to_json;
use regex_lite::Regex;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::{fs, slice};

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

/// Returns true if the schema describes a document; prints a place where it does not.
fn is_valid(perf: &Path, document: &Value) -> bool {
    let schema = json(&perf.join("record.schema.json"));
    obeys(&schema, &schema, document, "")
}

/// Returns true if a value obeys a part of a schema of JSON Schema 2020-12. Keywords that ours has
/// no use for are refused.
fn obeys(root: &Value, schema: &Value, value: &Value, place: &str) -> bool {
    let Some(rules) = schema.as_object() else {
        return schema == true;
    };
    let items = || value.as_array().into_iter().flatten();
    let fields = || value.as_object().into_iter().flatten();
    let holds = |keyword: &str, rule: &Value| {
        let limit = || rule.as_f64().expect("a number");
        let words = rule.as_array().map_or(slice::from_ref(rule), |words| words);
        let text = rule.as_str().unwrap_or_default();
        let part = |rule: &Value, name: &str, part: &Value| {
            obeys(root, rule, part, &format!("{place}/{name}"))
        };
        match keyword {
            "$schema" => text == "https://json-schema.org/draft/2020-12/schema",
            "$defs" | "title" | "description" | "format" => true,
            "$ref" => obeys(root, root.pointer(&text[1..]).expect(text), value, place),
            "properties" => fields().all(|(name, field)| {
                let own = rule.get(name);
                own.is_none_or(|own| part(own, name, field))
            }),
            "additionalProperties" => fields().all(|(name, field)| {
                schema["properties"].get(name).is_some() || part(rule, name, field)
            }),
            "propertyNames" => fields().all(|(name, _)| part(rule, name, &name[..].into())),
            "required" => words.iter().all(|name| {
                let name = name.as_str().expect("a name");
                !value.is_object() || value.get(name).is_some()
            }),
            "items" => (0..)
                .zip(items())
                .all(|(i, item)| part(rule, &i.to_string(), item)),
            "minItems" => !value.is_array() || items().count() as f64 >= limit(),
            "maxItems" => !value.is_array() || items().count() as f64 <= limit(),
            "minimum" => value.as_f64().is_none_or(|number| number >= limit()),
            "maximum" => value.as_f64().is_none_or(|number| number <= limit()),
            "pattern" => {
                let pattern = Regex::new(text).expect("a pattern");
                value.as_str().is_none_or(|text| pattern.is_match(text))
            }
            "type" => words.iter().any(|name| is_of_type(value, name)),
            "const" | "enum" => words.contains(value),
            _ => panic!("the keyword {keyword:?} is new here"),
        }
    };
    let broken = rules.iter().find(|(keyword, rule)| !holds(keyword, rule));
    broken.inspect(|(keyword, _)| println!("{place}: {keyword}"));
    broken.is_none()
}

fn is_of_type(value: &Value, name: &Value) -> bool {
    match name.as_str().expect("a type") {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        "number" => value.is_number(),
        "integer" => value.as_f64().is_some_and(|number| number.fract() == 0.0),
        other => panic!("the type {other:?} is new here"),
    }
}

fn value() -> Value {
    serde_json::from_str(&to_json(&fixture::record(2))).expect("JSON")
}

#[test]
fn what_is_written_validates() {
    let Some(perf) = perf() else { return };
    assert!(is_valid(&perf, &value()));
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
            assert!(is_valid(&perf, &document), "{}", path.display());
        }
    }
}

#[test]
fn broken_records_do_not() {
    let Some(perf) = perf() else { return };
    let unknown_kind = value()["scenes"][0]["rays"]["primary"].take();
    let breaks: [(&str, Value); 13] = [
        ("/schema_version", 1.into()),
        ("/machine/threads", Value::Null),
        ("/machine/caches/0/kind", "trace".into()),
        ("/run/size", Value::from(vec![1280])),
        ("/scenes/0/hash", "0x123456".into()),
        ("/rows/0/mrays_per_s/median", Value::Null),
        ("/rows/0/samples/3", (-1.0).into()),
        ("/rows/0/engine", "povray".into()),
        ("/program", serde_json::json!({})),
        ("/machine/caches/0/level", 5.into()),
        ("/run/size", Value::from(vec![64; 3])),
        ("/rows/0/threads", 1.5.into()),
        (
            "/scenes/0/rays",
            serde_json::json!({ "sideways": unknown_kind }),
        ),
    ];
    for (place, broken) in breaks {
        let mut document = value();
        *document.pointer_mut(place).expect(place) = broken;
        assert!(!is_valid(&perf, &document), "{place}");
    }
    for place in ["", "/program", "/rows/0", "/counters/0/work"] {
        let mut document = value();
        let object = document.pointer_mut(place).and_then(Value::as_object_mut);
        object.expect(place).insert("surplus".into(), 1.into());
        assert!(!is_valid(&perf, &document), "{place}: a surplus field");
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
