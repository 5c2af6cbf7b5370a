//! Rotations with `libm`, whose sines are the same everywhere; glam uses those of the system's
//! mathematics library.

use glam::{DMat3, DVec3, dvec3};

/// Counter-clockwise rotation about x, radians.
pub(super) fn about_x(angle: f64) -> DMat3 {
    let (sin, cos) = libm::sincos(angle);
    DMat3::from_cols(DVec3::X, dvec3(0.0, cos, sin), dvec3(0.0, -sin, cos))
}

/// Counter-clockwise rotation about y, radians.
pub(super) fn about_y(angle: f64) -> DMat3 {
    let (sin, cos) = libm::sincos(angle);
    DMat3::from_cols(dvec3(cos, 0.0, -sin), DVec3::Y, dvec3(sin, 0.0, cos))
}

/// Counter-clockwise rotation about z, radians.
pub(super) fn about_z(angle: f64) -> DMat3 {
    let (sin, cos) = libm::sincos(angle);
    DMat3::from_cols(dvec3(cos, sin, 0.0), dvec3(-sin, cos, 0.0), DVec3::Z)
}

/// Counter-clockwise rotation about a unit vector, radians (Rodrigues' formula).
pub(super) fn about(axis: DVec3, angle: f64) -> DMat3 {
    let (sin, cos) = libm::sincos(angle);
    let column = |e: DVec3| e * cos + axis.cross(e) * sin + axis * (axis.dot(e) * (1.0 - cos));
    DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))
}
