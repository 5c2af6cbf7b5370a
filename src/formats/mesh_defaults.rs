//! Defaults for the picture of a bare mesh.

use super::defaults::MissingParts;
use glam::Vec3;
use phalanx_scene::{Material, OutputEncoding, Scene, UpAxis};

/// The material of a mesh that names none: a warm light grey, matt.
pub(super) const GREY: Material = Material {
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
pub(super) const WHITE: Material = Material {
    ka: Vec3::splat(0.1),
    kd: Vec3::ONE,
    ..GREY
};

/// Parts that formats with only triangles do not have.
pub(super) const BARE: MissingParts = MissingParts {
    view: true,
    lights: true,
    background: true,
    up: UpAxis::Y,
    up_unsaid: true,
};

/// An empty scene for a mesh, with only the picture's size and tone, and with smooth shadows.
pub(super) fn empty_scene() -> Scene {
    Scene {
        width: 1280,
        height: 960,
        max_depth: 5,
        smooth_shadows: true,
        encoding: OutputEncoding::SRGB,
        ..Scene::default()
    }
}
