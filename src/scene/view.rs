//! The view and its orthonormal frame (design document, "Creating an orthonormal coordinate frame").

use glam::Vec3;

/// Where the picture is taken from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Eye position.
    pub eye: Vec3,
    /// The point looked at; must differ from `eye`.
    pub center: Vec3,
    /// Up vector, not parallel to `eye - center`.
    pub up: Vec3,
    /// Vertical field of view in degrees, in (0, 180).
    pub fovy: f32,
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

/// Why a view has no frame.
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
    /// A component is NaN or infinite.
    #[error("the camera holds a number that is not finite")]
    NotFinite,
}

/// Sine of the angle between `up` and the view direction below which they count as parallel: at 2⁻²⁰ rad the f32
/// inputs themselves no longer determine the frame.
const PARALLEL: f64 = 1.0 / 1_048_576.0;

impl View {
    /// The frame: w = a/|a| with a = eye − center, u = (b × w)/|b × w|, v = w × u; computed in f64, once.
    pub fn basis(&self) -> Result<Basis, ViewError> {
        let parts = [self.eye, self.center, self.up];
        if parts.iter().any(|p| !p.is_finite()) || !self.fovy.is_finite() {
            return Err(ViewError::NotFinite);
        }
        if !(self.fovy > 0.0 && self.fovy < 180.0) {
            return Err(ViewError::FieldOfView);
        }
        let a = self.eye.as_dvec3() - self.center.as_dvec3();
        let b = self.up.as_dvec3();
        let w = a.try_normalize().ok_or(ViewError::NoDirection)?;
        let b = b.try_normalize().ok_or(ViewError::NoUp)?;
        let side = b.cross(w);
        if side.length() < PARALLEL {
            return Err(ViewError::UpParallel);
        }
        let u = side.normalize();
        let v = w.cross(u);
        Ok(Basis {
            u: u.as_vec3(),
            v: v.as_vec3(),
            w: w.as_vec3(),
        })
    }
}
