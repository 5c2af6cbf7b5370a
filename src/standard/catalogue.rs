//! The scenes by name, with their purposes and sizes.

use super::builder::SceneBuilder;
use super::{modern, spd};
use std::ops::RangeInclusive;

/// Origin of a standard scene, which determines how its pictures are encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Eric Haines' Standard Procedural Databases: no transfer curve, floor.
    Spd,
    /// This project's own triangle scenes: sRGB, rounded.
    Modern,
}

/// Passes a scene of this size to a builder. It cannot fail, as sizes are checked before.
pub type Generator = fn(u32, &mut dyn SceneBuilder);

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
    /// Valid sizes.
    pub sizes: RangeInclusive<u32>,
    /// Meaning of the size.
    pub size_means: &'static str,
    /// Bounces after the primary ray.
    pub max_depth: u32,
    /// The generator.
    pub generate: Generator,
}

/// One of the Standard Procedural Databases, with its own default size and limits.
const fn database(
    name: &'static str,
    purpose: &'static str,
    (default_size, sizes): (u32, RangeInclusive<u32>),
    size_means: &'static str,
    generate: Generator,
) -> StandardScene {
    StandardScene {
        name,
        purpose,
        family: Family::Spd,
        default_size,
        sizes,
        size_means,
        max_depth: 4,
        generate,
    }
}

/// A modern scene, of a million triangles by default, and at least `least`.
const fn triangle_scene(
    name: &'static str,
    purpose: &'static str,
    least: u32,
    max_depth: u32,
    generate: Generator,
) -> StandardScene {
    StandardScene {
        name,
        purpose,
        family: Family::Modern,
        default_size: 1_000_000,
        sizes: least..=100_000_000,
        size_means: "triangles",
        max_depth,
        generate,
    }
}

/// All standard scenes: the databases by name, then the modern ones.
pub static CATALOGUE: &[StandardScene] = &[
    database(
        "balls",
        "sphereflake on a plane: mirrors, spheres of very different sizes",
        (4, 1..=8),
        "levels of the recursion: (9^(size+1) - 1) / 8 spheres",
        spd::balls::generate,
    ),
    database(
        "gears",
        "meshing gears, some of glass: concave polygons, refraction",
        (4, 1..=40),
        "gears along each side: 146 size^3 + 1 polygons",
        spd::gears::generate,
    ),
    database(
        "jacks",
        "jacks within jacks: cylinders and spheres, one light",
        (1, 1..=8),
        "levels of the recursion: 9 (8^size - 1) / 7 primitives",
        spd::jacks::generate,
    ),
    database(
        "lattice",
        "spheres joined by cylinders, seen from within: regular, six lights",
        (12, 1..=150),
        "cells along each side: (size+1)^3 spheres, 3 size (size+1)^2 cylinders",
        spd::lattice::generate,
    ),
    database(
        "mount",
        "fractal mountain under four crystal balls: small facets, long refracted paths",
        (6, 1..=12),
        "halvings of the mountain's side: 2 * 4^size triangles",
        spd::mount::generate,
    ),
    database(
        "rings",
        "a pyramid of linked pentagons of cylinders and spheres: depth complexity, reflection",
        (7, 1..=100),
        "layers of the pyramid: 5 size (size+1) (2 size+1) spheres and as many cylinders",
        spd::rings::generate,
    ),
    database(
        "shells",
        "a seashell of overlapping spheres: many primitives in one place, pathological for trees",
        (5, 1..=16),
        "doublings: 180 * 2^size + 1 spheres",
        spd::shells::generate,
    ),
    database(
        "sombrero",
        "a height field of a damped cosine: triangles in a regular grid",
        (1, 1..=8),
        "doublings: a grid of n by n heights, n = 16 * 2^size, in 2 (n-1)^2 triangles",
        spd::sombrero::generate,
    ),
    database(
        "teapot",
        "the teapot on a checkerboard: smooth triangles, mirrors",
        (12, 1..=600),
        "steps along each side of a patch: 64 size^2 - 8 size triangles, size^2 squares",
        spd::teapot::generate,
    ),
    database(
        "tetra",
        "recursive tetrahedra: mostly background, coherent, one light",
        (6, 1..=12),
        "levels of the recursion: 4^size triangles",
        spd::tetra::generate,
    ),
    database(
        "tree",
        "a tree of cones and spheres under seven lights: shadows through thin things",
        (11, 1..=22),
        "forks from the root to a tip: 2^(size+1) - 1 cones and as many spheres",
        spd::tree::generate,
    ),
    triangle_scene(
        "cornell",
        "a Cornell box with glass and mirror spheres: secondary rays, many lights, all hits near",
        4_000,
        8,
        modern::cornell::generate,
    ),
    triangle_scene(
        "terrain",
        "mountains by a lake: one large height field, grazing rays, many surfaces",
        4_000,
        3,
        modern::terrain::generate,
    ),
    triangle_scene(
        "menger",
        "a Menger sponge: axis-parallel faces, tunnels, rays that pass many boxes and hit none",
        4_000,
        4,
        modern::menger::generate,
    ),
    triangle_scene(
        "street",
        "a street of detailed houses and a furnished café: large and tiny triangles, seven lights",
        6_000,
        4,
        modern::street::generate,
    ),
    triangle_scene(
        "hair",
        "fur and grass of thin curved tubes: boxes that hold little, silhouettes everywhere",
        4_000,
        3,
        modern::hair::generate,
    ),
    triangle_scene(
        "room",
        "a finely detailed statue in a closed room: a teapot in a stadium, and no ray escapes",
        4_000,
        6,
        modern::room::generate,
    ),
    triangle_scene(
        "atrium",
        "a court of arcades and drapes: huge beside tiny triangles, long slanted beams",
        6_000,
        4,
        modern::atrium::generate,
    ),
];
