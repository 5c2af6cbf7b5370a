//! Camera rays, scalar and eight-wide (design document, "Creating a ray from the camera").
//!
//! α = tan(fov_x/2)·(j − W/2)/(W/2), β = tan(fov_y/2)·(H/2 − i)/(H/2), dir = (αu + βv − w)/|αu + βv − w|. With
//! fov_x = 2·atan(tan(fov_y/2)·W/H) the two slopes per pixel are one number, 2·tan(fov_y/2)/H: pixels are square. It
//! is computed in f64 with `libm`, so that every build starts from the same bits.

use crate::lanes::{F32x8, Lanes, Vec3x8};
use crate::scene::{View, ViewError};
use glam::Vec3;

/// A camera ready to make rays.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// Origin of every ray.
    pub eye: Vec3,
    right: Vec3,
    up: Vec3,
    back: Vec3,
    /// Slope from one pixel to the next, in both directions.
    slope: f32,
    half_width: f32,
    half_height: f32,
}

impl Camera {
    /// A camera for an image of `width` × `height` pixels.
    ///
    /// # Errors
    /// [`ViewError`] if the view has no frame.
    pub fn new(view: &View, width: u32, height: u32) -> Result<Camera, ViewError> {
        let basis = view.basis()?;
        let half_angle = (view.fovy as f64).to_radians() / 2.0;
        Ok(Camera {
            eye: view.eye,
            right: basis.u,
            up: basis.v,
            back: basis.w,
            slope: (2.0 * libm::tan(half_angle) / height as f64) as f32,
            half_width: width as f32 / 2.0,
            half_height: height as f32 / 2.0,
        })
    }

    /// Unit direction through the continuous pixel position (`row` down, `column` right); a pixel's centre is at + 0.5.
    pub fn direction(&self, row: f32, column: f32) -> Vec3 {
        let alpha = (column - self.half_width) * self.slope;
        let beta = (self.half_height - row) * self.slope;
        let d = (self.right * alpha + self.up * beta) - self.back;
        d * (1.0 / d.dot(d).sqrt())
    }

    /// Eight directions at once: the same operations in the same order.
    #[inline]
    pub fn directions(&self, row: F32x8, column: F32x8) -> Vec3x8 {
        let slope = F32x8::splat(self.slope);
        let alpha = (column - F32x8::splat(self.half_width)) * slope;
        let beta = (F32x8::splat(self.half_height) - row) * slope;
        let wide = |v: Vec3| Vec3x8::splat(v.x, v.y, v.z);
        let d = (wide(self.right).scale(alpha) + wide(self.up).scale(beta)) - wide(self.back);
        d.normalized()
    }
}
