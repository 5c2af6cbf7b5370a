//! Lux, candela and nits: lamps beside emission, before and after their common scale.

use super::{File, base64, messages};
use crate::common::frames::frame_of;
use glam::{DVec3, Vec3};
use phalanx::bvh::Bvh;
use phalanx::cache::{self, fingerprint};
use phalanx::formats::{AddedLight, Loaded, Options, Overrides, override_scene, read_bytes};
use phalanx::frame::{Accel, Engine, Sampling, Settings};
use serde_json::{Value, json};
use std::f32::consts::PI;
use std::path::Path;

/// Number of triangles in the row: of white paint, of a constant glow, of a
/// textured one, and of unlit paint.
const PLACES: usize = 4;
/// Nits of the constant glow, and of the textured one before its texture.
const NITS: [f32; 2] = [0.5, 0.75];

/// Four triangles in a row, facing a camera with parallel rays. The first is lit by the lamp; all
/// light is multiplied by `times`.
fn row_of_triangles(lamp: Value, place: Value, times: f32) -> File {
    let mut file = File::empty();
    let white = json!({"baseColorFactor": [1, 1, 1, 1], "metallicFactor": 0});
    // No highlight: a Lambert surface.
    let matt = json!({"KHR_materials_ior": {"ior": 1}});
    let glow = |nits: f32, mut material: Value| {
        material["pbrMetallicRoughness"] = json!({"baseColorFactor": [0, 0, 0, 1]});
        material["emissiveFactor"] = json!([1, 1, 1]);
        material["extensions"] =
            json!({"KHR_materials_emissive_strength": {"emissiveStrength": nits * times}});
        material
    };
    file.json["materials"] = json!([
        {"pbrMetallicRoughness": white, "extensions": matt},
        glow(NITS[0], json!({})),
        glow(NITS[1], json!({"emissiveTexture": {"index": 0}})),
        {"pbrMetallicRoughness": {"baseColorFactor": [0.25, 0.25, 0.25, 1]},
         "extensions": {"KHR_materials_unlit": {}}},
    ]);
    let picture = base64(include_bytes!("two.png"));
    file.json["images"] = json!([{"uri": format!("data:image/png;base64,{picture}")}]);
    file.json["textures"] = json!([{"source": 0}]);
    let uvs = file.floats(2, &[0.25; 6]);
    for k in 0..PLACES {
        let x = 2.0 * k as f32;
        let positions = file.floats(3, &[x, 0., 0., x + 1., 0., 0., x, 1., 0.]);
        let attributes = json!({"POSITION": positions, "TEXCOORD_0": uvs});
        let mesh = file.mesh(json!({"attributes": attributes, "material": k}));
        file.node(json!({"mesh": mesh}));
    }
    let size = json!({"xmag": 4, "ymag": 0.5, "zfar": 9, "znear": 0.1});
    file.json["cameras"] = json!([{"type": "orthographic", "orthographic": size}]);
    file.node(json!({"camera": 0, "translation": [4, 0.5, 1]}));
    file.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [lamp]}});
    let mut node = place;
    node["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
    file.node(node);
    file
}

fn options(lights: &[AddedLight]) -> Options {
    Options {
        look: Overrides {
            lights: lights.to_vec(),
            size: Some((64, 8)),
            ..Overrides::default()
        },
        ..Options::default()
    }
}

fn read(file: &File, lights: &[AddedLight]) -> Loaded {
    let loaded = read_bytes("gltf", file.text().as_bytes(), &options(lights));
    loaded.expect("a known ending").expect("a scene")
}

/// The red of each triangle, in a picture of 8 pixels a unit.
fn shown(loaded: &mut Loaded) -> [f32; PLACES] {
    let scene = &mut loaded.scene;
    (scene.width, scene.height) = (64, 8);
    let settings = Settings {
        sampling: Sampling::CENTER,
        ..Settings::of(scene)
    };
    let accel = Accel::build(scene, Engine::Simd);
    let film = frame_of(scene, &accel, settings).film;
    // Row 5 is at y = 0.3125, and column 1 at x = 0.1875.
    [0, 1, 2, 3].map(|k| film.planes[0][5 * 64 + 16 * k + 1])
}

const AT: Vec3 = Vec3::new(0.1875, 0.3125, 0.0);

/// A lamp of each kind, its node, and the lux that reach the white pixel.
fn lamps(times: f32) -> [(Value, Value, f32); 3] {
    let above = json!({"translation": [0.5, 0.5, 4]});
    let to = Vec3::new(0.5, 0.5, 4.0) - AT;
    let lux = 120.0 * (to.z / to.length()) / to.length_squared();
    let cone = json!({"innerConeAngle": 0.5, "outerConeAngle": 0.6});
    // Turned by 60° about y.
    let slanted = json!({"rotation": [0, 0.5, 0, 0.75f32.sqrt()]});
    [
        (
            json!({"type": "directional", "intensity": 6.0 * times}),
            slanted,
            3.0,
        ),
        (
            json!({"type": "point", "intensity": 120.0 * times}),
            above.clone(),
            lux,
        ),
        (
            json!({"type": "spot", "intensity": 120.0 * times, "spot": cone}),
            above,
            lux,
        ),
    ]
}

/// Ka of white paint, which no lamp scales.
const AMBIENT: f32 = 0.1;

#[test]
fn lamps_and_emission_keep_their_ratio() {
    let near = |is: f32, wanted: f32| {
        assert!((is / wanted - 1.0).abs() < 1e-4, "{is}, wanted {wanted}");
    };
    for times in [1.0, 1e3, 1e-3, 1e9] {
        for (lamp, place, lux) in lamps(times) {
            let mut loaded = read(&row_of_triangles(lamp, place, times), &[]);
            let warnings = messages(&loaded.warnings);
            let scaled = warnings
                .iter()
                .any(|line| line.contains("lights and emission are scaled"));
            assert_eq!(scaled, times != 1.0, "{warnings:?}");
            let scale = loaded.scene.light_scale;
            assert_eq!(scale != 1.0, scaled);
            let [white, glow, textured, unlit] = shown(&mut loaded);
            near(white - AMBIENT, lux * times / PI * scale);
            near(glow, NITS[0] * times * scale);
            near(textured, NITS[1] * times * scale);
            near((white - AMBIENT) / glow, lux / PI / NITS[0]);
            // A colour, and no light.
            assert_eq!(unlit, 0.25);
        }
    }
}

/// Lamps of the command have no units, and so nothing that stands beside them is scaled.
#[test]
fn other_lamps_bring_emission_back() {
    let (lamp, place, _) = lamps(1e3)[0].clone();
    let file = row_of_triangles(lamp, place, 1.0);
    let ours = AddedLight::Directional {
        toward: Vec3::Z,
        color: Vec3::ONE,
    };
    let mut loaded = read(&file, &[ours]);
    assert_eq!(loaded.scene.light_scale, 1.0);
    let [white, glow, ..] = shown(&mut loaded);
    assert!((white - AMBIENT - 1.0).abs() < 1e-5 && (glow - NITS[0]).abs() < 1e-6);
    // Of a file whose lamps need no scale, and of one without any, emission is the file's.
    let (lamp, place, _) = lamps(1.0)[0].clone();
    let mut unlit = row_of_triangles(lamp.clone(), place.clone(), 1.0);
    unlit.json["extensions"] = json!({});
    unlit.json["nodes"][5]["extensions"] = json!({});
    for file in [row_of_triangles(lamp, place, 1.0), unlit] {
        let scene = read(&file, &[]).scene;
        assert_eq!((scene.light_scale, scene.emission_lights), (1.0, true));
        assert_eq!(scene.materials.ke.get(1), Vec3::splat(NITS[0]));
    }
}

/// A cache holds the scale, and takes it back as its file does.
#[test]
fn caches_of_scaled_light_give_the_scenes_of_their_files() {
    let (lamp, place, _) = lamps(1e3)[1].clone();
    let file = row_of_triangles(lamp, place, 1.0);
    let ours = [AddedLight::Point {
        position: DVec3::Z,
        color: Vec3::ONE,
    }];
    let of_file = [&[][..], &ours].map(|lights| read(&file, lights).scene);
    let mut bytes = Vec::new();
    cache::write(&mut bytes, &of_file[0], &Bvh::build(&of_file[0])).unwrap();
    let mut cached = cache::open_bytes(Path::new("a.phx"), &bytes).unwrap().scene;
    assert_eq!(cached.light_scale, of_file[0].light_scale);
    let look = options(&ours).look;
    override_scene(&mut cached, &look, 0).unwrap();
    let [before, after] = of_file.map(|scene| fingerprint(&scene));
    assert_eq!(fingerprint(&cached), after);
    assert_ne!(before, after);
}
