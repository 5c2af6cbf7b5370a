//! Windows and doors of a house, and the parts attached to them.

use super::layout::{Area, REVEAL};
use super::palette::{IRON, LEAF, LIT, PANE, SHUTTER, TRIM, WOOD};
use super::stone::{LEAF_TRIANGLES, leaf};
use crate::modern::noise::Dice;
use crate::modern::props::{ON_WALL, PartBuilder, STANDING};
use glam::dvec3;

/// The four sides of a hole in the wall.
pub(super) fn reveal(parts: &mut PartBuilder, hole: Area) {
    parts.material(TRIM);
    let Area { x0, y0, x1, y1 } = hole;
    let corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)];
    for k in 0..4 {
        let ((ax, ay), (bx, by)) = (corners[k], corners[(k + 1) % 4]);
        let length = (bx - ax).abs() + (by - ay).abs();
        let cells = (parts.cells(length), parts.cells(REVEAL));
        let back = -REVEAL;
        let side = [(ax, ay, 0.0), (bx, by, 0.0), (bx, by, back), (ax, ay, back)];
        parts.quad(side, cells);
    }
}

pub(super) fn window(parts: &mut PartBuilder, hole: Area, kind: usize) {
    let Area { x0, y0, x1, y1 } = hole;
    let back = -0.16;
    // Half of the windows are lit, each a little differently behind its curtains.
    let panes = match kind {
        0..2 => [LIT + 1, LIT, LIT + 1],
        2..4 => [LIT + 2, LIT + 1, LIT + 2],
        4 => [LIT + 2, LIT + 2, LIT + 1],
        _ => [PANE; 3],
    };
    let third = (x1 - x0) / 3.0;
    for (k, material) in panes.into_iter().enumerate() {
        parts.material(material);
        let a = x0 + third * k as f64;
        let b = a + third;
        let pane = [(a, y0, back), (b, y0, back), (b, y1, back), (a, y1, back)];
        parts.quad(pane, (1, 1));
    }
    if parts.detail > 0.5 {
        sash(parts, hole);
    }
    parts.material(TRIM);
    parts.cuboid((x0 - 0.1, y0 - 0.07, -0.05), (x1 + 0.1, y0, 0.09), ON_WALL);
    if parts.detail > 0.8 {
        surround(parts, hole);
    }
}

/// The wooden frame of a window, its bars, and the glazing bars.
fn sash(parts: &mut PartBuilder, hole: Area) {
    parts.material(TRIM);
    let detail = parts.detail;
    let mut bar = |x0: f64, y0: f64, x1: f64, y1: f64, front: f64| {
        parts.cuboid((x0, y0, -0.16), (x1, y1, front), ON_WALL);
    };
    let Area { x0, y0, x1, y1 } = hole;
    let (w, middle) = (0.055, (x0 + x1) / 2.0);
    bar(x0, y0, x0 + w, y1, -0.09);
    bar(x1 - w, y0, x1, y1, -0.09);
    bar(x0 + w, y0, x1 - w, y0 + w, -0.09);
    bar(x0 + w, y1 - w, x1 - w, y1, -0.09);
    bar(middle - 0.035, y0 + w, middle + 0.035, y1 - w, -0.10);
    if detail > 1.5 {
        for k in 1..4 {
            let y = y0 + (y1 - y0) * f64::from(k) / 4.0;
            bar(x0 + w, y - 0.014, middle - 0.035, y + 0.014, -0.125);
            bar(middle + 0.035, y - 0.014, x1 - w, y + 0.014, -0.125);
        }
    }
}

/// The raised border about a window, with a keystone.
fn surround(parts: &mut PartBuilder, hole: Area) {
    parts.material(TRIM);
    let Area { x0, y0, x1, y1 } = hole;
    let mut slab = |x0: f64, y0: f64, x1: f64, y1: f64, front: f64| {
        parts.cuboid((x0, y0, -0.01), (x1, y1, front), ON_WALL);
    };
    slab(x0 - 0.13, y0, x0, y1 + 0.13, 0.04);
    slab(x1, y0, x1 + 0.13, y1 + 0.13, 0.04);
    slab(x0, y1, x1, y1 + 0.13, 0.04);
    let middle = (x0 + x1) / 2.0;
    slab(middle - 0.08, y1 - 0.02, middle + 0.08, y1 + 0.2, 0.075);
    let cap = [
        (0.04, 0.13),
        (0.06, 0.15),
        (0.11, 0.19),
        (0.12, 0.22),
        (0.0, 0.235),
    ];
    let mut top = parts.moved(0.0, y1, 0.0);
    top.moulding((x0 - 0.16, x1 + 0.16), &cap);
}

/// Two open shutters with slats.
pub(super) fn shutters(parts: &mut PartBuilder, hole: Area, material: usize) {
    if parts.detail < 0.3 {
        return;
    }
    parts.material(material);
    let (wide, y0, high) = (0.48, hole.y0, hole.y1 - hole.y0);
    for x in [hole.x0 - 0.15 - wide, hole.x1 + 0.15] {
        let mut slab = |(ax, ay): (f64, f64), (bx, by): (f64, f64), front: f64| {
            parts.cuboid((x + ax, y0 + ay, 0.02), (x + bx, y0 + by, front), ON_WALL);
        };
        slab((0.0, 0.0), (0.05, high), 0.06);
        slab((wide - 0.05, 0.0), (wide, high), 0.06);
        for y in [0.0, high / 2.0 - 0.03, high - 0.06] {
            slab((0.05, y), (wide - 0.05, y + 0.06), 0.06);
        }
        slab((0.05, 0.06), (wide - 0.05, high - 0.06), 0.025);
        let height = (y0 + 0.06, y0 + high - 0.06);
        slats(parts, (x + 0.05, x + wide - 0.05), height);
    }
}

fn slats(parts: &mut PartBuilder, width: (f64, f64), (y0, y1): (f64, f64)) {
    if parts.detail < 1.0 {
        return;
    }
    let count = ((y1 - y0) / 0.055) as usize;
    for k in 0..count {
        let y = y0 + 0.055 * k as f64;
        let slat = [
            (0.055, y),
            (0.058, y + 0.006),
            (0.03, y + 0.05),
            (0.026, y + 0.046),
        ];
        parts.moulding(width, &slat);
    }
}

pub(super) fn door(parts: &mut PartBuilder, hole: Area) {
    let Area { x0, y0, x1, y1 } = hole;
    let slab = |parts: &mut PartBuilder, x0: f64, y0: f64, x1: f64, y1: f64, front: f64| {
        parts.cuboid((x0, y0, -0.2), (x1, y1, front), ON_WALL);
    };
    parts.material(WOOD);
    slab(parts, x0, y0, x1, y1 - 0.4, -0.13);
    let middle = (x0 + x1) / 2.0;
    for (a, b) in [(x0 + 0.08, middle - 0.05), (middle + 0.05, x1 - 0.08)] {
        for (c, d) in [(y0 + 0.15, y0 + 0.75), (y0 + 0.87, y0 + 1.9)] {
            slab(parts, a, c, b, d, -0.11);
            slab(parts, a + 0.07, c + 0.07, b - 0.07, d - 0.07, -0.095);
        }
    }
    parts.material(LIT + 1);
    slab(parts, x0, y1 - 0.36, x1, y1, -0.15);
    if parts.detail > 0.8 {
        surround(parts, hole);
    }
    parts.material(TRIM);
    parts.cuboid((x0 - 0.2, 0.0, -0.1), (x1 + 0.2, 0.13, 0.4), STANDING);
}

/// A slab on two brackets, with a railing of turned balusters.
pub(super) fn balcony(parts: &mut PartBuilder, hole: Area) {
    parts.material(TRIM);
    let (x0, x1) = (hole.x0 - 0.3, hole.x1 + 0.3);
    let (floor, out) = (hole.y0 - 0.3, 0.72);
    parts.slab((x0, floor - 0.11, 0.0), (x1, floor, out));
    for x in [x0 + 0.12, x1 - 0.26] {
        parts.slab((x, floor - 0.36, 0.0), (x + 0.14, floor - 0.11, 0.2));
        parts.slab((x, floor - 0.23, 0.2), (x + 0.14, floor - 0.11, 0.45));
    }
    let rail = floor + 0.86;
    parts.slab((x0, rail, out - 0.11), (x1, rail + 0.07, out));
    parts.slab((x0, rail, 0.0), (x0 + 0.11, rail + 0.07, out - 0.11));
    parts.slab((x1 - 0.11, rail, 0.0), (x1, rail + 0.07, out - 0.11));
    if parts.detail < 0.7 {
        return;
    }
    let count = 11;
    for k in 0..count {
        let x = x0 + 0.055 + (x1 - x0 - 0.11) * f64::from(k) / f64::from(count - 1);
        baluster(&mut parts.moved(x, floor, out - 0.055));
    }
    for k in 0..4 {
        let z = 0.08 + 0.15 * f64::from(k);
        baluster(&mut parts.moved(x0 + 0.055, floor, z));
        baluster(&mut parts.moved(x1 - 0.055, floor, z));
    }
}

fn baluster(parts: &mut PartBuilder) {
    let profile = [
        (0.045, 0.0),
        (0.045, 0.06),
        (0.025, 0.09),
        (0.04, 0.18),
        (0.05, 0.27),
        (0.042, 0.36),
        (0.02, 0.5),
        (0.022, 0.66),
        (0.035, 0.72),
        (0.025, 0.76),
        (0.045, 0.8),
        (0.045, 0.86),
    ];
    parts.lathe(&profile, parts.cells(0.8).clamp(6, 64));
}

/// An iron box of plants under a window.
pub(super) fn flowers(parts: &mut PartBuilder, hole: Area, dice: &mut Dice) {
    if dice.below(3) != 0 {
        return;
    }
    parts.material(IRON);
    parts.slab((hole.x0, hole.y0, 0.0), (hole.x1, hole.y0 + 0.14, 0.17));
    let leaves = parts.cells(40.0);
    if parts.mesh.counted(LEAF_TRIANGLES * leaves as u64) {
        return;
    }
    for _ in 0..leaves {
        parts.material(match dice.below(7) {
            0 => SHUTTER + 2,
            _ => LEAF + dice.below(2),
        });
        let position = dvec3(
            dice.range(hole.x0, hole.x1),
            hole.y0 + 0.12 + 0.2 * dice.unit() * dice.unit(),
            0.1 + dice.range(-0.13, 0.16),
        );
        leaf(parts, position, dice, 0.055);
    }
}
