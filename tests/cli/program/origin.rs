//! Scenes far from the origin of their coordinates: input and output of positions, and everything
//! that stores the origin.

use super::TestFolder;
use serde_json::json;
use std::fs;

/// A box over a floor around x = 500000.25, z = -4012345.5.
const PLACE: [f64; 3] = [500_000.25, 0.0, -4_012_345.5];
const VIEW: [[f64; 3]; 2] = [[6.1, 8.0, 12.3], [0.2, 1.0, 0.0]];
const LIGHT: [f64; 3] = [4.1, 9.0, 5.2];

/// The scene with its coordinates' origin at the centre of the floor or far away; decimals are
/// exact either way.
fn obj(point: [f64; 3]) -> String {
    let mut text = String::new();
    for (x, y, z) in [
        (-5, 0, -5),
        (5, 0, -5),
        (5, 0, 5),
        (-5, 0, 5),
        (-1, 0, -1),
        (1, 0, -1),
        (1, 2, -1),
        (-1, 2, -1),
        (-1, 0, 1),
        (1, 0, 1),
        (1, 2, 1),
        (-1, 2, 1),
    ] {
        let [x, y, z] = [x, y, z].map(f64::from);
        text += &format!("v {} {} {}\n", point[0] + x, point[1] + y, point[2] + z);
    }
    let faces = [
        "4 3 2 1",
        "5 8 7 6",
        "9 10 11 12",
        "5 6 10 9",
        "6 7 11 10",
        "7 8 12 11",
        "8 5 9 12",
    ];
    text + &faces.map(|face| format!("f {face}\n")).concat()
}

fn words([x, y, z]: [f64; 3], point: [f64; 3], between: &str) -> String {
    format!(
        "{}{between}{}{between}{}",
        x + point[0],
        y + point[1],
        z + point[2]
    )
}

fn given(point: [f64; 3]) -> String {
    let [eye, center] = VIEW.map(|position| words(position, point, ","));
    let light = words(LIGHT, point, ",");
    format!("--camera {eye} {center} 0,1,0 40 --light {light} --size 64x48 --threads 1")
}

fn room() -> TestFolder {
    let room = TestFolder::new();
    room.write("near.obj", &obj([0.0; 3]));
    room.write("far.obj", &obj(PLACE));
    room
}

fn bytes(room: &TestFolder, name: &str) -> Vec<u8> {
    fs::read(room.path().join(name)).unwrap()
}

#[test]
fn the_picture_is_that_of_the_scene_at_the_origin() {
    let room = room();
    room.ok(&format!("render near.obj -o near.pfm {}", given([0.0; 3])));
    let near = bytes(&room, "near.pfm");
    // The automatic origin is next to the floor's centre, so single precision may round
    // differently; this one is at the centre.
    let place = words([0.0; 3], PLACE, ",");
    room.ok(&format!(
        "render far.obj -o far.pfm --origin {place} {}",
        given(PLACE)
    ));
    assert!(
        bytes(&room, "far.pfm") == near,
        "with its origin at the floor's middle"
    );
    room.ok(&format!("render far.obj -o auto.png {}", given(PLACE)));
    room.ok(&format!("render near.obj -o near.png {}", given([0.0; 3])));
    let [auto, near] = ["auto.png", "near.png"].map(|name| {
        phalanx::image::load(&room.path().join(name))
            .unwrap()
            .pixels
    });
    let pixels = auto.iter().zip(&near);
    let differing = pixels.filter(|(a, b)| a != b).count();
    assert!(differing <= 3, "{differing} of 3072 pixels");
    room.ok(&format!(
        "render far.obj -o none.pfm --origin none {}",
        given(PLACE)
    ));
    assert!(bytes(&room, "none.pfm") != bytes(&room, "far.pfm"));
}

#[test]
fn the_move_is_told_in_words_and_numbers_and_bounds_are_the_files() {
    let room = room();
    let ran = room.run("info far.obj");
    assert!(
        ran.stderr
            .contains("moved to a local origin: 500000, 0, -4012344"),
        "{}",
        ran.stderr
    );
    assert!(
        ran.stdout
            .contains("moved to a local origin: 500000, 0, -4012344\n"),
        "{}",
        ran.stdout
    );
    assert!(
        ran.stdout
            .contains("(499995.25, 0, -4012350.5) to (500005.25, 2, -4012340.5)")
    );
    let info = room.json("info far.obj --json");
    assert_eq!(info["origin"], json!([500_000.0, 0.0, -4_012_344.0]));
    assert_eq!(info["bounds"]["hi"], json!([500_005.25, 2.0, -4_012_340.5]));
    let near = room.json("info near.obj --json");
    assert_eq!(near["origin"], json!([0.0, 0.0, 0.0]));
    let line = format!("render far.obj -o far.png {}", given(PLACE));
    assert!(
        room.ok(&format!("{line} -v"))
            .contains("moved to a local origin: 500000, 0, -4012344\n")
    );
    assert_eq!(
        room.json(&format!("{line} --json"))["origin"],
        info["origin"]
    );
    room.refused(
        "info far.obj --origin 1,2",
        2,
        &["expected auto, none, or three numbers"],
    );
}

#[test]
fn a_cache_keeps_the_origin() {
    let room = room();
    room.ok("build far.obj -o far.phx");
    let line = |name: &str, out: &str| format!("render {name} -o {out} {}", given(PLACE));
    room.ok(&line("far.obj", "a.pfm"));
    room.ok(&line("far.phx", "b.pfm"));
    assert!(bytes(&room, "a.pfm") == bytes(&room, "b.pfm"));
    let [file, cache] =
        ["far.obj", "far.phx"].map(|name| room.json(&format!("info {name} --json")));
    for key in ["origin", "bounds"] {
        assert_eq!(cache[key], file[key], "{key}");
    }
    let ran = room.run("info far.phx --origin none");
    assert!(
        ran.stderr.contains("--origin has no effect"),
        "{}",
        ran.stderr
    );
}

#[test]
fn key_frames_are_in_the_files_coordinates() {
    let room = room();
    let keys = |point: [f64; 3]| {
        let [eye, center] = VIEW.map(|position| words(position, point, " "));
        let later = words([-3.0, 9.0, 8.0], point, " ");
        format!("0 {eye} {center} 0 1 0 40\n4 {later} {center} 0 1 0 40\n")
    };
    room.write("near.keys", &keys([0.0; 3]));
    room.write("far.keys", &keys(PLACE));
    let place = words([0.0; 3], PLACE, ",");
    for (name, point, origin) in [("near", [0.0; 3], "none"), ("far", PLACE, &place[..])] {
        room.ok(&format!(
            "render {name}.obj -o {name}#.pfm --origin {origin} --frames 0..2 --keyframes {name}.keys {}",
            given(point)
        ));
    }
    for frame in 0..3 {
        let [near, far] = ["near", "far"].map(|name| bytes(&room, &format!("{name}{frame}.pfm")));
        assert!(near == far, "frame {frame}");
    }
}

#[test]
fn plans_and_checkpoints_tell_scenes_of_another_origin_apart() {
    let room = room();
    let line = format!(
        "render far.obj -o a.png --checkpoint a.tiles {}",
        given(PLACE)
    );
    room.ok(&line);
    room.refused(
        &format!("{line} --origin none"),
        2,
        &["the scene's local origin is 500000,0,-4012344 there and 0,0,0 here"],
    );
    // An exact place in which decimals end late survives the plan's text.
    let origin = "--origin 500000.1,0,-4012345.700000001";
    let out = "-o merged.exr --aov position --shards 2";
    room.ok(&format!(
        "plan far.obj --plan p.json {out} {origin} {}",
        given(PLACE).replace(" --threads 1", "")
    ));
    for shard in 0..2 {
        room.ok(&format!("render --plan p.json --shard {shard}"));
    }
    room.ok("merge p.json");
    room.ok(&format!(
        "render far.obj -o whole.exr --aov position {origin} {}",
        given(PLACE)
    ));
    assert!(bytes(&room, "merged.exr") == bytes(&room, "whole.exr"));
    let plan = fs::read_to_string(room.path().join("p.json")).unwrap();
    room.write("older.json", &plan.replace("\"origin\"", "\"other\""));
    room.refused(
        "render --plan older.json --shard 0",
        1,
        &["not a plan", "origin"],
    );
}

#[test]
fn dumped_rays_say_where_their_coordinates_begin() {
    let room = room();
    room.ok("bench far.obj --size 8x8 --rays primary --dump-rays a.rays");
    let bytes = bytes(&room, "a.rays");
    let axis = |k: usize| f64::from_le_bytes(bytes[8 + 8 * k..16 + 8 * k].try_into().unwrap());
    assert_eq!([0, 1, 2].map(axis), [500_000.0, 0.0, -4_012_344.0]);
}

/// The first sample of a channel of an OpenEXR file.
fn samples(room: &TestFolder, name: &str, channel: &str) -> Vec<f32> {
    use exr::prelude::{ReadChannels, ReadLayers};
    let image = exr::image::read::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(room.path().join(name))
        .unwrap();
    let channels = image.layer_data.channel_data.list;
    let channel_of_file = channels
        .iter()
        .find(|channel_of_file| channel_of_file.name.eq(channel))
        .unwrap();
    channel_of_file.sample_data.values_as_f32().collect()
}

#[test]
fn positions_of_a_picture_keep_their_digits_beside_its_origin() {
    let room = room();
    for (name, position) in [("near", [0.0; 3]), ("far", PLACE)] {
        let options = given(position);
        room.ok(&format!(
            "render {name}.obj -o {name}.exr --aov P {options}"
        ));
    }
    let origin = b"500000 0 -4012344";
    assert!(memchr::memmem::find(&bytes(&room, "far.exr"), origin).is_some());
    assert!(memchr::memmem::find(&bytes(&room, "near.exr"), b"phalanx.origin").is_none());
    let shift = [0.25, 0.0, -1.5];
    for (axis, channel) in ["P.X", "P.Y", "P.Z"].into_iter().enumerate() {
        let [near, far] = ["near.exr", "far.exr"].map(|name| samples(&room, name, channel));
        let hits = near.iter().zip(&far).filter(|(near, _)| **near != 0.0);
        let errors = hits.map(|(near, far)| (near + shift[axis] - far).abs());
        let mut errors: Vec<f32> = errors.collect();
        errors.sort_by(f32::total_cmp);
        // Pixels at edges may see another face.
        let most = errors[errors.len() * 99 / 100];
        assert!(most < 1e-4, "{channel}: {most}");
    }
}
