//! `--exposure auto` and `--tone`.

use super::headers::{again, text};
use super::view::{ViewProcess, frame, shot, view};
use super::{SCENE, TestFolder};
use serde_json::{Value, json};
use std::fs;

impl TestFolder {
    /// The stops that a report tells.
    fn stops(&self, line: &str) -> f64 {
        let report = self.json(&format!("{line} --exposure auto --json"));
        report["image"]["exposure"].as_f64().expect(line)
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path().join(name)).expect(name)
    }
}

/// The scene without ambient light, with these words in place of others.
fn changed(from: &str, to: &str) -> String {
    assert!(SCENE.contains(from), "{from}");
    let scene = SCENE.replacen(from, to, 1);
    scene.replace("diffuse", "ambient 0 0 0\ndiffuse")
}

#[test]
fn automatic_stops_are_those_of_the_whole_frame_however_it_is_rendered() {
    let room = TestFolder::new();
    let line = "render a.test --size 200x150";
    let stops = room.stops(line);
    assert!(stops != 0.0 && (stops * 64.0).fract() == 0.0, "{stops}");
    for options in [
        "--engine scalar",
        "--kernel packet8",
        "--kernel packet16 --threads 1",
        "--kernel beam8 --threads 2 --tile 8",
        "--kernel beam16 --threads 3",
        "--kernel single --quality fast",
        "--spp 20 --aa adaptive",
        "--region 150 120 9 9",
        "--aov alpha --bits 16 --tone neutral",
        "--transfer srgb --filter mitchell --spp 2 -o a.jpg",
    ] {
        assert_eq!(room.stops(&format!("{line} {options}")), stops, "{options}");
    }
    assert_eq!(room.stops("render a.test --size 400x300"), stops);
    // The picture, which has several bands, is that of these stops to the last byte.
    room.ok(&format!("{line} -o given.png --exposure={stops}"));
    let report = room.ok(&format!("{line} -o auto.png --exposure auto"));
    assert!(
        report.contains(&format!("exposure     {stops} stops")),
        "{report}"
    );
    assert!(room.bytes("auto.png") == room.bytes("given.png"));
    let command = text(&room.bytes("auto.png"), "Comment");
    assert!(
        command.contains(&format!(" --exposure={stops}")),
        "{command}"
    );
    again(&room, &command, "again.png");
    assert!(
        room.bytes("again.png") == room.bytes("auto.png"),
        "{command}"
    );
    // A resumed one, too.
    let resumed = format!("{line} -o kept.png --checkpoint c.ckpt");
    room.ok(&resumed);
    assert_eq!(room.stops(&resumed), stops);
    assert!(room.bytes("kept.png") == room.bytes("auto.png"));
}

#[test]
fn shards_have_the_exposure_of_their_plan() {
    let room = TestFolder::new();
    let options = "--size 200x150 --exposure auto --tone neutral --transfer srgb";
    for more in ["", "--region 100 50 40 60"] {
        room.ok(&format!("render a.test -o whole.png {options} {more}"));
        let plan = format!("plan a.test --shards 3 -o m.png --plan p.json {options} {more} --json");
        room.names()
            .iter()
            .filter(|name| name.ends_with(".tiles"))
            .for_each(|name| {
                fs::remove_file(room.path().join(name)).unwrap();
            });
        let stops = room.json(&plan)["exposure"].as_f64().expect("stops");
        let planned: Value = serde_json::from_slice(&room.bytes("p.json")).unwrap();
        assert_eq!(planned["spec"]["encoding"]["exposure"], json!(stops));
        for shard in 0..3 {
            room.ok(&format!("render --plan p.json --shard {shard}"));
        }
        room.ok("merge p.json");
        assert!(room.bytes("m.png") == room.bytes("whole.png"), "{more}");
        // Another format has the radiance.
        room.ok("merge p.json -o m.exr");
        room.ok(&format!(
            "render a.test -o linear.exr --size 200x150 {more}"
        ));
        room.ok("compare m.exr linear.exr --tolerance 0");
    }
}

#[test]
fn a_sequence_has_the_exposure_of_its_paths_first_frame() {
    let room = TestFolder::new();
    let turn = "--turntable 6 --exposure auto --threads 2";
    let stops = room.stops("render a.test");
    assert_eq!(room.stops("render a.test -o f.png --turntable 6"), stops);
    let own = room.stops("render a.test --camera 4,0,-3 0,0,0 0,1,0 45");
    assert_ne!(own, stops);
    // Frames rendered apart, by shards or by their commands.
    room.ok(&format!("render a.test -o some.png --frames 3..4 {turn}"));
    let plan = format!("plan a.test --shards 2 -o planned.png --plan p.json {turn}");
    room.ok(plan.trim_end_matches(" --threads 2"));
    for shard in 0..2 {
        room.ok(&format!("render --plan p.json --shard {shard}"));
    }
    room.ok("merge p.json");
    for frame in 0..6 {
        let picture = room.bytes(&format!("f.{frame:04}.png"));
        assert!(
            room.bytes(&format!("planned.{frame:04}.png")) == picture,
            "{frame}"
        );
        if (3..5).contains(&frame) {
            assert!(
                room.bytes(&format!("some.{frame:04}.png")) == picture,
                "{frame}"
            );
        }
        let command = text(&picture, "Comment");
        assert!(
            command.contains(&format!("--exposure={stops}")),
            "{command}"
        );
        again(&room, &command, "again.png");
        assert!(room.bytes("again.png") == picture, "{command}");
    }
}

/// Powers of two, which change no other bit.
#[test]
fn the_units_of_lamps_do_not_matter() {
    let room = TestFolder::new();
    let options = "-o a.png --transfer srgb";
    room.write("a.test", &changed("", ""));
    let stops = room.stops(&format!("render a.test {options}"));
    let picture = phalanx::image::load(&room.path().join("a.png")).unwrap();
    let brighter = changed(
        "0.5 0.5 0.5\npoint 3 3 3 0.5 0.4 0.3",
        "1024 1024 1024\npoint 3 3 3 1024 819.2 614.4",
    );
    room.write("b.test", &brighter);
    let brighter = room.stops(&format!("render b.test {options}"));
    assert_eq!(brighter, stops - 11.0);
    let scaled = phalanx::image::load(&room.path().join("a.png")).unwrap();
    let samples = picture.pixels.as_flattened().iter();
    let largest = samples
        .zip(scaled.pixels.as_flattened())
        .map(|(a, b)| a.abs_diff(*b));
    // The lamps' colours are rounded.
    assert!(largest.max() <= Some(257));
}

#[test]
fn lamps_and_backgrounds_in_view_do_not_count() {
    let room = TestFolder::new();
    let matt =
        "ambient 0 0 0\ndirectional 1 1 3 0.5 0.5 0.5\ndiffuse 0.6 0.3 0.2\nsphere -1 0 0 1\n";
    let matt = format!("size 160 120\ncamera 0 0 5 0 0 0 0 1 0 45\n{matt}");
    let lamp = "diffuse 0 0 0\nemission 1e30 1e30 1e30\nsphere 0.4 1 1 0.15\n";
    room.write("matt.test", &matt);
    room.write("lamp.test", &format!("{matt}{lamp}"));
    let stops = room.stops("render matt.test");
    for seen in ["lamp.test", "matt.test --background 1e20,1e20,1e20"] {
        let other = room.stops(&format!("render {seen}"));
        assert!((other - stops).abs() < 0.1, "{seen}: {other} {stops}");
    }
    // A light of 1/2 needs a stop more than a light of 1, and a dark surface no more than another.
    let darker = matt.replace("0.6 0.3 0.2", "0.06 0.06 0.06");
    room.write("darker.test", &darker);
    assert_eq!(room.stops("render darker.test"), stops);
    assert!((0.9..1.2).contains(&stops), "{stops}");
}

#[test]
fn without_light_there_is_no_exposure() {
    let room = TestFolder::new();
    let dark = changed(
        "directional 1 1 1 0.5 0.5 0.5\npoint 3 3 3 0.5 0.4 0.3\n",
        "",
    );
    room.write("dark.test", &dark);
    let away = "a.test --camera 0,0,5 0,0,9 0,1,0 45";
    let ao = "a.test --integrator ao --spp 2";
    for line in ["dark.test --background 0,0,0", away, ao] {
        assert_eq!(room.stops(&format!("render {line}")), 0.0, "{line}");
    }
    let noted = room.run(&format!("render {ao} --exposure auto")).stderr;
    assert!(noted.contains("--exposure auto has no effect"), "{noted}");
    // Lamps beyond all measure: neither black nor white.
    let sun = changed("0.5 0.5 0.5\npoint", "1e30 1e30 1e30\npoint");
    room.write("sun.test", &sun);
    let stops = room.stops("render sun.test -o sun.png --size 80x48 --transfer srgb");
    assert!((-100.0..-98.0).contains(&stops), "{stops}");
    let sun = phalanx::image::load(&room.path().join("sun.png")).unwrap();
    let grey = |pixel: &&[u16; 4]| (0x2000..0xf000).contains(&pixel[0]);
    assert!(sun.pixels.iter().filter(grey).count() > 400);
}

#[test]
fn linear_is_what_pictures_have_by_default() {
    let room = TestFolder::new();
    let load = |options: &str| {
        room.ok(&format!("render a.test -o a.png {options}"));
        room.bytes("a.png")
    };
    let plain = load("");
    assert!(load("--tone linear --exposure 0") == plain);
    assert!(!text(&plain, "Comment").contains("tone"));
    assert!(load("--tone neutral") != plain);
}

/// A page's picture with this exposure and tone, and the camera rays that were traced for it.
fn seen(served: &ViewProcess, exposure: Value, tone: Value) -> (Vec<u8>, u64) {
    let mut rays = 0;
    let mut request = frame("shaded", 0, 4);
    (request["exposure"], request["tone"]) = (exposure, tone);
    loop {
        let reply = served.post("frame", request.clone());
        assert_eq!(reply.status, 200, "{}", reply.head);
        let info: Value = serde_json::from_str(reply.header("Frame")).unwrap();
        rays += info["rays"]["primary"].as_u64().unwrap();
        if info["samples"] == 4 {
            return (reply.body, rays);
        }
        request["have"] = info["samples"].clone();
    }
}

#[test]
fn a_page_changes_exposure_and_tone_of_the_picture_that_is_there() {
    let room = TestFolder::new();
    let served = ViewProcess::start(&room, "view a.test --exposure auto --tone neutral");
    let scene = &served.post("state", json!({})).json()["scene"];
    assert_eq!(scene["exposure"], json!(room.stops("render a.test")));
    assert_eq!(scene["tone"], "neutral");
    let stops = |request: Value| served.post("exposure", request).json()["exposure"].clone();
    let own = stops(shot("shaded", 1));
    let mut page = view();
    (page["eye"], page["center"]) = (json!([4, 0, -3]), json!([0, 0, 0]));
    let mut other = shot("shaded", 1);
    other["view"] = page;
    assert!(own.is_number() && stops(other) != own);
    assert_eq!(stops(shot("ao", 1)), 0.0);
    // Nothing said is what the options say, whatever another page has.
    let (by_options, rays) = seen(&served, json!(null), json!(null));
    assert!(rays >= 40 * 24 * 4, "{rays}");
    let by_options = (by_options, 0);
    let plain = seen(&served, json!(0), json!("linear"));
    assert!(plain.0 != by_options.0 && plain.1 == 0);
    assert!(seen(&served, json!(1), json!("linear")).0 != plain.0);
    assert!(seen(&served, json!(null), json!(null)) == by_options);
    assert!(seen(&served, scene["exposure"].clone(), json!("neutral")) == by_options);
    // A saved picture and its copied command are equal.
    for (exposure, tone) in [
        (json!(-1.25), "neutral"),
        (json!(0), "linear"),
        (own, "linear"),
    ] {
        let mut keep = shot("shaded", 2);
        (keep["exposure"], keep["tone"]) = (exposure.clone(), json!(tone));
        let command = served.post("command", keep.clone()).json()["command"].clone();
        let command = command.as_str().unwrap();
        let is_plain = exposure == json!(0);
        assert_eq!(command.contains("--exposure"), !is_plain, "{command}");
        assert_eq!(command.contains("--tone"), tone == "neutral", "{command}");
        room.ok(command.strip_prefix("phalanx ").unwrap());
        let saved = served.post("save", keep);
        let name = saved.header("Content-Disposition").split('"').nth(1);
        assert!(room.bytes(name.unwrap()) == saved.body, "{command}");
    }
    for (name, wrong) in [("exposure", json!(101)), ("tone", json!("filmic"))] {
        let mut request = frame("shaded", 0, 4);
        request[name] = wrong;
        assert_eq!(served.post("frame", request).status, 400, "{name}");
    }
}
