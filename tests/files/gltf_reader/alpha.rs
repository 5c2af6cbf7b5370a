//! Alpha modes: opacity of surfaces.

use super::{File, base64, messages};
use glam::Vec3;
use phalanx::formats::Loaded;
use phalanx::scene::{Material, NO_TEXTURE};
use serde_json::{Value, json};

/// A picture of 2 × 1 texels without alpha.
const OPAQUE: &[u8] = include_bytes!("two.png");

/// A picture of 2 × 1 texels, the right one transparent.
fn clear_right() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().expect("a header");
    writer
        .write_image_data(&[0, 255, 0, 255, 0, 0, 0, 0])
        .expect("texels");
    writer.finish().expect("a picture");
    bytes
}

fn loaded(material: Value, picture: Option<&[u8]>) -> Loaded {
    let mut file = File::triangle();
    let mut material = material;
    if let Some(picture) = picture {
        let uvs = file.floats(2, &[0., 0., 1., 0., 0., 1.]);
        file.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uvs);
        material["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
        file.json["textures"] = json!([{"source": 0}]);
        let uri = format!("data:image/png;base64,{}", base64(picture));
        file.json["images"] = json!([{"uri": uri}]);
    }
    file.json["materials"] = json!([material]);
    file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    let loaded = file.loaded();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    loaded
}

/// A material with this mode and alpha factor.
fn paint(mode: Value, alpha: f64) -> Value {
    json!({
        "alphaMode": mode,
        "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 1, alpha], "metallicFactor": 0}
    })
}

fn material(material: Value, picture: Option<&[u8]>) -> Material {
    loaded(material, picture).scene.materials.get(0)
}

/// Opacity, its texture and the cutoff.
fn cover(material: Material) -> (f32, u32, f32) {
    (
        material.opacity,
        material.opacity_texture,
        material.alpha_cutoff,
    )
}

const WHOLE: (f32, u32, f32) = (1.0, NO_TEXTURE, 0.0);

#[test]
fn opaque_materials_ignore_alpha() {
    let picture = clear_right();
    for mode in [json!("OPAQUE"), json!(null), json!("ELSE")] {
        let opaque = loaded(paint(mode, 0.25), Some(&picture));
        assert_eq!(cover(opaque.scene.materials.get(0)), WHOLE);
        assert!(opaque.scene.textures[0].alpha.is_empty(), "nobody reads it");
    }
}

#[test]
fn blended_materials_take_the_alpha_of_factor_and_texture() {
    let picture = clear_right();
    let even = material(paint(json!("BLEND"), 0.25), None);
    assert_eq!(cover(even), (0.25, NO_TEXTURE, 0.0));
    // Coverage weighs the surface as a whole: its colours are those of an opaque one.
    let opaque = material(paint(json!("OPAQUE"), 0.25), None);
    assert_eq!(
        (even.ka, even.kd, even.ks),
        (opaque.ka, opaque.kd, opaque.ks)
    );
    assert_eq!(even.kt, Vec3::ZERO);
    let textured = loaded(paint(json!("BLEND"), 1.0), Some(&picture));
    let blended = textured.scene.materials.get(0);
    assert_eq!((cover(blended), blended.texture), ((1.0, 0, 0.0), 0));
    assert_eq!(textured.scene.textures[0].alpha, [255, 0]);
    let unblended = material(paint(json!("BLEND"), 0.5), Some(OPAQUE));
    assert_eq!(cover(unblended), (0.5, NO_TEXTURE, 0.0));
}

#[test]
fn masks_have_a_cutoff() {
    let picture = clear_right();
    let mask = |alpha: f64, cutoff: Value, picture: Option<&[u8]>| {
        let mut paint = paint(json!("MASK"), alpha);
        if cutoff != Value::Null {
            paint["alphaCutoff"] = cutoff;
        }
        cover(material(paint, picture))
    };
    let clear = Some(&picture[..]);
    assert_eq!(mask(1.0, Value::Null, clear), (1.0, 0, 0.5));
    assert_eq!(mask(0.75, json!(0.25), clear), (0.75, 0, 0.25));
    // With a cutoff of 0 every alpha is enough, and with one above 1 none.
    assert_eq!(mask(1.0, json!(0), clear), WHOLE);
    assert_eq!(mask(1.0, json!(-1), clear), WHOLE);
    assert_eq!(mask(1.0, json!(1.5), clear), (0.0, NO_TEXTURE, 0.0));
    assert_eq!(mask(1.0, json!(1e300), clear), (0.0, NO_TEXTURE, 0.0));
    // One alpha all over the surface is decided by the reader.
    for picture in [None, Some(OPAQUE)] {
        assert_eq!(mask(0.5, Value::Null, picture), WHOLE);
        assert_eq!(mask(0.25, Value::Null, picture).0, 0.0);
        assert_eq!(mask(0.3, json!(0.3), picture), WHOLE);
    }
}

#[test]
fn old_materials_have_an_alpha_of_their_own() {
    let old = json!({
        "alphaMode": "BLEND",
        "extensions": {"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [1, 0, 0, 0.125]}}
    });
    let old = material(old, None);
    assert_eq!((cover(old), old.kd), ((0.125, NO_TEXTURE, 0.0), Vec3::X));
    let unlit = json!({
        "alphaMode": "BLEND",
        "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 0.5]},
        "extensions": {"KHR_materials_unlit": {}}
    });
    assert_eq!(material(unlit, None).opacity, 0.5);
}

#[test]
fn a_picture_that_is_not_there_has_no_alpha() {
    let mut file = File::triangle();
    let mut mask = paint(json!("MASK"), 1.0);
    mask["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
    file.json["materials"] = json!([mask]);
    file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    file.json["textures"] = json!([{"source": 0}]);
    file.json["images"] = json!([{"uri": "absent.png"}]);
    let loaded = file.loaded();
    assert_eq!(cover(loaded.scene.materials.get(0)), WHOLE);
    assert!(messages(&loaded.warnings)[0].contains("left out"));
}
