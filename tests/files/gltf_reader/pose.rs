//! Poses: morph targets and skins.

use super::{File, messages};
use glam::Vec3;
use phalanx::formats::Loaded;
use serde_json::{Value, json};

const UBYTE: u32 = 5121;
const USHORT: u32 = 5123;

fn corners(loaded: &Loaded, triangle: usize) -> [Vec3; 3] {
    let scene = &loaded.scene;
    let corners = scene.triangles.corners(triangle);
    corners.map(|corner| scene.file_position(corner).as_vec3())
}

fn near(a: [Vec3; 3], b: [Vec3; 3]) {
    let far = a.iter().zip(b).map(|(a, b)| (*a - b).abs().max_element());
    assert!(far.fold(0.0, f32::max) < 1e-5, "{a:?} is not {b:?}");
}

fn moved(offset: Vec3) -> [Vec3; 3] {
    [Vec3::ZERO, Vec3::X, Vec3::Y].map(|corner| corner + offset)
}

/// A triangle with a target that moves it by 1 along x, and another by 1 along y.
fn morphed() -> File {
    let mut file = File::triangle();
    let x = file.floats(3, &[1., 0., 0., 1., 0., 0., 1., 0., 0.]);
    let y = file.floats(3, &[0., 1., 0., 0., 1., 0., 0., 1., 0.]);
    file.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": x}, {"POSITION": y}]);
    file
}

#[test]
fn weights_of_the_node_come_before_those_of_the_mesh() {
    let pose_of = |mesh: Value, node: Value| {
        let mut file = morphed();
        for (row, weights) in [("meshes", mesh), ("nodes", node)] {
            if weights != Value::Null {
                file.json[row][0]["weights"] = weights;
            }
        }
        let loaded = file.loaded();
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        corners(&loaded, 0)
    };
    let none = Value::Null;
    near(pose_of(none.clone(), none.clone()), moved(Vec3::ZERO));
    near(pose_of(json!([1, 0]), none.clone()), moved(Vec3::X));
    near(
        pose_of(json!([0.5, -2]), none.clone()),
        moved(Vec3::new(0.5, -2.0, 0.0)),
    );
    near(
        pose_of(json!([1, 0]), json!([0, 0.25])),
        moved(Vec3::Y * 0.25),
    );
    near(pose_of(json!([1, 0]), json!([0, 0])), moved(Vec3::ZERO));
    // Weights without targets, and targets without weights, do nothing.
    near(pose_of(json!([1]), none.clone()), moved(Vec3::X));
    near(pose_of(json!([1, 0, 7]), none), moved(Vec3::X));
}

#[test]
fn nodes_of_one_pose_share_its_triangles() {
    let mut file = morphed();
    file.json["meshes"][0]["weights"] = json!([1, 0]);
    for (weights, x) in [
        (json!([1, 0]), 0),
        (json!([0, 0]), 10),
        (json!([0, 1]), 20),
        (json!([0, 1]), 30),
    ] {
        file.node(json!({"mesh": 0, "weights": weights, "translation": [x, 0, 0]}));
    }
    file.node(json!({"mesh": 0, "translation": [40, 0, 0]}));
    let loaded = file.loaded();
    let scene = &loaded.scene;
    // That of the mesh, twice; the same by a node; at rest; another one, twice.
    assert_eq!((scene.prim_count(), scene.visible_count()), (4, 6));
    assert_eq!((scene.meshes.len(), scene.instances.len()), (2, 4));
}

#[test]
fn normals_texture_coordinates_and_colours_are_morphed() {
    let mut file = morphed();
    let normals = file.floats(3, &[0., 0., 1., 0., 0., 1., 0., 0., 1.]);
    let more = file.floats(3, &[1., 0., -1., 0., 0., 0., 0., 0., 0.]);
    let colors = file.floats(3, &[0.5; 9]);
    let redder = file.floats(4, &[1., 0., 0., 0., -0.5, 0., 0., 0., 0., 0.25, 0., 0.]);
    let primitive = &mut file.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["NORMAL"] = json!(normals);
    primitive["attributes"]["COLOR_0"] = json!(colors);
    primitive["targets"] = json!([{"NORMAL": more, "COLOR_0": redder, "TANGENT": 0}]);
    file.json["meshes"][0]["weights"] = json!([1]);
    let scene = file.loaded().scene;
    assert_eq!(
        scene.triangles.corner_normals(0),
        Some([Vec3::X, Vec3::Z, Vec3::Z])
    );
    let half = Vec3::splat(0.5);
    let colors = scene.triangles.corner_colors(0).expect("colours");
    near(
        colors,
        [half.with_x(1.0), half.with_x(0.0), half.with_y(0.75)],
    );
}

#[test]
fn targets_may_be_sparse_and_of_integers() {
    let mut file = File::triangle();
    let indices = file.view(&[1]);
    let bytes: Vec<u8> = [0f32, 0., 4.]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let values = file.view(&bytes);
    let sparse = file.add(
        "accessors",
        json!({"componentType": 5126, "type": "VEC3", "count": 3, "sparse": {
            "count": 1,
            "indices": {"bufferView": indices, "componentType": 5121},
            "values": {"bufferView": values}
        }}),
    );
    let bytes = file.accessor(&[127, 0, 0, 0, 127, 0, 0, 0, 127], 5120, 3, 3);
    file.json["accessors"][bytes]["normalized"] = json!(true);
    file.json["meshes"][0]["primitives"][0]["targets"] =
        json!([{"POSITION": sparse}, {"POSITION": bytes}]);
    file.json["meshes"][0]["weights"] = json!([0.5, 1]);
    let want = [Vec3::X, Vec3::new(1.0, 1.0, 2.0), Vec3::new(0.0, 1.0, 1.0)];
    near(corners(&file.loaded(), 0), want);
    // Fewer rows than vertices are an error, but only if they are used.
    file.json["accessors"][bytes]["count"] = json!(2);
    assert!(file.refused()[0].contains("fewer rows than POSITION"));
    file.json["meshes"][0]["weights"] = json!([0.5, 0]);
    near(
        corners(&file.loaded(), 0),
        [Vec3::ZERO, Vec3::new(1.0, 0.0, 2.0), Vec3::Y],
    );
}

/// A triangle whose vertices follow the joints 0, 1 and 2 of a skin. The node itself moves away.
fn skinned(joints: &[Value], bound: Option<&[f32]>) -> File {
    let mut file = File::triangle();
    let numbers = file.accessor(&[0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0], UBYTE, 4, 3);
    let weights = file.floats(4, &[1., 0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0.]);
    let attributes = &mut file.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = json!(numbers);
    attributes["WEIGHTS_0"] = json!(weights);
    file.json["nodes"][0] = json!({"mesh": 0, "skin": 0, "translation": [0, 100, 0]});
    let rows: Vec<usize> = joints
        .iter()
        .map(|joint| file.node(joint.clone()))
        .collect();
    let mut skin = json!({"joints": rows});
    if let Some(matrices) = bound {
        let view: Vec<u8> = matrices.iter().flat_map(|v| v.to_le_bytes()).collect();
        let view = file.view(&view);
        let row = json!({"bufferView": view, "componentType": 5126, "type": "MAT4", "count": matrices.len() / 16});
        skin["inverseBindMatrices"] = json!(file.add("accessors", row));
    }
    file.json["skins"] = json!([skin]);
    file
}

fn three() -> [Value; 3] {
    [
        json!({"translation": [1, 0, 0]}),
        json!({"translation": [0, 2, 0]}),
        json!({"scale": [1, 3, 1]}),
    ]
}

#[test]
fn vertices_follow_their_joints_and_not_their_node() {
    let loaded = skinned(&three(), None).loaded();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    near(
        corners(&loaded, 0),
        [Vec3::X, Vec3::new(1.0, 2.0, 0.0), Vec3::Y * 3.0],
    );
}

#[test]
fn bound_matrices_come_first() {
    let mut matrices = Vec::new();
    for x in [-1.0, -1.0, -1.0] {
        matrices.extend([
            1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., x, 0., 0., 1.,
        ]);
    }
    let mut file = skinned(&three(), Some(&matrices));
    near(
        corners(&file.loaded(), 0),
        [
            Vec3::ZERO,
            Vec3::new(0.0, 2.0, 0.0),
            Vec3::new(-1.0, 3.0, 0.0),
        ],
    );
    let row = file.json["skins"][0]["inverseBindMatrices"]
        .as_u64()
        .unwrap() as usize;
    file.json["accessors"][row]["count"] = json!(2);
    assert!(file.refused()[0].contains("skins[0]: 2 matrices for its 3 joints"));
}

#[test]
fn joints_take_the_nodes_above_them_inside_the_scene_or_not() {
    let mut file = skinned(&three(), None);
    let parent = file.node(json!({"children": [1, 2, 3], "translation": [0, 0, 7]}));
    let want =
        [Vec3::X, Vec3::new(1.0, 2.0, 0.0), Vec3::Y * 3.0].map(|corner| corner + Vec3::Z * 7.0);
    for scene in [json!([0, parent]), json!([0])] {
        file.json["scenes"] = json!([{"nodes": scene}]);
        near(corners(&file.loaded(), 0), want);
    }
    // The skeleton far away: the scene moves along.
    file.json["nodes"][parent]["translation"] = json!([2_000_000, 0, 0]);
    let far = file.loaded();
    assert!(far.scene.is_moved());
    near(
        corners(&far, 0),
        [Vec3::X, Vec3::new(1.0, 2.0, 0.0), Vec3::Y * 3.0].map(|c| c + Vec3::X * 2e6),
    );
    // On a cycle next to the scene there is no position.
    file.json["scenes"] = json!([{"nodes": [0]}]);
    file.json["nodes"][1]["children"] = json!([parent]);
    assert!(file.refused()[0].contains("its joint nodes[1] has no position"));
}

/// The triangle's joints and weights as bytes of these types.
fn influenced(joints: (&[u8], u32), weights: (&[u8], u32, bool)) -> Loaded {
    let mut file = skinned(&three(), None);
    let numbers = file.accessor(joints.0, joints.1, 4, 3);
    let row = file.accessor(weights.0, weights.1, 4, 3);
    file.json["accessors"][row]["normalized"] = json!(weights.2);
    let attributes = &mut file.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = json!(numbers);
    attributes["WEIGHTS_0"] = json!(row);
    file.loaded()
}

#[test]
fn all_types_of_joints_and_weights() {
    let want = [Vec3::X, Vec3::new(1.0, 2.0, 0.0), Vec3::Y * 3.0];
    let joints = [0u8, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0];
    let wide: Vec<u8> = joints
        .iter()
        .flat_map(|&n| u16::from(n).to_le_bytes())
        .collect();
    let weights = [255u8, 0, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0];
    let shorts: Vec<u8> = weights
        .iter()
        .flat_map(|&n| (u16::from(n) * 257).to_le_bytes())
        .collect();
    for normalized in [true, false] {
        near(
            corners(
                &influenced((&joints, UBYTE), (&weights, UBYTE, normalized)),
                0,
            ),
            want,
        );
        near(
            corners(
                &influenced((&wide, USHORT), (&shorts, USHORT, normalized)),
                0,
            ),
            want,
        );
    }
    // Two joints with weights that sum to 2, to a half, to nothing.
    let joints = [0u8, 1, 0, 0, 0, 1, 0, 0, 2, 0, 0, 0];
    let floats = [1f32, 1., 0., 0., 0.375, 0.125, 0., 0., 0., 0., 0., 0.];
    let floats: Vec<u8> = floats.iter().flat_map(|v| v.to_le_bytes()).collect();
    near(
        corners(&influenced((&joints, UBYTE), (&floats, 5126, false)), 0),
        [
            Vec3::new(0.5, 1.0, 0.0),
            Vec3::new(1.75, 0.5, 0.0),
            Vec3::Y * 3.0,
        ],
    );
    // A joint that is not there counts only if it has a weight.
    let absent = [0u8, 9, 0, 0, 1, 9, 0, 0, 2, 9, 0, 0];
    let loaded = influenced((&absent, UBYTE), (&weights, UBYTE, true));
    assert!(loaded.warnings.is_empty());
    near(corners(&loaded, 0), want);
    let loaded = influenced((&[9; 12], UBYTE), (&weights, UBYTE, true));
    assert!(messages(&loaded.warnings)[0].contains("3 vertices follow joints"));
}

#[test]
fn a_second_set_of_joints_counts() {
    let mut file = skinned(&three(), None);
    let numbers = file.accessor(&[1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0], UBYTE, 4, 3);
    let weights = file.floats(4, &[1., 0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0.]);
    let attributes = &mut file.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_1"] = json!(numbers);
    attributes["WEIGHTS_1"] = json!(weights);
    near(
        corners(&file.loaded(), 0),
        [
            Vec3::new(0.5, 1.0, 0.0),
            Vec3::new(1.0, 2.0, 0.0),
            Vec3::new(0.0, 3.0, 0.0),
        ],
    );
}

#[test]
fn normals_and_winding_follow_the_joints() {
    let turn = 0.5f64.sqrt();
    for (joint, normal, order) in [
        // A quarter turn about x: z goes to −y.
        (
            json!({"rotation": [turn, 0, 0, turn]}),
            Vec3::NEG_Y,
            [Vec3::ZERO, Vec3::X, Vec3::Z],
        ),
        (
            json!({"scale": [-1, 1, 1]}),
            Vec3::Z,
            [Vec3::ZERO, Vec3::Y, Vec3::NEG_X],
        ),
    ] {
        let mut file = skinned(&[joint.clone(), joint.clone(), joint], None);
        let normals = file.floats(3, &[0., 0., 1., 0., 0., 1., 0., 0., 1.]);
        file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
        let loaded = file.loaded();
        near(corners(&loaded, 0), order);
        near(
            loaded.scene.triangles.corner_normals(0).expect("normals"),
            [normal; 3],
        );
    }
}

#[test]
fn a_skin_and_morph_targets_at_once() {
    let mut file = skinned(&three(), None);
    let x = file.floats(3, &[1., 0., 0., 1., 0., 0., 1., 0., 0.]);
    file.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": x}]);
    file.json["nodes"][0]["weights"] = json!([10]);
    near(
        corners(&file.loaded(), 0),
        [
            Vec3::new(11.0, 0.0, 0.0),
            Vec3::new(11.0, 2.0, 0.0),
            Vec3::new(10.0, 3.0, 0.0),
        ],
    );
}

/// The format requires joints in every primitive of such a mesh. Without them, its node is used.
#[test]
fn a_primitive_without_joints_stays_with_its_node() {
    let mut file = skinned(&three(), None);
    let attributes = &mut file.json["meshes"][0]["primitives"][0]["attributes"];
    attributes.as_object_mut().unwrap().remove("JOINTS_0");
    near(corners(&file.loaded(), 0), moved(Vec3::Y * 100.0));
    let mut none = skinned(&three(), None);
    none.json["nodes"][0]["skin"] = json!(4);
    assert!(none.refused()[0].contains("skins[4]: it is not there"));
    none.json["skins"] = json!([{"joints": []}]);
    none.json["nodes"][0]["skin"] = json!(0);
    assert!(none.refused()[0].contains("it has no joints"));
    none.json["skins"] = json!([{"joints": [77]}]);
    assert!(none.refused()[0].contains("nodes[77] has no position"));
}

#[test]
fn two_skins_of_one_mesh_stand_apart() {
    let mut file = skinned(&three(), None);
    let other = file.node(json!({"translation": [0, 0, 5]}));
    let skins = file.json["skins"].as_array_mut().unwrap();
    skins.push(json!({"joints": [other, other, other]}));
    file.node(json!({"mesh": 0, "skin": 1}));
    let loaded = file.loaded();
    assert_eq!(loaded.scene.triangles.len(), 2);
    near(
        corners(&loaded, 0),
        [Vec3::X, Vec3::new(1.0, 2.0, 0.0), Vec3::Y * 3.0],
    );
    near(corners(&loaded, 1), moved(Vec3::Z * 5.0));
}

/// Any number of targets may share one accessor, so a small file could cause a lot of work.
#[test]
fn displacements_are_bounded_by_the_file() {
    let mut file = File::triangle();
    let many = 20_000;
    let indices = file.indices(&vec![0; 3 * many]);
    let primitive = &mut file.json["meshes"][0]["primitives"][0];
    primitive["indices"] = json!(indices);
    primitive["targets"] = json!(vec![json!({"POSITION": 0}); many]);
    file.json["meshes"][0]["weights"] = json!(vec![1; many]);
    let refused = file.refused();
    assert!(
        refused[0].contains("its morph targets are too many for a file of this size"),
        "{refused:?}"
    );
}

/// Empty meshes posed by each of many nodes would take time quadratic in the file's size.
#[test]
fn poses_are_bounded_by_the_file() {
    for posed in [
        json!({"mesh": 0, "skin": 0}),
        json!({"mesh": 0, "weights": [1, 1]}),
    ] {
        let mut file = File::triangle();
        file.json["skins"] = json!([{"joints": [0]}]);
        file.json["meshes"][0]["primitives"] = json!(vec![json!({}); 30_000]);
        let nodes = (0..30_000).map(|k| {
            let mut node = posed.clone();
            if node["weights"].is_array() {
                node["weights"][0] = json!(k + 1);
            }
            node
        });
        file.json["nodes"] = nodes.collect();
        let refused = file.refused();
        assert!(
            refused[0].contains("poses are too many for a file of this size"),
            "{refused:?}"
        );
    }
}
