//! The camera's path, frame by frame.
//!
//! Everything is computed in f64 with `libm`, once per frame, so that every build renders the same
//! pictures.

use super::View;
use glam::{DVec3, Vec3};

/// A path of the camera.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraPath {
    /// A turntable: the camera turns around the axis through the centre of the scene's view, along
    /// its up vector. A full turn takes the given number of frames, counter-clockwise as viewed
    /// from above. Frame 0 is the scene's view.
    Turntable {
        /// Frames of a full turn.
        frames: u32,
    },
    /// Views at given frames, with interpolation between them; before the first and after the last
    /// the camera stands still.
    Keys(Vec<CameraKey>),
}

/// A view at a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct CameraKey {
    /// Frame number.
    pub frame: u32,
    /// View at that frame.
    pub view: View,
}

impl CameraPath {
    /// The view at a frame, for a scene with the view `scene`. [`View::basis`] checks that it has a
    /// frame of axes.
    pub fn view(&self, frame: u32, scene: &View) -> View {
        match self {
            CameraPath::Turntable { frames } => turned(scene, frame % frames.max(&1), *frames),
            CameraPath::Keys(keys) => between(keys, frame).unwrap_or(*scene),
        }
    }
}

/// Rodrigues' formula: v cos a + (k × v) sin a + k (k · v)(1 − cos a).
fn turned(view: &View, frame: u32, frames: u32) -> View {
    let axis = view.up.as_dvec3().try_normalize();
    let (Some(axis), 1..) = (axis, frame) else {
        return *view;
    };
    let angle = std::f64::consts::TAU * f64::from(frame) / f64::from(frames);
    let (sin, cos) = libm::sincos(angle);
    let center = view.center.as_dvec3();
    let arm = view.eye.as_dvec3() - center;
    let arm = arm * cos + axis.cross(arm) * sin + axis * (axis.dot(arm) * (1.0 - cos));
    View {
        eye: (center + arm).as_vec3(),
        ..*view
    }
}

/// Interpolates the keys by cubic Hermite curves; `None` without keys. The tangent at each key is
/// the slope between its neighbours (Catmull and Rom, "A Class of Local Interpolating Splines",
/// 1974, with frames for the knots). Keys are in the order of their frames.
fn between(keys: &[CameraKey], frame: u32) -> Option<View> {
    let next = keys.partition_point(|key| key.frame <= frame);
    let (Some(from), Some(to)) = (next.checked_sub(1).map(|k| keys[k]), keys.get(next)) else {
        return keys.get(next.saturating_sub(1)).map(|key| key.view);
    };
    let key = |k: usize| keys[k.min(keys.len() - 1)];
    let (before, after) = (key(next.saturating_sub(2)), key(next + 1));
    let span = f64::from(to.frame - from.frame);
    let t = f64::from(frame - from.frame) / span;
    let slope = |a: CameraKey, b: CameraKey, attribute: &dyn Fn(&View) -> DVec3| {
        (attribute(&b.view) - attribute(&a.view)) / f64::from(b.frame - a.frame).max(1.0)
    };
    let curve = |attribute: &dyn Fn(&View) -> DVec3| -> Vec3 {
        let (p, q) = (attribute(&from.view), attribute(&to.view));
        let (m, n) = (
            slope(before, *to, attribute) * span,
            slope(from, after, attribute) * span,
        );
        let (tt, ttt) = (t * t, t * t * t);
        let value = p * (2.0 * ttt - 3.0 * tt + 1.0)
            + m * (ttt - 2.0 * tt + t)
            + q * (3.0 * tt - 2.0 * ttt)
            + n * (ttt - tt);
        value.as_vec3()
    };
    let fovy = curve(&|view| DVec3::splat(view.fovy.into())).x;
    // Keyframes are of one kind; a view of the other kind has no height to go on from.
    let height = |view: &View| view.ortho.unwrap_or_default();
    let height = curve(&|view| DVec3::splat(height(view).into())).x;
    Some(View {
        eye: curve(&|view| view.eye.as_dvec3()),
        center: curve(&|view| view.center.as_dvec3()),
        up: curve(&|view| view.up.as_dvec3()),
        fovy,
        ortho: from.view.ortho.map(|_| height),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(x: f32) -> View {
        View {
            eye: Vec3::new(x, 1.0, 4.0),
            center: Vec3::new(0.0, 1.0, 0.0),
            up: Vec3::Y,
            fovy: 30.0 + x,
            ortho: None,
        }
    }

    #[test]
    fn a_turntable_goes_around_at_one_distance_and_comes_back() {
        let start = view(0.0);
        let path = CameraPath::Turntable { frames: 8 };
        assert_eq!(path.view(0, &start), start);
        assert_eq!(path.view(8, &start), start);
        let quarter = path.view(2, &start).eye;
        assert!(
            (quarter - Vec3::new(4.0, 1.0, 0.0)).length() < 1e-6,
            "{quarter}"
        );
        let half = path.view(4, &start).eye;
        assert!((half - Vec3::new(0.0, 1.0, -4.0)).length() < 1e-6, "{half}");
        // From above, about an axis of any length: the height does not change.
        let high = View {
            eye: Vec3::new(0.0, 3.0, 4.0),
            up: Vec3::new(0.0, 2.0, 0.0),
            ..start
        };
        for frame in 0..8 {
            let eye = path.view(frame, &high).eye;
            assert!((eye.y - 3.0).abs() < 1e-6, "{eye}");
            assert!((eye.x * eye.x + eye.z * eye.z - 16.0).abs() < 1e-4, "{eye}");
        }
    }

    #[test]
    fn keys_are_met_and_what_is_even_stays_even() {
        let key = |frame, x| CameraKey {
            frame,
            view: view(x),
        };
        let path = CameraPath::Keys(vec![key(10, 0.0), key(20, 1.0), key(40, 3.0)]);
        let eye = |frame| path.view(frame, &view(9.0)).eye.x;
        assert_eq!([eye(10), eye(20), eye(40)], [0.0, 1.0, 3.0]);
        // Before the first and after the last key the camera stands still.
        assert_eq!([eye(0), eye(41), eye(1000)], [0.0, 3.0, 3.0]);
        // A straight path at constant speed: 0.1 a frame.
        for frame in 10..=40 {
            let want = (frame - 10) as f32 * 0.1;
            assert!((eye(frame) - want).abs() < 1e-6, "{frame}: {}", eye(frame));
        }
        assert_eq!(path.view(20, &view(9.0)).fovy, 31.0);
        assert_eq!(CameraPath::Keys(Vec::new()).view(3, &view(9.0)), view(9.0));
        let one = CameraPath::Keys(vec![key(5, 2.0)]);
        assert_eq!([0, 5, 9].map(|f| one.view(f, &view(9.0)).eye.x), [2.0; 3]);
    }
}
