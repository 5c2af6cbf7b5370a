//! Views, lights and materials shared by the databases.

use crate::builder::{MaterialDesc, NffMaterial, SceneBuilder, StandardLight, StandardView};
use glam::{DVec3, dvec3};

/// The sky of all databases but jacks: "UNC sky blue".
pub(super) const SKY: DVec3 = dvec3(0.078, 0.361, 0.753);

/// A square view of `side` pixels, `angle` in NFF's sense, with z up.
pub(super) fn view(from: DVec3, target: DVec3, angle: f64, side: u32) -> StandardView {
    StandardView {
        from,
        at: target,
        up: DVec3::Z,
        fovy: StandardView::of_pixel_centres(angle, side),
        width: side,
        height: side,
    }
}

/// The statements before the first surface.
pub(super) fn prelude(
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

/// An opaque, matt material, as in most scenes.
pub(super) fn matte(rgb: DVec3) -> NffMaterial {
    shiny(rgb, [1.0, 0.0], 0.0, 0.0)
}

/// An opaque material with this diffuse and specular part, whose highlight falls to one half at
/// `degrees` ([`shine`]). `ior` is 0 if the original leaves it open.
pub(super) fn shiny(rgb: DVec3, [kd, ks]: [f64; 2], degrees: f64, ior: f64) -> NffMaterial {
    NffMaterial {
        rgb,
        kd,
        ks,
        shine: shine(degrees),
        transmittance: 0.0,
        ior,
    }
}

/// The Phong exponent whose highlight falls to one half at this angle from its middle, in degrees.
/// At 0 the original writes 100000, "essentially invisible".
pub(super) fn shine(degrees: f64) -> f64 {
    if degrees <= 0.0 {
        return 100_000.0;
    }
    libm::log(0.5) / libm::log(libm::cos(degrees.to_radians()))
}

pub(super) fn surface(builder: &mut dyn SceneBuilder, material: NffMaterial) {
    builder.material(&MaterialDesc::Nff(material));
}

/// The corners (±x, ±y) of a rectangle about the z axis at height `z`, counter-clockwise from
/// above.
pub(super) fn rectangle(x: f64, y: f64, z: f64) -> [DVec3; 4] {
    [
        dvec3(x, y, z),
        dvec3(-x, y, z),
        dvec3(-x, -y, z),
        dvec3(x, -y, z),
    ]
}
