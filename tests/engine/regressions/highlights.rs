//! Highlights without a mirror: KhronosGroup/glTF-Sample-Viewer#494, black plastic.

use crate::textures::{film, square, texture};
use glam::Vec3;
use phalanx::scene::{LobeWeights, Material, MetallicRoughness, Scene, Wrap};
use std::f32::consts::PI;

/// A square of one pixel, seen straight on, with this material and nothing else to see.
fn plate(material: Material) -> Scene {
    let picture = texture(1, 1, [Wrap::Repeat; 2], |_, _| [255; 3]);
    let mut scene = square([1, 1], picture, None);
    scene.materials = Default::default();
    scene.materials.push(&Material {
        ka: Vec3::ZERO,
        ..material
    });
    scene.background = Vec3::ONE;
    scene
}

fn plastic(roughness: f32) -> Material {
    let lobes = LobeWeights::of([0.0], [roughness]);
    Material {
        highlight: Vec3::splat(0.04),
        shininess: lobes.shininess[0],
        ..Material::DEFAULT
    }
}

fn lit(material: Material, light: Vec3) -> f32 {
    let mut scene = plate(material);
    scene.lights.add_directional(light.normalize(), Vec3::ONE);
    film(&scene).pixel(0, 0)[0]
}

#[test]
fn black_plastic_is_as_bright_as_ggx_at_the_middle_of_its_highlight() {
    for roughness in [0.3, 0.4, 0.5, 0.7, 1.0f32] {
        let ggx = 0.04 / (4.0 * roughness.powi(4));
        let middle = lit(plastic(roughness), Vec3::Z);
        assert!(
            (middle / ggx - 1.0).abs() < 1e-3,
            "{roughness}: {middle}, not {ggx}"
        );
        // The lobe fades out where the light ends, with no edge.
        let grazing = lit(plastic(roughness), Vec3::new(1.0, 0.0, 1e-3));
        assert!(grazing < 0.01 * middle, "{roughness}: {grazing}");
    }
}

#[test]
fn a_highlight_mirrors_nothing() {
    // The background is white, and would be seen in a mirror.
    assert_eq!(film(&plate(plastic(0.1))).pixel(0, 0), [0.0; 3]);
}

#[test]
fn constant_and_varied_plastic_have_the_same_highlight() {
    let light = Vec3::new(0.5, 0.2, 1.0);
    for (metallic, roughness) in [(0.0, 0.4), (0.25, 0.6), (0.0, 1.0)] {
        let varied = Material {
            ks: Vec3::splat(0.04),
            metallic_roughness: Some(MetallicRoughness {
                metallic,
                roughness,
            }),
            ..Material::DEFAULT
        };
        let lobes = LobeWeights::of([metallic], [roughness]);
        let constant = Material {
            ks: varied.ks * lobes.dielectric[0],
            highlight: varied.ks * lobes.highlight[0],
            shininess: lobes.shininess[0],
            ..Material::DEFAULT
        };
        let [a, b] = [constant, varied].map(|material| lit(material, light));
        assert!(
            (a / b - 1.0).abs() < 1e-5,
            "{metallic} {roughness}: {a} {b}"
        );
    }
}

#[test]
fn no_highlight_reflects_more_than_it_gets() {
    // Light from 200 × 200 directions of equal solid angle.
    const SIDE: usize = 200;
    for shininess in [0.0, 1.0, 10.0, 100.0] {
        let mut scene = plate(Material {
            highlight: Vec3::ONE,
            shininess,
            ..Material::DEFAULT
        });
        let each = 2.0 * PI / (SIDE * SIDE) as f32 / PI;
        for k in 0..SIDE * SIDE {
            let (row, turn) = ((k / SIDE) as f32 + 0.5, (k % SIDE) as f32 + 0.5);
            let (z, angle) = (row / SIDE as f32, 2.0 * PI * turn / SIDE as f32);
            let across = (1.0 - z * z).sqrt();
            let toward = Vec3::new(across * angle.cos(), across * angle.sin(), z);
            scene.lights.add_directional(toward, Vec3::splat(each));
        }
        let reflected = film(&scene).pixel(0, 0)[0];
        assert!(
            reflected > 0.2 && reflected < 1.01,
            "{shininess}: {reflected}"
        );
    }
}
