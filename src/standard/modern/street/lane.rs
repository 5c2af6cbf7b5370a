//! Objects in the lane, and its pavement.

use super::layout::{HALF, SEED, START};
use super::palette::{BULB, COBBLE, IRON, KERB, LEAF, TABLE, WOOD};
use super::stone::{LEAF_TRIANGLES, leaf, stone, stone_triangles};
use crate::builder::StandardLight;
use crate::modern::materials::rgb;
use crate::modern::noise::{Dice, fractal2};
use crate::modern::props::{LocalFrame, PartBuilder, STANDING, cells};
use crate::modern::setup::lamp;
use glam::{DVec3, dvec2, dvec3};

/// The lamp posts' x and z coordinates.
pub(super) const LAMPS: [(f64, f64); 3] = [(2.75, 2.6), (-2.75, -4.4), (2.75, -11.5)];

/// Height of a lantern's middle.
const LANTERN: f64 = 3.32;
/// Distance of the kerbs from the middle of the lane.
const KERB_AT: f64 = 2.3;
/// Height of the footways above the road.
const STEP: f64 = 0.1;

/// Light of a lamp post, under the lantern's roof, with nothing below.
pub(super) fn light((x, z): (f64, f64)) -> StandardLight {
    lamp(dvec3(x, LANTERN, z), rgb(0.95, 0.62, 0.28), 2.1)
}

fn lamp_post(parts: &mut PartBuilder) {
    parts.material(IRON);
    let profile = [
        (0.16, 0.0),
        (0.16, 0.1),
        (0.11, 0.16),
        (0.1, 0.5),
        (0.13, 0.54),
        (0.06, 0.62),
        (0.05, 1.4),
        (0.075, 1.44),
        (0.045, 1.5),
        (0.035, 2.7),
        (0.06, 2.75),
        (0.03, 2.8),
        (0.03, 2.95),
        (0.11, 3.02),
    ];
    parts.lathe(&profile, parts.cells(0.8).clamp(6, 96));
    let roof = [
        (0.24, 3.42),
        (0.18, 3.5),
        (0.06, 3.56),
        (0.03, 3.66),
        (0.0, 3.68),
    ];
    parts.lathe(&roof, 6);
    let rows = parts.cells(0.4);
    for k in 0..6 {
        let side = parts.frame.turned(60.0 * f64::from(k) + 30.0);
        let strut = [(0.11, 3.02, 0.0), (0.21, 3.42, 0.0)];
        parts.at(side).rod(strut, 0.011, (4, rows));
    }
    parts.material(BULB);
    // Below the light, so that light reaches the ground at a distance and all sides.
    let bulb = (0.0, LANTERN - STEP - 0.14, 0.0);
    parts.sphere(bulb, 0.085, parts.cells(0.15).max(1));
}

/// Everything in the lane except its pavement; `parts` are in the world's frame.
pub(super) fn furnish(parts: &mut PartBuilder, length: f64) {
    let end = START - length;
    for (x, z) in LAMPS.into_iter().filter(|(_, z)| *z > end) {
        lamp_post(&mut parts.moved(x, STEP, z));
    }
    kerbs(parts, end);
    garland(parts, 0.6);
    if length > 8.0 {
        garland(parts, -6.0);
    }
    bed(parts, end);
    let seat = LocalFrame::at(dvec3(3.1, STEP, -1.0)).turned(-90.0);
    bench(&mut parts.at(seat));
    for (x, z) in [(-3.05, 0.35), (-3.05, 6.6), (3.15, -3.2)] {
        if z > end {
            shrub(&mut parts.at(LocalFrame::at(dvec3(x, STEP, z))));
        }
    }
}

/// The earth under everything, visible between the stones.
fn bed(parts: &mut PartBuilder, end: f64) {
    parts.material(IRON);
    let (wide, near) = (HALF + 0.3, START + 4.2);
    let corners = [(-wide, near), (wide, near), (wide, end), (-wide, end)];
    parts.quad(corners.map(|(x, z)| (x, -0.04, z)), (1, 1));
}

/// Kerbs and footways.
fn kerbs(parts: &mut PartBuilder, end: f64) {
    parts.material(KERB);
    let near = START + 4.0;
    for side in [-1.0, 1.0] {
        let (inner, outer) = (KERB_AT * side, (HALF + 0.3) * side);
        let (lo, hi) = (f64::min(inner, outer), f64::max(inner, outer));
        let slabs = cells((near - end) / 1.2, 1.0);
        let step = (near - end) / slabs as f64;
        for k in 0..slabs {
            let z = end + step * k as f64;
            let corner = (lo, -0.05, z + 0.006);
            parts.cuboid(corner, (hi, STEP, z + step - 0.006), STANDING);
        }
    }
}

/// A string of small lamps across the lane.
fn garland(parts: &mut PartBuilder, z: f64) {
    let spans = 14;
    let column = |k: i32| {
        let t = f64::from(k) / f64::from(spans);
        let sag = 4.0 * t * (1.0 - t) * 0.75;
        (HALF * (2.0 * t - 1.0), 5.15 - sag, z + 0.5 * t)
    };
    for k in 0..spans {
        parts.material(IRON);
        parts.rod([column(k), column(k + 1)], 0.008, (4, parts.cells(0.5)));
        if k > 0 {
            parts.material(BULB);
            let (x, y, z) = column(k);
            parts.sphere((x, y - 0.06, z), 0.05, parts.cells(0.1).max(1));
        }
    }
}

fn bench(parts: &mut PartBuilder) {
    parts.material(IRON);
    for x in [-0.75, 0.69] {
        parts.slab((x, 0.0, -0.22), (x + 0.06, 0.42, -0.16));
        parts.slab((x, 0.0, 0.16), (x + 0.06, 0.42, 0.22));
        parts.slab((x, 0.42, -0.26), (x + 0.06, 0.86, -0.2));
    }
    parts.material(WOOD);
    for k in 0..4 {
        let z = -0.2 + 0.115 * f64::from(k);
        parts.slab((-0.85, 0.42, z), (0.85, 0.455, z + 0.085));
    }
    for k in 0..3 {
        let y = 0.53 + 0.12 * f64::from(k);
        parts.slab((-0.85, y, -0.2), (0.85, y + 0.085, -0.17));
    }
}

/// A round bush in a tub.
fn shrub(parts: &mut PartBuilder) {
    parts.material(TABLE);
    let tub = [
        (0.17, 0.0),
        (0.23, 0.4),
        (0.25, 0.4),
        (0.25, 0.45),
        (0.21, 0.45),
        (0.21, 0.41),
        (0.0, 0.4),
    ];
    parts.lathe(&tub, parts.cells(1.5).clamp(8, 96));
    let leaves = parts.cells(260.0);
    if parts.mesh.counted(LEAF_TRIANGLES * leaves as u64) {
        return;
    }
    let mut dice = Dice::of(SEED + 5, (parts.frame.origin.z * 16.0) as i64 as u64);
    for _ in 0..leaves {
        let p = dice.vector(-1.0, 1.0);
        let outward = p / (p.length() + 1e-9);
        let reach = 0.33 * (1.0 + 0.35 * fractal2(SEED, dvec2(p.x + p.z, p.y) * 2.0, 2));
        parts.material(LEAF + dice.below(2));
        let center = dvec3(0.0, 0.78, 0.0) + outward * (reach * dice.range(0.75, 1.0));
        leaf(parts, center, &mut dice, 0.05);
    }
}

/// Paves the road with stones of about this many triangles in all.
pub(super) fn pave(parts: &mut PartBuilder, length: f64, triangles: u64) {
    let (wide, near) = (2.0 * KERB_AT, START + 4.0);
    let long = length + 4.0;
    // Stones have a minimum size; beyond it they become rounder instead.
    let most = wide * long / (0.11 * 0.13);
    let inner = (1..200).find(|inner| triangles as f64 / stone_triangles(*inner) as f64 <= most);
    let inner = inner.unwrap_or(200);
    let count = (triangles as f64 / stone_triangles(inner) as f64).max(1.0);
    let columns = (count * wide / long * 1.18).sqrt().round().max(1.0);
    let rows = (count / columns).round().max(1.0);
    if parts
        .mesh
        .counted((columns * rows) as u64 * stone_triangles(inner))
    {
        return;
    }
    let size = dvec2(wide / columns, long / rows);
    // The road's x and z, and z up.
    let frame = LocalFrame {
        origin: dvec3(-KERB_AT, 0.0, near),
        axes: [DVec3::X, DVec3::NEG_Z, DVec3::Y],
    };
    let mut road = parts.at(frame);
    for row in 0..rows as u64 {
        let mut dice = Dice::of(SEED + 3, row);
        let shift = if row % 2 == 0 { 0.25 } else { -0.25 };
        for column in 0..columns as u64 {
            let x = size.x * (column as f64 + shift);
            let y = size.y * row as f64;
            road.material(COBBLE + dice.below(3));
            let sunk = 0.012 * fractal2(SEED + 4, dvec2(x, y) * 0.9, 2) - 0.006 * dice.unit();
            let depth = 0.22 * size.x.min(0.12);
            let corner = dvec3(x, y, sunk - depth);
            stone(&mut road, corner, size, (0.16, depth), inner);
        }
    }
}
