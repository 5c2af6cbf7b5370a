//! The view and its orthonormal frame (design document, "Creating an orthonormal coordinate
//! frame").

use glam::{DVec3, Vec3};

/// The camera's view. JSON gives its numbers back to the bit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct View {
    /// Eye position.
    pub eye: Vec3,
    /// The point looked at; must differ from `eye`.
    pub center: Vec3,
    /// Up vector, not parallel to `eye - center`.
    pub up: Vec3,
    /// Vertical field of view in degrees, in (0, 180).
    pub fovy: f32,
    /// Visible height of an orthographic view, in units of the scene, whose rays are parallel;
    /// `None` for a perspective view. An orthographic view's `fovy` is not used.
    #[cfg_attr(
        feature = "serde",
        serde(default, skip_serializing_if = "Option::is_none")
    )]
    pub ortho: Option<f32>,
}

/// The orthonormal camera frame: u to the right, v up, w backward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis {
    /// Right: (b × w)/|b × w| with b the up vector.
    pub u: Vec3,
    /// Up: w × u.
    pub v: Vec3,
    /// Backward: (eye − center)/|eye − center|.
    pub w: Vec3,
}

/// Reasons why a view has no frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ViewError {
    /// `eye == center`.
    #[error("the camera stands on the point it looks at")]
    NoDirection,
    /// `up` is zero.
    #[error("the camera's up vector is zero")]
    NoUp,
    /// `up` is parallel to the view direction.
    #[error("the camera's up vector is parallel to its view direction")]
    UpParallel,
    /// Field of view outside (0, 180).
    #[error("the camera's field of view must lie between 0 and 180 degrees")]
    FieldOfView,
    /// Height of an orthographic view that is zero or negative.
    #[error("the height of the camera's parallel view must be positive")]
    Height,
    /// A component is NaN or infinite.
    #[error("the camera holds a number that is not finite")]
    NotFinite,
}

/// Sine of the angle between `up` and the view direction below which they count as parallel: at
/// 2⁻²⁰ rad the f32 inputs themselves no longer determine the frame.
const PARALLEL: f64 = 1.0 / 1_048_576.0;

impl View {
    /// The frame: w = a/|a| with a = eye − center, u = (b × w)/|b × w|, v = w × u; computed in f64,
    /// once.
    pub fn basis(&self) -> Result<Basis, ViewError> {
        let places = [self.eye, self.center, self.up].map(Vec3::as_dvec3);
        let [u, v, w] = axes(places, self.fovy, self.ortho)?.map(|axis| axis.as_vec3());
        Ok(Basis { u, v, w })
    }
}

/// The frame u, v, w of a view with this eye, center and up vector.
pub(super) fn axes(
    [eye, center, up]: [DVec3; 3],
    fovy: f32,
    ortho: Option<f32>,
) -> Result<[DVec3; 3], ViewError> {
    let numbers = fovy.is_finite() && ortho.is_none_or(f32::is_finite);
    if !(numbers && eye.is_finite() && center.is_finite() && up.is_finite()) {
        return Err(ViewError::NotFinite);
    }
    if ortho.is_some_and(|height| height <= 0.0) {
        return Err(ViewError::Height);
    }
    if !(fovy > 0.0 && fovy < 180.0) {
        return Err(ViewError::FieldOfView);
    }
    let w = (eye - center).try_normalize();
    let w = w.ok_or(ViewError::NoDirection)?;
    let b = up.try_normalize().ok_or(ViewError::NoUp)?;
    let side = b.cross(w);
    if side.length() < PARALLEL {
        return Err(ViewError::UpParallel);
    }
    let u = side.normalize();
    Ok([u, w.cross(u), w])
}
