//! The camera as matrices, in the form that other programs read from picture files.

use crate::camera::Camera;
use crate::{Scene, ViewError};

/// Maps from the coordinates of the scene's file, relative to the scene's origin, as OpenEXR
/// defines them ("Standard Attributes"). A point is a row (x, y, z, 1) that is multiplied with the
/// matrix from its left; rows of the matrix follow each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraMatrices {
    /// To the camera's coordinates: x to the right, y up, z along the direction of view, in units
    /// of the file.
    pub world_to_camera: [f32; 16],
    /// To the picture: x from 0 at its left side to 1, y from 0 at its upper side to 1, after the
    /// division by w. The third coordinate is 1 - 1/z, or z for parallel rays, with the z of the
    /// camera's coordinates.
    pub world_to_ndc: [f32; 16],
}

impl CameraMatrices {
    /// The matrices of a scene's view, for an image of `width` × `height` pixels. They are computed
    /// in double precision and rounded at the end.
    ///
    /// # Errors
    /// [`ViewError`] if the view has no frame.
    pub fn of(scene: &Scene, (width, height): (u32, u32)) -> Result<CameraMatrices, ViewError> {
        let camera = Camera::new(&scene.view, width, height)?;
        let axes = [camera.right, camera.up, -camera.back].map(|axis| axis.as_dvec3());
        let eye = camera.eye.as_dvec3() / f64::from(scene.scale);
        // The rows of a map's columns: the factors of x, y, z and 1.
        let [x, y, z] = axes.map(|axis| [axis.x, axis.y, axis.z, -axis.dot(eye)]);
        let unit = [0.0, 0.0, 0.0, 1.0];
        // Where the ray through a point crosses the picture: column = W/2 + x / (z s), with s the
        // slope between pixels; for parallel rays, without z.
        let slope = f64::from(camera.slope);
        let (slope, divisor, depth) = if camera.parallel {
            (slope / f64::from(scene.scale), unit, z)
        } else {
            (slope, z, combine(z, 1.0, unit, -1.0))
        };
        let [across, down] = [width, height].map(|n| 1.0 / (slope * f64::from(n)));
        let column = combine(divisor, 0.5, x, across);
        let row = combine(divisor, 0.5, y, -down);
        Ok(CameraMatrices {
            world_to_camera: matrix([x, y, z, unit]),
            world_to_ndc: matrix([column, row, depth, divisor]),
        })
    }
}

/// `a` times `ka` plus `b` times `kb`.
fn combine(a: [f64; 4], ka: f64, b: [f64; 4], kb: f64) -> [f64; 4] {
    std::array::from_fn(|k| a[k] * ka + b[k] * kb)
}

/// The matrix with these columns; a zero has no sign.
fn matrix(columns: [[f64; 4]; 4]) -> [f32; 16] {
    std::array::from_fn(|index| columns[index % 4][index / 4] as f32 + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::View;
    use glam::{DVec3, Vec3};

    fn apply(matrix: &[f32; 16], point: DVec3) -> [f64; 4] {
        let point = [point.x, point.y, point.z, 1.0];
        std::array::from_fn(|column| {
            let terms = (0..4).map(|row| point[row] * f64::from(matrix[4 * row + column]));
            terms.sum()
        })
    }

    /// Checks that points along camera rays land on the rays' pixel positions, at their depth.
    #[test]
    fn points_on_camera_rays_land_where_the_rays_pass_the_picture() {
        for ortho in [None, Some(6.0)] {
            let scene = Scene {
                view: View {
                    eye: Vec3::new(1.0, 2.0, 5.0),
                    center: Vec3::new(0.5, 0.0, -1.0),
                    up: Vec3::Y,
                    fovy: 40.0,
                    ortho,
                },
                scale: 2.0,
                origin: [30.0, 0.0, -7.0],
                ..Scene::default()
            };
            let size = (640, 480);
            let camera = Camera::new(&scene.view, size.0, size.1).unwrap();
            let matrices = CameraMatrices::of(&scene, size).unwrap();
            for (row, column, t) in [(50.0, 100.0, 3.0), (350.0, 500.0, 8.0), (10.5, 600.25, 2.0)] {
                let (org, dir) = camera.ray(row, column);
                let point = scene.relative_position(org + dir * t).as_dvec3();
                let [x, y, _, w] = apply(&matrices.world_to_ndc, point);
                let want = [column / 640.0, row / 480.0];
                let got = [x / w, y / w];
                let near = |(a, b): (f64, f32)| (a - f64::from(b)).abs() < 1e-4;
                assert!(got.into_iter().zip(want).all(near), "{got:?} {want:?}");
                let [_, _, z, one] = apply(&matrices.world_to_camera, point);
                let depth = f64::from(t * dir.dot(-camera.back)) / 2.0;
                assert!((z - depth).abs() < 1e-4 && one == 1.0, "{z} {depth}");
            }
        }
    }
}
