//! The café: its open front, and its interior.

use super::house::House;
use super::layout::{Area, GROUND, SEED};
use super::opening::reveal;
use super::palette::{
    BOTTLE, BULB, CHINA, IRON, LIT, PICTURE, PLANK, SHADE, SHUTTER, TABLE, TRIM, WARM_WALL, WOOD,
};
use crate::builder::StandardLight;
use crate::modern::materials::rgb;
use crate::modern::noise::Dice;
use crate::modern::props::{LocalFrame, PartBuilder, STANDING, cells};
use crate::modern::setup::lamp;
use glam::dvec3;
use std::f64::consts::TAU;

/// The open window and the open door.
const WINDOW: Area = Area::new(0.55, 0.62, 3.75, 2.62);
const DOOR: Area = Area::new(4.45, 0.0, 5.65, 2.62);
/// Width of the house.
const WIDTH: f64 = 7.2;
/// Extent of the room from wall to wall; the constants below give its back, floor and ceiling.
const ROOM: (f64, f64) = (0.2, WIDTH - 0.2);
const BACK: f64 = -4.6;
const FRONT: f64 = -0.2;
const FLOOR: f64 = 0.12;
const CEILING: f64 = 3.1;
/// Positions of the hanging lamps.
const LAMPS: [(f64, f64); 3] = [(1.5, -1.3), (4.9, -1.6), (3.2, -3.3)];
const LAMP: f64 = 2.18;

pub(super) fn lights(house: &LocalFrame) -> impl Iterator<Item = StandardLight> {
    let house = *house;
    LAMPS.into_iter().map(move |(x, z)| {
        let position = house.point(dvec3(x, LAMP - 0.1, z));
        lamp(position, rgb(0.66, 0.42, 0.19), 1.75)
    })
}

/// The front of the ground floor.
pub(super) fn front(parts: &mut PartBuilder, house: &House) {
    let between = (WINDOW.x1 + DOOR.x0) / 2.0;
    house.wall_around(parts, Area::new(0.0, 0.0, between, GROUND), WINDOW);
    house.wall_around(parts, Area::new(between, 0.0, WIDTH, GROUND), DOOR);
    reveal(parts, WINDOW);
    reveal(parts, DOOR);
    parts.material(SHUTTER);
    for Area { x0, y0, x1, y1 } in [WINDOW, DOOR] {
        parts.slab((x0 - 0.14, y0, 0.0), (x0, y1 + 0.14, 0.07));
        parts.slab((x1, y0, 0.0), (x1 + 0.14, y1 + 0.14, 0.07));
        parts.slab((x0, y1, 0.0), (x1, y1 + 0.14, 0.07));
    }
    let Area { x0, y0, x1, .. } = WINDOW;
    parts.slab((x0 - 0.2, y0 - 0.08, -0.1), (x1 + 0.2, y0 + 0.012, 0.16));
    // The sign board over both, and its letters' glow.
    parts.slab((0.35, 2.8, 0.0), (5.9, 3.24, 0.1));
    parts.material(LIT);
    parts.slab((2.2, 2.93, 0.1), (4.1, 3.11, 0.12));
    // The door, swung inward.
    parts.material(WOOD);
    let door = parts.frame.moved(DOOR.x1 - 0.02, 0.0, -0.2).turned(-62.0);
    parts.at(door).slab((-1.1, FLOOR, -0.03), (0.0, 2.55, 0.03));
    awning(parts);
}

/// Striped cloth over the window.
fn awning(parts: &mut PartBuilder) {
    let stripes = 16;
    let (from, to) = (WINDOW.x0 - 0.15, WINDOW.x1 + 0.15);
    let wide = (to - from) / f64::from(stripes);
    let cloth = [
        (0.86, 2.22),
        (0.86, 2.36),
        (0.62, 2.48),
        (0.35, 2.60),
        (0.1, 2.74),
    ];
    for k in 0..stripes {
        parts.material(if k % 2 == 0 { TRIM } else { SHUTTER + 2 });
        let x = from + wide * f64::from(k);
        parts.moulding((x, x + wide), &cloth);
    }
}

/// The room, and everything in it.
pub(super) fn furnish(house: &mut PartBuilder) {
    room(house);
    for (x, z) in LAMPS {
        hanging_lamp(&mut house.moved(x, 0.0, z));
    }
    let floor = house.frame.moved(0.0, FLOOR, 0.0);
    for (number, (x, z)) in (0..).zip([(1.35, -1.15), (3.0, -2.0), (1.2, -2.9)]) {
        let seat = floor.moved(x, 0.0, z).turned(35.0 * f64::from(number));
        table(&mut house.at(seat));
        for k in 0..3 {
            let around = seat.turned(120.0 * f64::from(k) + 20.0);
            chair(&mut house.at(around.moved(0.0, 0.0, 0.62)));
        }
    }
    bar(&mut house.at(floor));
    // One table outside, under the awning.
    let outside = house.frame.moved(2.1, 0.1, 0.72).turned(15.0);
    table(&mut house.at(outside));
    for turn in [85.0, -80.0] {
        chair(&mut house.at(outside.turned(turn).moved(0.0, 0.0, 0.6)));
    }
}

fn room(house: &mut PartBuilder) {
    house.material(WARM_WALL);
    let (l, r) = ROOM;
    let back = [(l, FLOOR), (r, FLOOR), (r, CEILING), (l, CEILING)].map(|(x, y)| (x, y, BACK));
    let side = |x: f64, from: f64, to: f64| {
        [(FLOOR, from), (FLOOR, to), (CEILING, to), (CEILING, from)].map(|(y, z)| (x, y, z))
    };
    let ceiling = [(l, BACK), (r, BACK), (r, FRONT), (l, FRONT)].map(|(x, z)| (x, CEILING, z));
    for wall in [back, side(l, FRONT, BACK), side(r, BACK, FRONT), ceiling] {
        house.wall(wall);
    }
    house.material(PLANK);
    let planks = 24;
    let wide = (r - l) / f64::from(planks);
    for k in 0..planks {
        let x = l + wide * f64::from(k);
        let top = FLOOR - 0.003 * f64::from(k % 3);
        house.cuboid(
            (x, 0.0, BACK),
            (x + wide - 0.006, top, FRONT + 0.2),
            [true, true, false, true, false, true],
        );
    }
    house.material(TABLE);
    let skirting = [
        (0.03, FLOOR),
        (0.03, FLOOR + 1.0),
        (0.06, FLOOR + 1.03),
        (0.0, FLOOR + 1.06),
    ];
    let mut back = house.moved(0.0, 0.0, BACK);
    back.moulding(ROOM, &skirting);
    for (k, x) in (0..).zip([0.7, 2.0, 3.3]) {
        let high = 0.62 + 0.12 * f64::from(k);
        back.material(TABLE);
        back.slab((x, 1.5, 0.0), (x + 0.9, 1.5 + high, 0.04));
        back.material(PICTURE);
        back.slab((x + 0.07, 1.57, 0.04), (x + 0.83, 1.43 + high, 0.045));
    }
}

/// Number of sides of turned work of this radius.
fn around(radius: f64, detail: f64) -> usize {
    cells(TAU * radius, detail * 1.5).clamp(8, 400)
}

fn hanging_lamp(parts: &mut PartBuilder) {
    parts.material(SHADE);
    let shade = [
        (0.22, LAMP),
        (0.2, LAMP + 0.06),
        (0.12, LAMP + 0.17),
        (0.03, LAMP + 0.22),
    ];
    parts.lathe(&shade, around(0.2, parts.detail));
    parts.material(IRON);
    let cord = [(0.0, LAMP + 0.2, 0.0), (0.0, CEILING, 0.0)];
    parts.rod(cord, 0.008, (4, parts.cells(0.8)));
    parts.material(BULB);
    parts.sphere((0.0, LAMP + 0.05, 0.0), 0.05, parts.cells(0.1).max(1));
}

fn table(parts: &mut PartBuilder) {
    parts.material(TABLE);
    let profile = [
        (0.22, 0.0),
        (0.21, 0.025),
        (0.05, 0.06),
        (0.035, 0.12),
        (0.045, 0.3),
        (0.03, 0.45),
        (0.04, 0.66),
        (0.1, 0.70),
        (0.36, 0.705),
        (0.37, 0.72),
        (0.36, 0.735),
        (0.0, 0.736),
    ];
    parts.lathe(&profile, around(0.36, parts.detail));
    if parts.detail < 0.6 {
        return;
    }
    parts.material(CHINA);
    let saucer = [(0.03, 0.0), (0.075, 0.012), (0.072, 0.016), (0.0, 0.006)];
    let bowl = [
        (0.018, 0.006),
        (0.032, 0.02),
        (0.042, 0.065),
        (0.039, 0.065),
        (0.028, 0.022),
        (0.0, 0.014),
    ];
    for (x, z) in [(0.14, 0.12), (-0.15, 0.05)] {
        let mut cup = parts.moved(x, 0.737, z);
        cup.lathe(&saucer, around(0.07, cup.detail));
        cup.lathe(&bowl, around(0.07, cup.detail));
    }
}

/// A chair whose back is away from the frame's origin side: along z.
fn chair(parts: &mut PartBuilder) {
    parts.material(WOOD);
    parts.slab((-0.2, 0.42, -0.2), (0.2, 0.45, 0.2));
    if parts.detail < 0.25 {
        return;
    }
    for (x, z, top) in [
        (-0.2, -0.2, 0.42),
        (0.165, -0.2, 0.42),
        (-0.2, 0.165, 0.88),
        (0.165, 0.165, 0.88),
    ] {
        parts.slab((x, 0.0, z), (x + 0.035, top, z + 0.035));
    }
    parts.slab((-0.2, 0.80, 0.17), (0.2, 0.88, 0.195));
    if parts.detail > 0.6 {
        for k in 0..4 {
            let x = -0.13 + 0.08 * f64::from(k);
            parts.slab((x, 0.45, 0.172), (x + 0.025, 0.80, 0.19));
        }
        parts.slab((-0.165, 0.2, -0.19), (0.165, 0.225, -0.175));
        parts.slab((-0.165, 0.2, 0.175), (0.165, 0.225, 0.19));
    }
}

/// The counter at the right, with shelves of bottles behind it.
fn bar(parts: &mut PartBuilder) {
    parts.material(TABLE);
    parts.cuboid((4.6, 0.0, -3.5), (6.9, 1.02, -3.0), STANDING);
    parts.material(WOOD);
    parts.cuboid((4.5, 1.02, -3.58), (6.95, 1.07, -2.92), STANDING);
    let mut dice = Dice::of(SEED + 6, 0);
    for board in 0..3 {
        let y = 1.15 + 0.5 * f64::from(board);
        parts.material(TABLE);
        parts.slab((4.4, y - 0.04, BACK), (6.9, y, BACK + 0.28));
        if parts.detail < 0.4 {
            continue;
        }
        for k in 0..18 {
            parts.material(BOTTLE + dice.below(3));
            let (r, h) = (dice.range(0.03, 0.045), dice.range(0.26, 0.36));
            let bottle = [
                (0.0, 0.0),
                (r, 0.004),
                (r, h * 0.6),
                (0.012, h * 0.75),
                (0.012, h),
                (0.0, h),
            ];
            let sides = around(0.05, parts.detail);
            let mut bottom = parts.moved(4.5 + 0.135 * f64::from(k), y, BACK + 0.14);
            bottom.lathe(&bottle, sides);
        }
    }
}
