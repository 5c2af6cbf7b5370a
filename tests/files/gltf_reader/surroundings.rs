//! Cameras and lights.

use super::{File, messages};
use glam::Vec3;
use phalanx::formats::{Loaded, Options, Overrides, read_bytes};
use phalanx::scene::View;
use serde_json::{Value, json};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

fn near(a: Vec3, b: Vec3) {
    assert!((a - b).abs().max_element() < 1e-6, "{a} is not {b}");
}

/// A triangle and a camera at a node.
fn seen(camera: Value, node: Value) -> Loaded {
    let mut file = File::triangle();
    file.json["cameras"] = json!([camera]);
    let mut node = node;
    node["camera"] = json!(0);
    file.node(node);
    file.loaded()
}

fn perspective() -> Value {
    json!({"type": "perspective", "perspective": {"yfov": FRAC_PI_2, "znear": 1}})
}

fn orthographic(xmag: f64, ymag: f64) -> Value {
    json!({"type": "orthographic", "orthographic": {"xmag": xmag, "ymag": ymag, "zfar": 2, "znear": 1}})
}

fn direction(view: &View) -> Vec3 {
    (view.center - view.eye).normalize()
}

#[test]
fn the_first_camera_is_the_view() {
    let mut file = File::triangle();
    let mut first = perspective();
    first["perspective"]["aspectRatio"] = json!(2);
    file.json["cameras"] = json!([orthographic(1.0, 1.0), first]);
    // Turned about y by 90 degrees: looks along −x.
    let turn = 0.5f64.sqrt();
    file.node(json!({"camera": 1, "translation": [7, 0, 0], "rotation": [0, turn, 0, turn]}));
    file.node(json!({"camera": 0}));
    let loaded = file.loaded();
    let view = loaded.scene.view;
    assert_eq!(
        (view.eye, view.fovy, view.ortho),
        (Vec3::new(7., 0., 0.), 90.0, None)
    );
    near(direction(&view), Vec3::NEG_X);
    near(view.up, Vec3::Y);
    assert_eq!((loaded.scene.width, loaded.scene.height), (1920, 960));
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
}

/// Width of the picture, and visible height, for half a width and half a height of the file.
fn visible(xmag: f64, ymag: f64) -> Option<(u32, f32)> {
    let loaded = seen(orthographic(xmag, ymag), json!({"translation": [0, 0, 4]}));
    let (scene, view) = (&loaded.scene, loaded.scene.view);
    let ortho = view.ortho?;
    near(view.eye, Vec3::new(0.0, 0.0, 4.0));
    near(direction(&view), Vec3::NEG_Z);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    assert!(view.basis().is_ok() && scene.height == 960);
    Some((scene.width, ortho))
}

#[test]
fn an_orthographic_camera_shows_its_width_and_height() {
    assert_eq!(visible(1.5, 1.5), Some((960, 3.0)));
    assert_eq!(visible(3.0, 1.5), Some((1920, 3.0)));
    assert_eq!(visible(0.75, 1.5), Some((480, 3.0)));
    // Negative ones would turn the picture over.
    assert_eq!(visible(-1.5, -1.5), Some((960, 3.0)));
    // Pictures have bounds of their shape, within which all of it is to be seen.
    assert_eq!(visible(200.0, 1.0), Some((9600, 40.0)));
    assert_eq!(visible(0.01, 1.0), Some((96, 2.0)));
    let none = seen(orthographic(1.0, 0.0), json!({}));
    assert_eq!(none.scene.view.ortho, None, "the camera that is made up");
    assert!(messages(&none.warnings)[0].contains("left out"));
}

#[test]
fn pictures_of_other_shapes_show_all_of_a_parallel_view() {
    let mut file = File::triangle();
    file.json["cameras"] = json!([orthographic(3.0, 1.5)]);
    file.node(json!({"camera": 0}));
    let visible = |size: (u32, u32)| {
        let options = Options {
            look: Overrides {
                size: Some(size),
                ..Overrides::default()
            },
            ..Options::default()
        };
        let loaded = read_bytes("gltf", file.text().as_bytes(), &options);
        loaded
            .expect("an ending")
            .expect("a scene")
            .scene
            .view
            .ortho
    };
    assert_eq!(visible((200, 100)), Some(3.0));
    assert_eq!(visible((400, 100)), Some(3.0), "wider");
    assert_eq!(visible((100, 100)), Some(6.0), "narrower");
    assert_eq!(visible((100, 200)), Some(12.0));
}

/// The format: the scale of a camera's node is ignored.
#[test]
fn scaled_and_mirrored_cameras_look_along_their_axes() {
    let view_of = |node: Value| seen(perspective(), node).scene.view;
    let scaled = view_of(json!({"scale": [2, 3, 4], "translation": [0, 0, 9]}));
    near(direction(&scaled), Vec3::NEG_Z);
    near(scaled.up, Vec3::Y);
    let parallel = seen(orthographic(1.0, 1.0), json!({"scale": [5, 5, 5]}));
    assert_eq!(parallel.scene.view.ortho, Some(2.0));
    let mirrored = view_of(json!({"scale": [-1, 1, 1]}));
    near(direction(&mirrored), Vec3::NEG_Z);
    near(mirrored.up, Vec3::Y);
    let turned = view_of(json!({"scale": [1, 1, -1]}));
    near(direction(&turned), Vec3::Z);
    let over = view_of(json!({"matrix": [-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, 1, 2, 3, 1]}));
    near(direction(&over), Vec3::Z);
    near(over.up, Vec3::NEG_Y);
    // One axis is gone, and the two others still say where the camera looks.
    for flat in [json!([1, 1, 0]), json!([1, 0, 1]), json!([0, 1, 1])] {
        let view = view_of(json!({"scale": flat, "translation": [0, 0, 9]}));
        near(direction(&view), Vec3::NEG_Z);
        near(view.up, Vec3::Y);
    }
    let nowhere = seen(perspective(), json!({"scale": [0, 0, 0]}));
    assert!(messages(&nowhere.warnings)[0].contains("left out"));
    assert!(nowhere.scene.view.basis().is_ok());
}

fn lit(lights: Value) -> Loaded {
    let mut file = File::triangle();
    let count = lights.as_array().unwrap().len();
    file.json["extensions"] = json!({"KHR_lights_punctual": {"lights": lights}});
    for k in 0..count {
        file.node(json!({"translation": [0.5, 0.5, 2], "extensions": {"KHR_lights_punctual": {"light": k}}}));
    }
    file.loaded()
}

#[test]
fn lights() {
    let loaded = lit(json!([
        {"type": "directional", "intensity": 2, "color": [1, 0.5, 0]},
        {"type": "point", "intensity": 4},
    ]));
    let lights = &loaded.scene.lights;
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    assert_eq!(*lights.directional, [true, false]);
    assert_eq!(
        (lights.position.get(0), lights.position.get(1)),
        (Vec3::Z, Vec3::new(0.5, 0.5, 2.0))
    );
    let pi = std::f32::consts::PI;
    near(lights.color.get(0), Vec3::new(2.0, 1.0, 0.0) / pi);
    near(lights.color.get(1), Vec3::splat(4.0) / pi);
    assert_eq!(lights.attenuation.get(1), Vec3::Z);
}

#[test]
fn a_range_is_not_shown() {
    let warning_of = |range: Value| {
        let mut lamp = json!({"type": "point", "intensity": 4});
        lamp["range"] = range;
        let loaded = lit(json!([lamp, lamp]));
        near(
            loaded.scene.lights.color.get(0),
            Vec3::splat(4.0 / std::f32::consts::PI),
        );
        loaded.warnings.into_iter().map(|w| w.message).collect()
    };
    let warning_of: [Vec<String>; 3] = [json!(3), json!("far"), Value::Null].map(warning_of);
    let ranges = vec!["not shown: ranges of lights".to_owned()];
    assert_eq!(warning_of, [ranges.clone(), ranges, Vec::new()]);
}

#[test]
fn lights_of_another_exposure_are_scaled_alike() {
    let loaded = lit(json!([
        {"type": "directional", "intensity": 30_000},
        {"type": "directional", "intensity": 10_000},
    ]));
    near(loaded.scene.lights.color.get(0), Vec3::splat(0.75));
    near(loaded.scene.lights.color.get(1), Vec3::splat(0.25));
    assert!(messages(&loaded.warnings)[0].contains("scaled"));
}

#[test]
fn spot_lights_have_a_cone() {
    let loaded = lit(json!([
        {"type": "spot", "intensity": 4, "spot": {"innerConeAngle": 0.25, "outerConeAngle": 0.5}},
        {"type": "spot", "intensity": 4, "spot": {}},
        {"type": "spot", "intensity": 4},
        {"type": "spot", "intensity": 4, "spot": {"innerConeAngle": 3, "outerConeAngle": 2}},
        {"type": "spot", "intensity": 4, "spot": {"innerConeAngle": -1, "outerConeAngle": 0}},
        {"type": "point", "intensity": 4},
    ]));
    let lights = &loaded.scene.lights;
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    near(lights.color.get(0), Vec3::splat(4.0 / std::f32::consts::PI));
    assert_eq!(lights.attenuation.get(0), Vec3::Z);
    near(lights.axis.get(0), Vec3::NEG_Z);
    assert!((0..5).all(|light| lights.is_spot(light)) && !lights.is_spot(5));
    // The share of the light at an angle, before it is squared.
    let share = |light: usize, angle: f32| {
        let share = angle.cos() * lights.cone.x[light] + lights.cone.y[light];
        share.clamp(0.0, 1.0)
    };
    assert_eq!((share(0, 0.2), share(0, 0.6)), (1.0, 0.0));
    assert!(share(0, 0.4) > 0.1 && share(0, 0.4) < 0.9);
    for light in [1, 2] {
        assert!(share(light, 0.0) > 0.999 && share(light, FRAC_PI_4) < 1e-6);
        assert!(share(light, 0.5) > 0.1 && share(light, 0.5) < 0.9);
    }
    // Impossible angles become the nearest possible ones.
    assert_eq!((share(3, 1.5), share(3, 1.6)), (1.0, 0.0));
    assert_eq!(share(4, 0.01), 0.0);
    assert!((0..5).all(|light| lights.cone.x[light].is_finite()));
}

#[test]
fn a_light_shines_along_its_node() {
    let mut file = File::triangle();
    file.json["extensions"] =
        json!({"KHR_lights_punctual": {"lights": [{"type": "spot", "intensity": 4}]}});
    let turn = 0.5f64.sqrt();
    let light = json!({"KHR_lights_punctual": {"light": 0}});
    file.node(json!({"rotation": [-turn, 0, 0, turn], "extensions": light}));
    let scene = file.loaded().scene;
    near(scene.lights.axis.get(0), Vec3::NEG_Y);
}
