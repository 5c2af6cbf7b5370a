//! Columns: plinth, base, fluted shaft, and a capital of leaves and scrolls.

use super::layout::{BASES, BAY, Storey, THICK, Wing};
use super::palette::{CARVED, STONE};
use super::turning::{flat, plain, revolve, ring};
use crate::modern::noise::smoothstep;
use crate::modern::props::{PartBuilder, STANDING};
use libm::{cos, sin};
use std::f64::consts::TAU;

/// Number of a shaft's flutes.
const FLUTES: f64 = 20.0;

/// The columns of a wing, and the pier at its left end.
pub(super) fn colonnade(parts: &mut PartBuilder, wing: &Wing, storey: &Storey) {
    pier(parts, storey);
    for k in 1..wing.bays {
        let x = BAY * f64::from(k);
        column(&mut parts.moved(x, storey.floor, 0.0), storey);
    }
}

/// A square pier in a corner of the court.
fn pier(parts: &mut PartBuilder, storey: &Storey) {
    let (half, foot) = (0.38, 0.44);
    let (floor, spring) = (storey.floor, storey.spring);
    let fine = parts.detail >= BASES;
    let mut stone = flat(parts);
    stone.material(STONE);
    stone.cuboid((-half, floor, -half), (half, spring, half), STANDING);
    if fine {
        stone.material(CARVED);
        stone.cuboid((-foot, floor, -foot), (foot, floor + 0.3, foot), STANDING);
        stone.slab((-foot, spring - 0.22, -foot), (foot, spring, foot));
    }
}

fn column(parts: &mut PartBuilder, storey: &Storey) {
    let r = storey.column;
    let high = storey.spring - storey.floor;
    let (foot, head) = (storey.pedestal, high - 0.12);
    parts.material(STONE);
    let half = 1.42 * r;
    let abacus = (1.62 * r).max(THICK);
    flat(parts).cuboid((-half, 0.0, -half), (half, foot, half), STANDING);
    flat(parts).slab((-abacus, head, -abacus), (abacus, high, abacus));
    parts.material(CARVED);
    let bell = 2.3 * r;
    let bottom = if parts.detail < BASES { foot } else { foot + r };
    if parts.detail >= BASES {
        base(&mut parts.moved(0.0, foot, 0.0), r);
    }
    let high = head - bell - bottom;
    shaft(&mut parts.moved(0.0, bottom, 0.0), r, high);
    capital(&mut parts.moved(0.0, head - bell, 0.0), r, bell);
}

/// A base of two tori with a hollow between them, one radius high.
fn base(parts: &mut PartBuilder, r: f64) {
    let outline = [
        (1.34, 0.0),
        (1.44, 0.08),
        (1.44, 0.28),
        (1.34, 0.38),
        (1.22, 0.38),
        (1.22, 0.38),
        (1.1, 0.44),
        (1.1, 0.62),
        (1.2, 0.66),
        (1.2, 0.66),
        (1.3, 0.7),
        (1.3, 0.86),
        (1.2, 0.92),
        (1.0, 0.92),
        (1.0, 1.0),
    ]
    .map(|(x, y)| (x * r, y * r));
    revolve(parts, &outline, (8, 2), plain);
}

/// A shaft that swells a little; its flutes appear when there are quads enough to show them.
fn shaft(parts: &mut PartBuilder, r: f64, high: f64) {
    let outline = [
        (r, 0.0),
        (1.01 * r, 0.3 * high),
        (0.97 * r, 0.65 * high),
        (0.86 * r, high),
    ];
    let around = parts.cells(TAU * r);
    let depth = if around >= 80 { 0.09 * r } else { 0.0 };
    // Straight along its axis: fewer rows than quads around.
    let least = (around.max(6), parts.cells(0.12 * high).clamp(1, 64));
    revolve(&mut flat(parts), &outline, least, |turn, t| {
        let ends = smoothstep(0.0, 0.03, t) * smoothstep(1.0, 0.97, t);
        -depth * ends * sin(FLUTES / 2.0 * turn).abs()
    });
}

/// A bell with two rows of leaves and four scrolls under the corners of its abacus.
fn capital(parts: &mut PartBuilder, r: f64, high: f64) {
    let outline = [
        (0.86 * r, 0.0),
        (1.02 * r, 0.03 * high),
        (1.02 * r, 0.07 * high),
        (0.88 * r, 0.1 * high),
        (0.92 * r, 0.45 * high),
        (1.05 * r, 0.75 * high),
        (1.5 * r, 0.96 * high),
        (1.5 * r, high),
    ];
    let carved = parts.cells(TAU * r) >= 32;
    let leaf = |from: f64, to: f64, t: f64| {
        let t = (t - from) / (to - from);
        // A leaf leans outward and breaks off at its tip.
        if (0.0..1.0).contains(&t) { t * t * (1.0 - t * t * t * t) } else { 0.0 }
    };
    revolve(parts, &outline, (6, 1), |turn, t| {
        if !carved {
            return 0.0;
        }
        let rib = 1.0 - 0.25 * cos(48.0 * turn).abs();
        let lower = cos(4.0 * turn).abs() * leaf(0.12, 0.45, t);
        let upper = sin(4.0 * turn).abs() * leaf(0.2, 0.72, t);
        r * 0.62 * rib * lower.max(upper)
    });
    if parts.detail < 6.0 {
        return;
    }
    let wire = (
        parts.cells(TAU * 0.1 * r).max(5),
        parts.cells(TAU * 0.28 * r).max(8),
    );
    for corner in 0..4 {
        let frame = parts.frame.turned(90.0 * f64::from(corner) + 45.0);
        let mut scroll = parts.at(frame.moved(1.55 * r, 0.8 * high, 0.0));
        ring(&mut scroll, (0.3 * r, 0.3 * r), 0.11 * r, wire);
        ring(&mut scroll, (0.1 * r, 0.1 * r), 0.09 * r, wire);
    }
}
