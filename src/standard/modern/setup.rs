//! Views and lights of the modern scenes.

use crate::builder::{StandardLight, StandardView};
use glam::{DVec3, dvec3};

/// A view of 1280x960 pixels with y up.
pub(super) fn hd(from: DVec3, target: DVec3, fovy: f64) -> StandardView {
    StandardView {
        from,
        at: target,
        up: DVec3::Y,
        fovy,
        width: 1280,
        height: 960,
    }
}

/// A light so far away in this direction that its rays are practically parallel.
pub(super) fn sun(toward: DVec3, color: DVec3) -> StandardLight {
    StandardLight::colored(toward / toward.length() * 1e4, color)
}

/// A lamp that has this colour at distance `reach`. Closer up it is brighter, but at most twice as
/// bright.
pub(super) fn lamp(position: DVec3, color: DVec3, reach: f64) -> StandardLight {
    StandardLight {
        attenuation: dvec3(0.5, 0.0, 0.5 / (reach * reach)),
        ..StandardLight::colored(position, color)
    }
}
