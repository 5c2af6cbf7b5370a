//! Camera rays, one at a time (design document, "Creating a ray from the camera").
//!
//! With the image W × H pixels, the ray through row i and column j is
//!
//! ```text
//! α   = tan(fov_x/2)·(j − W/2)/(W/2)
//! β   = tan(fov_y/2)·(H/2 − i)/(H/2)
//! dir = (αu + βv − w)/|αu + βv − w|
//! ```
//!
//! With fov_x = 2·atan(tan(fov_y/2)·W/H) the two slopes per pixel are one number, 2·tan(fov_y/2)/H:
//! pixels are square. It is computed in f64 with `libm`, so that every build starts from the same
//! bits.
//!
//! With a lens, rays start on it and meet in the plane of focus (Cook, Porter and Carpenter,
//! "Distributed Ray Tracing", 1984).

use crate::{View, ViewError};
use glam::Vec3;

/// A thin lens at the eye: objects in the plane of focus are sharp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Diameter; with 0, the lens is a pinhole.
    pub aperture: f32,
    /// Distance of the plane of focus, along the direction of view.
    pub focus: f32,
}

/// Reasons why a lens is not possible.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LensError {
    /// Negative, or not finite.
    #[error("the aperture must be a number of at least 0")]
    Aperture,
    /// Zero, negative, or not finite.
    #[error("the distance of focus must be a positive number")]
    Focus,
    /// An orthographic camera has no lens.
    #[error("a camera of parallel rays has no lens: leave out --aperture")]
    Parallel,
    /// Rays would leave the range of single precision.
    #[error(
        "the aperture is too wide: at most a thousand times the distance of focus, and no wider than the largest scene"
    )]
    TooWide,
}

/// Largest aperture, in units of the focus distance. Beyond it, rays through the rim are parallel
/// to the picture.
const MAX_APERTURE_PER_FOCUS: f32 = 1000.0;

/// Largest aperture in scene units: the range of a scene's coordinates.
const MAX_APERTURE: f32 = 268_435_456.0; // 2^28

/// A camera, prepared to generate rays.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// Origin of every ray, or the centre of the lens.
    pub eye: Vec3,
    /// Unit vector to the right of the picture.
    pub right: Vec3,
    /// Unit vector to the top of the picture.
    pub up: Vec3,
    /// Unit vector against the direction of view.
    pub back: Vec3,
    /// Change of slope from one pixel to the next, in both directions; for parallel rays, their
    /// spacing.
    pub slope: f32,
    /// True for an orthographic camera: all rays have the view direction, and start side by side.
    pub parallel: bool,
    /// Half the width of the image, in pixels.
    pub half_width: f32,
    /// Half the height of the image, in pixels.
    pub half_height: f32,
    lens: Option<LensDisk>,
}

/// A lens, prepared for its rays.
#[derive(Clone, Copy, Debug)]
pub struct LensDisk {
    /// Radius, in units of the scene.
    pub radius: f32,
    /// The radius divided by the distance of focus: the change of slope of a ray through the rim.
    pub spread: f32,
}

impl LensDisk {
    /// No lens: every ray starts at the eye.
    pub const PINHOLE: LensDisk = LensDisk {
        radius: 0.0,
        spread: 0.0,
    };
}

impl Camera {
    /// A camera for an image of `width` × `height` pixels.
    ///
    /// # Errors
    /// [`ViewError`] if the view has no frame.
    pub fn new(view: &View, width: u32, height: u32) -> Result<Camera, ViewError> {
        let basis = view.basis()?;
        let half_angle = (view.fovy as f64).to_radians() / 2.0;
        let perspective = || 2.0 * libm::tan(half_angle);
        let visible = view.ortho.map_or_else(perspective, f64::from);
        Ok(Camera {
            eye: view.eye,
            right: basis.u,
            up: basis.v,
            back: basis.w,
            slope: (visible / height as f64) as f32,
            parallel: view.ortho.is_some(),
            half_width: width as f32 / 2.0,
            half_height: height as f32 / 2.0,
            lens: None,
        })
    }

    /// Width and height of the image in pixels.
    #[inline]
    pub fn size(&self) -> (u32, u32) {
        // Integers and halves are exact in f32.
        (
            (2.0 * self.half_width) as u32,
            (2.0 * self.half_height) as u32,
        )
    }

    /// The same camera with a lens, in units of the scene.
    ///
    /// # Errors
    /// [`LensError`] if such a lens is not possible.
    pub fn with_lens(self, Lens { aperture, focus }: Lens) -> Result<Camera, LensError> {
        if !(aperture.is_finite() && aperture >= 0.0) {
            return Err(LensError::Aperture);
        }
        if !(focus.is_finite() && focus > 0.0) {
            return Err(LensError::Focus);
        }
        if self.parallel && aperture > 0.0 {
            return Err(LensError::Parallel);
        }
        if f64::from(aperture) > f64::from(MAX_APERTURE_PER_FOCUS) * f64::from(focus)
            || aperture > MAX_APERTURE
        {
            return Err(LensError::TooWide);
        }
        let lens = (aperture > 0.0).then(|| LensDisk {
            radius: 0.5 * aperture,
            spread: (0.5 * f64::from(aperture) / f64::from(focus)) as f32,
        });
        Ok(Camera { lens, ..self })
    }

    /// The lens; a pinhole for a camera without one.
    #[inline]
    pub fn lens(&self) -> LensDisk {
        self.lens.unwrap_or(LensDisk::PINHOLE)
    }

    /// Returns true if rays start all over a lens instead of only at the eye.
    #[inline]
    pub fn has_lens(&self) -> bool {
        self.lens.is_some()
    }

    /// Origin and unit direction of the ray through a pixel position, as in [`Camera::direction`].
    /// An orthographic camera's rays start in the plane of the eye, at (α, β) times the distance of
    /// pixels, and go along −w.
    #[inline]
    pub fn ray(&self, row: f32, column: f32) -> (Vec3, Vec3) {
        if !self.parallel {
            return (self.eye, self.direction(row, column));
        }
        let [alpha, beta] = self.slopes(row, column);
        let org = (self.eye + self.right * alpha) + self.up * beta;
        (org, -self.back)
    }

    /// Origin and unit direction of the ray through a pixel position, as in [`Camera::direction`],
    /// and a point of the lens, which is given on the unit disc.
    ///
    /// All rays of a pixel position meet in one point of the plane of focus. A ray that starts `x`
    /// radii further right on the lens has a slope to the right that is smaller by `x` times radius
    /// over distance of focus.
    #[inline]
    pub fn through_lens(&self, row: f32, column: f32, [x, y]: [f32; 2]) -> (Vec3, Vec3) {
        let LensDisk { radius, spread } = self.lens();
        let org = (self.eye + self.right * (x * radius)) + self.up * (y * radius);
        (
            org,
            self.direction_with(row, column, [x * spread, y * spread]),
        )
    }

    /// Unit direction through the continuous pixel position (`row` down, `column` right); a pixel's
    /// centre is at + 0.5.
    #[inline]
    pub fn direction(&self, row: f32, column: f32) -> Vec3 {
        self.direction_with(row, column, [0.0; 2])
    }

    /// Slopes to the right and up at a pixel position; for parallel rays, distances.
    #[inline]
    fn slopes(&self, row: f32, column: f32) -> [f32; 2] {
        [
            (column - self.half_width) * self.slope,
            (self.half_height - row) * self.slope,
        ]
    }

    /// Unit direction whose slopes to the right and up are smaller by `less` than those of
    /// [`Camera::direction`].
    #[inline]
    fn direction_with(&self, row: f32, column: f32, less: [f32; 2]) -> Vec3 {
        let [alpha, beta] = self.slopes(row, column);
        let (alpha, beta) = (alpha - less[0], beta - less[1]);
        let d = (self.right * alpha + self.up * beta) - self.back;
        d * (1.0 / d.dot(d).sqrt())
    }
}
