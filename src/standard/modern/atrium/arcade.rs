//! The arcades: walls on arches, their mouldings and ornaments, cornices, vaults and doors.

use super::layout::{AISLE, ARCHIVOLTS, BAY, CARVINGS, DOORS, GROUND, Storey, THICK, Wing};
use super::palette::{BOARDS, BRASS, CARVED, PLASTER, STONE, TERRACOTTA, TIMBER, VAULT};
use super::relief::{lion, rosette};
use super::turning::{flat, length, long_moulding, plain, revolve, smooth};
use crate::modern::mesh_builder::Grid;
use crate::modern::props::{LocalFrame, ON_WALL, PartBuilder};
use glam::{DVec2, dvec2, dvec3};
use libm::{cos, sin};
use std::f64::consts::PI;

/// The arcade of a storey: one bay after the other, and the cornice above them.
pub(super) fn storey(parts: &mut PartBuilder, wing: &Wing, storey: &Storey) {
    for k in 0..wing.bays {
        let x = BAY * f64::from(k);
        let mut bay = parts.moved(x, 0.0, 0.0);
        arch_wall(&mut bay, storey);
        if bay.detail > ARCHIVOLTS {
            archivolt(&mut bay, storey);
        }
        if bay.detail > 2.0 {
            keystone(&mut bay, storey);
        }
        if k > 0 && bay.detail > CARVINGS {
            spandrel_ornament(&mut bay, storey, k);
        }
    }
    cornice(parts, wing, storey.top);
}

/// The end of the `i`-th of a number of segments, from left to right, on a bay's arch widened by
/// this much.
fn arch_point(storey: &Storey, i: usize, segments: usize, wider: f64) -> DVec2 {
    let turn = PI * i as f64 / segments as f64;
    let out = dvec2(-cos(turn), sin(turn)) * (storey.arch + wider);
    dvec2(BAY / 2.0, storey.spring) + out
}

/// The wall of a bay: both faces above the arch, and its soffit. Regardless of the scene's size, an
/// arch has few segments, and a long triangle reaches from each of them to the top.
fn arch_wall(parts: &mut PartBuilder, storey: &Storey) {
    let segments = 2 * parts.cells(2.0).clamp(3, 14);
    parts.material(STONE);
    let frame = parts.frame;
    let mut lower = vec![dvec2(0.0, storey.spring)];
    lower.extend((0..=segments).map(|i| arch_point(storey, i, segments, 0.0)));
    lower.push(dvec2(BAY, storey.spring));
    let last = lower.len() - 1;
    let point = |i: usize, j: usize, z: f64| {
        let y = if j == 0 { lower[i].y } else { storey.top };
        frame.point(dvec3(lower[i].x, y, z))
    };
    let face = Grid::open(last, 1);
    parts.mesh.grid(face, |i, j| point(i, j, THICK));
    parts.mesh.grid(face, |i, j| point(last - i, j, -THICK));
    parts.mesh.grid(Grid::open(segments, 1), |i, j| {
        let z = if j == 0 { -THICK } else { THICK };
        point(i + 1, 0, z)
    });
}

/// The moulding around an arch, toward the court.
fn archivolt(parts: &mut PartBuilder, storey: &Storey) {
    let outline = [
        (0.0, 0.0),
        (0.0, 0.05),
        (0.0, 0.05),
        (0.07, 0.05),
        (0.07, 0.05),
        (0.07, 0.085),
        (0.14, 0.085),
        (0.14, 0.085),
        (0.16, 0.13),
        (0.215, 0.13),
        (0.24, 0.07),
        (0.24, 0.0),
    ];
    let rows = parts.cells(length(&outline)).max(3);
    let segments = 2 * parts.cells(PI * storey.arch / 3.0).max(4);
    parts.material(CARVED);
    if parts.mesh.counted(2 * (rows * segments) as u64) {
        return;
    }
    let (curve, frame) = (smooth(&outline, rows), parts.frame);
    parts.mesh.grid(Grid::open(segments, rows), |i, j| {
        let on = arch_point(storey, i, segments, curve[j].x);
        frame.point(on.extend(THICK + curve[j].y))
    });
}

/// A wedge with a flower at the top of an arch.
fn keystone(parts: &mut PartBuilder, storey: &Storey) {
    let y = storey.spring + storey.arch;
    let (low, high, z) = (0.1, 0.15, THICK + 0.17);
    let bottom = [(-low, y - 0.04), (low, y - 0.04)];
    let top = [(high, y + 0.36), (-high, y + 0.36)];
    let mut stone = parts.moved(BAY / 2.0, 0.0, 0.0);
    let [a, b, c, d] = [bottom[0], bottom[1], top[0], top[1]];
    let front = |(x, y): (f64, f64)| (x, y, z);
    let back = |(x, y): (f64, f64)| (x, y, THICK);
    stone.quad([a, b, c, d].map(front), (1, 1));
    for (p, q) in [(a, b), (b, c), (c, d), (d, a)] {
        stone.quad([back(p), back(q), front(q), front(p)], (1, 1));
    }
    rosette(&mut stone.moved(0.0, y + 0.17, z), 0.085);
}

/// A lion's head above every other column, a flower above the rest.
fn spandrel_ornament(parts: &mut PartBuilder, storey: &Storey, k: u32) {
    parts.material(CARVED);
    let y = storey.spring + 0.82;
    let mut place = parts.moved(0.0, y, THICK);
    match k % 2 {
        0 => rosette(&mut place, 0.23),
        _ => lion(&mut place, 0.25),
    }
}

/// A cornice over a storey on small blocks; its strips are as long as the wing.
fn cornice(parts: &mut PartBuilder, wing: &Wing, top: f64) {
    let outline = [
        (0.0, 0.0),
        (0.05, 0.0),
        (0.05, 0.0),
        (0.05, 0.05),
        (0.1, 0.07),
        (0.1, 0.13),
        (0.1, 0.13),
        (0.26, 0.13),
        (0.26, 0.13),
        (0.26, 0.19),
        (0.26, 0.19),
        (0.29, 0.2),
        (0.3, 0.26),
        (0.36, 0.3),
        (0.36, 0.3),
        (-0.3, 0.3),
    ]
    .map(|(out, up)| (THICK + out, top + up));
    parts.material(CARVED);
    long_moulding(parts, (0.0, wing.length()), &outline, 4);
    if parts.detail < 4.0 {
        return;
    }
    let blocks = 12 * wing.bays;
    let mut stone = flat(parts);
    for k in 0..blocks {
        let x = BAY / 12.0 * (f64::from(k) + 0.5);
        let lo = (x - 0.055, top + 0.015, THICK + 0.04);
        stone.cuboid(lo, (x + 0.055, top + 0.125, THICK + 0.22), ON_WALL);
    }
}

/// The aisle behind the ground floor's arcade: paving, outer wall, vaults, and doors.
pub(super) fn aisle(parts: &mut PartBuilder, wing: &Wing) {
    let (long, top) = (wing.length(), 5.1);
    let mut wall = flat(parts);
    wall.material(PLASTER);
    let (from, to) = (-AISLE, long + AISLE);
    let corners = [(from, 0.0), (to, 0.0), (to, top), (from, top)];
    wall.wall(corners.map(|(x, y)| (x, y, -AISLE)));
    wall.material(TERRACOTTA);
    let (from, to) = (-wing.ends, long + wing.ends);
    let corners = [(from, 0.4), (to, 0.4), (to, -AISLE), (from, -AISLE)];
    wall.wall(corners.map(|(x, z)| (x, 0.012, z)));
    wall.material(VAULT);
    for x in [-AISLE, long] {
        // Ceilings of the corners, which have no vaults.
        let corners = [(x, -AISLE), (x + AISLE, -AISLE), (x + AISLE, 0.0), (x, 0.0)];
        if wing.ends > 0.0 {
            wall.wall(corners.map(|(x, z)| (x, 4.55, z)));
        }
    }
    parts.material(CARVED);
    let skirting = [
        (0.05, 0.0),
        (0.05, 0.22),
        (0.05, 0.22),
        (0.02, 0.25),
        (0.0, 0.26),
    ];
    let rail = [
        (0.0, 2.96),
        (0.04, 2.98),
        (0.09, 3.02),
        (0.09, 3.08),
        (0.0, 3.1),
    ];
    let mut back = parts.moved(0.0, 0.0, -AISLE);
    long_moulding(&mut back, (0.0, long), &skirting, 2);
    long_moulding(&mut back, (0.0, long), &rail, 3);
    for k in 0..wing.bays {
        let mut bay = parts.moved(BAY * f64::from(k), 0.0, 0.0);
        vault(&mut bay);
        if k % 2 == 1 && bay.detail > DOORS {
            door(&mut bay.moved(BAY / 2.0, 0.0, -AISLE));
        }
    }
}

/// A groin vault: the higher of two barrels that cross.
fn vault(parts: &mut PartBuilder) {
    parts.material(VAULT);
    let n = 2 * parts.cells(0.3).clamp(1, 24);
    let (front, deep, frame) = (-THICK, AISLE - THICK, parts.frame);
    let along = |i: usize| {
        let turn = PI * i as f64 / n as f64;
        ((1.0 - cos(turn)) / 2.0, sin(turn))
    };
    // Seen from below, x runs to the right and z upward.
    parts.mesh.grid(Grid::open(n, n), |i, j| {
        let ((u, over), (v, across)) = (along(i), along(j));
        let y = GROUND.spring + 1.42 * over.max(across);
        frame.point(dvec3(BAY * u, y, front - deep * (1.0 - v)))
    });
}

/// A door of boards with studs, in a frame of stone.
fn door(parts: &mut PartBuilder) {
    let (half, high) = (0.62, 2.3);
    let mut plain_work = flat(parts);
    plain_work.material(STONE);
    for x in [-half - 0.16, half] {
        plain_work.cuboid((x, 0.0, 0.0), (x + 0.16, high, 0.1), ON_WALL);
    }
    let wide = half + 0.24;
    plain_work.cuboid((-wide, high, 0.0), (wide, high + 0.22, 0.14), ON_WALL);
    plain_work.material(TIMBER);
    plain_work.cuboid((-half, 0.0, 0.0), (half, high, 0.03), ON_WALL);
    plain_work.material(BOARDS);
    for (x, y) in [(-0.56, 0.14), (0.06, 0.14), (-0.56, 1.22), (0.06, 1.22)] {
        plain_work.cuboid((x, y, 0.03), (x + 0.5, y + 0.94, 0.055), ON_WALL);
    }
    if parts.detail < 5.0 {
        return;
    }
    parts.material(BRASS);
    for row in 0..3 {
        for column in 0..10 {
            let (x, y) = (-0.56 + 0.124 * f64::from(column), [0.07, 1.15, 2.23][row]);
            stud(parts, (x, y, 0.03), 0.022);
        }
    }
    stud(parts, (0.0, 1.15, 0.045), 0.055);
}

/// A round head of a nail on a wall.
fn stud(parts: &mut PartBuilder, (x, y, z): (f64, f64, f64), r: f64) {
    let [right, up, out] = parts.frame.axes;
    let frame = LocalFrame {
        axes: [up, out, right],
        ..parts.frame.moved(x, y, z)
    };
    let dome = [
        (r, 0.0),
        (r, 0.5 * r),
        (0.6 * r, 0.9 * r),
        (0.12 * r, 0.95 * r),
    ];
    revolve(&mut parts.at(frame), &dome, (6, 2), plain);
}
