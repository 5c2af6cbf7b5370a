//! Defaults of a mesh about which its file says nothing: materials, size and tone of its picture.

use glam::Vec3;
use phalanx_scene::{DefaultedParts, Material, OutputEncoding, Scene};

/// The material of a mesh that names none: a warm light grey, matt.
pub(crate) const GREY: Material = Material {
    ka: Vec3::new(0.075, 0.073, 0.07),
    ke: Vec3::ZERO,
    kd: Vec3::new(0.75, 0.73, 0.70),
    ks: Vec3::ZERO,
    kt: Vec3::ZERO,
    shininess: 1.0,
    ior: 1.0,
    texture: phalanx_scene::NO_TEXTURE,
    ..Material::DEFAULT
};

/// The material beneath colours of vertices or faces, if the mesh names none: white, matt.
pub(crate) const WHITE: Material = Material {
    ka: Vec3::splat(0.1),
    kd: Vec3::ONE,
    ..GREY
};

/// An empty scene for a mesh, with only the picture's size and tone, and with smooth shadows.
/// Formats with only triangles give none of the other parts.
pub(crate) fn empty_scene() -> Scene {
    Scene {
        width: 1280,
        height: 960,
        max_depth: 5,
        smooth_shadows: true,
        encoding: OutputEncoding::SRGB,
        defaulted: DefaultedParts {
            view: true,
            light: true,
            samples: true,
            sky: true,
            ..DefaultedParts::default()
        },
        ..Scene::default()
    }
}
