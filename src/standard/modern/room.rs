//! room: a knot of rope, cast in gold, on a pedestal in a closed room.
//!
//! The knot has seven tenths of the triangles in a thousandth of the room's volume. A tree that
//! splits space evenly performs badly here, and no ray ever leaves.

use super::assembly;
use super::knot::knot;
use super::materials::{glass, glow, matte, polished, rgb};
use super::props::{LocalFrame, ON_WALL, PartBuilder, STANDING, cells, fitted_detail};
use super::setup::{hd, lamp};
use crate::builder::{DocumentMaterial, SceneBuilder};
use glam::{DVec3, dvec3};
use libm::{cos, sin};
use std::f64::consts::TAU;

const AMBIENT: DVec3 = dvec3(0.15, 0.125, 0.105);
/// Half the width and depth of the room, and its height.
const HALF: f64 = 3.0;
const HEIGHT: f64 = 3.3;
/// Middle of the statue.
const STATUE: DVec3 = dvec3(-0.1, 1.36, -0.2);

const PLASTER: usize = 0;
const WOOD: usize = 1;
const TILES: [usize; 2] = [2, 3];
const GOLD: usize = 4;
const STONE: usize = 5;
const GLASS: usize = 6;
const MIRROR: usize = 7;
const BULB: usize = 8;
const SHADE: usize = 9;
const CEILING: usize = 10;
const RUG: [usize; 2] = [11, 12];
const DARK_WOOD: usize = 13;

fn palette() -> [DocumentMaterial; 14] {
    let dull = |r: f64, g: f64, b: f64| matte(rgb(r, g, b), AMBIENT);
    let marble = |material| polished(material, rgb(0.10, 0.10, 0.10), 400.0);
    [
        dull(0.30, 0.42, 0.41),
        dull(0.66, 0.61, 0.53),
        marble(dull(0.64, 0.60, 0.54)),
        marble(dull(0.07, 0.075, 0.08)),
        polished(dull(0.46, 0.27, 0.075), rgb(0.50, 0.36, 0.15), 60.0),
        polished(dull(0.62, 0.60, 0.57), rgb(0.05, 0.05, 0.05), 200.0),
        glass(1.5),
        polished(dull(0.01, 0.01, 0.012), rgb(0.82, 0.84, 0.84), 2000.0),
        glow(rgb(1.0, 0.92, 0.74)),
        DocumentMaterial {
            ke: rgb(0.34, 0.22, 0.10),
            ..dull(0.65, 0.56, 0.42)
        },
        dull(0.74, 0.71, 0.65),
        dull(0.36, 0.035, 0.04),
        dull(0.48, 0.30, 0.10),
        polished(dull(0.13, 0.06, 0.028), rgb(0.04, 0.04, 0.04), 80.0),
    ]
}

pub(crate) fn generate(size: u32, builder: &mut dyn SceneBuilder) {
    builder.view(&hd(dvec3(1.75, 1.62, 2.75), dvec3(-0.35, 1.23, -0.4), 42.0));
    builder.background(DVec3::ZERO);
    builder.light(&lamp(dvec3(0.55, 2.38, 0.75), rgb(0.62, 0.53, 0.40), 1.7));
    builder.light(&lamp(dvec3(-2.62, 1.78, -1.1), rgb(0.40, 0.27, 0.13), 1.3));
    builder.light(&lamp(dvec3(0.9, 1.78, -2.62), rgb(0.40, 0.27, 0.13), 1.3));
    builder.light(&lamp(dvec3(2.3, 2.6, 2.5), rgb(0.20, 0.24, 0.30), 2.2));
    let budget = u64::from(size);
    let detail = fitted_detail(budget * 3 / 10, (0.1, 2000.0), 1, |parts, _| furnish(parts));
    assembly::draw(builder, palette(), &|mesh| {
        furnish(&mut PartBuilder::new(mesh, detail));
        let left = budget.saturating_sub(mesh.triangles());
        mesh.material(GOLD);
        knot(mesh, left as f64, STATUE);
    });
}

/// Everything except the statue.
fn furnish(parts: &mut PartBuilder) {
    floor(parts);
    shell(parts);
    for quarter in 0..4 {
        let wall = LocalFrame::at(DVec3::ZERO).turned(90.0 * f64::from(quarter));
        panels(&mut parts.at(wall.moved(0.0, 0.0, -HALF)));
    }
    pedestal(&mut parts.moved(STATUE.x, 0.0, STATUE.z));
    pendant(&mut parts.moved(0.55, 0.0, 0.75));
    let left = LocalFrame::at(dvec3(-HALF, 1.62, -1.1)).turned(90.0);
    sconce(&mut parts.at(left));
    sconce(&mut parts.moved(0.9, 1.62, -HALF));
    mirror(&mut parts.moved(-0.85, 1.02, -HALF));
    table(&mut parts.moved(-2.1, 0.0, 0.45));
}

/// Tiles, and a rug of two colours.
fn floor(parts: &mut PartBuilder) {
    parts.tiles(TILES, HALF, 10);
    for (material, half, height) in [(RUG[1], 1.22, 0.012), (RUG[0], 1.12, 0.018)] {
        parts.material(material);
        let rug = LocalFrame::at(dvec3(-0.1, 0.0, -0.2)).turned(45.0);
        let mut rug = parts.at(rug);
        rug.cuboid((-half, 0.0, -half), (half, height, half), STANDING);
    }
}

/// Ceiling and upper walls, which face inward.
fn shell(parts: &mut PartBuilder) {
    let n = parts.cells(2.0 * HALF);
    let high = parts.cells(HEIGHT);
    for quarter in 0..4 {
        let mut wall = parts.at(parts.frame.turned(90.0 * f64::from(quarter)));
        wall.material(PLASTER);
        let corners = [(-HALF, 0.0), (HALF, 0.0), (HALF, HEIGHT), (-HALF, HEIGHT)];
        wall.quad(corners.map(|(x, y)| (x, y, -HALF)), (n, high));
    }
    parts.material(CEILING);
    let corners = [(-HALF, -HALF), (HALF, -HALF), (HALF, HALF), (-HALF, HALF)];
    parts.quad(corners.map(|(x, z)| (x, HEIGHT, z)), (n, n));
}

/// The wooden lower wall with raised panels, its rail, and the cornice under the ceiling.
fn panels(wall: &mut PartBuilder) {
    wall.material(WOOD);
    let width = (-HALF, HALF);
    let base = [(0.06, 0.0), (0.06, 0.13), (0.045, 0.16), (0.03, 0.17)];
    let rail = [
        (0.03, 0.84),
        (0.07, 0.87),
        (0.075, 0.91),
        (0.055, 0.94),
        (0.0, 0.945),
    ];
    wall.moulding(width, &[(0.03, 0.0), (0.03, 0.86)]);
    wall.moulding(width, &base);
    wall.moulding(width, &rail);
    for k in 0..5 {
        let x = -HALF + 0.13 + 1.16 * f64::from(k);
        for (inset, depth) in [(0.0, 0.045), (0.07, 0.06)] {
            let lo = (x + inset, 0.26 + inset, 0.03);
            let hi = (x + 1.06 - inset, 0.76 - inset, depth);
            wall.cuboid(lo, hi, ON_WALL);
        }
    }
    wall.material(CEILING);
    let steps = 12;
    let cornice = (0..=steps).map(|k| {
        let turn = TAU / 4.0 * f64::from(k) / f64::from(steps);
        (0.16 * (1.0 - cos(turn)), HEIGHT - 0.16 * (1.0 - sin(turn)))
    });
    wall.moulding(width, &cornice.collect::<Vec<_>>());
}

/// Number of sides of turned work of this radius.
fn around(radius: f64, detail: f64) -> usize {
    cells(TAU * radius, detail).max(10)
}

fn pedestal(parts: &mut PartBuilder) {
    parts.material(STONE);
    let mut turned = parts.at(parts.frame.turned(20.0));
    for (half, from, to) in [(0.34, 0.0, 0.12), (0.30, 0.64, 0.72)] {
        turned.slab((-half, from, -half), (half, to, half));
    }
    let profile = [
        (0.31, 0.12),
        (0.325, 0.15),
        (0.31, 0.19),
        (0.25, 0.21),
        (0.235, 0.24),
        (0.215, 0.30),
        (0.205, 0.42),
        (0.21, 0.52),
        (0.23, 0.575),
        (0.27, 0.60),
        (0.285, 0.625),
        (0.27, 0.64),
    ];
    parts.lathe(&profile, around(0.25, parts.detail));
    parts.material(GOLD);
    let foot = [
        (0.16, 0.72),
        (0.16, 0.735),
        (0.07, 0.76),
        (0.055, 0.97),
        (0.0, 0.98),
    ];
    parts.lathe(&foot, around(0.16, parts.detail));
}

/// The lamp over the statue: a shade open downward, a bulb, a cord.
fn pendant(parts: &mut PartBuilder) {
    parts.material(SHADE);
    let shade = [
        (0.27, 2.46),
        (0.22, 2.56),
        (0.10, 2.66),
        (0.03, 2.70),
        (0.012, 2.74),
    ];
    parts.lathe(&shade, around(0.25, parts.detail));
    parts.material(DARK_WOOD);
    let cord = [(0.008, 2.70), (0.008, 3.22), (0.05, 3.28), (0.05, HEIGHT)];
    parts.lathe(&cord, 10);
    parts.material(BULB);
    parts.sphere((0.0, 2.48, 0.0), 0.055, parts.cells(0.1).max(2));
}

/// A bracket on a wall with a small shade.
fn sconce(wall: &mut PartBuilder) {
    wall.material(DARK_WOOD);
    wall.slab((-0.05, -0.12, 0.0), (0.05, 0.12, 0.03));
    wall.slab((-0.012, -0.03, 0.03), (0.012, -0.006, 0.38));
    let candle = [
        (0.035, -0.03),
        (0.04, 0.0),
        (0.015, 0.012),
        (0.015, 0.08),
        (0.0, 0.082),
    ];
    let mut arm = wall.moved(0.0, 0.0, 0.38);
    arm.lathe(&candle, around(0.03, arm.detail));
    arm.material(SHADE);
    // Open at both ends, so that its light reaches the wall above and below.
    arm.lathe(&[(0.15, 0.06), (0.085, 0.26)], around(0.15, arm.detail));
}

/// A mirror in a gilt frame.
fn mirror(wall: &mut PartBuilder) {
    let (half, high) = (0.52, 1.36);
    wall.material(MIRROR);
    let n = wall.cells(1.0);
    let corners = [(-half, 0.0), (half, 0.0), (half, high), (-half, high)];
    wall.quad(corners.map(|(x, y)| (x, y, 0.04)), (n, n));
    wall.material(GOLD);
    let mut bar = |(x0, y0): (f64, f64), (x1, y1): (f64, f64)| {
        for (inset, depth) in [(0.0, 0.05), (0.02, 0.075)] {
            let lo = (x0 + inset, y0 + inset, 0.0);
            wall.cuboid(lo, (x1 - inset, y1 - inset, depth), ON_WALL);
        }
    };
    let w = 0.09;
    bar((-half - w, -w), (-half, high + w));
    bar((half, -w), (half + w, high + w));
    bar((-half, -w), (half, 0.0));
    bar((-half, high), (half, high + w));
}

/// A round table with a sphere of glass on it.
fn table(parts: &mut PartBuilder) {
    parts.material(DARK_WOOD);
    let profile = [
        (0.24, 0.0),
        (0.23, 0.03),
        (0.06, 0.07),
        (0.04, 0.12),
        (0.055, 0.24),
        (0.035, 0.36),
        (0.05, 0.52),
        (0.03, 0.6),
        (0.12, 0.655),
        (0.38, 0.665),
        (0.4, 0.675),
        (0.4, 0.695),
        (0.38, 0.705),
        (0.0, 0.705),
    ];
    parts.lathe(&profile, around(0.4, parts.detail));
    parts.material(GLASS);
    parts.sphere((0.0, 0.875, 0.0), 0.17, parts.cells(0.5).max(5));
}
