//! Names of nodes, meshes, materials and cameras, and the choice among cameras.

use super::{File, messages};
use phalanx::formats::{Loaded, Options, Overrides, override_scene, read_bytes};
use phalanx::scene::{Scene, SceneError, object_names};
use serde_json::{Value, json};

fn named(scene: &Scene) -> Vec<String> {
    let names = (0..scene.id_count() as u32).map(|prim| scene.prim_names(prim));
    names
        .map(|names| names.map(|name| name.unwrap_or("-")).join(":"))
        .collect()
}

/// A mesh of two triangles with materials of these names, which look the same.
fn two_materials(names: [Value; 2]) -> File {
    let mut file = File::empty();
    let positions = file.floats(3, &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
    file.json["materials"] = json!(names.map(|name| json!({"name": name})));
    let primitive = |material| json!({"attributes": {"POSITION": positions}, "material": material});
    let primitives = [0, 1].map(primitive);
    file.json["meshes"] = json!([{"name": "mesh", "primitives": primitives}]);
    file
}

#[test]
fn a_node_names_all_that_it_shows() {
    let mut file = two_materials([json!("red"), json!("rouge")]);
    file.node(json!({"mesh": 0, "name": "cup"}));
    let scene = file.loaded().scene;
    assert_eq!(named(&scene), ["cup:red", "cup:rouge"]);
    assert_eq!(scene.materials.len(), 1);
    assert_eq!(object_names(&scene).collect::<Vec<_>>(), ["cup"]);
    let mut file = two_materials([json!("red"), json!("rouge")]);
    file.node(json!({"mesh": 0}));
    assert_eq!(named(&file.loaded().scene), ["mesh:red", "mesh:rouge"]);
}

#[test]
fn instances_have_names_of_their_own() {
    let mut file = two_materials([json!("red"), json!("")]);
    for node in [
        json!({"mesh": 0, "name": "left"}),
        json!({"mesh": 0, "name": "right", "translation": [3, 0, 0]}),
        json!({"mesh": 0, "translation": [6, 0, 0]}),
        // A map without an inverse is baked.
        json!({"mesh": 0, "name": "flat", "scale": [1, 1, 0]}),
    ] {
        file.node(node);
    }
    let scene = file.loaded().scene;
    let stored = ["-:red", "-:-", "flat:red", "flat:-"];
    let shown = [
        "left:red",
        "left:-",
        "right:red",
        "right:-",
        "mesh:red",
        "mesh:-",
    ];
    assert_eq!(named(&scene), [&stored[..], &shown].concat());
    let objects: Vec<String> = object_names(&scene).collect();
    assert_eq!(objects, ["flat", "left", "right", "mesh"]);
    assert_eq!(scene.name_sizes()[1], [("red", 4)]);
}

/// Nothing depends on a name, so nothing that stands in its place is an error.
#[test]
fn a_name_can_be_anything() {
    for (name, want) in [
        (r#""a\u0000\u001b\"é""#, "a\0\u{1b}\"é:-"),
        (r#""\ud800""#, "-:-"),
        ("7", "-:-"),
        ("null", "-:-"),
        (r#"{"a": [1]}"#, "-:-"),
        (r#""  ""#, "-:-"),
    ] {
        let mut file = File::triangle();
        file.json["nodes"][0]["name"] = json!("NAME");
        for (integer, number) in [("5126", "5126"), ("5126", "5126.0")] {
            let text = file
                .text()
                .replace("\"NAME\"", name)
                .replace(integer, number);
            let loaded = read_bytes("gltf", text.as_bytes(), &Options::default()).unwrap();
            let loaded = loaded.unwrap_or_else(|errors| panic!("{name}: {errors:?}"));
            assert_eq!(named(&loaded.scene), [want], "{name} {number}");
        }
    }
}

#[test]
fn messages_name_rows() {
    let mut file = File::triangle();
    file.json["meshes"][0]["name"] = json!("cup\u{1b}");
    file.json["meshes"][0]["primitives"][0]["mode"] = json!(9);
    assert_eq!(
        file.refused(),
        ["meshes[0] `cup\\u{1b}`: primitives[0]: there is no mode 9"]
    );
}

/// A triangle before cameras of these fields of view, whose nodes have these names.
fn cameras(names: &[(&str, f64)]) -> File {
    let mut file = File::triangle();
    file.json["cameras"] = json!([]);
    for (name, yfov) in names {
        let camera = json!({"type": "perspective", "perspective": {"yfov": yfov, "znear": 1, "aspectRatio": yfov}});
        let camera = file.add("cameras", camera);
        file.node(json!({"camera": camera, "name": name, "translation": [0, 0, 5]}));
    }
    file
}

fn read(file: &File, camera: Option<&str>) -> Result<Loaded, Vec<String>> {
    let options = Options {
        look: Overrides {
            camera: camera.map(str::to_owned),
            ..Overrides::default()
        },
        ..Options::default()
    };
    let read = read_bytes("gltf", file.text().as_bytes(), &options).unwrap();
    read.map_err(|errors| errors.into_iter().map(|error| error.message).collect())
}

#[test]
fn a_camera_is_chosen_by_name_or_else_by_number() {
    let mut file = cameras(&[
        ("A", 0.5),
        ("1", 0.75),
        ("", 1.0),
        ("A", 1.25),
        ("bad", 0.0),
    ]);
    file.json["cameras"][2]["name"] = json!("own");
    let chosen = |choice: Option<&str>| {
        let loaded = read(&file, choice).unwrap();
        assert_eq!(
            messages(&loaded.warnings),
            ["the camera is left out: it has no direction or no field of view"]
        );
        let scene = loaded.scene;
        assert_eq!(scene.cameras.len(), 4);
        let width = (f64::from(scene.view.fovy).to_radians() * 960.0).round();
        assert_eq!(f64::from(scene.width), width);
        scene.used_camera().unwrap()
    };
    let choice = [
        None,
        Some("A"),
        Some("1"),
        Some("0"),
        Some("2"),
        Some("own"),
        Some(" 3 "),
    ];
    assert_eq!(choice.map(chosen), [0, 0, 1, 0, 2, 2, 3]);
    let refused = read(&file, Some("B\u{1b}")).unwrap_err();
    let known = "the cameras are `A` (0), `1` (1), `own` (2), `A` (3)";
    assert_eq!(
        refused,
        [format!("no camera is called `B\\u{{1b}}`: {known}")]
    );
    let none = read(&File::triangle(), Some("0")).unwrap_err();
    assert_eq!(
        none,
        ["no camera is called `0`: the scene has no cameras to choose from"]
    );
    let many = cameras(&[("x", 0.5); 30]);
    let refused = read(&many, Some("y")).unwrap_err().concat();
    assert!(refused.ends_with("`x` (11) and 18 more"), "{refused}");
}

#[test]
fn several_cameras_are_noted() {
    let note = |file: &File, camera| {
        let notes = read(file, camera).unwrap().notes;
        notes.into_iter().find(|note| note.contains("cameras"))
    };
    let two = cameras(&[("A", 0.5), ("", 0.75)]);
    let expected = "the file has 2 cameras: `A` (0) is used, not 1 (see --camera-name)";
    assert_eq!(note(&two, None).as_deref(), Some(expected));
    assert_eq!(note(&two, Some("1")), None);
    assert_eq!(note(&cameras(&[("A", 0.5)]), None), None);
}

/// A finished scene, such as that of a cache, has the view and the shape of any of its cameras.
#[test]
fn a_finished_scene_takes_another_camera() {
    let mut file = cameras(&[("A", 0.5), ("B", 0.75)]);
    let magnified = json!({"type": "orthographic", "orthographic": {"xmag": 3, "ymag": 2, "zfar": 9, "znear": 1}});
    let camera = file.add("cameras", magnified);
    file.node(json!({"camera": camera, "name": "C", "translation": [1e10, 0, 5]}));
    for choice in ["0", "B", "C"] {
        let fresh = read(&file, Some(choice)).unwrap().scene;
        for built_with in [None, Some("B"), Some("C")] {
            let mut scene = read(&file, built_with).unwrap().scene;
            let wide = Overrides {
                size: Some((300, 100)),
                ..Overrides::default()
            };
            let overrides = Overrides {
                camera: Some(choice.to_owned()),
                ..wide.clone()
            };
            let taken = override_scene(&mut scene, &overrides, 0);
            if matches!(taken, Err(SceneError::TooFar(_))) {
                assert!(choice == "C" && built_with != Some("C"));
                continue;
            }
            assert_eq!(
                (scene.width, scene.used_camera()),
                (fresh.width, fresh.used_camera())
            );
            let mut want = fresh.clone();
            override_scene(&mut want, &wide, 0).unwrap();
            if scene.scale == want.scale {
                assert_eq!(scene.view, want.view, "{choice} {built_with:?}");
            }
        }
    }
}
