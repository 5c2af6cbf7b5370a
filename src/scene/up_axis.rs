//! The up axis of a file that does not specify it.

use glam::{DVec3, Vec3};

/// The up axis. Formats without a camera leave it to their users.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpAxis {
    /// The first axis.
    X,
    /// The second axis, as in most models for display.
    #[default]
    Y,
    /// The third axis, as in most models for printing, and in maps.
    Z,
    /// The negative first axis.
    NegX,
    /// The negative second axis.
    NegY,
    /// The negative third axis.
    NegZ,
}

impl UpAxis {
    /// All of them with their names.
    pub const ALL: [(&str, UpAxis); 6] = [
        ("x", UpAxis::X),
        ("y", UpAxis::Y),
        ("z", UpAxis::Z),
        ("-x", UpAxis::NegX),
        ("-y", UpAxis::NegY),
        ("-z", UpAxis::NegZ),
    ];

    /// The axis nearest to a vector.
    pub fn nearest(up: Vec3) -> UpAxis {
        let along = |axis: UpAxis| axis.frame()[1].as_vec3().dot(up);
        let nearer = |a, b| if along(b) > along(a) { b } else { a };
        UpAxis::ALL
            .map(|(_, axis)| axis)
            .into_iter()
            .fold(UpAxis::Y, nearer)
    }

    /// The axes to the right, up, and toward the viewer of a model seen from the front. Each is
    /// the frame of [`UpAxis::Y`] turned by quarters of a circle.
    #[inline]
    pub fn frame(self) -> [DVec3; 3] {
        use DVec3 as V;
        match self {
            UpAxis::X => [V::NEG_Y, V::X, V::Z],
            UpAxis::Y => [V::X, V::Y, V::Z],
            UpAxis::Z => [V::X, V::Z, V::NEG_Y],
            UpAxis::NegX => [V::Y, V::NEG_X, V::Z],
            UpAxis::NegY => [V::NEG_X, V::NEG_Y, V::Z],
            UpAxis::NegZ => [V::X, V::NEG_Z, V::Y],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_right_handed() {
        for (name, axis) in UpAxis::ALL {
            let [right, up, back] = axis.frame();
            assert_eq!(right.cross(up), back, "{name}");
            assert_eq!(name.starts_with('-'), up.min_element() < 0.0, "{name}");
            let letter = ["x", "y", "z"][up.abs().max_position()];
            assert!(name.ends_with(letter), "{name}");
        }
    }
}
