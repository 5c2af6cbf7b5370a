//! The camera's view of a frame, as plans and keys store it.

use super::field_error::FieldError;
use phalanx_scene::View;
use serde::{Deserialize, Serialize};

/// A [`View`] with named fields, in the scene's coordinates. JSON gives its numbers back to the
/// bit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrameView {
    /// Eye position.
    pub eye: [f32; 3],
    /// The point looked at.
    pub center: [f32; 3],
    /// Up vector.
    pub up: [f32; 3],
    /// Vertical field of view in degrees.
    pub fovy: f32,
    /// Visible height of an orthographic view; `None` for a perspective view.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ortho: Option<f32>,
}

impl FrameView {
    /// Checks that a view has axes: it may come from a file of anybody, where `field` holds it.
    ///
    /// # Errors
    /// The reason why it has none.
    pub(crate) fn check(&self, field: &str) -> Result<(), FieldError> {
        let basis = View::from(*self).basis().map(drop);
        basis.map_err(|error| {
            FieldError::new(field, format!("none ({error})"), "a view that has axes")
        })
    }
}

impl From<View> for FrameView {
    fn from(view: View) -> FrameView {
        FrameView {
            eye: view.eye.to_array(),
            center: view.center.to_array(),
            up: view.up.to_array(),
            fovy: view.fovy,
            ortho: view.ortho,
        }
    }
}

impl From<FrameView> for View {
    fn from(view: FrameView) -> View {
        View {
            eye: view.eye.into(),
            center: view.center.into(),
            up: view.up.into(),
            fovy: view.fovy,
            ortho: view.ortho,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn json_gives_a_view_back_to_the_bit() {
        let view = View {
            eye: Vec3::new(0.1, -0.0, 7.038_531e-26),
            center: Vec3::new(f32::from_bits(1), 1.0 / 3.0, 16_777_217.0),
            up: Vec3::Y,
            fovy: 44.999_996,
            ortho: Some(0.3),
        };
        for view in [
            view,
            View {
                ortho: None,
                ..view
            },
        ] {
            let frame_view = FrameView::from(view);
            let text = serde_json::to_string(&frame_view).unwrap();
            let again: FrameView = serde_json::from_str(&text).unwrap();
            let bits = |v: [f32; 3]| v.map(f32::to_bits);
            assert_eq!(bits(again.eye), bits(frame_view.eye), "{text}");
            assert_eq!(View::from(again), view, "{text}");
            assert!(again.check("view").is_ok());
        }
        let bad = FrameView {
            center: view.eye.to_array(),
            ..view.into()
        };
        assert!(bad.check("view").is_err());
    }
}
