//! The court: its floor of slabs, the basin with a fountain, and trees in urns.

use super::layout::{BAY, HALF, SEED, VASES};
use super::palette::{CARVED, FRUIT, LEAVES, SLABS, STONE, TIMBER, URN, WATER};
use super::turning::{flat, plain, revolve};
use crate::modern::noise::Dice;
use crate::modern::props::{PartBuilder, STANDING};
use glam::{DVec3, dvec3};
use libm::{cos, sin};
use std::f64::consts::{PI, TAU};

/// Half the width of the basin, and height of its coping.
const BASIN: f64 = 1.35;
const COPING: f64 = 0.4;

/// Everything that stands in a court of this many bays in length.
pub(super) fn furnish(parts: &mut PartBuilder, bays: u32) {
    let long = BAY * f64::from(bays) / 2.0;
    floor(parts, bays);
    let pool = long * 0.55;
    basin(parts, pool);
    fountain(parts);
    let rows = bays / 2;
    for k in 0..rows {
        let z = pool * (2.0 * (f64::from(k) + 0.5) / f64::from(rows) - 1.0);
        for (side, x) in (0..).zip([-2.55, 2.55]) {
            tree(&mut parts.moved(x, 0.0, z), u64::from(2 * k + side));
        }
    }
    if parts.detail < VASES {
        return;
    }
    for x in [-BASIN - 0.1, BASIN + 0.1] {
        for z in [-pool - 0.1, pool + 0.1] {
            vase(&mut parts.moved(x, COPING + 0.04, z));
        }
    }
}

/// Square slabs of two metres in two colours.
fn floor(parts: &mut PartBuilder, bays: u32) {
    let side = 2.0;
    let (columns, rows) = ((HALF + 0.1) as u32, (BAY * f64::from(bays) / side) as u32);
    let mut slab = flat(parts);
    for row in 0..rows {
        for column in 0..columns {
            slab.material(SLABS[((row + column) % 2) as usize]);
            let x = side * f64::from(column) - HALF;
            let z = side * f64::from(row) - f64::from(rows);
            let corners = [(x, z + side), (x + side, z + side), (x + side, z), (x, z)];
            slab.wall(corners.map(|(x, z)| (x, 0.0, z)));
        }
    }
}

fn basin(parts: &mut PartBuilder, long: f64) {
    let (wide, rim) = (BASIN, 0.3);
    let mut stone = flat(parts);
    let (outer, end) = (wide + rim, long + rim);
    let walls = [
        ((-outer, -end), (-wide, end)),
        ((wide, -end), (outer, end)),
        ((-wide, -end), (wide, -long)),
        ((-wide, long), (wide, end)),
    ];
    for (lo, hi) in walls {
        stone.material(STONE);
        stone.cuboid((lo.0, 0.0, lo.1), (hi.0, COPING - 0.06, hi.1), STANDING);
        stone.material(CARVED);
        let (lo, hi) = (
            (lo.0 - 0.04, COPING - 0.06, lo.1 - 0.04),
            (hi.0 + 0.04, COPING + 0.04, hi.1 + 0.04),
        );
        stone.slab(lo, hi);
    }
    stone.material(WATER);
    let corners = [(-wide, long), (wide, long), (wide, -long), (-wide, -long)];
    stone.wall(corners.map(|(x, z)| (x, COPING - 0.12, z)));
}

/// Two bowls on a turned shaft in the middle of the basin.
fn fountain(parts: &mut PartBuilder) {
    parts.material(CARVED);
    let shaft = [
        (0.34, 0.2),
        (0.34, 0.5),
        (0.34, 0.5),
        (0.2, 0.56),
        (0.13, 0.7),
        (0.2, 0.84),
        (0.2, 0.92),
        (0.12, 1.0),
        (0.12, 1.14),
    ];
    revolve(parts, &shaft, (6, 5), plain);
    bowl(&mut parts.moved(0.0, 1.12, 0.0), 0.78);
    let upper = [
        (0.1, 1.2),
        (0.06, 1.4),
        (0.1, 1.55),
        (0.1, 1.6),
        (0.06, 1.66),
        (0.06, 1.8),
    ];
    revolve(parts, &upper, (6, 3), plain);
    bowl(&mut parts.moved(0.0, 1.78, 0.0), 0.4);
    finial(&mut parts.moved(0.0, 1.84, 0.0));
}

/// A bowl with godroons beneath, and water in it.
fn bowl(parts: &mut PartBuilder, r: f64) {
    parts.material(CARVED);
    let outline = [
        (0.14, 0.0),
        (0.5, 0.02),
        (0.85, 0.16),
        (0.97, 0.27),
        (1.04, 0.29),
        (1.04, 0.34),
        (0.96, 0.34),
        (0.9, 0.25),
    ]
    .map(|(x, y)| (x * r, y * r));
    revolve(parts, &outline, (8, 4), |turn, t| {
        if t < 0.6 {
            0.045 * r * sin(12.0 * turn).abs() * sin(t / 0.6 * PI)
        } else {
            0.0
        }
    });
    parts.material(WATER);
    let surface = [(0.94 * r, 0.28 * r), (0.04, 0.28 * r)];
    flat(parts).lathe(&surface, 12);
    parts.material(CARVED);
}

/// A pine cone on a short neck.
fn finial(parts: &mut PartBuilder) {
    let outline = [
        (0.05, 0.0),
        (0.04, 0.12),
        (0.09, 0.16),
        (0.125, 0.26),
        (0.1, 0.38),
        (0.05, 0.48),
        (0.008, 0.5),
    ];
    revolve(parts, &outline, (6, 3), |turn, t| {
        let scales = sin(6.0 * turn + 40.0 * t) * sin(6.0 * turn - 40.0 * t);
        0.012 * scales * (1.0 - t)
    });
}

/// A vase with a lid.
fn vase(parts: &mut PartBuilder) {
    parts.material(URN);
    let outline = [
        (0.13, 0.0),
        (0.13, 0.04),
        (0.13, 0.04),
        (0.05, 0.08),
        (0.06, 0.12),
        (0.19, 0.24),
        (0.22, 0.4),
        (0.16, 0.52),
        (0.12, 0.58),
        (0.17, 0.64),
        (0.17, 0.66),
        (0.1, 0.7),
        (0.03, 0.76),
        (0.04, 0.8),
        (0.006, 0.84),
    ];
    revolve(parts, &outline, (6, 6), |turn, t| {
        let belly = (1.0 - (t - 0.42).abs() / 0.16).max(0.0);
        0.016 * belly * sin(10.0 * turn).abs()
    });
}

/// An orange tree, cut round, in an urn.
fn tree(parts: &mut PartBuilder, number: u64) {
    parts.material(URN);
    let urn = [
        (0.26, 0.0),
        (0.26, 0.06),
        (0.26, 0.06),
        (0.2, 0.08),
        (0.33, 0.3),
        (0.37, 0.5),
        (0.34, 0.56),
        (0.41, 0.58),
        (0.41, 0.65),
        (0.41, 0.65),
        (0.35, 0.65),
        (0.34, 0.58),
    ];
    revolve(parts, &urn, (8, 4), |turn, t| {
        let belly = (1.0 - (t - 0.45).abs() / 0.14).max(0.0);
        0.02 * belly * (cos(14.0 * turn) + 0.5 * cos(7.0 * turn))
    });
    let mut flat = flat(parts);
    flat.material(TIMBER);
    flat.lathe(&[(0.34, 0.6), (0.045, 0.62), (0.035, 1.6)], 8);
    crown(&mut parts.moved(0.0, 1.75, 0.0), number);
}

/// Leaves and fruit about the frame's origin.
fn crown(parts: &mut PartBuilder, number: u64) {
    parts.material(LEAVES[0]);
    parts.sphere((0.0, 0.0, 0.0), 0.47, parts.cells(0.6).max(1));
    let mut dice = Dice::of(SEED + 1, number);
    leaves(parts, &mut dice);
    if parts.detail < 3.0 {
        return;
    }
    parts.material(FRUIT);
    for _ in 0..14 {
        let offset = direction(&mut dice) * 0.6;
        let frequency = parts.cells(0.07).max(2);
        parts.sphere((offset.x, offset.y, offset.z), 0.042, frequency);
    }
}

/// Random numbers for each leaf of [`leaves`].
const LEAF_NUMBERS: u64 = 8;

/// The leaves of a crown.
fn leaves(parts: &mut PartBuilder, dice: &mut Dice) {
    let count = parts.cells(90.0).max(25);
    if parts.mesh.counted(2 * count as u64) {
        return dice.skip(LEAF_NUMBERS * count as u64);
    }
    // More leaves are smaller, so that the density of a crown stays the same.
    let size = (3.2 / (count as f64).sqrt()).clamp(0.035, 0.16);
    for _ in 0..count {
        let out = direction(dice);
        let position = out * dice.range(0.42, 0.62);
        leaf(parts, position, out, size, dice);
    }
}

/// A uniformly distributed direction.
fn direction(dice: &mut Dice) -> DVec3 {
    let y = dice.range(-1.0, 1.0);
    let turn = dice.range(0.0, TAU);
    let r = (1.0 - y * y).sqrt();
    dvec3(r * cos(turn), y, r * sin(turn))
}

/// A leaf of two triangles that faces away from the crown, more or less.
fn leaf(parts: &mut PartBuilder, position: DVec3, out: DVec3, size: f64, dice: &mut Dice) {
    let normal = (out + direction(dice) * 0.75).normalize();
    let tip = normal.cross(direction(dice));
    let tip = tip / (tip.length() + 1e-3) * size;
    let side = normal.cross(tip) * 0.42;
    let place = |p: DVec3| parts.frame.point(position + p);
    let corners = [place(-tip), place(side), place(tip), place(-side)];
    parts.mesh.material(LEAVES[dice.below(LEAVES.len())]);
    parts.mesh.quad(corners, 1, 1);
}
