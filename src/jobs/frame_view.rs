//! Check of the view of a frame, which plans and keys store.

use super::field_error::FieldError;
use phalanx_scene::View;

/// Checks that a view has axes: it may come from a file of anybody, where `field` holds it.
///
/// # Errors
/// The reason why it has none.
pub(crate) fn check_view(view: &View, field: &str) -> Result<(), FieldError> {
    let basis = view.basis().map(drop);
    basis.map_err(|error| FieldError::new(field, format!("none ({error})"), "a view that has axes"))
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
            let text = serde_json::to_string(&view).unwrap();
            let again: View = serde_json::from_str(&text).unwrap();
            let bits = |v: Vec3| v.to_array().map(f32::to_bits);
            assert_eq!(bits(again.eye), bits(view.eye), "{text}");
            assert_eq!(again, view, "{text}");
            assert!(check_view(&again, "view").is_ok());
        }
        let bad = View {
            center: view.eye,
            ..view
        };
        assert!(check_view(&bad, "view").is_err());
    }
}
