//! A cache gives the same picture as its file, with any options when it is built or used.
//!
//! `PHALANX_CACHE_PAIRS` says how many pairs of random scenes and options are tried.

use crate::common::rng::Rng;
use glam::{DVec3, Vec3};
use phalanx::bvh::Bvh;
use phalanx::cache::{self, fingerprint};
use phalanx::formats::{self, AddedLight, Options, OrthoHeight, Overrides, ReadOptions, UpAxis};
use phalanx::frame::{Accel, Control, Engine, Frame, Settings, render};
use phalanx::open::{Opened, open};
use phalanx::scene::{FileView, Material, Scene};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Number of pairs in an ordinary test run.
const PAIRS: usize = 200;

const ENDINGS: [&str; 6] = ["test", "obj", "stl", "ply", "gltf", "nff"];

/// A few triangles close together, with numbers that every format can represent.
fn corners(rng: &mut Rng) -> Vec<Vec3> {
    // The last is one whose camera leaves the range of a stored scene, for narrow pictures.
    let size = rng.pick(&[1.0, 1.0, 30.0, 1e-3, 4e7, 1.2e7]);
    let middle = rng.point(2.0);
    let count = 3 * (2 + rng.below(6));
    (0..count)
        .map(|_| (middle + rng.point(1.0)) * size)
        .collect()
}

fn words(v: Vec3) -> String {
    format!("{} {} {}", v.x, v.y, v.z)
}

/// Writes a scene in the format with this extension to a folder.
fn write_scene(rng: &mut Rng, ending: &str, folder: &Path) -> PathBuf {
    let path = folder.join(format!("s.{ending}"));
    let corners = corners(rng);
    let triangles = corners.len() / 3;
    let mirror = rng.once_in(2);
    let text = match ending {
        "obj" => {
            let ks = f32::from(u8::from(mirror)) * 0.5;
            let material = format!("newmtl m\nKd .5 .4 .3\nKs {ks} {ks} {ks}\nNs 90\nillum 3\n");
            std::fs::write(folder.join("s.mtl"), material).expect("a file");
            let vertices: String = corners
                .iter()
                .map(|&v| format!("v {}\n", words(v)))
                .collect();
            let face = |k: usize| format!("f {} {} {}\n", 3 * k + 1, 3 * k + 2, 3 * k + 3);
            let faces: String = (0..triangles).map(face).collect();
            format!("mtllib s.mtl\n{vertices}usemtl m\n{faces}")
        }
        "stl" => {
            let facet = |t: &[Vec3]| {
                let loops: String = t
                    .iter()
                    .map(|&v| format!("vertex {}\n", words(v)))
                    .collect();
                format!("facet normal 0 0 0\nouter loop\n{loops}endloop\nendfacet\n")
            };
            let facets: String = corners.chunks(3).map(facet).collect();
            format!("solid s\n{facets}endsolid s\n")
        }
        "ply" => {
            let vertices: String = corners.iter().map(|&v| words(v) + "\n").collect();
            let face = |k: usize| format!("3 {} {} {}\n", 3 * k, 3 * k + 1, 3 * k + 2);
            let faces: String = (0..triangles).map(face).collect();
            format!(
                "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
                 element face {triangles}\nproperty list uchar int vertex_indices\nend_header\n{vertices}{faces}",
                corners.len()
            )
        }
        "gltf" => gltf(rng, &corners, mirror, folder).to_string(),
        "nff" => {
            let view = "v\nfrom 3 2 9\nat 0 0 0\nup 0 1 0\nangle 40\nhither 1\nresolution 24 18\n";
            let light = "l 3 9 4\n";
            let (view, light) = (rng.pick(&[view, ""]), rng.pick(&[light, ""]));
            let polygon =
                |t: &[Vec3]| format!("p 3\n{}\n{}\n{}\n", words(t[0]), words(t[1]), words(t[2]));
            let polygons: String = corners.chunks(3).map(polygon).collect();
            let ks = if mirror { 0.5 } else { 0.0 };
            format!("b .1 .2 .3\n{view}{light}f .5 .4 .3 .5 {ks} 9 0 1\n{polygons}s 1 1 1 .5\n")
        }
        _ => {
            let vertex = |&v: &Vec3| format!("vertex {}\n", words(v));
            let vertices: String = corners.iter().map(vertex).collect();
            let tri = |k: usize| format!("tri {} {} {}\n", 3 * k, 3 * k + 1, 3 * k + 2);
            let tris: String = (0..triangles).map(tri).collect();
            format!(
                "size 24 18\ncamera 3 2 9 0 0 0 0 1 0 40\npoint 4 9 5 1 1 1\nmaxverts {}\n\
                 diffuse .5 .4 .3\nspecular .2 .2 .2\n{vertices}{tris}",
                corners.len()
            )
        }
    };
    std::fs::write(&path, text).expect("a file");
    path
}

/// A document with its buffer, optionally with a camera of either kind and a light.
fn gltf(rng: &mut Rng, corners: &[Vec3], mirror: bool, folder: &Path) -> Value {
    let positions: Vec<u8> = corners
        .iter()
        .flat_map(|v| v.to_array())
        .flat_map(f32::to_le_bytes)
        .collect();
    std::fs::write(folder.join("s.bin"), &positions).expect("a file");
    let lens = match rng.below(3) {
        0 => json!([]),
        1 => json!([{"type": "perspective", "perspective": {"yfov": 0.6, "znear": 0.01}}]),
        _ => {
            let [xmag, ymag] = [rng.magnitude(0.5, 8.0), rng.magnitude(0.5, 8.0)];
            let size = json!({"xmag": xmag, "ymag": ymag, "znear": 0.01, "zfar": 100});
            json!([{"type": "orthographic", "orthographic": size}])
        }
    };
    let mut nodes = vec![json!({"mesh": 0})];
    if lens != json!([]) {
        nodes.push(json!({"camera": 0, "translation": [rng.range(-1.0, 1.0), 0.5, 6]}));
    }
    let lamp = json!({"KHR_lights_punctual": {"light": 0}});
    let lit = rng.once_in(2);
    if lit {
        nodes.push(json!({"translation": [3, 5, 4], "extensions": lamp}));
    }
    let lights = json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 40}]}});
    let mut document = json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": (0..nodes.len()).collect::<Vec<_>>()}],
        "nodes": nodes,
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": if lit { lights } else { json!({}) },
        "materials": [{"pbrMetallicRoughness": {
            "metallicFactor": u8::from(mirror), "roughnessFactor": u8::from(!mirror)
        }}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "buffers": [{"byteLength": positions.len(), "uri": "s.bin"}],
        "bufferViews": [{"buffer": 0, "byteLength": positions.len()}],
        "accessors": [{
            "bufferView": 0, "componentType": 5126, "count": corners.len(), "type": "VEC3"
        }],
    });
    if lens != json!([]) {
        document["cameras"] = lens;
    }
    document
}

/// Random options of a command, usually few.
fn options(rng: &mut Rng) -> Options {
    let mut options = Options::default();
    options.read.threads = 1;
    if rng.once_in(3) {
        options.look.up = Some(rng.pick(&UpAxis::ALL).1);
    }
    if rng.once_in(3) {
        options.look.ortho = Some(rng.pick(&[
            OrthoHeight::Fitting,
            OrthoHeight::Fitting,
            OrthoHeight::Given(3.5),
        ]));
    }
    if rng.once_in(5) {
        options.look.view = Some(FileView {
            eye: rng.direction().as_dvec3() * 9.0,
            center: rng.point(1.0).as_dvec3(),
            up: rng.direction(),
            fovy: rng.range(20.0, 70.0),
            ortho: None,
        });
    }
    if rng.once_in(5) {
        options.look.lights = vec![AddedLight::Point {
            position: DVec3::new(4.0, 3.0, 8.0),
            color: rng.color(),
        }];
    }
    if rng.once_in(5) {
        options.look.background = Some(rng.color());
    }
    options
}

/// The combined options: if both sides set one, the later one counts.
fn joined(built: &Options, options: &Options) -> Options {
    let (first, second) = (&built.look, &options.look);
    let look = Overrides {
        view: second.view.or(first.view),
        up: second.up.or(first.up),
        ortho: second.ortho.or(first.ortho),
        lights: if second.lights.is_empty() {
            first.lights.clone()
        } else {
            second.lights.clone()
        },
        background: second.background.or(first.background),
        ..second.clone()
    };
    let read = ReadOptions {
        material: built.read.material,
        ..options.read.clone()
    };
    Options {
        read,
        look,
        ..Options::default()
    }
}

fn picture(scene: &Scene, bvh: Option<Bvh>, size: Option<(u32, u32)>) -> Frame {
    let accel = bvh.map_or_else(|| Accel::build(scene, Engine::Simd), Accel::with_tree);
    let own = (scene.width, scene.height);
    let (width, height) = size.unwrap_or(match own {
        // The default size of formats without one: too large for thousands of pictures.
        (24, 18) => own,
        (width, height) => (width.div_ceil(40), height.div_ceil(40)),
    });
    let settings = Settings {
        width,
        height,
        threads: 1,
        ..Settings::of(scene)
    };
    render(scene, &accel, &settings, &Control::default()).expect("nobody interrupts")
}

#[test]
fn a_cache_gives_the_picture_of_its_file_under_any_options() {
    let pairs = std::env::var("PHALANX_CACHE_PAIRS");
    let pairs = pairs.map_or(PAIRS, |pairs| pairs.parse().expect("a number"));
    let mut rng = Rng::new(48);
    let folder = tempfile::tempdir().expect("a folder");
    let (mut seen, mut rescaled, mut wrong) = (0, 0, Vec::new());
    for pair in 0..pairs {
        let ending = ENDINGS[pair % ENDINGS.len()];
        let path = write_scene(&mut rng, ending, folder.path());
        let mut built = options(&mut rng);
        if rng.once_in(3) {
            built.read.material = Some(Material {
                ks: Vec3::splat(0.4),
                ..Material::default()
            });
        }
        let mut options = options(&mut rng);
        options.look.turntable = rng.once_in(6);
        options.look.size = rng.pick(&[
            None,
            Some((24, 18)),
            Some((20, 20)),
            Some((7, 40)),
            Some((50, 9)),
        ]);
        let stored = formats::load(&path, &built).expect("a scene").scene;
        let phx = folder.path().join(format!("{pair}.phx"));
        let mut bytes = Vec::new();
        cache::write(&mut bytes, &stored, &Bvh::build(&stored)).expect("writing to memory");
        std::fs::write(&phx, bytes).expect("a file");
        let file = formats::load(&path, &joined(&built, &options)).map(|loaded| loaded.scene);
        let why = match (file, open(&phx, &options)) {
            (Ok(file), Ok(Opened { scene, bvh, .. })) => {
                rescaled += usize::from(bvh.is_none());
                let film = picture(&file, None, options.look.size).film;
                seen += usize::from(film.planes[0].iter().any(|&c| c != film.planes[0][0]));
                if picture(&scene, bvh, options.look.size).film != film {
                    "pictures differ".to_owned()
                } else if fingerprint(&scene) != fingerprint(&file) {
                    "scenes differ".to_owned()
                } else {
                    continue;
                }
            }
            (Err(_), Err(_)) => continue,
            (file, cached) => format!("{:?} but {:?}", file.err(), cached.err()),
        };
        wrong.push(format!(
            "{pair} ({ending}): {why}, built {built:?}, asked {options:?}"
        ));
    }
    assert!(seen * 2 > pairs && rescaled > 0, "{seen}, {rescaled}");
    let first = wrong.first().map_or("", String::as_str);
    assert!(wrong.is_empty(), "{} of {pairs}: {first}", wrong.len());
}
