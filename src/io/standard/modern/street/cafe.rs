//! The café: its open front, and its interior.

use super::house::{Area, GROUND, House};
use super::{
    BOTTLE, BULB, CHINA, IRON, LIT, PICTURE, PLANK, SEED, SHADE, SHUTTER, TABLE, TRIM, WARM_WALL,
    WOOD,
};
use crate::standard::builder::StandardLight;
use crate::standard::modern::geodesic;
use crate::standard::modern::lamp;
use crate::standard::modern::materials::rgb;
use crate::standard::modern::mesh_builder::MeshBuilder;
use crate::standard::modern::noise::Dice;
use crate::standard::modern::props::{
    ALL, LocalFrame, STANDING, cells, cuboid, lathe, moulding, rod,
};
use glam::{DVec2, DVec3};
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
        let position = house.point(DVec3::new(x, LAMP - 0.1, z));
        lamp(position, rgb(0.66, 0.42, 0.19), 1.75)
    })
}

/// The front of the ground floor.
pub(super) fn front(mesh: &mut MeshBuilder, house: &House, detail: f64) {
    let between = (WINDOW.x1 + DOOR.x0) / 2.0;
    house.wall_around(mesh, Area::new(0.0, 0.0, between, GROUND), WINDOW, detail);
    house.wall_around(mesh, Area::new(between, 0.0, WIDTH, GROUND), DOOR, detail);
    house.reveal(mesh, WINDOW, detail);
    house.reveal(mesh, DOOR, detail);
    let frame = &house.frame;
    let slab = |mesh: &mut MeshBuilder, lo: (f64, f64, f64), hi: (f64, f64, f64)| {
        cuboid(mesh, frame, (lo.into(), hi.into()), detail, ALL);
    };
    mesh.material(SHUTTER);
    for hole in [WINDOW, DOOR] {
        slab(
            mesh,
            (hole.x0 - 0.14, hole.y0, 0.0),
            (hole.x0, hole.y1 + 0.14, 0.07),
        );
        slab(
            mesh,
            (hole.x1, hole.y0, 0.0),
            (hole.x1 + 0.14, hole.y1 + 0.14, 0.07),
        );
        slab(
            mesh,
            (hole.x0, hole.y1, 0.0),
            (hole.x1, hole.y1 + 0.14, 0.07),
        );
    }
    slab(
        mesh,
        (WINDOW.x0 - 0.2, WINDOW.y0 - 0.08, -0.1),
        (WINDOW.x1 + 0.2, WINDOW.y0 + 0.012, 0.16),
    );
    // The sign board over both, and its letters' glow.
    slab(mesh, (0.35, 2.8, 0.0), (5.9, 3.24, 0.1));
    mesh.material(LIT);
    slab(mesh, (2.2, 2.93, 0.1), (4.1, 3.11, 0.12));
    // The door, swung inward.
    mesh.material(WOOD);
    let door = frame.moved(DOOR.x1 - 0.02, 0.0, -0.2).turned(-62.0);
    let leaf = (DVec3::new(-1.1, FLOOR, -0.03), DVec3::new(0.0, 2.55, 0.03));
    cuboid(mesh, &door, leaf, detail, ALL);
    awning(mesh, frame, detail);
}

/// Striped cloth over the window.
fn awning(mesh: &mut MeshBuilder, frame: &LocalFrame, detail: f64) {
    let stripes = 16;
    let (from, to) = (WINDOW.x0 - 0.15, WINDOW.x1 + 0.15);
    let wide = (to - from) / f64::from(stripes);
    for k in 0..stripes {
        mesh.material(if k % 2 == 0 { TRIM } else { SHUTTER + 2 });
        let x = from + wide * f64::from(k);
        let cloth = [
            (0.86, 2.22),
            (0.86, 2.36),
            (0.62, 2.48),
            (0.35, 2.60),
            (0.1, 2.74),
        ];
        moulding(mesh, frame, (x, x + wide), &cloth.map(DVec2::from), detail);
    }
}

/// The room, and everything in it.
pub(super) fn furnish(mesh: &mut MeshBuilder, house: &LocalFrame, detail: f64) {
    room(mesh, house, detail);
    for (x, z) in LAMPS {
        hanging_lamp(mesh, &house.moved(x, 0.0, z), detail);
    }
    let floor = house.moved(0.0, FLOOR, 0.0);
    for (number, (x, z)) in [(1.35, -1.15), (3.0, -2.0), (1.2, -2.9)]
        .into_iter()
        .enumerate()
    {
        let seat = floor.moved(x, 0.0, z).turned(35.0 * number as f64);
        table(mesh, &seat, detail);
        for k in 0..3 {
            let around = seat.turned(120.0 * f64::from(k) + 20.0);
            chair(mesh, &around.moved(0.0, 0.0, 0.62), detail);
        }
    }
    bar(mesh, &floor, detail);
    // One table outside, under the awning.
    let outside = house.moved(2.1, 0.1, 0.72).turned(15.0);
    table(mesh, &outside, detail);
    for turn in [85.0, -80.0] {
        chair(mesh, &outside.turned(turn).moved(0.0, 0.0, 0.6), detail);
    }
}

fn room(mesh: &mut MeshBuilder, house: &LocalFrame, detail: f64) {
    let at = |x: f64, y: f64, z: f64| house.point(DVec3::new(x, y, z));
    let (l, r) = ROOM;
    let wall = |mesh: &mut MeshBuilder, corners: [DVec3; 4]| {
        let [a, b, _, d] = corners;
        mesh.quad(
            corners,
            cells((b - a).length(), detail),
            cells((d - a).length(), detail),
        );
    };
    mesh.material(WARM_WALL);
    wall(
        mesh,
        [
            at(l, FLOOR, BACK),
            at(r, FLOOR, BACK),
            at(r, CEILING, BACK),
            at(l, CEILING, BACK),
        ],
    );
    wall(
        mesh,
        [
            at(l, FLOOR, FRONT),
            at(l, FLOOR, BACK),
            at(l, CEILING, BACK),
            at(l, CEILING, FRONT),
        ],
    );
    wall(
        mesh,
        [
            at(r, FLOOR, BACK),
            at(r, FLOOR, FRONT),
            at(r, CEILING, FRONT),
            at(r, CEILING, BACK),
        ],
    );
    wall(
        mesh,
        [
            at(l, CEILING, BACK),
            at(r, CEILING, BACK),
            at(r, CEILING, FRONT),
            at(l, CEILING, FRONT),
        ],
    );
    mesh.material(PLANK);
    let planks = 24;
    let wide = (r - l) / f64::from(planks);
    for k in 0..planks {
        let x = l + wide * f64::from(k);
        let top = FLOOR - 0.003 * f64::from(k % 3);
        let corners = (
            DVec3::new(x, 0.0, BACK),
            DVec3::new(x + wide - 0.006, top, FRONT + 0.2),
        );
        cuboid(
            mesh,
            house,
            corners,
            detail,
            [true, true, false, true, false, true],
        );
    }
    mesh.material(TABLE);
    let skirting = [
        (0.03, FLOOR),
        (0.03, FLOOR + 1.0),
        (0.06, FLOOR + 1.03),
        (0.0, FLOOR + 1.06),
    ];
    let back = house.moved(0.0, 0.0, BACK);
    moulding(mesh, &back, ROOM, &skirting.map(DVec2::from), detail);
    for (k, x) in [0.7, 2.0, 3.3].into_iter().enumerate() {
        let high = 0.62 + 0.12 * k as f64;
        mesh.material(TABLE);
        let frame = (
            DVec3::new(x, 1.5, 0.0),
            DVec3::new(x + 0.9, 1.5 + high, 0.04),
        );
        cuboid(mesh, &back, frame, detail, ALL);
        mesh.material(PICTURE);
        let picture = (
            DVec3::new(x + 0.07, 1.57, 0.04),
            DVec3::new(x + 0.83, 1.43 + high, 0.045),
        );
        cuboid(mesh, &back, picture, detail, ALL);
    }
}

/// Number of sides of turned work of this radius.
fn around(radius: f64, detail: f64) -> usize {
    cells(TAU * radius, detail * 1.5).clamp(8, 400)
}

fn hanging_lamp(mesh: &mut MeshBuilder, place: &LocalFrame, detail: f64) {
    mesh.material(SHADE);
    let shade = [
        (0.22, LAMP),
        (0.2, LAMP + 0.06),
        (0.12, LAMP + 0.17),
        (0.03, LAMP + 0.22),
    ];
    lathe(
        mesh,
        place,
        &shade.map(DVec2::from),
        around(0.2, detail),
        detail,
    );
    mesh.material(IRON);
    let cord = [
        DVec3::new(0.0, LAMP + 0.2, 0.0),
        DVec3::new(0.0, CEILING, 0.0),
    ]
    .map(|p| place.point(p));
    rod(mesh, (cord[0], cord[1]), 0.008, 4, cells(0.8, detail));
    mesh.material(BULB);
    let center = place.point(DVec3::new(0.0, LAMP + 0.05, 0.0));
    geodesic::sphere(mesh, cells(0.1, detail).max(1), |p| center + p * 0.05);
}

fn table(mesh: &mut MeshBuilder, place: &LocalFrame, detail: f64) {
    mesh.material(TABLE);
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
    lathe(
        mesh,
        place,
        &profile.map(DVec2::from),
        around(0.36, detail),
        detail,
    );
    if detail < 0.6 {
        return;
    }
    mesh.material(CHINA);
    for (x, z) in [(0.14, 0.12), (-0.15, 0.05)] {
        let cup = place.moved(x, 0.737, z);
        let saucer = [(0.03, 0.0), (0.075, 0.012), (0.072, 0.016), (0.0, 0.006)];
        lathe(
            mesh,
            &cup,
            &saucer.map(DVec2::from),
            around(0.07, detail),
            detail,
        );
        let bowl = [
            (0.018, 0.006),
            (0.032, 0.02),
            (0.042, 0.065),
            (0.039, 0.065),
            (0.028, 0.022),
            (0.0, 0.014),
        ];
        lathe(
            mesh,
            &cup,
            &bowl.map(DVec2::from),
            around(0.07, detail),
            detail,
        );
    }
}

/// A chair whose back is away from the frame's origin side: along z.
fn chair(mesh: &mut MeshBuilder, place: &LocalFrame, detail: f64) {
    mesh.material(WOOD);
    let slab = |mesh: &mut MeshBuilder, lo: (f64, f64, f64), hi: (f64, f64, f64)| {
        cuboid(mesh, place, (lo.into(), hi.into()), detail, ALL);
    };
    slab(mesh, (-0.2, 0.42, -0.2), (0.2, 0.45, 0.2));
    if detail < 0.25 {
        return;
    }
    for (x, z, top) in [
        (-0.2, -0.2, 0.42),
        (0.165, -0.2, 0.42),
        (-0.2, 0.165, 0.88),
        (0.165, 0.165, 0.88),
    ] {
        slab(mesh, (x, 0.0, z), (x + 0.035, top, z + 0.035));
    }
    slab(mesh, (-0.2, 0.80, 0.17), (0.2, 0.88, 0.195));
    if detail > 0.6 {
        for k in 0..4 {
            let x = -0.13 + 0.08 * f64::from(k);
            slab(mesh, (x, 0.45, 0.172), (x + 0.025, 0.80, 0.19));
        }
        slab(mesh, (-0.165, 0.2, -0.19), (0.165, 0.225, -0.175));
        slab(mesh, (-0.165, 0.2, 0.175), (0.165, 0.225, 0.19));
    }
}

/// The counter at the right, with shelves of bottles behind it.
fn bar(mesh: &mut MeshBuilder, floor: &LocalFrame, detail: f64) {
    let slab = |mesh: &mut MeshBuilder, lo: (f64, f64, f64), hi: (f64, f64, f64)| {
        cuboid(mesh, floor, (lo.into(), hi.into()), detail, STANDING);
    };
    mesh.material(TABLE);
    slab(mesh, (4.6, 0.0, -3.5), (6.9, 1.02, -3.0));
    mesh.material(WOOD);
    slab(mesh, (4.5, 1.02, -3.58), (6.95, 1.07, -2.92));
    let mut dice = Dice::of(SEED + 6, 0);
    for shelf in 0..3 {
        let y = 1.15 + 0.5 * f64::from(shelf);
        mesh.material(TABLE);
        cuboid(
            mesh,
            floor,
            (
                DVec3::new(4.4, y - 0.04, BACK),
                DVec3::new(6.9, y, BACK + 0.28),
            ),
            detail,
            ALL,
        );
        for k in 0..18 {
            if detail < 0.4 {
                break;
            }
            let place = floor.moved(4.5 + 0.135 * f64::from(k), y, BACK + 0.14);
            mesh.material(BOTTLE + dice.below(3));
            let (r, h) = (dice.range(0.03, 0.045), dice.range(0.26, 0.36));
            let bottle = [
                (0.0, 0.0),
                (r, 0.004),
                (r, h * 0.6),
                (0.012, h * 0.75),
                (0.012, h),
                (0.0, h),
            ];
            lathe(
                mesh,
                &place,
                &bottle.map(DVec2::from),
                around(0.05, detail),
                detail,
            );
        }
    }
}
