//! Local origin: the origin of the scene's coordinates, in those of its file.
//!
//! Single precision resolves 2⁻²⁴ of a coordinate. A building of 20 m at map coordinates of 5·10⁵ m
//! would have a resolution of 3 cm. So readers subtract an origin near the geometry in double
//! precision, and round the difference.

use super::{Scene, View, ViewError};
use glam::{DVec3, Vec3};

/// View in the coordinates of a file, before an origin is subtracted from its positions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FileView {
    /// Eye position.
    pub eye: DVec3,
    /// The point looked at; must differ from `eye`.
    pub center: DVec3,
    /// Up vector, not parallel to `eye - center`.
    pub up: Vec3,
    /// Vertical field of view in degrees, in (0, 180).
    pub fovy: f32,
    /// Visible height of an orthographic view; `None` for a perspective one.
    pub ortho: Option<f64>,
}

impl FileView {
    /// Checks that the view has a frame of axes, in double precision.
    ///
    /// # Errors
    /// [`ViewError`].
    pub fn check(&self) -> Result<(), ViewError> {
        let places = [self.eye, self.center, self.up.as_dvec3()];
        let height = self.ortho.map(|height| height as f32);
        super::view::axes(places, self.fovy, height).map(drop)
    }
}

impl From<View> for FileView {
    fn from(view: View) -> FileView {
        FileView {
            eye: view.eye.as_dvec3(),
            center: view.center.as_dvec3(),
            up: view.up,
            fovy: view.fovy,
            ortho: view.ortho.map(f64::from),
        }
    }
}

impl Scene {
    /// Scene position of a file position: `(position − origin) · scale`, rounded once.
    pub fn scene_position(&self, position: DVec3) -> Vec3 {
        ((position - DVec3::from_array(self.origin)) * f64::from(self.scale)).as_vec3()
    }

    /// File position of a scene position: `position / scale + origin`.
    pub fn file_position(&self, position: Vec3) -> DVec3 {
        let position = position.as_dvec3() / f64::from(self.scale);
        let moved = |c: f64, origin: f64| {
            // Adding 0 would turn −0 into 0.
            if origin == 0.0 { c } else { c + origin }
        };
        DVec3::new(
            moved(position.x, self.origin[0]),
            moved(position.y, self.origin[1]),
            moved(position.z, self.origin[2]),
        )
    }

    /// File position of a scene position, relative to the scene's origin: `position / scale`,
    /// rounded once.
    pub fn relative_position(&self, position: Vec3) -> Vec3 {
        (position.as_dvec3() / f64::from(self.scale)).as_vec3()
    }

    /// Scene view of a view in the file's coordinates.
    pub fn view_of(&self, view: &FileView) -> View {
        View {
            eye: self.scene_position(view.eye),
            center: self.scene_position(view.center),
            up: view.up,
            fovy: view.fovy,
            ortho: view
                .ortho
                .map(|height| (height * f64::from(self.scale)) as f32),
        }
    }

    /// The view in the file's coordinates of a view of the scene.
    pub fn file_view(&self, view: &View) -> FileView {
        let height = view.ortho.map(f64::from);
        FileView {
            eye: self.file_position(view.eye),
            center: self.file_position(view.center),
            up: view.up,
            fovy: view.fovy,
            ortho: height.map(|height| height / f64::from(self.scale)),
        }
    }

    /// Returns true if the scene has a local origin: its coordinates differ from those of the file.
    pub fn is_moved(&self) -> bool {
        self.origin != [0.0; 3]
    }

    /// The origin as text, as in `500000, 0, -4012344`; none for a scene that is not moved.
    pub fn describe_origin(&self) -> Option<String> {
        let [x, y, z] = self.origin;
        self.is_moved().then(|| format!("{x}, {y}, {z}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_go_to_the_scene_and_back() {
        let scene = Scene {
            origin: [500_000.0, 0.0, -4_012_352.0],
            scale: 0.25,
            ..Scene::default()
        };
        let file = DVec3::new(500_123.25, -3.5, -4_012_345.125);
        let position = scene.scene_position(file);
        assert_eq!(position, Vec3::new(30.8125, -0.875, 1.71875));
        assert_eq!(scene.file_position(position), file);
    }

    #[test]
    fn without_an_origin_every_bit_stays() {
        let scene = Scene::default();
        for c in [-0.0, 0.0, 1e-45, -3.402_823_5e38, 0.1] {
            let back = scene.file_position(Vec3::splat(c)).as_vec3();
            assert_eq!(back.x.to_bits(), c.to_bits());
            let placed = scene.scene_position(DVec3::splat(f64::from(c)));
            assert_eq!(placed.x.to_bits(), c.to_bits());
        }
    }

    #[test]
    fn a_far_view_is_checked_in_double_precision() {
        let view = FileView {
            eye: DVec3::new(6_400_000.125, 0.0, 0.0),
            center: DVec3::new(6_400_000.0, 0.0, 0.0),
            up: Vec3::Y,
            fovy: 40.0,
            ortho: None,
        };
        assert_eq!(view.check(), Ok(()));
        let on_the_point = FileView {
            eye: view.center,
            ..view
        };
        assert_eq!(on_the_point.check(), Err(ViewError::NoDirection));
    }
}
