//! The Standard Procedural Databases: E. Haines, "A Proposal for Standard Graphics Environments",
//! IEEE Computer Graphics and Applications 7(11), November 1987, pages 3 to 5. The algorithms and
//! constants are those of the SPD package, version 3.14; each file names its program.
//!
//! Primitives come in the order of the original programs, so that a scene of this module and an NFF
//! file of the original program agree primitive by primitive. Pictures have 512 × 512 pixels and
//! rays of depth 5, which counts the eye's: 4 bounces.

pub(super) mod balls;
pub(super) mod gears;
pub(super) mod jacks;
pub(super) mod lattice;
pub(super) mod mount;
pub(super) mod rings;
mod rotation;
pub(super) mod shells;
pub(super) mod sombrero;
pub(super) mod teapot;
mod teapot_data;
pub(super) mod tetra;
pub(super) mod tree;

use super::builder::{MaterialDesc, NffMaterial, SceneBuilder, StandardLight, StandardView};
use glam::{DVec3, dvec3};

/// Bounces after the eye ray.
const MAX_DEPTH: u32 = 4;

/// The sky of all databases but jacks: "UNC sky blue".
const SKY: DVec3 = dvec3(0.078, 0.361, 0.753);

/// A square view of `side` pixels, `angle` in NFF's sense, with z up.
fn view(from: DVec3, at: DVec3, angle: f64, side: u32) -> StandardView {
    StandardView {
        from,
        at,
        up: DVec3::Z,
        fovy: StandardView::of_pixel_centres(angle, side),
        width: side,
        height: side,
    }
}

/// The statements before the first surface.
fn prelude(
    builder: &mut dyn SceneBuilder,
    background: DVec3,
    view: &StandardView,
    lights: &[DVec3],
) {
    builder.background(background);
    builder.view(view);
    for &position in lights {
        builder.light(&StandardLight::of_level(position));
    }
}

/// An opaque, dull material, as in most scenes.
fn matte(rgb: DVec3) -> NffMaterial {
    NffMaterial {
        rgb,
        kd: 1.0,
        ks: 0.0,
        shine: shine(0.0),
        transmittance: 0.0,
        ior: 0.0,
    }
}

/// The Phong exponent whose highlight falls to one half at this angle from its middle, in degrees.
/// At 0 the original writes 100000, "essentially invisible".
fn shine(degrees: f64) -> f64 {
    if degrees <= 0.0 {
        return 100_000.0;
    }
    libm::log(0.5) / libm::log(libm::cos(degrees.to_radians()))
}

fn surface(builder: &mut dyn SceneBuilder, material: NffMaterial) {
    builder.material(&MaterialDesc::Nff(material));
}

/// The corners (±x, ±y) of a rectangle about the z axis at height `z`, counter-clockwise from
/// above.
fn rectangle(x: f64, y: f64, z: f64) -> [DVec3; 4] {
    [
        dvec3(x, y, z),
        dvec3(-x, y, z),
        dvec3(-x, -y, z),
        dvec3(x, -y, z),
    ]
}
