//! Materials, textures, lights and cameras.

use super::{File, base64, messages};
use glam::{Vec2, Vec3};
use phalanx::formats::{Loaded, Options, Overrides, ReadOptions, load};
use phalanx::scene::{MapTarget, Material, NO_TEXTURE, OutputEncoding, Scene, TextureMap, Wrap};
use serde_json::{Value, json};

/// A picture of 2 × 1 texels, red and green.
const PNG: &[u8] = include_bytes!("two.png");

fn with_material(material: Value) -> File {
    let mut file = File::triangle();
    let row = file.add("materials", material);
    file.json["meshes"][0]["primitives"][0]["material"] = json!(row);
    file
}

fn surface(material: Value) -> Material {
    with_material(material).loaded().scene.materials.get(0)
}

fn pbr(metallic: f64, roughness: f64) -> Value {
    json!({"pbrMetallicRoughness": {
        "baseColorFactor": [0.5, 0.25, 1, 1],
        "metallicFactor": metallic,
        "roughnessFactor": roughness,
    }})
}

const COLOR: Vec3 = Vec3::new(0.5, 0.25, 1.0);

fn near(a: Vec3, b: Vec3) {
    assert!((a - b).abs().max_element() < 1e-6, "{a} is not {b}");
}

#[test]
fn metallic_roughness() {
    let matt = surface(pbr(1.0, 1.0));
    assert_eq!(
        (matt.kd, matt.ks, matt.kt, matt.texture),
        (COLOR, Vec3::ZERO, Vec3::ZERO, NO_TEXTURE)
    );
    near(matt.ka, COLOR * 0.1);
    let mirror = surface(pbr(1.0, 0.0));
    assert_eq!(
        (mirror.kd, mirror.ks, mirror.shininess),
        (Vec3::ZERO, COLOR, 10_000.0)
    );
    let polished = surface(pbr(0.0, 0.0));
    near(polished.ks, Vec3::splat(0.04));
    near(polished.highlight, Vec3::splat(0.04));
    assert_eq!((matt.highlight, mirror.highlight), (Vec3::ZERO, Vec3::ZERO));
    near(polished.kd, COLOR);
    // Half way to matt a quarter is left of the mirror image.
    let brushed = surface(pbr(1.0, 0.25));
    near(brushed.ks, COLOR * 0.25);
    near(brushed.kd, COLOR * 0.75);
    assert_eq!(brushed.shininess, 510.0);
}

#[test]
fn extensions_of_materials() {
    let glass = |volume: f64| {
        let mut material = pbr(0.0, 0.0);
        material["extensions"] = json!({
            "KHR_materials_transmission": {"transmissionFactor": 0.75},
            "KHR_materials_ior": {"ior": 2.0},
            "KHR_materials_volume": {"thicknessFactor": volume},
        });
        surface(material)
    };
    near(glass(1.0).kt, COLOR * 0.75);
    near(glass(1.0).kd, COLOR * 0.25);
    near(glass(1.0).ks, Vec3::splat(1.0 / 9.0));
    assert_eq!((glass(1.0).ior, glass(0.0).ior), (2.0, 1.0));
    let lamp = surface(json!({
        "emissiveFactor": [0.5, 1, 0],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8}}
    }));
    assert_eq!(lamp.ke, Vec3::new(4.0, 8.0, 0.0));
    let mut unlit = pbr(0.0, 0.5);
    unlit["extensions"] = json!({
        "KHR_materials_unlit": {},
        "KHR_materials_emissive_strength": {"emissiveStrength": 8}
    });
    unlit["emissiveFactor"] = json!([0, 0, 1]);
    let unlit = surface(unlit);
    assert_eq!((unlit.ka, unlit.ke), (COLOR, Vec3::ZERO));
    assert_eq!((unlit.kd, unlit.ks), (Vec3::ZERO, Vec3::ZERO));
    let old = surface(
        json!({"extensions": {"KHR_materials_pbrSpecularGlossiness": {
            "diffuseFactor": [0.5, 0.25, 1, 1], "specularFactor": [0.25, 0.5, 0.125], "glossinessFactor": 1
        }}}),
    );
    assert_eq!((old.kd, old.ks), (COLOR, Vec3::new(0.25, 0.5, 0.125)));
}

#[test]
fn materials_are_single_sided_unless_they_say_otherwise_or_transmit() {
    let is_single_sided = |material: Value| surface(material).single_sided;
    assert!(is_single_sided(json!({})));
    assert!(is_single_sided(
        json!({"doubleSided": false, "alphaMode": "BLEND"})
    ));
    assert!(is_single_sided(
        json!({"extensions": {"KHR_materials_unlit": {}}})
    ));
    assert!(!is_single_sided(json!({"doubleSided": true})));
    assert!(!is_single_sided(
        json!({"doubleSided": true, "extensions": {"KHR_materials_unlit": {}}})
    ));
    let transmission = json!({"transmissionFactor": 0.5});
    assert!(!is_single_sided(
        json!({"extensions": {"KHR_materials_transmission": transmission}, "pbrMetallicRoughness": {"metallicFactor": 0}})
    ));
    // The default material of glTF, and the user's.
    let bare = |options: &Options| {
        let bytes = File::triangle().glb();
        let loaded = phalanx::formats::read_bytes("glb", &bytes, options);
        let loaded = loaded.expect("a known ending").expect("a scene");
        loaded.scene.materials.get(0).single_sided
    };
    let given = Options {
        read: ReadOptions {
            material: Some(Material::DEFAULT),
            ..ReadOptions::default()
        },
        ..Options::default()
    };
    let two_sided = Options {
        look: Overrides {
            two_sided: true,
            ..Overrides::default()
        },
        ..Options::default()
    };
    assert!(bare(&Options::default()));
    assert!(!bare(&given) && !bare(&two_sided));
}

#[test]
fn transmission_without_a_volume_is_a_thin_sheet() {
    let sheet = |change: fn(&mut Value)| {
        let mut material = pbr(0.0, 0.0);
        material["extensions"] = json!({
            "KHR_materials_transmission": {"transmissionFactor": 0.75},
            "KHR_materials_ior": {"ior": 2.0},
        });
        change(&mut material);
        with_material(material).loaded()
    };
    let thin = sheet(|_| ()).scene.materials.get(0);
    assert!(thin.thin && thin.ior == 1.0, "{thin:?}");
    near(thin.kt, COLOR * 0.75);
    let glass = sheet(|material| {
        material["extensions"]["KHR_materials_volume"] = json!({"thicknessFactor": 0.1});
    });
    let glass = glass.scene.materials.get(0);
    assert!(!glass.thin && glass.ior == 2.0, "{glass:?}");
    let metal = sheet(|material| material["pbrMetallicRoughness"]["metallicFactor"] = json!(1));
    assert!(
        !metal.scene.materials.get(0).thin,
        "metals transmit nothing"
    );
    // A texture that is not read may say anything.
    let unread = sheet(|material| {
        let transmission = &mut material["extensions"]["KHR_materials_transmission"];
        transmission["transmissionTexture"] = json!({"index": 0});
    });
    let opaque = unread.scene.materials.get(0);
    assert!(!opaque.thin && opaque.kt == Vec3::ZERO, "{opaque:?}");
    near(opaque.kd, COLOR);
    let warnings = messages(&unread.warnings);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(
        warnings[0].contains("transmission textures"),
        "{warnings:?}"
    );
}

#[test]
fn what_is_not_shown_is_told_once() {
    let loaded = with_material(json!({
        "occlusionTexture": {"index": 0}, "emissiveTexture": {}, "emissiveFactor": [1, 1, 1],
        "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 1}}
    }))
    .loaded();
    assert_eq!(loaded.scene.materials.get(0).ke, Vec3::ZERO);
    let warnings = messages(&loaded.warnings);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains("occlusion textures"), "{warnings:?}");
    assert!(
        warnings[0].contains("`KHR_materials_clearcoat`"),
        "{warnings:?}"
    );
}

#[test]
fn the_users_material_stands_in_where_there_is_none() {
    let bytes = File::triangle().glb();
    let red = Material {
        kd: Vec3::X,
        ..Material::default()
    };
    let options = Options {
        read: ReadOptions {
            material: Some(red),
            ..ReadOptions::default()
        },
        ..Options::default()
    };
    let read = |options: &Options| {
        let loaded = phalanx::formats::read_bytes("glb", &bytes, options);
        loaded
            .expect("an ending")
            .expect("a scene")
            .scene
            .materials
            .get(0)
    };
    assert_eq!(read(&options), red);
    assert!(
        read(&Options::default()).kd.min_element() > 0.5,
        "light grey"
    );
}

/// A triangle with a picture at the location given by `image`.
fn textured(image: impl FnOnce(&mut File) -> Value) -> File {
    let mut file = with_material(json!({
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0}
    }));
    let uvs = file.floats(2, &[0., 0., 1., 0., 0., 1.]);
    let second = file.floats(2, &[0.5, 0.5, 0.25, 0.5, 0.5, 0.25]);
    let attributes = &mut file.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["TEXCOORD_0"] = json!(uvs);
    attributes["TEXCOORD_1"] = json!(second);
    file.json["textures"] = json!([{"source": 0, "sampler": 0}]);
    file.json["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648}]);
    file.json["images"] = json!([image(&mut file)]);
    file
}

fn data_uri(_: &mut File) -> Value {
    json!({"uri": format!("data:image/png;base64,{}", base64(PNG))})
}

fn assert_textured(loaded: &Loaded) {
    let scene = &loaded.scene;
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    assert_eq!(scene.materials.texture[0], 0);
    let texture = &scene.textures[0];
    assert_eq!((texture.width, texture.height), (2, 1));
    assert_eq!(texture.texels, [[255, 0, 0], [0, 255, 0]]);
    assert_eq!(texture.wrap, [Wrap::Clamp, Wrap::Mirror]);
    let uvs = scene.triangles.corner_uvs(0, 0).expect("uvs");
    assert_eq!(uvs, [Vec2::ZERO, Vec2::X, Vec2::Y]);
}

#[test]
fn pictures_in_buffers_text_and_files() {
    assert_textured(
        &textured(|file| json!({"bufferView": file.view(PNG), "mimeType": "image/png"})).loaded(),
    );
    assert_textured(&textured(data_uri).loaded());
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a b.png"), PNG).unwrap();
    let path = folder.path().join("scene.gltf");
    let mut file = textured(|_| json!({"uri": "a%20b.png"}));
    let mut json = file.json.clone();
    json["buffers"] = json!([{"byteLength": file.buffer.len(), "uri": "scene%2Ebin"}]);
    std::fs::write(folder.path().join("scene.bin"), &file.buffer).unwrap();
    std::fs::write(&path, json.to_string()).unwrap();
    assert_textured(&load(&path, &Options::default()).expect("a scene"));
    // Not there, or not a picture: a flat colour, and a warning.
    for (uri, reason) in [
        ("absent.png", ""),
        (
            "data:image/png;base64,AAAA",
            "not a picture of a kind that is read",
        ),
        ("data:image/png;base64,A?AA", "base64 text is broken"),
        ("data:,x", "not a picture of a kind that is read"),
        ("../a.png", "folder"),
    ] {
        file.json["images"] = json!([{"uri": uri}]);
        let loaded = file.loaded();
        assert_eq!(loaded.scene.materials.texture[0], NO_TEXTURE);
        let message = messages(&loaded.warnings)[0];
        assert!(
            message.contains("left out") && message.contains(reason),
            "{uri}: {message}"
        );
        assert_eq!(loaded.scene.triangles.corner_uvs(0, 0), None);
    }
}

#[test]
fn uvs_are_chosen_and_transformed() {
    let uvs = |info: Value| {
        let mut file = textured(data_uri);
        file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = info;
        file.loaded().scene.triangles.corner_uvs(0, 0).expect("uvs")
    };
    let second = [Vec2::splat(0.5), Vec2::new(0.25, 0.5), Vec2::new(0.5, 0.25)];
    assert_eq!(uvs(json!({"index": 0, "texCoord": 1})), second);
    let transform = |t: Value| uvs(json!({"index": 0, "extensions": {"KHR_texture_transform": t}}));
    assert_eq!(transform(json!({"texCoord": 1})), second);
    let moved = transform(json!({"offset": [0.5, 0.25], "scale": [2, 3]}));
    assert_eq!(
        moved,
        [
            Vec2::new(0.5, 0.25),
            Vec2::new(2.5, 0.25),
            Vec2::new(0.5, 3.25)
        ]
    );
    // A quarter turn counter-clockwise, as seen with v downward: u goes up.
    let turned = transform(json!({"rotation": std::f64::consts::FRAC_PI_2}));
    assert!(
        (turned[1] - Vec2::new(0.0, -1.0)).length() < 1e-6,
        "{turned:?}"
    );
    assert!(
        (turned[2] - Vec2::new(1.0, 0.0)).length() < 1e-6,
        "{turned:?}"
    );
}

/// Maps of the first material.
fn maps(scene: &Scene) -> Vec<TextureMap> {
    scene.maps.range(scene.materials.get(0).maps).collect()
}

#[test]
fn maps_have_channels_and_layers_of_their_own() {
    let mut file = textured(data_uri);
    let second = || json!({"index": 0, "texCoord": 1});
    let material = &mut file.json["materials"][0];
    material["emissiveFactor"] = json!([1, 2, 3]);
    material["emissiveTexture"] = second();
    material["normalTexture"] = json!({"index": 0, "scale": 0.5});
    let pbr = &mut material["pbrMetallicRoughness"];
    pbr["metallicRoughnessTexture"] = second();
    pbr["metallicFactor"] = json!(0.75);
    pbr["roughnessFactor"] = json!(0.25);
    let scene = file.loaded().scene;
    let maps_of_scene = maps(&scene).into_iter();
    let maps_of_scene = maps_of_scene.map(|map| (map.target, map.channel, map.uv_layer, map.scale));
    let expected = [
        (MapTarget::Emission, 0, 1, 1.0),
        (MapTarget::Normal, 0, 0, 0.5),
        (MapTarget::Roughness, 1, 1, 1.0),
        (MapTarget::Metallic, 2, 1, 1.0),
    ];
    assert!(maps_of_scene.eq(expected), "{:?}", maps(&scene));
    let material = scene.materials.get(0);
    let lobes = material.metallic_roughness.expect("varied");
    assert_eq!((lobes.metallic, lobes.roughness), (0.75, 0.25));
    assert_eq!(
        (material.kd, material.ke),
        (Vec3::ONE, Vec3::new(1.0, 2.0, 3.0))
    );
    let uvs = |layer| scene.triangles.corner_uvs(0, layer).expect("coordinates");
    assert_ne!(uvs(0), uvs(1));
    assert_eq!(scene.triangles.corner_uvs(0, 2), None);
    // The file has no tangents: those of the texture coordinates.
    assert!(scene.triangles.corner_tangents(0).is_some());
}

#[test]
fn tangents_are_the_files() {
    let tangents = [0.0, 0.0, -2.0, -1.0].repeat(3);
    let with = |normal: Value| {
        let mut file = textured(data_uri);
        let normals = file.floats(3, &[0.0, 0.0, 1.0].repeat(3));
        let rows = file.floats(4, &tangents);
        let attributes = &mut file.json["meshes"][0]["primitives"][0]["attributes"];
        (attributes["NORMAL"], attributes["TANGENT"]) = (json!(normals), json!(rows));
        file.json["materials"][0]["normalTexture"] = normal;
        let scene = file.loaded().scene;
        scene.triangles.corner_tangents(0).expect("tangents")
    };
    let (map, sign) = with(json!({"index": 0}));
    assert_eq!((map, sign), ([-Vec3::Z; 3], -1.0));
    let turned = json!({"index": 0, "extensions": {"KHR_texture_transform": {"rotation": 1}}});
    assert_ne!(
        with(turned).0[0],
        -Vec3::Z,
        "those of the texture coordinates"
    );
}

#[test]
fn textured_metal_is_converted_at_each_hit() {
    let mut file = textured(data_uri);
    let pbr = &mut file.json["materials"][0]["pbrMetallicRoughness"];
    pbr["metallicFactor"] = json!(1);
    pbr["roughnessFactor"] = json!(0);
    let surface = file.loaded().scene.materials.get(0);
    assert_eq!((surface.kd, surface.ks), (Vec3::ONE, Vec3::splat(0.04)));
    assert!(surface.metallic_roughness.is_some());
    // Rough metal is matt paint everywhere.
    file.json["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = json!(0.5);
    let surface = file.loaded().scene.materials.get(0);
    assert_eq!((surface.kd, surface.ks), (Vec3::ONE, Vec3::ZERO));
    assert_eq!(surface.metallic_roughness, None);
}

#[test]
fn defaults_of_a_bare_mesh() {
    let loaded = File::triangle().loaded();
    let scene = &loaded.scene;
    assert_eq!(
        (scene.width, scene.height, scene.encoding),
        (1280, 960, OutputEncoding::SRGB)
    );
    assert_eq!(scene.lights.len(), 2);
    assert!(scene.background.min_element() > 0.0);
}
