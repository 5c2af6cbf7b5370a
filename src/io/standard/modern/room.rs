//! room: a knot of rope, cast in gold, on a pedestal in a closed room.
//!
//! Seven tenths of the triangles are the knot's, in a thousandth of the room's volume. A tree that
//! splits space evenly does badly here, and no ray ever leaves.

use super::geodesic;
use super::knot::knot;
use super::materials::{glass, glow, matte, polished, rgb};
use super::mesh_builder::{MeshBuilder, fit_detail};
use super::props::{ALL, LocalFrame, STANDING, cells, cuboid, lathe, moulding};
use super::{SIZES, hd, lamp};
use crate::standard::builder::{DocumentMaterial, SceneBuilder};
use crate::standard::catalogue::{Family, SceneParams, StandardScene};
use glam::{DVec2, DVec3};
use libm::{cos, sin};
use std::f64::consts::TAU;

pub(in crate::standard) const ENTRY: StandardScene = StandardScene {
    name: "room",
    purpose: "a finely detailed statue in a closed room: a teapot in a stadium, and no ray escapes",
    family: Family::Modern,
    default_size: 1_000_000,
    sizes: SIZES,
    size_means: "triangles",
    max_depth: 6,
    generate,
};

const AMBIENT: DVec3 = DVec3::new(0.15, 0.125, 0.105);
/// Half the width and depth of the room, and its height.
const HALF: f64 = 3.0;
const HEIGHT: f64 = 3.3;
/// Middle of the statue.
const STATUE: DVec3 = DVec3::new(-0.1, 1.36, -0.2);

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
    let marble = |color| polished(matte(color, AMBIENT), rgb(0.10, 0.10, 0.10), 400.0);
    let gold = matte(rgb(0.46, 0.27, 0.075), AMBIENT);
    let mirror = matte(rgb(0.01, 0.01, 0.012), AMBIENT);
    [
        matte(rgb(0.30, 0.42, 0.41), AMBIENT),
        matte(rgb(0.66, 0.61, 0.53), AMBIENT),
        marble(rgb(0.64, 0.60, 0.54)),
        marble(rgb(0.07, 0.075, 0.08)),
        polished(gold, rgb(0.50, 0.36, 0.15), 60.0),
        polished(
            matte(rgb(0.62, 0.60, 0.57), AMBIENT),
            rgb(0.05, 0.05, 0.05),
            200.0,
        ),
        glass(1.5),
        polished(mirror, rgb(0.82, 0.84, 0.84), 2000.0),
        glow(rgb(1.0, 0.92, 0.74)),
        DocumentMaterial {
            ke: rgb(0.34, 0.22, 0.10),
            ..matte(rgb(0.65, 0.56, 0.42), AMBIENT)
        },
        matte(rgb(0.74, 0.71, 0.65), AMBIENT),
        matte(rgb(0.36, 0.035, 0.04), AMBIENT),
        matte(rgb(0.48, 0.30, 0.10), AMBIENT),
        polished(
            matte(rgb(0.13, 0.06, 0.028), AMBIENT),
            rgb(0.04, 0.04, 0.04),
            80.0,
        ),
    ]
}

fn generate(params: &SceneParams, builder: &mut dyn SceneBuilder) {
    builder.view(&hd(
        DVec3::new(1.75, 1.62, 2.75),
        DVec3::new(-0.35, 1.23, -0.4),
        42.0,
    ));
    builder.background(DVec3::ZERO);
    builder.light(&lamp(
        DVec3::new(0.55, 2.38, 0.75),
        rgb(0.62, 0.53, 0.40),
        1.7,
    ));
    builder.light(&lamp(
        DVec3::new(-2.62, 1.78, -1.1),
        rgb(0.40, 0.27, 0.13),
        1.3,
    ));
    builder.light(&lamp(
        DVec3::new(0.9, 1.78, -2.62),
        rgb(0.40, 0.27, 0.13),
        1.3,
    ));
    builder.light(&lamp(DVec3::new(2.3, 2.6, 2.5), rgb(0.20, 0.24, 0.30), 2.2));
    let palette = palette();
    let mut mesh = MeshBuilder::new(builder, &palette);
    let budget = u64::from(params.size);
    let detail = fit_detail(budget * 3 / 10, (0.1, 2000.0), furnish);
    furnish(&mut mesh, detail);
    let left = budget.saturating_sub(mesh.triangles());
    mesh.material(GOLD);
    knot(&mut mesh, left as f64, STATUE);
    mesh.finish();
}

/// Everything except the statue, with `detail` quads to a unit of length.
fn furnish(mesh: &mut MeshBuilder, detail: f64) {
    floor(mesh, detail);
    shell(mesh, detail);
    for quarter in 0..4 {
        let wall = LocalFrame::at(DVec3::ZERO).turned(90.0 * f64::from(quarter));
        panels(mesh, &wall.moved(0.0, 0.0, -HALF), detail);
    }
    pedestal(mesh, detail);
    pendant(mesh, detail);
    sconce(
        mesh,
        &LocalFrame::at(DVec3::new(-HALF, 1.62, -1.1)).turned(90.0),
        detail,
    );
    sconce(mesh, &LocalFrame::at(DVec3::new(0.9, 1.62, -HALF)), detail);
    mirror(
        mesh,
        &LocalFrame::at(DVec3::new(-0.85, 1.02, -HALF)),
        detail,
    );
    table(mesh, &LocalFrame::at(DVec3::new(-2.1, 0.0, 0.45)), detail);
}

/// Tiles, and a rug of two colours.
fn floor(mesh: &mut MeshBuilder, detail: f64) {
    let side = 10;
    let step = 2.0 * HALF / f64::from(side);
    for row in 0..side {
        for column in 0..side {
            mesh.material(TILES[((row + column) % 2) as usize]);
            let (x, z) = (
                -HALF + step * f64::from(column),
                HALF - step * f64::from(row),
            );
            let at = |dx: f64, dz: f64| DVec3::new(x + dx, 0.0, z - dz);
            let n = cells(step, detail);
            mesh.quad(
                [at(0.0, 0.0), at(step, 0.0), at(step, step), at(0.0, step)],
                n,
                n,
            );
        }
    }
    for (material, half, height) in [(RUG[1], 1.22, 0.012), (RUG[0], 1.12, 0.018)] {
        mesh.material(material);
        let corner = DVec3::new(half, height, half);
        let rug = LocalFrame::at(DVec3::new(-0.1, 0.0, -0.2)).turned(45.0);
        cuboid(
            mesh,
            &rug,
            (DVec3::new(-half, 0.0, -half), corner),
            detail,
            STANDING,
        );
    }
}

/// Ceiling and upper walls, which face inward.
fn shell(mesh: &mut MeshBuilder, detail: f64) {
    let n = cells(2.0 * HALF, detail);
    for quarter in 0..4 {
        let wall = LocalFrame::at(DVec3::ZERO).turned(90.0 * f64::from(quarter));
        let at = |x: f64, y: f64| wall.point(DVec3::new(x, y, -HALF));
        mesh.material(PLASTER);
        let corners = [
            at(-HALF, 0.0),
            at(HALF, 0.0),
            at(HALF, HEIGHT),
            at(-HALF, HEIGHT),
        ];
        mesh.quad(corners, n, cells(HEIGHT, detail));
    }
    mesh.material(CEILING);
    let at = |x: f64, z: f64| DVec3::new(x * HALF, HEIGHT, z * HALF);
    mesh.quad(
        [at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)],
        n,
        n,
    );
}

/// The wooden lower wall with raised panels, its rail, and the cornice under the ceiling.
fn panels(mesh: &mut MeshBuilder, wall: &LocalFrame, detail: f64) {
    mesh.material(WOOD);
    let whole = (-HALF, HALF);
    moulding(
        mesh,
        wall,
        whole,
        &[DVec2::new(0.03, 0.0), DVec2::new(0.03, 0.86)],
        detail,
    );
    let base = [(0.06, 0.0), (0.06, 0.13), (0.045, 0.16), (0.03, 0.17)];
    let rail = [
        (0.03, 0.84),
        (0.07, 0.87),
        (0.075, 0.91),
        (0.055, 0.94),
        (0.0, 0.945),
    ];
    moulding(mesh, wall, whole, &base.map(DVec2::from), detail);
    moulding(mesh, wall, whole, &rail.map(DVec2::from), detail);
    for k in 0..5 {
        let x = -HALF + 0.13 + 1.16 * f64::from(k);
        for (inset, depth) in [(0.0, 0.045), (0.07, 0.06)] {
            let lo = DVec3::new(x + inset, 0.26 + inset, 0.03);
            let hi = DVec3::new(x + 1.06 - inset, 0.76 - inset, depth);
            cuboid(
                mesh,
                wall,
                (lo, hi),
                detail,
                [true, true, true, true, false, true],
            );
        }
    }
    mesh.material(CEILING);
    let steps = 12;
    let cornice: Vec<_> = (0..=steps)
        .map(|k| {
            let turn = TAU / 4.0 * f64::from(k) / f64::from(steps);
            DVec2::new(0.16 * (1.0 - cos(turn)), HEIGHT - 0.16 * (1.0 - sin(turn)))
        })
        .collect();
    moulding(mesh, wall, whole, &cornice, detail);
}

/// Number of sides of turned work of this radius.
fn around(radius: f64, detail: f64) -> usize {
    cells(TAU * radius, detail).max(10)
}

fn pedestal(mesh: &mut MeshBuilder, detail: f64) {
    mesh.material(STONE);
    let place = LocalFrame::at(STATUE * DVec3::new(1.0, 0.0, 1.0));
    let block = |mesh: &mut MeshBuilder, half: f64, from: f64, to: f64| {
        let corners = (DVec3::new(-half, from, -half), DVec3::new(half, to, half));
        cuboid(mesh, &place.turned(20.0), corners, detail, ALL);
    };
    block(mesh, 0.34, 0.0, 0.12);
    block(mesh, 0.30, 0.64, 0.72);
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
    lathe(
        mesh,
        &place,
        &profile.map(DVec2::from),
        around(0.25, detail),
        detail,
    );
    mesh.material(GOLD);
    let foot = [
        (0.16, 0.72),
        (0.16, 0.735),
        (0.07, 0.76),
        (0.055, 0.97),
        (0.0, 0.98),
    ];
    lathe(
        mesh,
        &place,
        &foot.map(DVec2::from),
        around(0.16, detail),
        detail,
    );
}

/// The lamp over the statue: a shade open downward, a bulb, a cord.
fn pendant(mesh: &mut MeshBuilder, detail: f64) {
    let place = LocalFrame::at(DVec3::new(0.55, 0.0, 0.75));
    mesh.material(SHADE);
    let shade = [
        (0.27, 2.46),
        (0.22, 2.56),
        (0.10, 2.66),
        (0.03, 2.70),
        (0.012, 2.74),
    ];
    lathe(
        mesh,
        &place,
        &shade.map(DVec2::from),
        around(0.25, detail),
        detail,
    );
    mesh.material(DARK_WOOD);
    let cord = [(0.008, 2.70), (0.008, 3.22), (0.05, 3.28), (0.05, HEIGHT)];
    lathe(mesh, &place, &cord.map(DVec2::from), 10, detail);
    mesh.material(BULB);
    let frequency = cells(0.1, detail).max(2);
    geodesic::sphere(mesh, frequency, |p| {
        place.point(DVec3::new(0.0, 2.48, 0.0) + p * 0.055)
    });
}

/// A bracket on a wall with a small shade.
fn sconce(mesh: &mut MeshBuilder, wall: &LocalFrame, detail: f64) {
    mesh.material(DARK_WOOD);
    let plate = (DVec3::new(-0.05, -0.12, 0.0), DVec3::new(0.05, 0.12, 0.03));
    cuboid(mesh, wall, plate, detail, ALL);
    let arm = (
        DVec3::new(-0.012, -0.03, 0.03),
        DVec3::new(0.012, -0.006, 0.38),
    );
    cuboid(mesh, wall, arm, detail, ALL);
    let place = wall.moved(0.0, 0.0, 0.38);
    let candle = [
        (0.035, -0.03),
        (0.04, 0.0),
        (0.015, 0.012),
        (0.015, 0.08),
        (0.0, 0.082),
    ];
    lathe(
        mesh,
        &place,
        &candle.map(DVec2::from),
        around(0.03, detail),
        detail,
    );
    mesh.material(SHADE);
    // Open at both ends, so that its light reaches the wall above and below.
    let shade = [(0.15, 0.06), (0.085, 0.26)];
    lathe(
        mesh,
        &place,
        &shade.map(DVec2::from),
        around(0.15, detail),
        detail,
    );
}

/// A mirror in a gilt frame.
fn mirror(mesh: &mut MeshBuilder, wall: &LocalFrame, detail: f64) {
    let (half, high) = (0.52, 1.36);
    mesh.material(MIRROR);
    let n = cells(1.0, detail);
    let at = |x: f64, y: f64| wall.point(DVec3::new(x, y, 0.04));
    mesh.quad(
        [
            at(-half, 0.0),
            at(half, 0.0),
            at(half, high),
            at(-half, high),
        ],
        n,
        n,
    );
    mesh.material(GOLD);
    let bar = |mesh: &mut MeshBuilder, (x0, y0): (f64, f64), (x1, y1): (f64, f64)| {
        for (inset, depth) in [(0.0, 0.05), (0.02, 0.075)] {
            let lo = DVec3::new(x0 + inset, y0 + inset, 0.0);
            let hi = DVec3::new(x1 - inset, y1 - inset, depth);
            cuboid(
                mesh,
                wall,
                (lo, hi),
                detail,
                [true, true, true, true, false, true],
            );
        }
    };
    let w = 0.09;
    bar(mesh, (-half - w, -w), (-half, high + w));
    bar(mesh, (half, -w), (half + w, high + w));
    bar(mesh, (-half, -w), (half, 0.0));
    bar(mesh, (-half, high), (half, high + w));
}

/// A round table with a sphere of glass on it.
fn table(mesh: &mut MeshBuilder, place: &LocalFrame, detail: f64) {
    mesh.material(DARK_WOOD);
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
    lathe(
        mesh,
        place,
        &profile.map(DVec2::from),
        around(0.4, detail),
        detail,
    );
    mesh.material(GLASS);
    let frequency = cells(0.5, detail).max(5);
    geodesic::sphere(mesh, frequency, |p| {
        place.point(DVec3::new(0.0, 0.875, 0.0) + p * 0.17)
    });
}
