//! `phalanx bench`: files, tables, exit codes.

use super::TestFolder;
use super::signals::signal;
use serde_json::Value;
use std::fs;
use std::process::Stdio;
use std::time::Duration;

/// Fast enough for a test; the measurements themselves are ignored.
const FAST: &str = "--size 48x32 --repeat 2 --min-time 0 --threads 1,2";

fn record(room: &TestFolder, name: &str) -> Value {
    let text = fs::read_to_string(room.path().join(name)).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn rows<'r>(record: &'r Value, engine: &str, kernel: &str) -> Vec<&'r Value> {
    let rows = record["rows"].as_array().unwrap().iter();
    rows.filter(|row| row["engine"] == engine && row["kernel"] == kernel)
        .collect()
}

#[test]
fn every_engine_has_a_row_for_every_kind_and_number_of_threads() {
    let room = TestFolder::new();
    let ran = room.run(&format!(
        "bench a.test standard:balls:2 {FAST} --json r.json --csv r.csv --html r.html"
    ));
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    for part in ["a.test: 1 triangles", "× oracle", "reflection", "frame"] {
        assert!(ran.stdout.contains(part), "{part} in {}", ran.stdout);
    }
    let too_long = ran.stdout.lines().find(|line| line.chars().count() > 80);
    assert_eq!(too_long, None, "{}", ran.stdout);
    let heads = ran
        .stdout
        .lines()
        .position(|line| line.contains("× oracle"));
    let first_row = ran.stdout.lines().nth(heads.unwrap() + 1).unwrap();
    assert!(first_row.trim_start().starts_with("frame"), "{first_row}");
    let last = ran.stdout.lines().last().unwrap();
    assert!(
        last.starts_with("phalanx ") && last.contains("Mrays/s primary, "),
        "{last}"
    );
    assert!(
        last.ends_with("× its scalar oracle (2 threads, 2 scenes)"),
        "{last}"
    );
    let record = record(&room, "r.json");
    // Two scenes, six kinds and the frame, two numbers of threads.
    for (engine, kernel) in [
        ("phalanx", "auto"),
        ("phalanx", phalanx::trace::Kernel::packets().name()),
        ("oracle", "scalar"),
    ] {
        let rows = rows(&record, engine, kernel);
        assert_eq!(rows.len(), 2 * 7 * 2, "{engine} {kernel}");
        for row in rows {
            assert!(
                row["mrays_per_s"]["median"].as_f64().unwrap() > 0.0,
                "{row}"
            );
            assert!(row["samples"].as_array().unwrap().len() >= 2, "{row}");
        }
    }
    let scene = &record["scenes"][0]["rays"];
    assert_eq!(scene["primary"]["rays"], 48 * 32);
    assert_eq!(scene["diffuse"]["rays"], scene["primary"]["hits"]);
    let csv = fs::read_to_string(room.path().join("r.csv")).unwrap();
    let samples = record["rows"].as_array().unwrap().iter();
    let samples = samples.map(|row| row["samples"].as_array().unwrap().len());
    assert_eq!(csv.lines().count(), 1 + samples.sum::<usize>());
    let page = fs::read_to_string(room.path().join("r.html")).unwrap();
    assert!(page.contains("standard:balls:2") && page.contains("data:image/png;base64,"));
    assert_eq!(room.names(), ["r.csv", "r.html", "r.json"]);
}

#[test]
fn work_is_the_same_twice_and_more_of_it_than_the_baseline_exits_with_5() {
    let room = TestFolder::new();
    let count = "bench standard:balls:2 --size 48x32 --counters-only";
    let ran = room.run(&format!("{count} --json a.json"));
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(ran.stdout.contains("per ray"), "{}", ran.stdout);
    let again = room.run(&format!("{count} --baseline a.json --fail-above 0%"));
    assert_eq!(again.code, Some(0), "{}{}", again.stdout, again.stderr);
    let mut less = record(&room, "a.json");
    let visits = &mut less["counters"][0]["work"]["node_visits"];
    *visits = (visits.as_u64().unwrap() - 1).into();
    room.write("less.json", &less.to_string());
    let more = room.run(&format!("{count} --baseline less.json --fail-above 0%"));
    assert_eq!(more.code, Some(5), "{}", more.stdout);
    assert!(more.stdout.contains("node_visits"), "{}", more.stdout);
    let allowed = room.run(&format!("{count} --baseline less.json --fail-above 3%"));
    assert_eq!(allowed.code, Some(0), "{}", allowed.stdout);
}

/// Peers build their best trees by default, and so does phalanx.
#[test]
fn trees_are_the_best_unless_said_otherwise() {
    let room = TestFolder::new();
    let count = "bench standard:terrain:20k --size 48x32 --counters-only --kernel packet8";
    let visits = |name: &str| {
        let record = record(&room, name);
        let nodes = record["counters"][0]["work"]["node_visits"].as_u64();
        (record["run"]["quality"].clone(), nodes.unwrap())
    };
    assert_eq!(room.run(&format!("{count} --json best.json")).code, Some(0));
    let fast = format!("{count} --quality fast --json fast.json");
    assert_eq!(room.run(&fast).code, Some(0));
    let fastest = format!("{count} --quality fastest --json fastest.json");
    assert_eq!(room.run(&fastest).code, Some(0));
    let [best, fast, fastest] = ["best.json", "fast.json", "fastest.json"].map(visits);
    assert_eq!((&best.0, &fast.0), (&"best".into(), &"fast".into()));
    assert_eq!(fastest, fast, "another name of fast");
    assert!(
        best.1 < fast.1,
        "{} nodes, {} of the fast one",
        best.1,
        fast.1
    );
    let ran = room.run(&format!("{count} --baseline fast.json"));
    assert!(ran.stderr.contains("BVH quality fast"), "{}", ran.stderr);
}

#[test]
fn rates_are_compared_with_a_baseline_of_this_machine_and_these_rays() {
    let room = TestFolder::new();
    // Fewer samples do not allow any statement.
    let run = format!("bench standard:balls:2 {FAST} --rays primary,shadow")
        .replace("--repeat 2", "--repeat 7");
    assert_eq!(room.run(&format!("{run} --json a.json")).code, Some(0));
    // Ten times faster than any fluctuation explains: this run must look slower.
    let mut faster = record(&room, "a.json");
    for row in faster["rows"].as_array_mut().unwrap() {
        if row["engine"] == "phalanx" {
            for figure in row["mrays_per_s"].as_object_mut().unwrap().values_mut() {
                *figure = (figure.as_f64().unwrap() * 1000.0).into();
            }
        }
    }
    room.write("faster.json", &faster.to_string());
    let slower = room.run(&format!("{run} --baseline faster.json --fail-above 8%"));
    assert_eq!(slower.code, Some(5), "{}{}", slower.stdout, slower.stderr);
    let ran = room.run(&format!("{run} --baseline faster.json"));
    assert_eq!(ran.code, Some(0), "without --fail-above it only tells");
    let mut elsewhere = record(&room, "a.json");
    elsewhere["machine"]["cpu"] = "another".into();
    room.write("elsewhere.json", &elsewhere.to_string());
    let refused = room.run(&format!("{run} --baseline elsewhere.json"));
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    assert!(refused.stderr.contains("--force"), "{}", refused.stderr);
    let forced = room.run(&format!("{run} --baseline elsewhere.json --force"));
    assert_eq!(forced.code, Some(0), "{}", forced.stderr);
    let rays = format!(
        "bench standard:balls:2 {FAST} --size 32x32 --rays primary --baseline a.json --force"
    );
    let other = room.run(&rays.replacen("--size 48x32 ", "", 1));
    assert_eq!(other.code, Some(2), "{}", other.stderr);
    records_are_compared_and_put_on_a_page(&room);
}

/// `a.json` and `elsewhere.json` have the same rates, `faster.json` others.
fn records_are_compared_and_put_on_a_page(room: &TestFolder) {
    let same = room.ok("bench compare a.json elsewhere.json");
    let position = |part: &str| {
        same.find(part)
            .unwrap_or_else(|| panic!("{part} in {same}"))
    };
    assert!(
        position("  B  elsewhere.json") < position("ranks over"),
        "{same}"
    );
    assert!(
        position("ranks over") < position("geometric means"),
        "{same}"
    );
    assert!(same.contains("None of "), "{same}");
    let all = room.ok("bench compare a.json faster.json --all --filter primary.oracle");
    assert!(
        all.contains("oracle scalar") && !all.contains("shadow"),
        "{all}"
    );
    let markdown = room.ok("bench compare a.json faster.json --markdown --html c.html");
    assert!(markdown.contains("| rank | record |"), "{markdown}");
    let json = room.ok("bench compare a.json faster.json --json --threshold 5%");
    let document: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(document["threshold"], 0.05);
    assert_eq!(document["ranks"][0]["record"], 1, "{json}");
    assert_eq!(document["rates"][0]["engine"], "phalanx", "{json}");
    room.ok("bench report a.json -o one.html");
    room.ok("bench report a.json faster.json -o two.html");
    let page = |name: &str| fs::read_to_string(room.path().join(name)).unwrap();
    assert_eq!(page("c.html"), page("two.html"));
    assert!(page("one.html").contains("id=\"sizes\""));
    assert!(page("two.html").contains("id=\"machines\""));
    room.refused(
        "bench compare a.json faster.json --filter a(",
        2,
        &["--filter", "closing", "regular expression"],
    );
    room.refused(
        "bench compare a.json faster.json --filter nothing",
        2,
        &["primary phalanx auto"],
    );
    room.refused("bench compare a.json", 2, &["2"]);
}

#[test]
fn what_cannot_be_measured_is_said_with_what_to_do() {
    let room = TestFolder::new();
    for (line, code, part) in [
        (
            "bench a.test --against embree --embree nowhere",
            2,
            "pip install embreex",
        ),
        ("bench a.test --embree nowhere", 2, "--against embree"),
        ("bench a.test --rays sideways", 2, "primary"),
        ("bench --filter no-such-scene", 2, "no-such-scene"),
        ("bench missing.test", 1, "missing.test"),
        ("bench a.test --fail-above 3%", 2, "--baseline"),
        ("bench a.test --baseline missing.json", 1, "missing.json"),
        ("bench compare a.test a.test", 2, "JSON"),
        (
            "bench a.test standard:balls:2 --dump-rays x.rays",
            2,
            "one scene",
        ),
        ("bench a.test --json nowhere/r.json", 1, "nowhere"),
    ] {
        let ran = room.run(line);
        assert_eq!(ran.code, Some(code), "{line}: {}", ran.stderr);
        assert!(ran.stderr.contains(part), "{line}: {}", ran.stderr);
    }
    assert!(room.names().is_empty());
}

/// Parses the documented layout, independently of the writer.
#[test]
fn dumped_rays_can_be_read_by_their_documentation() {
    let room = TestFolder::new();
    let ran = room.run("bench a.test --size 20x10 --rays primary,shadow --dump-rays a.rays");
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(ran.stdout.contains("200 primary"), "{}", ran.stdout);
    let bytes = fs::read(room.path().join("a.rays")).unwrap();
    assert_eq!(&bytes[..8], b"PHXRAYS2");
    assert_eq!(bytes[8..32], [0; 24], "the scene is not moved");
    let word = |offset: usize| u32::from_le_bytes(bytes[offset..offset + 4].try_into().unwrap());
    let number = |offset: usize| f32::from_bits(word(offset));
    assert_eq!(word(32), 2);
    let mut offset = 36;
    for (name, query, tmax) in [("primary", 0, f32::INFINITY), ("shadow", 1, 1.0)] {
        assert_eq!(
            bytes[offset..offset + 16]
                .trim_ascii_end()
                .split(|b| *b == 0)
                .next()
                .unwrap(),
            name.as_bytes()
        );
        assert_eq!((word(offset + 16), number(offset + 20)), (query, tmax));
        let rays = word(offset + 24) as usize;
        assert_eq!(word(offset + 28), 0);
        let (first, ids, t) = (
            offset + 32,
            offset + 32 + 24 * rays,
            offset + 32 + 28 * rays,
        );
        if query == 0 {
            assert_eq!(rays, 200);
            // All start at the eye, with unit directions; what is hit has a distance.
            assert_eq!([0, 4, 8].map(|k| number(first + k)), [0.0, 0.0, 5.0]);
            let length: f32 = [12, 16, 20].map(|k| number(first + k).powi(2)).iter().sum();
            assert!((length - 1.0).abs() < 1e-5);
            let hit = |k: usize| word(ids + 4 * k) != u32::MAX;
            assert!((0..rays).any(hit) && !(0..rays).all(hit));
            assert!((0..rays).all(|k| hit(k) == (number(t + 4 * k) > 0.0)));
        } else {
            assert!((0..rays).all(|k| word(ids + 4 * k) <= 1));
        }
        offset = t + 4 * rays;
    }
    assert_eq!(offset, bytes.len());
}

#[test]
fn heat_is_a_second_picture_with_a_legend() {
    let room = TestFolder::new();
    for kind in ["nodes", "prims", "time"] {
        let ran = room.run(&format!(
            "render standard:balls:2 --size 40x24 --heat {kind} {kind}.png -o a.png"
        ));
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        let heat = phalanx::image::load(&room.path().join(format!("{kind}.png"))).unwrap();
        assert_eq!(heat.width, 40);
        assert!(heat.height > 24);
        let distinct: std::collections::BTreeSet<_> = heat.pixels[..40 * 24].iter().collect();
        assert!(distinct.len() > 1, "{kind} is of one colour");
    }
    let wrong = room.run("render a.test --heat sideways b.png -o c.png");
    assert_eq!(wrong.code, Some(2));
    assert!(
        wrong.stderr.contains("nodes, prims or time"),
        "{}",
        wrong.stderr
    );
    let scalar = room.run("render a.test --heat nodes b.png -o c.png --engine scalar");
    assert_eq!(scalar.code, Some(2));
    assert_eq!(
        room.names(),
        ["a.png", "nodes.png", "prims.png", "time.png"]
    );
}

#[test]
fn reports_go_to_stdout_and_quiet_is_quiet() {
    let room = TestFolder::new();
    let line = format!("bench a.test {FAST} --rays primary --json");
    let json: Value = serde_json::from_str(&room.ok(&format!("{line} -"))).unwrap();
    assert_eq!(json["scenes"][0]["name"], "a.test");
    let html = room.ok(&format!("{line} r.json --html -"));
    assert!(html.starts_with("<!DOCTYPE html>"), "{html}");
    let page = room.ok("bench report r.json r.json -o -");
    assert!(page.starts_with("<!DOCTYPE html>"), "{page}");
    let hashes: Value =
        serde_json::from_str(&room.ok("verify a.test --threads 1 --record -")).unwrap();
    assert!(hashes["scenes"].is_array());
    assert_eq!(
        room.ok(&format!("bench a.test {FAST} -q --baseline r.json")),
        ""
    );
    assert_eq!(room.ok("verify a.test --threads 1 -q"), "");
    room.refused(
        &format!("{line} - --csv -"),
        2,
        &["--json and --csv are the same file"],
    );
    room.refused(
        "render a.test -o a.png --checkpoint -",
        2,
        &["--checkpoint -"],
    );
    room.refused("plan a.test --shards 2 -o a.png --plan -", 2, &["--plan -"]);
    assert!(!room.path().join("-").exists());
}

#[test]
fn a_baseline_of_another_machine_is_refused_before_anything_is_measured() {
    let room = TestFolder::new();
    room.ok(&format!("bench a.test {FAST} --rays primary --json r.json"));
    let other = fs::read_to_string(room.path().join("r.json")).unwrap();
    let cpu = record(&room, "r.json")["machine"]["cpu"].to_string();
    room.write("other.json", &other.replace(&cpu, "\"Imaginary 9000\""));
    for (scene, baseline, why) in [
        ("a.test", "other.json", "another CPU: Imaginary 9000"),
        ("standard:balls:1", "r.json", "no scene in common"),
    ] {
        let line = format!("bench {scene} {FAST} --rays primary --baseline {baseline}");
        let ran = room.run(&line);
        assert_eq!((ran.code, ran.stdout.as_str()), (Some(2), ""), "{line}");
        assert!(ran.stderr.contains(why), "{}", ran.stderr);
    }
    room.ok(&format!(
        "bench a.test {FAST} --rays primary --baseline other.json --force"
    ));
}

#[test]
fn a_record_without_a_file_is_the_output() {
    let room = TestFolder::new();
    let ran = room.run(&format!("bench a.test {FAST} --rays primary --json"));
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let record: Value = serde_json::from_str(&ran.stdout).expect("JSON alone");
    assert_eq!(record["run"].get("partial"), None);
    assert!(ran.stderr.contains("Mrays/s"), "{}", ran.stderr);
    // The option's value would be the record's file, and the scene is one.
    let before = fs::read(room.path().join("a.test")).unwrap();
    room.refused("bench --json a.test", 2, &["a.test", "before --json"]);
    assert_eq!(fs::read(room.path().join("a.test")).unwrap(), before);
}

#[test]
fn records_name_files_without_their_folders() {
    let room = TestFolder::new();
    fs::create_dir(room.path().join("private")).unwrap();
    fs::copy(
        room.path().join("a.test"),
        room.path().join("private/a.test"),
    )
    .unwrap();
    let folder = room.path().join("private").display().to_string();
    room.ok(&format!(
        "bench a.test {folder}/a.test {FAST} --rays primary --csv={folder}/r.csv --json {folder}/r.json --html {folder}/r.html"
    ));
    for file in ["r.json", "r.csv", "r.html"] {
        let text = fs::read_to_string(room.path().join("private").join(file)).unwrap();
        assert!(!text.contains("private"), "{file}");
    }
    let record = record(&room, "private/r.json");
    let arguments = record["run"]["arguments"].as_array().unwrap();
    assert!(
        arguments.contains(&Value::from("--csv=r.csv")),
        "{arguments:?}"
    );
    let names: Vec<&Value> = record["scenes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|s| &s["name"])
        .collect();
    assert_eq!(names, ["a.test", "a.test (2)"]);
}

#[test]
fn each_scene_has_its_camera() {
    let room = TestFolder::new();
    room.ok("build a.test -o a.phx");
    let (near, away) = (
        "--camera 0,0,5 0,0,0 0,1,0 60",
        "--camera 0,0,5 0,0,9 0,1,0 60",
    );
    let hits = |scenes: &str, cameras: &str| -> Vec<u64> {
        room.ok(&format!(
            "bench {scenes} {FAST} --rays primary {cameras} --json r.json"
        ));
        let record = record(&room, "r.json");
        let scenes = record["scenes"].as_array().unwrap().iter();
        scenes
            .map(|scene| scene["rays"]["primary"]["hits"].as_u64().unwrap())
            .collect()
    };
    let own = hits("a.test", "")[0];
    let [near_hits, none] = hits("a.test a.test", &format!("{near} {away}"))[..] else {
        panic!("two scenes")
    };
    assert!(near_hits > 0 && none == 0 && own > 0 && own != near_hits);
    // One is for all, but a cache keeps its own where the others have one each.
    assert_eq!(hits("a.test a.test", near), [near_hits; 2]);
    assert_eq!(hits("a.phx", near), [near_hits]);
    assert_eq!(hits("a.phx a.test", near), [own, near_hits]);
    let three = format!("bench a.test a.test a.test {FAST} {near} {away}");
    room.refused(&three, 2, &["one for each"]);
    // The suite's answers are those of its own camera.
    room.ok(&format!(
        "bench standard:balls:2 --rays primary --repeat 1 --threads 1 {near}"
    ));
}

/// A run that would take an hour.
const ENDLESS: &str = "bench a.test --size 48x32 --repeat 10000 --min-time 3600 --threads 1 --rays primary --json r.json";

#[test]
fn a_run_that_is_ended_keeps_its_rates() {
    let room = TestFolder::new();
    let is_partial = || {
        let record = record(&room, "r.json");
        let rows = record["rows"].as_array().unwrap();
        assert!(!rows.is_empty() && record["run"]["partial"] == true);
        room.ok("bench report r.json -o r.html");
        let page = fs::read_to_string(room.path().join("r.html")).unwrap();
        assert!(page.contains("ended early"));
    };
    let ran = room.run(&format!("{ENDLESS} --time-limit 2"));
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(ran.stdout.contains("partial"), "{}", ran.stdout);
    is_partial();
    for (name, code) in [("INT", 130), ("TERM", 143)] {
        fs::remove_file(room.path().join("r.json")).unwrap();
        let child = room
            .command(ENDLESS)
            .stderr(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_secs(2));
        signal(&child, name);
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{name}: {stderr}");
        assert!(stderr.contains("interrupted: 1 of 1 scenes"), "{stderr}");
        is_partial();
    }
    let ran = room.run(&format!("{ENDLESS} --time-limit 0"));
    assert_eq!(
        (ran.code, ran.stdout.as_str()),
        (Some(2), ""),
        "{}",
        ran.stderr
    );
    assert!(ran.stderr.contains("--time-limit"), "{}", ran.stderr);
}

#[test]
fn reports_of_records_without_a_common_rate_are_refused() {
    let room = TestFolder::new();
    let bench = |scene: &str, rays: &str, name: &str| {
        room.ok(&format!("bench {scene} {FAST} --rays {rays} --json {name}"));
    };
    bench("a.test", "primary", "a.json");
    bench("a.test", "shadow", "b.json");
    bench("standard:balls:1", "primary", "c.json");
    for command in ["report", "compare"] {
        for (records, words) in [
            (
                "a.json c.json",
                [
                    "no scene in common",
                    "a.json: a.test",
                    "c.json: standard:balls:1",
                ],
            ),
            (
                "a.json b.json",
                [
                    "no kind of rays in common",
                    "a.json: primary",
                    "b.json: shadow",
                ],
            ),
        ] {
            let page = if command == "report" { "-o no.html" } else { "" };
            room.refused(&format!("bench {command} {records} {page}"), 2, &words);
        }
    }
    assert!(!room.path().join("no.html").exists());
}

#[test]
fn a_quick_run_has_as_many_scenes_as_its_help_says() {
    let suite = include_str!("../../../perf/suite.toml");
    assert_eq!(suite.matches("quick = true").count(), 8);
    let help = TestFolder::new().ok("bench -h");
    assert!(help.contains("Measure only eight scenes"), "{help}");
}

/// A box of six squares around one of finely divided faces.
fn furnished_room() -> String {
    let mut text = String::new();
    for (lo, size, cells) in [(0.0, 10.0, 1), (1.0, 2.0, 14)] {
        for face in 0..6 {
            for cell in 0..cells * cells {
                for [a, b] in [[0, 0], [1, 0], [1, 1], [0, 1]] {
                    let coordinate = |k: u32| f64::from(k) / f64::from(cells);
                    let mut corner = [
                        coordinate(cell % cells + a),
                        coordinate(cell / cells + b),
                        f64::from(face / 3),
                    ];
                    corner.rotate_right(face as usize % 3);
                    let [x, y, z] = corner.map(|c| lo + c * size);
                    text += &format!("v {x} {y} {z}\n");
                }
                text += "f -4 -3 -2 -1\n";
            }
        }
    }
    text
}

#[test]
fn a_room_seen_from_outside_gets_the_hint_of_render() {
    let room = TestFolder::new();
    room.write("room.obj", &furnished_room());
    let hint = "if this is a room, try a camera inside it: --camera 5.0,5.0,5.0";
    for line in [
        "render room.obj -o a.png --size 40x30",
        &format!("bench room.obj {FAST} --rays primary"),
    ] {
        let ran = room.run(line);
        assert!(
            ran.code == Some(0) && ran.stderr.contains(hint),
            "{line}: {}",
            ran.stderr
        );
    }
}
