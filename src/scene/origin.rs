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

    /// File position of a scene position with the digits that single precision has near the
    /// scene's origin: a coordinate of 500000.31 in the file is that again.
    pub fn short_position(&self, position: Vec3) -> DVec3 {
        let local = self.relative_position(position).to_array().map(shortest);
        DVec3::from_array(std::array::from_fn(|axis| match self.origin[axis] {
            0.0 => local[axis],
            origin => origin + local[axis],
        }))
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

    /// The view with positions that the file's coordinates give to the bit. Only a scene that was
    /// moved has others: close to its origin, single precision resolves more than double precision
    /// does in the file. A view that would visibly change stays as it is.
    pub fn representable_view(&self, view: &View) -> View {
        let rounded = self.view_of(&self.file_view(view));
        // The numbers may be too small to be squared in single precision.
        let apart = |a: Vec3, b: Vec3| a.as_dvec3().distance(b.as_dvec3());
        let distance = apart(view.eye, view.center);
        let moved = apart(rounded.eye, view.eye) + apart(rounded.center, view.center);
        if moved <= distance * MAX_MOVE { rounded } else { *view }
    }

    /// The view in the file's coordinates with as few digits as give it back to the bit, if it is
    /// [representable](Scene::representable_view).
    pub fn shortest_view(&self, view: &View) -> FileView {
        let exact = self.file_view(view);
        let height = exact.ortho.map(|height| shortest(height as f32));
        let short = FileView {
            eye: self.short_position(view.eye),
            center: self.short_position(view.center),
            ortho: height,
            ..exact
        };
        let again = self.view_of(&short);
        FileView {
            eye: if again.eye == view.eye { short.eye } else { exact.eye },
            center: if again.center == view.center { short.center } else { exact.center },
            ortho: if again.ortho == view.ortho { short.ortho } else { exact.ortho },
            ..exact
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

/// Largest move of eye and target together that does not count as visible, as a share of the
/// distance between them.
const MAX_MOVE: f64 = 1e-5;

/// The shortest decimal that rounds to a number.
fn shortest(c: f32) -> f64 {
    c.to_string().parse().unwrap_or(f64::from(c))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_told_as_files_have_them() {
        let mut scene = Scene {
            scale: 0.25,
            ..Scene::default()
        };
        let short = |scene: &Scene, x, y, z| scene.short_position(Vec3::new(x, y, z)).to_array();
        assert_eq!(short(&scene, 0.025, -0.0, 1e9), [0.1, 0.0, 4e9]);
        scene.origin = [500_000.0, 0.0, -4_012_352.0];
        scene.scale = 1.0;
        let position = short(&scene, 0.31, 0.1, 7.25);
        assert_eq!(position, [500_000.31, 0.1, -4_012_344.75]);
    }

    #[test]
    fn told_views_come_back_to_the_bit() {
        let places = [1e-7, 0.000_123_456_7, -0.1, 3.5, 1234.567, 2e8];
        for (origin, scale) in [(0.0, 1.0), (0.0, 0.25), (4_012_352.0, 1.0), (-5e5, 8.0)] {
            let scene = Scene {
                origin: [origin, 0.0, -origin],
                scale,
                ..Scene::default()
            };
            for (k, &x) in places.iter().enumerate() {
                let view = View {
                    eye: Vec3::new(x, places[(k + 1) % 6], 0.7 * x),
                    center: Vec3::new(places[(k + 2) % 6], x, -0.3),
                    ortho: (x > 0.0).then_some(x),
                    ..scene.view
                };
                let view = scene.representable_view(&view);
                assert_eq!(scene.representable_view(&view), view);
                let shortest = scene.shortest_view(&view);
                let text =
                    [shortest.eye, shortest.center].map(|p| p.to_array().map(|c| c.to_string()));
                let [eye, center] = text.map(|p| p.map(|c| c.parse::<f64>().unwrap()));
                let again = FileView {
                    eye: eye.into(),
                    center: center.into(),
                    ..shortest
                };
                assert_eq!(scene.view_of(&again), view, "{origin} {scale} {x}");
            }
        }
        let view = View {
            eye: Vec3::new(0.1, 0.2, 7.0),
            ..Scene::default().view
        };
        let shortest = Scene::default().shortest_view(&view);
        assert_eq!(shortest.eye.to_array(), [0.1, 0.2, 7.0], "few digits");
    }

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
