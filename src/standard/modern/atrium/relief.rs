//! Carved ornaments on walls: heads of lions, and flowers.

use crate::modern::mesh_builder::Grid;
use crate::modern::props::{PartBuilder, on_circle};
use glam::{DVec2, dvec2, dvec3};
use libm::{cos, exp, sin};
use std::f64::consts::TAU;

/// Draws a round relief in the frame's xy plane: `height` gives its rise along z, in radii, at a
/// point of the unit disc.
fn medallion(parts: &mut PartBuilder, radius: f64, fineness: f64, height: impl Fn(DVec2) -> f64) {
    let around = parts.cells(TAU * radius * fineness).max(8);
    let rows = parts.cells(radius * fineness).max(2);
    let frame = parts.frame;
    let surface = |p: DVec2| {
        let p = dvec3(p.x, p.y, height(p)) * radius;
        frame.point(p)
    };
    // Rows run from the rim inward, which is upward for columns that run counter-clockwise.
    let ring = |i: usize, j: usize| {
        let r = 1.0 - 0.96 * j as f64 / rows as f64;
        surface(on_circle(i, around) * r)
    };
    parts.mesh.grid(Grid::tube(around, rows), ring);
    if !parts.mesh.counted(around as u64) {
        parts
            .mesh
            .fan(surface(DVec2::ZERO), around, |i| ring(i, rows));
    }
}

/// A bump of this width and height one.
fn bump(p: DVec2, center: (f64, f64), width: f64) -> f64 {
    let d = (p - DVec2::from(center)).length_squared() / (width * width);
    exp(-d)
}

/// A lion's head within a rim, looking out of the wall.
pub(super) fn lion(parts: &mut PartBuilder, radius: f64) {
    medallion(parts, radius, 2.2, |p| {
        let r = p.length();
        if r > 0.9 {
            return 0.16 * sin((1.0 - r) * 10.0 * TAU / 2.0) * f64::from(u8::from(r < 1.0));
        }
        let turn = libm::atan2(p.y, p.x);
        let strands = 0.5 + 0.5 * cos(22.0 * turn + 9.0 * sin(5.0 * r));
        let mane = exp(-((r - 0.62) / 0.24) * ((r - 0.62) / 0.24));
        let head = 0.55 * (1.0 - (r / 0.7) * (r / 0.7)).max(0.0);
        let snout = 0.34 * bump(p, (0.0, -0.12), 0.2) + 0.1 * bump(p, (0.0, -0.03), 0.09);
        let pair = |x: f64, y: f64, width| bump(p, (-x, y), width) + bump(p, (x, y), width);
        let (eyes, brows) = (pair(0.21, 0.16, 0.075), pair(0.2, 0.29, 0.1));
        let ears = pair(0.45, 0.44, 0.12);
        let mouth = bump(p * dvec2(0.5, 1.0), (0.0, -0.31), 0.055);
        0.06 + mane * (0.22 + 0.13 * strands) + head + snout - 0.17 * eyes
            + 0.09 * brows
            + 0.25 * ears
            - 0.2 * mouth
    });
}

/// A flower of two rings of petals.
pub(super) fn rosette(parts: &mut PartBuilder, radius: f64) {
    medallion(parts, radius, 2.0, |p| {
        let r = p.length();
        let turn = libm::atan2(p.y, p.x);
        let petal = |shift: f64| cos(4.0 * turn + shift).abs().sqrt();
        let outer = petal(0.0) * (1.0 - r) * r * 1.5;
        let inner = petal(TAU / 4.0) * (0.62 - r).max(0.0) * r * 3.2;
        outer + inner + 0.3 * bump(p, (0.0, 0.0), 0.16)
    });
}
