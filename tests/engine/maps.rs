//! Textures that vary a material: emission, lobes and normals by hand-computed values, and random
//! maps for the comparison of both engines.

use crate::common::rng::Rng;
use crate::textures::{film, square, texture};
use glam::{DAffine3, DMat3, Vec2, Vec3};
use phalanx::scene::{
    LobeWeights, MapTarget, Material, MetallicRoughness, Scene, TextureMap, Wrap,
};

/// The lower left corner of the picture stands at that of the square.
const UVS: [Vec2; 4] = [
    Vec2::new(0.0, 1.0),
    Vec2::ONE,
    Vec2::new(1.0, 0.0),
    Vec2::ZERO,
];

/// A square of one pixel with a texture of one texel, a map of it, and light along `light`.
fn mapped(texel: [u8; 3], map: TextureMap, material: Material, light: Vec3) -> Scene {
    let picture = texture(1, 1, [Wrap::Repeat; 2], |_, _| texel);
    let mut scene = square([1, 1], picture, Some(UVS));
    scene.materials = Default::default();
    let maps = scene.maps.push_all(&[map]);
    scene.materials.push(&Material {
        ka: Vec3::ZERO,
        maps,
        ..material
    });
    scene.lights.add_directional(light.normalize(), Vec3::ONE);
    scene.add_missing_tangents();
    scene
}

fn map(target: MapTarget) -> TextureMap {
    TextureMap {
        target,
        texture: 0,
        channel: 1,
        uv_layer: 0,
        scale: 1.0,
    }
}

fn pixel(scene: &Scene) -> Vec3 {
    Vec3::from(film(scene).pixel(0, 0))
}

#[track_caller]
fn assert_near(actual: Vec3, expected: Vec3) {
    let apart = (actual - expected).abs().max_element();
    assert!(apart < 1e-6, "{actual} instead of {expected}");
}

#[test]
fn an_emission_map_glows_by_itself() {
    let glow = Material {
        ke: Vec3::new(2.0, 1.0, 0.5),
        ..Material::DEFAULT
    };
    let scene = mapped([255, 188, 0], map(MapTarget::Emission), glow, -Vec3::Z);
    let half = phalanx::sampling::linear_of_srgb()[188];
    assert_near(pixel(&scene), Vec3::new(2.0, half, 0.0));
}

#[test]
fn lobes_of_a_map_are_those_of_constants() {
    let base = Material {
        kd: Vec3::new(0.8, 0.4, 0.2),
        ks: Vec3::splat(0.04),
        metallic_roughness: Some(MetallicRoughness {
            metallic: 1.0,
            roughness: 0.3,
        }),
        ..Material::DEFAULT
    };
    let light = Vec3::new(0.3, 0.2, 1.0);
    for (target, [metallic, roughness]) in [
        (MapTarget::Metallic, [102.0 / 255.0, 0.3]),
        (MapTarget::Roughness, [1.0, 102.0 / 255.0 * 0.3]),
    ] {
        // The same once more with the map's value as a constant.
        let constant = Material {
            metallic_roughness: Some(MetallicRoughness {
                metallic,
                roughness,
            }),
            ..base
        };
        let actual = pixel(&mapped([9, 102, 200], map(target), base, light));
        let expected = pixel(&mapped([255; 3], map(target), constant, light));
        assert_near(actual, expected);
        // And the constant is Blinn-Phong of the table's weights.
        let lobes = LobeWeights::of([metallic], [roughness]);
        let ([metal], [dielectric], [s]) = (lobes.metal, lobes.dielectric, lobes.shininess);
        let highlight = base.ks * (1.0 - metallic) * (s + 2.0) / 8.0;
        let to_light = light.normalize();
        let half = (to_light + Vec3::Z).normalize();
        let ks = base.ks * dielectric + base.kd * metal;
        let lobe = ks + highlight * to_light.z;
        let lit = base.kd * (1.0 - metal) * to_light.z + lobe * half.z.powf(s);
        assert_near(actual, lit);
    }
    let matt = LobeWeights::of([1.0], [0.5]);
    assert_eq!((matt.metal, matt.dielectric), ([0.0], [0.0]));
}

#[test]
fn factors_of_ks_and_its_exponent() {
    let shiny = Material {
        ks: Vec3::splat(0.5),
        shininess: 40.0,
        ..Material::DEFAULT
    };
    let light = Vec3::new(0.5, 0.0, 1.0);
    let half = (light.normalize() + Vec3::Z).normalize().z;
    let dim = phalanx::sampling::linear_of_srgb()[102];
    let specular = pixel(&mapped([102; 3], map(MapTarget::Specular), shiny, light));
    assert_near(specular, Vec3::splat(0.5 * dim * half.powf(40.0)));
    let duller = pixel(&mapped([0, 51, 0], map(MapTarget::Shininess), shiny, light));
    assert_near(duller, Vec3::splat(0.5 * half.powf(8.0)));
}

/// Diffuse light from `light` on a white square, bumped by a normal map of one texel.
fn bumped(texel: [u8; 3], scale: f32, light: Vec3) -> Scene {
    let white = Material {
        kd: Vec3::ONE,
        ..Material::DEFAULT
    };
    let normal = TextureMap {
        scale,
        ..map(MapTarget::Normal)
    };
    mapped(texel, normal, white, light)
}

fn decoded(texel: [u8; 3], scale: f32) -> Vec3 {
    let unit = Vec3::from(texel.map(f32::from)) / 255.0 * 2.0 - 1.0;
    (unit * Vec3::new(scale, scale, 1.0)).normalize()
}

#[test]
fn a_normal_map_turns_the_shading_normal() {
    let light = Vec3::new(0.6, 0.3, 0.7);
    // Red is to the right, green upward, blue toward the viewer.
    for (texel, scale) in [([220, 90, 200], 1.0), ([40, 200, 230], 0.5)] {
        let expected = decoded(texel, scale).dot(light.normalize());
        assert_near(pixel(&bumped(texel, scale, light)), Vec3::splat(expected));
    }
}

#[test]
fn relief_follows_its_instance() {
    let light = Vec3::new(0.6, 0.3, 0.7);
    let texel = [220, 90, 200];
    let plain = bumped(texel, 1.0, light);
    let (corners, uvs) = (plain.triangles.corners.clone(), plain.triangles.uvs.clone());
    for matrix in [
        DMat3::from_diagonal(glam::dvec3(-1.0, 1.0, 1.0)),
        DMat3::from_cols_array(&[2.0, 0.0, 0.0, 0.7, 1.5, 0.0, 0.0, 0.0, 3.0]),
        DMat3::from_rotation_z(1.0),
    ] {
        let mut scene = bumped(texel, 1.0, light);
        // The world's own square makes way for an instance of it.
        let mut shown = Scene {
            prims: Default::default(),
            triangles: Default::default(),
            ..scene.clone()
        };
        let mesh = shown.begin_mesh();
        let t = &mut scene.triangles;
        shown.append_mesh(phalanx::scene::Mesh {
            vertices: std::mem::take(&mut t.vertices),
            corners: corners.clone(),
            uvs: uvs.clone(),
            vertex_uvs: std::mem::take(&mut t.vertex_uvs),
            ..Default::default()
        });
        shown.end_mesh(mesh);
        shown.add_missing_tangents();
        let placed = DAffine3::from_mat3(matrix);
        shown.add_instance(mesh, placed).expect("invertible");
        let normal = matrix.inverse().transpose() * decoded(texel, 1.0).as_dvec3();
        let expected = normal.normalize().as_vec3().dot(light.normalize()).max(0.0);
        assert_near(pixel(&shown), Vec3::splat(expected));
    }
}

#[test]
fn normals_never_point_behind_their_surface() {
    // Blue 0 points straight behind: mirrored at the surface, it is the plain normal.
    let light = Vec3::new(0.4, 0.0, 1.0);
    let expected = Vec3::splat(light.normalize().z);
    let plain = [128, 128, 0];
    let tilt = (decoded(plain, 1.0) * Vec3::new(1.0, 1.0, -1.0)).dot(light.normalize());
    assert!((tilt - expected.x).abs() < 0.01);
    assert_near(pixel(&bumped(plain, 1.0, light)), Vec3::splat(tilt));
}

/// Up to four maps of any kind, for scenes of `textures` textures and two layers of texture
/// coordinates.
pub(crate) fn random_maps(rng: &mut Rng, textures: usize) -> Vec<TextureMap> {
    let targets = [
        MapTarget::Emission,
        MapTarget::Specular,
        MapTarget::Shininess,
        MapTarget::Metallic,
        MapTarget::Roughness,
        MapTarget::Normal,
        MapTarget::Normal,
    ];
    let one = |rng: &mut Rng| TextureMap {
        target: rng.pick(&targets),
        texture: rng.below(textures) as u32,
        channel: rng.below(3) as u32,
        uv_layer: rng.below(2) as u32,
        scale: rng.pick(&[1.0, 1.0, 0.3, -2.0, 0.0, 40.0]),
    };
    let count = rng.pick(&[0, 1, 2, 4]);
    (0..count).map(|_| one(rng)).collect()
}

/// Metallic and roughness of half of all materials.
pub(crate) fn random_lobes(rng: &mut Rng) -> Option<MetallicRoughness> {
    rng.once_in(2).then(|| MetallicRoughness {
        metallic: rng.pick(&[0.0, 1.0, 0.5]),
        roughness: rng.pick(&[0.0, 0.1, 0.3, 0.5, 1.0]),
    })
}

/// Tangents of any direction and length, 0 among them, and signs: one for each of `count` vertices.
pub(crate) fn random_tangents(rng: &mut Rng, count: usize) -> (Vec<Vec3>, Vec<f32>) {
    let tangent = |rng: &mut Rng| rng.direction() * rng.pick(&[1.0, 1.0, 0.0, 1e-20, 1e10]);
    let tangents = (0..count).map(|_| tangent(rng)).collect();
    let signs = (0..count).map(|_| rng.pick(&[1.0, -1.0])).collect();
    (tangents, signs)
}
