//! The scenes by name, with their purposes and sizes.

use super::builder::SceneBuilder;
use super::{modern, spd};
use std::ops::RangeInclusive;

/// Origin of a standard scene, which decides how its pictures are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Eric Haines' Standard Procedural Databases: no transfer curve, floor.
    Spd,
    /// This project's own triangle scenes: sRGB, rounded.
    Modern,
}

/// Parameters of a generator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SceneParams {
    /// The size parameter, within the range of its [`StandardScene`].
    pub size: u32,
}

/// Passes a scene to a builder. It cannot fail: sizes are checked before.
pub type Generator = fn(&SceneParams, &mut dyn SceneBuilder);

/// A standard scene.
#[derive(Clone, Debug)]
pub struct StandardScene {
    /// The name after `standard:`.
    pub name: &'static str,
    /// Content of the scene, and its use: one line.
    pub purpose: &'static str,
    /// Origin of the scene.
    pub family: Family,
    /// Default size.
    pub default_size: u32,
    /// Sizes in which it can be made.
    pub sizes: RangeInclusive<u32>,
    /// Meaning of the size.
    pub size_means: &'static str,
    /// Bounces after the primary ray.
    pub max_depth: u32,
    /// The generator.
    pub generate: Generator,
}

/// All standard scenes: the databases, then the modern ones.
pub static CATALOGUE: &[StandardScene] = &[
    // The Standard Procedural Databases, by name.
    spd::balls::ENTRY,
    spd::gears::ENTRY,
    spd::jacks::ENTRY,
    spd::lattice::ENTRY,
    spd::mount::ENTRY,
    spd::rings::ENTRY,
    spd::shells::ENTRY,
    spd::sombrero::ENTRY,
    spd::teapot::ENTRY,
    spd::tetra::ENTRY,
    spd::tree::ENTRY,
    // Modern triangle scenes.
    modern::cornell::ENTRY,
    modern::terrain::ENTRY,
    modern::menger::ENTRY,
    modern::street::ENTRY,
    modern::hair::ENTRY,
    modern::room::ENTRY,
    modern::atrium::ENTRY,
];
