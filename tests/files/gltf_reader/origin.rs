//! Files with nodes or accessors far from the origin.

use super::File;
use glam::{DVec3, Vec3};
use phalanx::formats::{Loaded, Options, Origin, ReadOptions, read_bytes};
use phalanx::scene::Scene;
use serde_json::json;

const PLACE: [f64; 3] = [500_123.25, 0.0, -4_012_345.5];

/// A triangle in local coordinates that single precision could not represent at `PLACE`.
fn shape(file: &mut File, offset: [f32; 3]) {
    let [x, y, z] = offset;
    let corners = [x - 4.1, y, z, x + 4.3, y, z + 0.7, x, y + 3.3, z];
    let positions = file.floats(3, &corners);
    file.mesh(json!({"attributes": {"POSITION": positions}}));
}

fn corners(scene: &Scene) -> Vec<[Vec3; 3]> {
    (0..scene.triangles.len())
        .map(|i| scene.triangles.corners(i))
        .collect()
}

fn at(file: &File, origin: Origin) -> Loaded {
    let options = Options {
        read: ReadOptions {
            origin,
            ..ReadOptions::default()
        },
        ..Options::default()
    };
    read_bytes("gltf", file.text().as_bytes(), &options)
        .unwrap()
        .unwrap()
}

#[test]
fn a_nodes_translation_is_taken_from_the_origin_in_double_precision() {
    let mut file = File::empty();
    shape(&mut file, [0.0; 3]);
    file.node(json!({"mesh": 0, "translation": PLACE}));
    let scene = file.loaded().scene;
    let difference = (DVec3::from(scene.origin) - DVec3::from(PLACE)).abs();
    assert!(
        difference.max_element() < 2.0 && scene.origin[1] == 0.0,
        "{difference}"
    );
    let moved = DVec3::from(PLACE) - DVec3::from(scene.origin);
    let want = |c: [f32; 3]| (Vec3::from(c).as_dvec3() + moved).as_vec3();
    let own = [[-4.1, 0.0, 0.0], [4.3, 0.0, 0.7], [0.0, 3.3, 0.0]];
    assert_eq!(corners(&scene), [own.map(want)]);
    // Without it a quarter of a metre is all that is left.
    let rounded = at(&file, Origin::File).scene;
    assert_eq!(corners(&rounded)[0][1].z, -4_012_344.8);
}

/// Each coordinate in the file, and its difference from the chosen origin, fits single precision.
#[test]
fn accessors_of_single_precision_move_exactly_or_not_at_all() {
    let mut file = File::empty();
    shape(&mut file, [500_000.0, 0.0, -4_012_344.0]);
    file.node(json!({"mesh": 0}));
    let loaded = file.loaded();
    assert!(loaded.scene.is_moved());
    let standing = corners(&at(&file, Origin::File).scene)[0];
    let back = corners(&loaded.scene)[0].map(|c| loaded.scene.file_position(c));
    assert_eq!(back, standing.map(|c| c.as_dvec3()), "every bit");
    let inexact = at(&file, Origin::At([499_990.1, 0.0, 0.0]));
    assert_eq!(inexact.scene.origin, [0.0; 3]);
    assert_eq!(corners(&inexact.scene)[0], standing);
    assert!(
        inexact.notes[0].contains("would round them"),
        "{:?}",
        inexact.notes
    );
}

#[test]
fn the_maps_of_instances_take_the_origin() {
    let mut file = File::empty();
    shape(&mut file, [0.0; 3]);
    file.node(json!({"mesh": 0, "translation": PLACE}));
    let other = [PLACE[0] + 3.5, 0.25, PLACE[2]];
    file.node(json!({"mesh": 0, "translation": other}));
    let scene = file.loaded().scene;
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 2));
    assert_eq!(
        corners(&scene)[0][1],
        Vec3::new(4.3, 0.0, 0.7),
        "its own space"
    );
    for (k, position) in [PLACE, other].into_iter().enumerate() {
        let there = scene.instances.world_columns(k)[3];
        assert_eq!(
            scene.file_position(there).to_array(),
            position,
            "instance {k}"
        );
        assert!(there.abs().max_element() < 16.0);
    }
}

/// Map coordinates in an accessor, which nodes undo: near in the world, far in the mesh's own
/// space.
#[test]
fn a_mesh_that_is_far_away_in_its_own_space_is_stored_near() {
    let offset = [500_000.0, 0.0, -4_012_344.0f32];
    let mut file = File::empty();
    shape(&mut file, offset);
    let back = |x: f64| json!({"mesh": 0, "translation": [x - 500_000.0, 0.0, 4_012_344.0]});
    file.node(back(0.0));
    file.node(back(9.25));
    let scene = file.loaded().scene;
    assert_eq!(scene.origin, [0.0; 3], "the world is near");
    let stored = corners(&scene)[0];
    assert!(
        stored.iter().all(|c| c.abs().max_element() < 16.0),
        "{stored:?}"
    );
    for (k, x) in [0.0, 9.25].into_iter().enumerate() {
        let [mx, my, mz, t] = scene.instances.world_columns(k);
        let world = |c: Vec3| mx * c.x + my * c.y + mz * c.z + t;
        let file = |c: f32, offset: f32, shift: f32| (offset + c) - offset + shift;
        let first = world(stored[1]);
        let want = [
            file(4.3, offset[0], x as f32),
            0.0,
            file(0.7, offset[2], 0.0),
        ];
        assert_eq!(first.to_array(), want, "instance {k}");
    }
}

#[test]
fn cameras_and_lights_of_nodes_move_with_the_scene() {
    let mut file = File::empty();
    shape(&mut file, [0.0; 3]);
    file.node(json!({"mesh": 0, "translation": PLACE}));
    file.json["cameras"] =
        json!([{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}]);
    let eye = [PLACE[0], 1.5, PLACE[2] + 12.1];
    file.node(json!({"camera": 0, "translation": eye}));
    file.json["extensions"] =
        json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 900.0}]}});
    let lamp = [PLACE[0] + 1.1, 8.0, PLACE[2]];
    let light = json!({"KHR_lights_punctual": {"light": 0}});
    file.node(json!({"translation": lamp, "extensions": light}));
    let scene = file.loaded().scene;
    let local = |position: [f64; 3]| (DVec3::from(position) - DVec3::from(scene.origin)).as_vec3();
    assert!(scene.is_moved());
    assert_eq!(scene.view.eye, local(eye));
    assert_eq!(scene.lights.position.get(0), local(lamp));
}
