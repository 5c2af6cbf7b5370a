//! The gallery on the upper floor: balustrades, and the timbers of its roof.

use super::layout::{AISLE, BALUSTERS, BAY, EAVE, RAFTERS, ROOF, THICK, UPPER, Wing};
use super::palette::{BOARDS, CARVED, PLASTER, STONE, TERRACOTTA, TIMBER};
use super::turning::{beam, flat, plain, revolve};
use crate::modern::props::{FramePoint, PartBuilder};

/// Floor, outer wall and balustrade of a wing.
pub(super) fn gallery(parts: &mut PartBuilder, wing: &Wing) {
    let (long, floor) = (wing.length(), UPPER.floor);
    let mut wall = flat(parts);
    wall.material(PLASTER);
    let (from, to) = (-AISLE, long + AISLE);
    let corners = [(from, floor), (to, floor), (to, ROOF.1), (from, ROOF.1)];
    wall.wall(corners.map(|(x, y)| (x, y, -AISLE)));
    wall.material(TERRACOTTA);
    let (from, to) = (-wing.ends, long + wing.ends);
    let corners = [(from, THICK), (to, THICK), (to, -AISLE), (from, -AISLE)];
    wall.wall(corners.map(|(x, z)| (x, floor, z)));
    for k in 0..wing.bays {
        balustrade(&mut parts.moved(BAY * f64::from(k), floor, 0.0));
    }
}

/// The railing of a bay, between the pedestals of its columns.
fn balustrade(parts: &mut PartBuilder) {
    let (from, to) = (0.234, BAY - 0.234);
    parts.material(STONE);
    let mut rail = flat(parts);
    rail.slab((from, 0.0, -0.11), (to, 0.12, 0.11));
    rail.slab((from, 0.9, -0.13), (to, 1.0, 0.13));
    rail.material(CARVED);
    let count = match parts.detail {
        ..BALUSTERS => 0,
        BALUSTERS..4.0 => 5,
        _ => 9,
    };
    let step = (to - from) / f64::from(count);
    for k in 0..count {
        let x = from + step * (f64::from(k) + 0.5);
        baluster(&mut parts.moved(x, 0.12, 0.0));
    }
}

fn baluster(parts: &mut PartBuilder) {
    let outline = [
        (0.062, 0.0),
        (0.062, 0.05),
        (0.062, 0.05),
        (0.04, 0.06),
        (0.03, 0.1),
        (0.045, 0.13),
        (0.08, 0.2),
        (0.086, 0.29),
        (0.05, 0.4),
        (0.028, 0.52),
        (0.027, 0.6),
        (0.05, 0.62),
        (0.05, 0.65),
        (0.032, 0.66),
        (0.032, 0.68),
        (0.062, 0.71),
        (0.062, 0.71),
        (0.062, 0.78),
    ];
    revolve(parts, &outline, (4, 2), plain);
}

/// Height of the roof's lower face at this z of a wing.
fn roof_height(z: f64) -> f64 {
    ROOF.0 + (ROOF.1 - ROOF.0) * (EAVE - z) / (AISLE + EAVE)
}

/// The roof of a wing, which slopes down toward the court, and all its timbers: long slanted beams
/// of a few triangles, most of them across each other.
pub(super) fn roof(parts: &mut PartBuilder, wing: &Wing) {
    let long = wing.length();
    let fine = parts.detail > RAFTERS;
    let step = if fine { 0.25 } else { 1.0 };
    let mut wood = flat(parts);
    wood.material(BOARDS);
    let plan = [
        (-AISLE, -AISLE),
        (long + AISLE, -AISLE),
        (long - EAVE, EAVE),
        (EAVE, EAVE),
    ];
    wood.wall(plan.map(|(x, z)| (x, roof_height(z), z)));
    let [a, b, c, d] = plan.map(|(x, z)| (x, roof_height(z) + 0.14, z));
    wood.material(TERRACOTTA);
    wood.wall([d, c, b, a]);
    wood.material(TIMBER);
    let (y, z) = (ROOF.0, EAVE);
    let lo = (EAVE, y - 0.05, z - 0.02);
    wood.slab(lo, (long - EAVE, y + 0.15, z + 0.03));
    let hip = [(-AISLE, -AISLE), (EAVE, EAVE)];
    slanted(&mut wood, hip, 0.13, (0.16, 0.22));
    for k in 0..=(f64::from(wing.bays) / step) as u32 {
        let x = BAY * step * f64::from(k);
        let rafter = [(x, -AISLE), (x, EAVE - 0.03)];
        if x > EAVE && x < long - EAVE {
            slanted(&mut wood, rafter, 0.08, (0.1, 0.15));
        }
    }
    for k in 0..wing.bays {
        let x = BAY * f64::from(k);
        for brace in [[(x, -AISLE), (x + BAY, 0.0)], [(x + BAY, -AISLE), (x, 0.0)]] {
            slanted(&mut wood, brace, 0.22, (0.12, 0.1));
        }
        if k > 0 && fine {
            frame(&mut wood.moved(x, 0.0, 0.0));
        }
    }
}

/// A timber beneath the roof between two points of its plan, this far under it.
fn slanted(wood: &mut PartBuilder, plan: [(f64, f64); 2], under: f64, section: (f64, f64)) {
    let ends = plan.map(|(x, z)| (x, roof_height(z) - under, z));
    beam(wood, ends, section);
}

/// The timbers of a column's line: a tie, two braces, and a strut.
fn frame(wood: &mut PartBuilder) {
    let tie = UPPER.top - 0.25;
    let timbers: [([FramePoint; 2], (f64, f64)); 4] = [
        ([(0.0, tie, -AISLE), (0.0, tie, 0.0)], (0.2, 0.26)),
        ([(0.0, 7.2, -AISLE), (0.0, tie, -AISLE + 1.5)], (0.14, 0.16)),
        ([(0.0, tie, -2.4), (0.0, 10.1, -1.2)], (0.12, 0.14)),
        ([(0.0, tie, -0.9), (0.0, 10.4, -2.2)], (0.12, 0.14)),
    ];
    for (ends, section) in timbers {
        beam(wood, ends, section);
    }
}
