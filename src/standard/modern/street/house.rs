//! A house of the street: its facade, and a body behind it.

use super::{
    BRICK, IRON, LEAF, LIT, PANE, ROOF, SEED, SHUTTER, SHUTTERS, STUCCO, STUCCOS, TRIM, WOOD, cafe,
};
use crate::standard::modern::noise::{Dice, fractal2};
use crate::standard::modern::parts::{ALL, Frame, STANDING, cells, cuboid, lathe, moulding, rod};
use crate::standard::modern::pen::{Net, Pen};
use glam::{DVec2, DVec3};
use libm::{cos, sin};
use std::f64::consts::{PI, TAU};

/// Height of the ground floor and of those above.
pub(super) const GROUND: f64 = 3.4;
const FLOOR: f64 = 3.05;
/// How deep windows lie in the wall.
const REVEAL: f64 = 0.2;
/// All sides of a box but its back, where it meets the wall.
const ON_WALL: [bool; 6] = [true, true, true, true, false, true];

/// A rectangle of the facade: left, bottom, right, top.
#[derive(Clone, Copy, Debug)]
pub(super) struct Area {
    pub(super) x0: f64,
    pub(super) y0: f64,
    pub(super) x1: f64,
    pub(super) y1: f64,
}

impl Area {
    pub(super) const fn new(x0: f64, y0: f64, x1: f64, y1: f64) -> Area {
        Area { x0, y0, x1, y1 }
    }
}

pub(super) struct House {
    /// At the facade's lower left corner: x to the right, z toward the street.
    pub(super) frame: Frame,
    seed: u64,
    width: f64,
    floors: usize,
    bays: usize,
    wall: usize,
    brick: bool,
    shutter: Option<usize>,
    balconies: bool,
    cafe: bool,
}

impl House {
    pub(super) fn new(frame: Frame, number: u64, width: f64, cafe: bool) -> House {
        let mut dice = Dice::of(SEED, number);
        let floors = 3 + dice.below(2);
        House {
            frame,
            seed: SEED + 1000 * (number + 1),
            width,
            floors: if cafe { 3 } else { floors },
            bays: 3 + dice.below(2),
            wall: STUCCO + (number as usize * 2 + dice.below(2)) % STUCCOS,
            brick: number % 3 == 1,
            shutter: (number % 3 != 1).then(|| SHUTTER + dice.below(SHUTTERS)),
            balconies: cafe || dice.below(2) == 0,
            cafe,
        }
    }

    fn height(&self) -> f64 {
        GROUND + FLOOR * (self.floors - 1) as f64
    }

    pub(super) fn build(&self, pen: &mut Pen, detail: f64) {
        self.body(pen, detail);
        for floor in 1..self.floors {
            for bay in 0..self.bays {
                self.bay(pen, floor, bay, detail);
            }
        }
        self.ledges(pen, detail);
        match self.cafe {
            true => cafe::front(pen, self, detail),
            false => (0..self.bays).for_each(|bay| self.bay(pen, 0, bay, detail)),
        }
    }

    /// Side and back walls and the roof.
    fn body(&self, pen: &mut Pen, detail: f64) {
        pen.look(self.wall);
        let from = if self.cafe { GROUND } else { 0.0 };
        let top = self.height();
        let corners = (
            DVec3::new(0.0, from, -7.0),
            DVec3::new(self.width, top, -REVEAL),
        );
        cuboid(
            pen,
            &self.frame,
            corners,
            detail * 0.25,
            [true, true, self.cafe, true, true, true],
        );
        pen.look(ROOF);
        let (eaves, ridge) = (DVec2::new(0.42, top + 0.22), DVec2::new(-3.4, top + 2.9));
        let (across, rows) = (cells(self.width, detail), cells(4.6, detail * 0.6));
        let frame = &self.frame;
        pen.net(Net::open(across, rows), |i, j| {
            let (u, v) = (i as f64 / across as f64, j as f64 / rows as f64);
            let p = eaves + (ridge - eaves) * v;
            let wave = 0.03 * sin(u * self.width * TAU / 0.3);
            frame.point(DVec3::new(u * self.width, p.y + wave, p.x))
        });
        pen.look(self.wall);
        for x in [0.0, self.width] {
            let at = |p: DVec2| frame.point(DVec3::new(x, p.y, p.x));
            let gable = [
                at(DVec2::new(0.0, top)),
                at(ridge),
                at(DVec2::new(-7.0, top)),
            ];
            pen.triangle(1, |i, j| gable[i + 2 * j]);
        }
    }

    /// One window, or the door, with the wall around it.
    fn bay(&self, pen: &mut Pen, floor: usize, bay: usize, detail: f64) {
        let wide = self.width / self.bays as f64;
        let (x0, x1) = (wide * bay as f64, wide * (bay + 1) as f64);
        let (y0, y1) = match floor {
            0 => (0.0, GROUND),
            _ => (
                GROUND + FLOOR * (floor - 1) as f64,
                GROUND + FLOOR * floor as f64,
            ),
        };
        let middle = (x0 + x1) / 2.0;
        let door = floor == 0 && bay == self.bays / 2;
        let (half, sill, top) = if door {
            (0.55, 0.0, 2.45)
        } else {
            (0.5, 0.82, 2.42)
        };
        let opening = Area::new(middle - half, y0 + sill, middle + half, y0 + top);
        self.wall_around(pen, Area::new(x0, y0, x1, y1), opening, detail);
        self.reveal(pen, opening, detail);
        let mut dice = Dice::of(self.seed, (floor * 16 + bay) as u64);
        if door {
            self.door(pen, opening, detail);
        } else {
            let kind = dice.below(10);
            let balcony = self.balconies && floor > 0 && (bay + floor) % 2 == 1;
            self.window(pen, opening, kind, detail);
            if let Some(shutter) = self.shutter.filter(|_| !balcony) {
                self.shutters(pen, opening, shutter, detail);
            }
            if balcony {
                self.balcony(pen, opening, detail);
            } else if detail > 1.2 {
                self.flowers(pen, opening, &mut dice, detail);
            }
        }
    }

    /// The parts of a wall that an opening leaves.
    pub(super) fn wall_around(&self, pen: &mut Pen, wall: Area, hole: Area, detail: f64) {
        self.masonry(pen, Area::new(wall.x0, wall.y0, hole.x0, wall.y1), detail);
        self.masonry(pen, Area::new(hole.x1, wall.y0, wall.x1, wall.y1), detail);
        if hole.y0 > wall.y0 {
            self.masonry(pen, Area::new(hole.x0, wall.y0, hole.x1, hole.y0), detail);
        }
        self.masonry(pen, Area::new(hole.x0, hole.y1, hole.x1, wall.y1), detail);
    }

    /// A piece of wall: stucco, or bricks where there is detail enough for them.
    pub(super) fn masonry(&self, pen: &mut Pen, area: Area, detail: f64) {
        let (wide, high) = (area.x1 - area.x0, area.y1 - area.y0);
        if self.brick && detail > 3.0 + 0.01 * (self.seed % 100) as f64 {
            self.bricks(pen, area, detail);
            return;
        }
        pen.look(self.wall);
        let (across, rows) = (cells(wide, detail), cells(high, detail));
        pen.net(Net::open(across, rows), |i, j| {
            let x = area.x0 + wide * (i as f64 / across as f64);
            let y = area.y0 + high * (j as f64 / rows as f64);
            let rough = 0.008 * fractal2(self.seed, DVec2::new(x, y) * 5.0, 2);
            self.frame.point(DVec3::new(x, y, rough))
        });
    }

    fn bricks(&self, pen: &mut Pen, area: Area, detail: f64) {
        let (wide, high) = (area.x1 - area.x0, area.y1 - area.y0);
        let (columns, courses) = (cells(wide, 1.0 / 0.24), cells(high, 1.0 / 0.08));
        let inner = cells(0.5, detail * 0.1);
        if pen.counted((columns * courses) as u64 * stone_triangles(inner)) {
            return;
        }
        let size = DVec2::new(wide / columns as f64, high / courses as f64);
        let mut dice = Dice::of(
            self.seed,
            (area.x0 * 64.0) as u64 * 4096 + (area.y0 * 64.0) as u64,
        );
        for course in 0..courses {
            for column in 0..columns {
                pen.look(BRICK + dice.below(3));
                let corner = DVec3::new(
                    area.x0 + size.x * column as f64,
                    area.y0 + size.y * course as f64,
                    0.0,
                );
                let depth = dice.range(0.012, 0.022);
                stone(pen, &self.frame, corner, size, (0.07, depth), inner);
            }
        }
    }

    /// The four sides of a hole in the wall.
    pub(super) fn reveal(&self, pen: &mut Pen, hole: Area, detail: f64) {
        pen.look(TRIM);
        let at = |x: f64, y: f64, z: f64| self.frame.point(DVec3::new(x, y, z));
        let corners = [
            (hole.x0, hole.y0),
            (hole.x1, hole.y0),
            (hole.x1, hole.y1),
            (hole.x0, hole.y1),
        ];
        for k in 0..4 {
            let ((ax, ay), (bx, by)) = (corners[k], corners[(k + 1) % 4]);
            let length = (bx - ax).abs() + (by - ay).abs();
            let (a, b) = (at(ax, ay, 0.0), at(bx, by, 0.0));
            let (c, d) = (at(bx, by, -REVEAL), at(ax, ay, -REVEAL));
            pen.quad([a, b, c, d], cells(length, detail), cells(REVEAL, detail));
        }
    }

    fn window(&self, pen: &mut Pen, hole: Area, kind: usize, detail: f64) {
        let frame = &self.frame;
        let back = -0.16;
        // Half of the windows are lit, each a little differently behind its curtains.
        let looks = match kind {
            0..2 => [LIT + 1, LIT, LIT + 1],
            2..4 => [LIT + 2, LIT + 1, LIT + 2],
            4 => [LIT + 2, LIT + 2, LIT + 1],
            _ => [PANE; 3],
        };
        let third = (hole.x1 - hole.x0) / 3.0;
        for (k, look) in looks.into_iter().enumerate() {
            pen.look(look);
            let x = hole.x0 + third * k as f64;
            let at = |x: f64, y: f64| frame.point(DVec3::new(x, y, back));
            let corners = [
                at(x, hole.y0),
                at(x + third, hole.y0),
                at(x + third, hole.y1),
                at(x, hole.y1),
            ];
            pen.quad(corners, 1, 1);
        }
        if detail > 0.5 {
            self.sash(pen, hole, detail);
        }
        pen.look(TRIM);
        let sill = (
            DVec3::new(hole.x0 - 0.1, hole.y0 - 0.07, -0.05),
            DVec3::new(hole.x1 + 0.1, hole.y0, 0.09),
        );
        cuboid(pen, frame, sill, detail, ON_WALL);
        if detail > 0.8 {
            self.surround(pen, hole, detail);
        }
    }

    /// The wooden frame of a window, its bars, and the glazing bars.
    fn sash(&self, pen: &mut Pen, hole: Area, detail: f64) {
        pen.look(TRIM);
        let bar = |pen: &mut Pen, x0: f64, y0: f64, x1: f64, y1: f64, front: f64| {
            let corners = (DVec3::new(x0, y0, -0.16), DVec3::new(x1, y1, front));
            cuboid(pen, &self.frame, corners, detail, ON_WALL);
        };
        let Area { x0, y0, x1, y1 } = hole;
        let (w, middle) = (0.055, (x0 + x1) / 2.0);
        bar(pen, x0, y0, x0 + w, y1, -0.09);
        bar(pen, x1 - w, y0, x1, y1, -0.09);
        bar(pen, x0 + w, y0, x1 - w, y0 + w, -0.09);
        bar(pen, x0 + w, y1 - w, x1 - w, y1, -0.09);
        bar(pen, middle - 0.035, y0 + w, middle + 0.035, y1 - w, -0.10);
        if detail > 1.5 {
            for k in 1..4 {
                let y = y0 + (y1 - y0) * f64::from(k) / 4.0;
                bar(pen, x0 + w, y - 0.014, middle - 0.035, y + 0.014, -0.125);
                bar(pen, middle + 0.035, y - 0.014, x1 - w, y + 0.014, -0.125);
            }
        }
    }

    /// The raised border about a window, with a keystone.
    fn surround(&self, pen: &mut Pen, hole: Area, detail: f64) {
        pen.look(TRIM);
        let Area { x0, y0, x1, y1 } = hole;
        let slab = |pen: &mut Pen, x0: f64, y0: f64, x1: f64, y1: f64, front: f64| {
            cuboid(
                pen,
                &self.frame,
                (DVec3::new(x0, y0, -0.01), DVec3::new(x1, y1, front)),
                detail,
                ON_WALL,
            );
        };
        slab(pen, x0 - 0.13, y0, x0, y1 + 0.13, 0.04);
        slab(pen, x1, y0, x1 + 0.13, y1 + 0.13, 0.04);
        slab(pen, x0, y1, x1, y1 + 0.13, 0.04);
        let middle = (x0 + x1) / 2.0;
        slab(
            pen,
            middle - 0.08,
            y1 - 0.02,
            middle + 0.08,
            y1 + 0.2,
            0.075,
        );
        let cap = [
            (0.04, 0.13),
            (0.06, 0.15),
            (0.11, 0.19),
            (0.12, 0.22),
            (0.0, 0.235),
        ];
        let place = self.frame.moved(0.0, y1, 0.0);
        moulding(
            pen,
            &place,
            (x0 - 0.16, x1 + 0.16),
            &cap.map(DVec2::from),
            detail,
        );
    }

    /// Two open shutters with slats.
    fn shutters(&self, pen: &mut Pen, hole: Area, look: usize, detail: f64) {
        if detail < 0.3 {
            return;
        }
        pen.look(look);
        let (wide, high) = (0.48, hole.y1 - hole.y0);
        for x in [hole.x0 - 0.15 - wide, hole.x1 + 0.15] {
            let slab = |pen: &mut Pen, (ax, ay): (f64, f64), (bx, by): (f64, f64), front: f64| {
                let lo = DVec3::new(x + ax, hole.y0 + ay, 0.02);
                let hi = DVec3::new(x + bx, hole.y0 + by, front);
                cuboid(pen, &self.frame, (lo, hi), detail, ON_WALL);
            };
            slab(pen, (0.0, 0.0), (0.05, high), 0.06);
            slab(pen, (wide - 0.05, 0.0), (wide, high), 0.06);
            for y in [0.0, high / 2.0 - 0.03, high - 0.06] {
                slab(pen, (0.05, y), (wide - 0.05, y + 0.06), 0.06);
            }
            slab(pen, (0.05, 0.06), (wide - 0.05, high - 0.06), 0.025);
            self.slats(
                pen,
                (x + 0.05, x + wide - 0.05),
                (hole.y0 + 0.06, hole.y0 + high - 0.06),
                detail,
            );
        }
    }

    fn slats(&self, pen: &mut Pen, (x0, x1): (f64, f64), (y0, y1): (f64, f64), detail: f64) {
        if detail < 1.0 {
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
            moulding(pen, &self.frame, (x0, x1), &slat.map(DVec2::from), detail);
        }
    }

    fn door(&self, pen: &mut Pen, hole: Area, detail: f64) {
        pen.look(WOOD);
        let Area { x0, y0, x1, y1 } = hole;
        let slab = |pen: &mut Pen, x0: f64, y0: f64, x1: f64, y1: f64, front: f64| {
            cuboid(
                pen,
                &self.frame,
                (DVec3::new(x0, y0, -0.2), DVec3::new(x1, y1, front)),
                detail,
                ON_WALL,
            );
        };
        slab(pen, x0, y0, x1, y1 - 0.4, -0.13);
        let middle = (x0 + x1) / 2.0;
        for (a, b) in [(x0 + 0.08, middle - 0.05), (middle + 0.05, x1 - 0.08)] {
            for (c, d) in [(0.15, 0.75), (0.87, 1.9)] {
                slab(pen, a, y0 + c, b, y0 + d, -0.11);
                slab(
                    pen,
                    a + 0.07,
                    y0 + c + 0.07,
                    b - 0.07,
                    y0 + d - 0.07,
                    -0.095,
                );
            }
        }
        pen.look(LIT + 1);
        slab(pen, x0, y1 - 0.36, x1, y1, -0.15);
        if detail > 0.8 {
            self.surround(pen, Area::new(x0, y0, x1, y1), detail);
        }
        pen.look(TRIM);
        let step = (
            DVec3::new(x0 - 0.2, 0.0, -0.1),
            DVec3::new(x1 + 0.2, 0.13, 0.4),
        );
        cuboid(pen, &self.frame, step, detail, STANDING);
    }

    /// A slab on two brackets, with a railing of turned balusters.
    pub(super) fn balcony(&self, pen: &mut Pen, hole: Area, detail: f64) {
        pen.look(TRIM);
        let (x0, x1) = (hole.x0 - 0.3, hole.x1 + 0.3);
        let (floor, out) = (hole.y0 - 0.3, 0.72);
        let slab = |pen: &mut Pen, lo: (f64, f64, f64), hi: (f64, f64, f64)| {
            cuboid(pen, &self.frame, (lo.into(), hi.into()), detail, ALL);
        };
        slab(pen, (x0, floor - 0.11, 0.0), (x1, floor, out));
        for x in [x0 + 0.12, x1 - 0.26] {
            slab(pen, (x, floor - 0.36, 0.0), (x + 0.14, floor - 0.11, 0.2));
            slab(pen, (x, floor - 0.23, 0.2), (x + 0.14, floor - 0.11, 0.45));
        }
        let rail = floor + 0.86;
        slab(pen, (x0, rail, out - 0.11), (x1, rail + 0.07, out));
        slab(pen, (x0, rail, 0.0), (x0 + 0.11, rail + 0.07, out - 0.11));
        slab(pen, (x1 - 0.11, rail, 0.0), (x1, rail + 0.07, out - 0.11));
        if detail < 0.7 {
            return;
        }
        let baluster = |pen: &mut Pen, x: f64, z: f64| {
            let place = self.frame.moved(x, floor, z);
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
            let around = cells(0.8, detail).clamp(6, 64);
            lathe(pen, &place, &profile.map(DVec2::from), around, detail);
        };
        let count = 11;
        for k in 0..count {
            let x = x0 + 0.055 + (x1 - x0 - 0.11) * f64::from(k) / f64::from(count - 1);
            baluster(pen, x, out - 0.055);
        }
        for k in 0..4 {
            let z = 0.08 + 0.15 * f64::from(k);
            baluster(pen, x0 + 0.055, z);
            baluster(pen, x1 - 0.055, z);
        }
    }

    /// An iron box of plants under a window.
    fn flowers(&self, pen: &mut Pen, hole: Area, dice: &mut Dice, detail: f64) {
        if dice.below(3) != 0 {
            return;
        }
        pen.look(IRON);
        let corners = (
            DVec3::new(hole.x0, hole.y0, 0.0),
            DVec3::new(hole.x1, hole.y0 + 0.14, 0.17),
        );
        cuboid(pen, &self.frame, corners, detail, ALL);
        for _ in 0..cells(40.0, detail) {
            pen.look(if dice.below(7) == 0 {
                SHUTTER + 2
            } else {
                LEAF + dice.below(2)
            });
            let place = DVec3::new(
                dice.range(hole.x0, hole.x1),
                hole.y0 + 0.12 + 0.2 * dice.unit() * dice.unit(),
                0.1 + dice.range(-0.13, 0.16),
            );
            leaf(pen, &self.frame, place, dice, 0.055);
        }
    }

    /// The lines between the floors, and the cornice with its dentils.
    fn ledges(&self, pen: &mut Pen, detail: f64) {
        pen.look(TRIM);
        let whole = (0.0, self.width);
        for floor in 0..self.floors - 1 {
            let y = GROUND + FLOOR * floor as f64;
            let ledge = [
                (0.0, -0.11),
                (0.05, -0.09),
                (0.055, -0.03),
                (0.09, 0.0),
                (0.09, 0.05),
                (0.0, 0.07),
            ];
            moulding(
                pen,
                &self.frame.moved(0.0, y, 0.0),
                whole,
                &ledge.map(DVec2::from),
                detail,
            );
        }
        let top = self.frame.moved(0.0, self.height(), 0.0);
        let steps = 6;
        let curve = (0..=steps).map(|k| {
            let turn = PI / 2.0 * f64::from(k) / f64::from(steps);
            DVec2::new(0.1 + 0.24 * sin(turn), 0.02 + 0.16 * (1.0 - cos(turn)))
        });
        let ends = [(0.34, 0.24), (0.36, 0.26), (0.36, 0.3), (0.0, 0.32)];
        let start = [(0.0, -0.3), (0.06, -0.28), (0.06, -0.06), (0.1, -0.04)];
        let profile: Vec<_> = start
            .map(DVec2::from)
            .into_iter()
            .chain(curve)
            .chain(ends.map(DVec2::from))
            .collect();
        moulding(pen, &top, whole, &profile, detail);
        if detail > 1.0 {
            for k in 0..(self.width / 0.2) as usize {
                let x = 0.2 * k as f64 + 0.05;
                let dentil = (DVec3::new(x, -0.2, 0.05), DVec3::new(x + 0.1, -0.07, 0.12));
                cuboid(pen, &top, dentil, detail, ON_WALL);
            }
        }
        pen.look(IRON);
        let gutter = self.frame.moved(0.06, 0.0, 0.07);
        let ends = (
            gutter.point(DVec3::ZERO),
            gutter.point(DVec3::Y * self.height()),
        );
        rod(
            pen,
            ends,
            0.045,
            cells(0.6, detail).clamp(5, 64),
            cells(self.height(), detail),
        );
    }
}

/// A leaf: two triangles in a chance direction.
pub(super) fn leaf(pen: &mut Pen, frame: &Frame, place: DVec3, dice: &mut Dice, size: f64) {
    let mut side = || {
        DVec3::new(
            dice.range(-1.0, 1.0),
            dice.range(-1.0, 1.0),
            dice.range(-1.0, 1.0),
        ) * size
    };
    let (a, b) = (side(), side());
    let at = |p: DVec3| frame.point(place + p);
    pen.quad([at(-a), at(b * 0.6), at(a), at(-b * 0.6)], 1, 1);
}

/// Triangles of a [`stone`].
pub(super) fn stone_triangles(inner: usize) -> u64 {
    2 * (inner as u64 + 2) * (inner as u64 + 2)
}

/// A stone of a wall or pavement: a cushion on a rectangle from `corner` on in x and y of the frame, which it leaves
/// free by `rim` of its size and rises above by `depth` along z, in `inner`² quads and a bevel around them.
pub(super) fn stone(
    pen: &mut Pen,
    frame: &Frame,
    corner: DVec3,
    size: DVec2,
    (rim, depth): (f64, f64),
    inner: usize,
) {
    let last = inner + 2;
    let along = |i: usize| match i {
        0 => 0.02,
        i if i == last => 0.98,
        i => rim + (1.0 - 2.0 * rim) * ((i - 1) as f64 / inner as f64),
    };
    pen.net(Net::open(last, last), |i, j| {
        let (u, v) = (along(i), along(j));
        let border = i == 0 || j == 0 || i == last || j == last;
        let bulge = 1.0 + 2.0 * u * (1.0 - u) * v * (1.0 - v);
        let height = if border { 0.0 } else { depth * bulge };
        frame.point(corner + DVec3::new(u * size.x, v * size.y, height))
    });
}
