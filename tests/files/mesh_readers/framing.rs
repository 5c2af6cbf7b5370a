//! The default camera and light, for the requested picture, from a file or from a cache.

use super::read;
use phalanx::bvh::Bvh;
use phalanx::cache;
use phalanx::formats::{Options, OrthoHeight, Overrides, UpAxis, read_bytes};
use phalanx::open::{Opened, open};
use phalanx::scene::Scene;
use std::path::PathBuf;

/// A wide board, a thin rod leaning away, and nothing in between.
const BOARD: &str = "v -5 0 0\nv 5 0 0\nv 5 1 0\nv -5 1 0\nv 0 4 -8\nf 1 2 3 4\nf 1 1 5\n";

fn read_with(options: &Options) -> Scene {
    read_bytes("obj", BOARD.as_bytes(), options)
        .unwrap()
        .unwrap()
        .scene
}

/// The picture's largest coordinate of any vertex, where its sides are at 1.
fn largest(scene: &Scene, (width, height): (u32, u32)) -> f32 {
    let basis = scene.view.basis().unwrap();
    let slope = (scene.view.fovy / 2.0).to_radians().tan();
    let slope_of = |k: usize| {
        let to = scene.triangles.vertices.get(k) - scene.view.eye;
        let across = to.dot(basis.u).abs() * height as f32 / width as f32;
        across.max(to.dot(basis.v).abs()) / (-to.dot(basis.w) * slope)
    };
    (0..5).map(slope_of).fold(0.0, f32::max)
}

#[test]
fn all_vertices_are_in_a_picture_of_any_size() {
    for size in [(400, 400), (200, 400), (1920, 1080), (64, 4096), (4096, 64)] {
        for (_, up) in UpAxis::ALL {
            let options = Options {
                look: Overrides {
                    size: Some(size),
                    up: Some(up),
                    ..Overrides::default()
                },
                ..Options::default()
            };
            let scene = read_with(&options);
            let largest = largest(&scene, size);
            assert!((0.9..0.97).contains(&largest), "{size:?} {up:?}: {largest}");
            // The size is the picture's, which a scene does not change for.
            assert_eq!((scene.width, scene.height), (1280, 960));
        }
    }
}

/// A cache of the scene, opened with options.
fn through_a_cache(name: &str, scene: &Scene, options: &Options) -> Opened {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let path = folder.join(format!("framing-{name}.phx"));
    let bvh = Bvh::build(scene);
    let mut file = std::fs::File::create(&path).unwrap();
    cache::write(&mut file, scene, &bvh).unwrap();
    let opened = open(&path, options).unwrap();
    std::fs::remove_file(&path).unwrap();
    opened
}

#[test]
fn a_cache_frames_as_its_file_does() {
    let view = phalanx::scene::FileView {
        eye: glam::DVec3::new(1.0, 2.0, 30.0),
        center: glam::DVec3::ZERO,
        up: glam::Vec3::Y,
        fovy: 40.0,
        ortho: None,
    };
    let light = phalanx::formats::AddedLight::Directional {
        toward: glam::Vec3::Y,
        color: glam::Vec3::ONE,
    };
    let all = [
        Overrides::default(),
        Overrides {
            size: Some((200, 400)),
            ..Overrides::default()
        },
        Overrides {
            up: Some(UpAxis::Z),
            ..Overrides::default()
        },
        Overrides {
            up: Some(UpAxis::NegX),
            size: Some((9, 7)),
            ..Overrides::default()
        },
        Overrides {
            turntable: true,
            ..Overrides::default()
        },
        Overrides {
            ortho: Some(OrthoHeight::Fitting),
            size: Some((300, 200)),
            ..Overrides::default()
        },
        Overrides {
            view: Some(view),
            ..Overrides::default()
        },
        Overrides {
            lights: vec![light],
            size: Some((1, 9)),
            ..Overrides::default()
        },
    ];
    let all = all.map(|look| Options {
        look,
        ..Options::default()
    });
    for (k, first) in all.iter().enumerate() {
        let stored = read_with(first);
        for (j, second) in all.iter().enumerate() {
            // What a cache was built with stays, where nothing else is given.
            if second.look.view.is_none() && first.look.view.is_some()
                || second.look.lights.is_empty() && !first.look.lights.is_empty()
                || second.look.up.is_none() && first.look.up.is_some()
                || first.look.size.is_some() && j != k
                || first.look.turntable && !second.look.turntable
                || first.look.ortho.is_some() && second.look.ortho.is_none()
            {
                continue;
            }
            let direct = read_with(second);
            let cached = through_a_cache(&format!("{k}-{j}"), &stored, second).scene;
            assert_eq!(cached.view, direct.view, "{k} {j}");
            assert_eq!(cached.lights.position, direct.lights.position, "{k} {j}");
            assert_eq!(cached.defaulted, direct.defaulted, "{k} {j}");
        }
    }
}

#[test]
fn an_axis_that_does_nothing_is_said_to() {
    let options = Options {
        look: Overrides {
            up: Some(UpAxis::Z),
            ..Overrides::default()
        },
        ..Options::default()
    };
    let text = "size 8 8\ncamera 0 0 5 0 0 0 0 1 0 45\nsphere 0 0 0 1\n";
    let loaded = read_bytes("test", text.as_bytes(), &options)
        .unwrap()
        .unwrap();
    assert_eq!(
        loaded.notes,
        ["--up has no effect on a scene that has a camera"]
    );
    let stored = through_a_cache("note", &loaded.scene, &options);
    assert_eq!(stored.notes, loaded.notes);
    assert!(read("test", text.as_bytes()).notes.is_empty());
}
