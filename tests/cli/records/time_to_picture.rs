//! The README's table of seconds to a picture matches a record in `perf/`.
//!
//! `perf/time_to_picture` makes such records and prints the table of one. The rule is repeated
//! here, so that no Python is needed; `.ci/run` compares the script's own table with the README,
//! too.

use super::markers;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

fn text<'a>(value: &'a Value, key: &str) -> &'a str {
    let part = value[key].as_str();
    part.unwrap_or_else(|| panic!("no text {key:?} in {value}"))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    let part = value[key].as_array();
    part.unwrap_or_else(|| panic!("no list {key:?} in {value}"))
}

fn median(samples: &[Value]) -> f64 {
    let mut samples: Vec<f64> = samples.iter().map(number).collect();
    samples.sort_by(f64::total_cmp);
    let middle = samples.len() / 2;
    match samples.len() % 2 {
        0 => f64::midpoint(samples[middle - 1], samples[middle]),
        _ => samples[middle],
    }
}

fn seconds_text(seconds: f64) -> String {
    let digits = if seconds < 10.0 { 2 } else { 1 };
    format!("{seconds:.digits$}")
}

/// Medians of a tracer in a scene.
fn median_of(scene: &Value, tracer: &str) -> Option<f64> {
    let mut runs = list(scene, "runs").iter();
    let run = runs.find(|run| run["tracer"] == tracer)?;
    Some(median(list(run, "samples")))
}

/// A record as Markdown: medians, ratios to ours, the depths, and the machine.
fn table(record: &Value) -> String {
    let tracers = list(record, "tracers");
    let names: Vec<&str> = tracers.iter().map(|tracer| text(tracer, "name")).collect();
    let threads = &record["threads"];
    let plural = if *threads == 1 { "" } else { "s" };
    let mut out = format!(
        "| Seconds from start to PNG, {threads} thread{plural} | {} |\n|---|{}\n",
        names.join(" | "),
        "---:|".repeat(names.len())
    );
    let mut depths = Vec::new();
    for scene in list(record, "scenes") {
        let ours = median_of(scene, "phalanx").expect("ours");
        let cells = names.iter().map(|&name| match median_of(scene, name) {
            None => "–".to_owned(),
            Some(ours) if name == "phalanx" => format!("**{}**", seconds_text(ours)),
            Some(theirs) => format!("{} (× {:.1})", seconds_text(theirs), theirs / ours),
        });
        let cells: Vec<String> = cells.collect();
        let (title, primitives) = (text(scene, "title"), text(scene, "primitives"));
        let (width, height) = (&scene["size"][0], &scene["size"][1]);
        let cells = cells.join(" | ");
        out += &format!("| {title}, {primitives}, {width}×{height} | {cells} |\n");
        let compared = list(scene, "comparisons").iter();
        let counts =
            compared.map(|comparison| comparison["depth_differs"].as_u64().expect("a count"));
        if let Some(most) = counts.max() {
            depths.push(format!("{most} ({})", text(scene, "name")));
        }
    }
    let machine = &record["machine"];
    let mut facts = format!(
        "{}, {} hardware threads",
        text(machine, "cpu"),
        machine["hardware_threads"]
    );
    if machine["virtualised"] == true {
        facts += ", virtualised";
    }
    let versions = tracers.iter().zip(&names);
    let versions: Vec<String> = versions
        .map(|(tracer, name)| format!("{name} {}", text(tracer, "version")))
        .collect();
    let day = text(record, "started").split('T').next().unwrap_or("");
    let spp = record["samples_per_pixel"].as_u64().unwrap_or(1);
    let plural = if spp == 1 { "" } else { "s" };
    out += &format!(
        "\nMedians of {} whole processes, in turns, {spp} sample{plural} per pixel; {facts}; {}; {day}.",
        record["rounds"],
        versions.join(", ")
    );
    if !depths.is_empty() {
        let depths = depths.join(", ");
        out += &format!(" Pixels whose depth differs by more than 0.1 %: {depths}.");
    }
    out + "\n"
}

fn load(path: &Path) -> Value {
    let text = fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let record: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(record["kind"], "time-to-picture", "{}", path.display());
    assert_eq!(record["schema_version"], 1, "{}", path.display());
    for scene in list(&record, "scenes") {
        for run in list(scene, "runs") {
            let samples = list(run, "samples").len();
            assert_eq!(record["rounds"], samples, "{}: {run}", path.display());
        }
    }
    record
}

#[test]
fn the_table_is_that_of_a_record() {
    markers::held("README.md", "time to picture", |path| table(&load(path)));
}

#[test]
fn a_table_of_two_scenes() {
    let record = json!({
        "started": "2026-11-26T01:02:03Z",
        "machine": {"cpu": "Imaginary 9000", "hardware_threads": 4, "virtualised": true},
        "threads": 1,
        "samples_per_pixel": 4,
        "rounds": 3,
        "tracers": [
            {"name": "phalanx", "version": "0.1.0"},
            {"name": "Mitsuba scalar_rgb", "version": "3.9.1"},
        ],
        "scenes": [
            {
                "name": "a", "title": "A", "primitives": "12 triangles", "size": [4, 3],
                "runs": [
                    {"tracer": "phalanx", "samples": [0.5, 0.25, 3.0]},
                    {"tracer": "Mitsuba scalar_rgb", "samples": [12.0, 11.0, 13.0]},
                ],
                "comparisons": [
                    {"depth_differs": 9}, {"depth_differs": 12},
                ],
            },
            {
                "name": "b", "title": "B", "primitives": "2 spheres", "size": [1, 1],
                "runs": [{"tracer": "phalanx", "samples": [1.0, 2.0]}],
                "comparisons": [],
            },
        ],
    });
    let expected = "\
| Seconds from start to PNG, 1 thread | phalanx | Mitsuba scalar_rgb |
|---|---:|---:|
| A, 12 triangles, 4×3 | **0.50** | 12.0 (× 24.0) |
| B, 2 spheres, 1×1 | **1.50** | – |

Medians of 3 whole processes, in turns, 4 samples per pixel; Imaginary 9000, 4 hardware threads, virtualised; phalanx 0.1.0, Mitsuba scalar_rgb 3.9.1; 2026-11-26. Pixels whose depth differs by more than 0.1 %: 12 (a).
";
    assert_eq!(table(&record), expected);
}
