//! The user's overrides of a scene.

use glam::{DVec3, Vec3};
use phalanx_scene::{EnvironmentLight, FileView, OrthoHeight, UpAxis};

/// The user's overrides: of parts that a file gives, and of defaults for those that it lacks.
#[derive(Clone, Debug, Default)]
pub struct Overrides {
    /// Replaces the file's camera.
    pub view: Option<FileView>,
    /// Takes another camera of the file than the first, by its name, or else by its number from 0.
    pub camera: Option<String>,
    /// Size of the picture, in pixels, for a default camera if the file has none; `None` for the
    /// scene's size.
    pub size: Option<(u32, u32)>,
    /// The up axis for a default camera; `None` for the format's.
    pub up: Option<UpAxis>,
    /// Makes the camera's rays parallel.
    pub ortho: Option<OrthoHeight>,
    /// True if a default camera will go around the scene, all of which it must show from every
    /// side.
    pub turntable: bool,
    /// Replaces the file's lights, unless empty.
    pub lights: Vec<AddedLight>,
    /// Replaces the file's lights by default ones beside the camera.
    pub headlight: bool,
    /// Surrounds the scene, and unless a background is given, is seen behind it.
    pub environment: Option<EnvironmentLight>,
    /// Turns the environment about the up axis, by degrees; `None` as it is.
    pub environment_turn: Option<f64>,
    /// Replaces the file's background.
    pub background: Option<Vec3>,
    /// Replaces the format's [`Scene::smooth_shadows`](phalanx_scene::Scene::smooth_shadows).
    pub smooth_shadows: Option<bool>,
    /// Shows single-sided materials from behind, too.
    pub two_sided: bool,
}

/// A light of [`Overrides`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AddedLight {
    /// A point light that does not fade.
    Point {
        /// Position, in the file's coordinates.
        position: DVec3,
        /// Colour.
        color: Vec3,
    },
    /// Light from infinitely far away.
    Directional {
        /// The vector toward it, of any length but zero.
        toward: Vec3,
        /// Colour.
        color: Vec3,
    },
}
