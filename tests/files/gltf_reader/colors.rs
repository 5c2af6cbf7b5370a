//! Vertex colours.

use super::{File, messages};
use glam::Vec3;
use phalanx::formats::Loaded;
use serde_json::{Value, json};

const FLOAT: u32 = 5126;
const UBYTE: u32 = 5121;
const USHORT: u32 = 5123;

/// A triangle with these bytes as colours.
fn colored(bytes: &[u8], kind: u32, width: usize) -> File {
    let mut file = File::triangle();
    let colors = file.accessor(bytes, kind, width, 3);
    file.json["accessors"][colors]["normalized"] = json!(kind != FLOAT);
    file.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
    file
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn colors(loaded: &Loaded) -> [Vec3; 3] {
    loaded.scene.triangles.corner_colors(0).expect("colours")
}

fn near(a: [Vec3; 3], b: [Vec3; 3]) {
    let far = a.iter().zip(b).map(|(a, b)| (*a - b).abs().max_element());
    assert!(far.fold(0.0, f32::max) < 1e-6, "{a:?} is not {b:?}");
}

const RGB: [Vec3; 3] = [Vec3::X, Vec3::new(0.0, 0.5, 0.0), Vec3::new(0.2, 0.4, 1.0)];

#[test]
fn all_types_of_colours_are_read() {
    let three = [1., 0., 0., 0., 0.5, 0., 0.2, 0.4, 1.];
    let four = [1., 0., 0., 1., 0., 0.5, 0., 0.25, 0.2, 0.4, 1., 0.];
    let bytes =
        |values: &[f32]| -> Vec<u8> { values.iter().map(|v| (v * 255.0).round() as u8).collect() };
    let shorts = |values: &[f32]| -> Vec<u8> {
        let words = values.iter().map(|v| (v * 65_535.0).round() as u16);
        words.flat_map(u16::to_le_bytes).collect()
    };
    near(colors(&colored(&floats(&three), FLOAT, 3).loaded()), RGB);
    near(colors(&colored(&floats(&four), FLOAT, 4).loaded()), RGB);
    near(colors(&colored(&shorts(&three), USHORT, 3).loaded()), {
        let half = (32_768.0 / 65_535.0) as f32;
        [RGB[0], Vec3::new(0.0, half, 0.0), RGB[2]]
    });
    let half = Vec3::new(0.0, 128.0 / 255.0, 0.0);
    near(
        colors(&colored(&bytes(&four), UBYTE, 4).loaded()),
        [RGB[0], half, RGB[2]],
    );
    // Exporters forget to say that integers are shares.
    let mut forgotten = colored(&bytes(&four), UBYTE, 4);
    forgotten.json["accessors"][1]["normalized"] = json!(false);
    near(colors(&forgotten.loaded()), [RGB[0], half, RGB[2]]);
    let wrong = colored(&floats(&three[..6]), FLOAT, 2);
    assert!(wrong.refused()[0].contains("its type should be VEC3 or VEC4"));
}

#[test]
fn colours_are_clamped_and_those_that_are_no_numbers_left_out() {
    let wide = colored(
        &floats(&[2., -1., 0.5, 0., 0., 0., 1., 1., f32::INFINITY]),
        FLOAT,
        3,
    );
    let clamped = [Vec3::new(1.0, 0.0, 0.5), Vec3::ZERO, Vec3::ONE];
    near(colors(&wide.loaded()), clamped);
    let bad = colored(
        &floats(&[0., 0., 0., 0., f32::NAN, 0., 1., 1., 1.]),
        FLOAT,
        3,
    )
    .loaded();
    assert_eq!(bad.scene.triangles.corner_colors(0), None);
    assert!(messages(&bad.warnings)[0].contains("one vertex colour is no number"));
}

/// Vertex colours multiply the base colour, so without a material the base is white instead of
/// grey.
#[test]
fn the_material_under_colours() {
    let surface_of = |material: Option<Value>| {
        let mut file = colored(&floats(&[1., 0., 0., 0., 1., 0., 0., 0., 1.]), FLOAT, 3);
        if let Some(material) = material {
            file.json["materials"] = json!([material]);
            file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        }
        file.loaded().scene.materials.get(0)
    };
    assert_eq!(surface_of(None).kd, Vec3::ONE);
    // A mirror that vertices colour is paint, as one that a texture colours.
    let metal = surface_of(Some(json!({"pbrMetallicRoughness": {
        "baseColorFactor": [0.5, 0.25, 1, 1], "roughnessFactor": 0
    }})));
    assert_eq!(
        (metal.kd, metal.ks),
        (Vec3::new(0.5, 0.25, 1.0), Vec3::splat(0.04))
    );
}

#[test]
fn primitives_with_and_without_colours_mix() {
    let mut file = colored(&floats(&[1., 0., 0., 0., 1., 0., 0., 0., 1.]), FLOAT, 3);
    let bare = json!({"attributes": {"POSITION": 0}});
    let first = file.json["meshes"][0]["primitives"][0].clone();
    file.json["meshes"][0]["primitives"] = json!([bare, first, bare]);
    let scene = file.loaded().scene;
    let rows = |k: usize| scene.triangles.corner_colors(k);
    assert_eq!((rows(0), rows(2)), (None, None));
    assert_eq!(rows(1), Some([Vec3::X, Vec3::Y, Vec3::Z]));
    assert_eq!(scene.triangles.vertex_opacity, [1.0; 3]);
    let kd = |k: u32| scene.materials.get(scene.prim_material(k) as usize).kd;
    assert!(kd(0) != kd(1) && kd(0) == kd(2));
}

#[test]
fn white_colours_cost_nothing() {
    let white = colored(&[255; 12], UBYTE, 4).loaded();
    assert!(white.scene.triangles.colors.is_empty());
    assert!(white.scene.triangles.vertex_colors.is_empty());
    assert!(File::triangle().loaded().scene.triangles.colors.is_empty());
}

/// Opacities of the vertices in an alpha mode.
fn opacities(mode: &str) -> Vec<f32> {
    let mut file = colored(
        &floats(&[1., 0., 0., 1., 0., 1., 0., 0.5, 0., 0., 1., 0.]),
        FLOAT,
        4,
    );
    file.json["materials"] = json!([{"alphaMode": mode}]);
    file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    file.loaded().scene.triangles.vertex_opacity.to_vec()
}

#[test]
fn the_alpha_of_colours_counts_in_masks_and_blends_alone() {
    assert_eq!(opacities("OPAQUE"), [1.0; 3]);
    assert_eq!(opacities("MASK"), [1.0, 0.5, 0.0]);
    assert_eq!(opacities("BLEND"), [1.0, 0.5, 0.0]);
}
