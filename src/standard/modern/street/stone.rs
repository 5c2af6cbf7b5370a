//! Small objects in large numbers: stones and leaves.

use crate::modern::mesh_builder::Grid;
use crate::modern::noise::Dice;
use crate::modern::props::PartBuilder;
use glam::{DVec2, DVec3, dvec3};

/// Number of triangles of a [`leaf`].
pub(super) const LEAF_TRIANGLES: u64 = 2;

/// A leaf: two triangles in a random direction.
pub(super) fn leaf(parts: &mut PartBuilder, position: DVec3, dice: &mut Dice, size: f64) {
    let mut side = || dice.vector(-1.0, 1.0) * size;
    let (a, b) = (side(), side());
    let place = |p: DVec3| parts.frame.point(position + p);
    parts
        .mesh
        .quad([place(-a), place(b * 0.6), place(a), place(-b * 0.6)], 1, 1);
}

/// Number of triangles of a [`stone`].
pub(super) fn stone_triangles(inner: usize) -> u64 {
    2 * (inner as u64 + 2) * (inner as u64 + 2)
}

/// A stone of a wall or pavement: a cushion on a rectangle from `corner` on in x and y of the
/// frame. It leaves a border of `rim` times its size free, and rises by `depth` along z. It has
/// `inner`² quads and a bevel around them.
pub(super) fn stone(
    parts: &mut PartBuilder,
    corner: DVec3,
    size: DVec2,
    (rim, depth): (f64, f64),
    inner: usize,
) {
    let last = inner + 2;
    let along = |i: usize| match i {
        0 => 0.02,
        i if i == last => 0.98,
        i => rim + (1.0 - 2.0 * rim) * ((i - 1) as f64 / inner as f64),
    };
    let frame = parts.frame;
    parts.mesh.grid(Grid::open(last, last), |i, j| {
        let (u, v) = (along(i), along(j));
        let border = i == 0 || j == 0 || i == last || j == last;
        let bulge = 1.0 + 2.0 * u * (1.0 - u) * v * (1.0 - v);
        let height = if border { 0.0 } else { depth * bulge };
        frame.point(corner + dvec3(u * size.x, v * size.y, height))
    });
}
