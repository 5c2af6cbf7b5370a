//! A house of the street: its facade, and a body behind it.

use super::layout::{Area, FLOOR, GROUND, REVEAL, SEED};
use super::opening;
use super::palette::{BRICK, IRON, ROOF, SHUTTER, SHUTTERS, STUCCO, STUCCOS, TRIM};
use super::stone::{stone, stone_triangles};
use crate::modern::mesh_builder::Grid;
use crate::modern::noise::{Dice, fractal2};
use crate::modern::props::{LocalFrame, ON_WALL, PartBuilder, cells};
use glam::{dvec2, dvec3};
use libm::{cos, sin};
use std::f64::consts::{PI, TAU};

pub(super) struct House {
    /// Frame at the facade's lower left corner: x to the right, z toward the street.
    pub(super) frame: LocalFrame,
    seed: u64,
    width: f64,
    floors: usize,
    bays: usize,
    wall: usize,
    brick: bool,
    shutter: Option<usize>,
    balconies: bool,
    /// True if the ground floor is the café's.
    pub(super) cafe: bool,
}

/// Height of a floor's upper end.
fn top(floor: usize) -> f64 {
    GROUND + FLOOR * floor as f64
}

impl House {
    pub(super) fn new(frame: LocalFrame, number: u64, width: f64, cafe: bool) -> House {
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
        top(self.floors - 1)
    }

    /// Everything but the ground floor of the café.
    pub(super) fn build(&self, parts: &mut PartBuilder) {
        self.body(parts);
        for floor in 1..self.floors {
            (0..self.bays).for_each(|bay| self.bay(parts, floor, bay));
        }
        self.ledges(parts);
        if !self.cafe {
            (0..self.bays).for_each(|bay| self.bay(parts, 0, bay));
        }
    }

    /// Side and back walls and the roof.
    fn body(&self, parts: &mut PartBuilder) {
        let (frame, width, top) = (parts.frame, self.width, self.height());
        parts.material(self.wall);
        let from = if self.cafe { GROUND } else { 0.0 };
        let mut walls = parts.with_detail(parts.detail * 0.25);
        let sides = [true, true, self.cafe, true, true, true];
        walls.cuboid((0.0, from, -7.0), (width, top, -REVEAL), sides);
        parts.material(ROOF);
        let (eaves, ridge) = (dvec2(0.42, top + 0.22), dvec2(-3.4, top + 2.9));
        let (across, rows) = (parts.cells(width), cells(4.6, parts.detail * 0.6));
        parts.mesh.grid(Grid::open(across, rows), |i, j| {
            let (u, v) = (i as f64 / across as f64, j as f64 / rows as f64);
            let p = eaves + (ridge - eaves) * v;
            let wave = 0.03 * sin(u * width * TAU / 0.3);
            frame.point(dvec3(u * width, p.y + wave, p.x))
        });
        parts.material(self.wall);
        for x in [0.0, width] {
            let gable = [dvec2(0.0, top), ridge, dvec2(-7.0, top)];
            let gable = gable.map(|p| frame.point(dvec3(x, p.y, p.x)));
            parts.mesh.triangle(1, |i, j| gable[i + 2 * j]);
        }
    }

    /// One window, or the door, with the wall around it.
    fn bay(&self, parts: &mut PartBuilder, floor: usize, bay: usize) {
        let wide = self.width / self.bays as f64;
        let (x0, x1) = (wide * bay as f64, wide * (bay + 1) as f64);
        let y0 = if floor == 0 { 0.0 } else { top(floor - 1) };
        let y1 = top(floor);
        let middle = (x0 + x1) / 2.0;
        let door = floor == 0 && bay == self.bays / 2;
        let (half, sill, head) = if door { (0.55, 0.0, 2.45) } else { (0.5, 0.82, 2.42) };
        let hole = Area::new(middle - half, y0 + sill, middle + half, y0 + head);
        self.wall_around(parts, Area::new(x0, y0, x1, y1), hole);
        opening::reveal(parts, hole);
        if door {
            opening::door(parts, hole);
            return;
        }
        let mut dice = Dice::of(self.seed, (floor * 16 + bay) as u64);
        opening::window(parts, hole, dice.below(10));
        let balcony = self.balconies && floor > 0 && (bay + floor) % 2 == 1;
        if balcony {
            opening::balcony(parts, hole);
            return;
        }
        if let Some(shutter) = self.shutter {
            opening::shutters(parts, hole, shutter);
        }
        if parts.detail > 1.2 {
            opening::flowers(parts, hole, &mut dice);
        }
    }

    /// The parts of a wall around an opening.
    pub(super) fn wall_around(&self, parts: &mut PartBuilder, wall: Area, hole: Area) {
        self.masonry(parts, Area::new(wall.x0, wall.y0, hole.x0, wall.y1));
        self.masonry(parts, Area::new(hole.x1, wall.y0, wall.x1, wall.y1));
        if hole.y0 > wall.y0 {
            self.masonry(parts, Area::new(hole.x0, wall.y0, hole.x1, hole.y0));
        }
        self.masonry(parts, Area::new(hole.x0, hole.y1, hole.x1, wall.y1));
    }

    /// A part of a wall: stucco, or bricks if there is detail enough for them.
    fn masonry(&self, parts: &mut PartBuilder, area: Area) {
        let (wide, high) = (area.x1 - area.x0, area.y1 - area.y0);
        if self.brick && parts.detail > 3.0 + 0.01 * (self.seed % 100) as f64 {
            self.bricks(parts, area);
            return;
        }
        parts.material(self.wall);
        let (frame, across, rows) = (parts.frame, parts.cells(wide), parts.cells(high));
        parts.mesh.grid(Grid::open(across, rows), |i, j| {
            let x = area.x0 + wide * (i as f64 / across as f64);
            let y = area.y0 + high * (j as f64 / rows as f64);
            let rough = 0.008 * fractal2(self.seed, dvec2(x, y) * 5.0, 2);
            frame.point(dvec3(x, y, rough))
        });
    }

    fn bricks(&self, parts: &mut PartBuilder, area: Area) {
        let (wide, high) = (area.x1 - area.x0, area.y1 - area.y0);
        let (columns, courses) = (cells(wide, 1.0 / 0.24), cells(high, 1.0 / 0.08));
        let inner = cells(0.5, parts.detail * 0.1);
        let triangles = (columns * courses) as u64 * stone_triangles(inner);
        if parts.mesh.counted(triangles) {
            return;
        }
        let size = dvec2(wide / columns as f64, high / courses as f64);
        let column_and_row = (area.x0 * 64.0) as u64 * 4096 + (area.y0 * 64.0) as u64;
        let mut dice = Dice::of(self.seed, column_and_row);
        for course in 0..courses {
            for column in 0..columns {
                parts.material(BRICK + dice.below(3));
                let corner = dvec2(area.x0, area.y0) + size * dvec2(column as f64, course as f64);
                let depth = dice.range(0.012, 0.022);
                stone(parts, corner.extend(0.0), size, (0.07, depth), inner);
            }
        }
    }

    /// The lines between the floors, and the cornice with its dentils.
    fn ledges(&self, parts: &mut PartBuilder) {
        parts.material(TRIM);
        let width = (0.0, self.width);
        let ledge = [
            (0.0, -0.11),
            (0.05, -0.09),
            (0.055, -0.03),
            (0.09, 0.0),
            (0.09, 0.05),
            (0.0, 0.07),
        ];
        for floor in 0..self.floors - 1 {
            parts.moved(0.0, top(floor), 0.0).moulding(width, &ledge);
        }
        let steps = 6;
        let curve = (0..=steps).map(|k| {
            let turn = PI / 2.0 * f64::from(k) / f64::from(steps);
            (0.1 + 0.24 * sin(turn), 0.02 + 0.16 * (1.0 - cos(turn)))
        });
        let start = [(0.0, -0.3), (0.06, -0.28), (0.06, -0.06), (0.1, -0.04)];
        let ends = [(0.34, 0.24), (0.36, 0.26), (0.36, 0.3), (0.0, 0.32)];
        let profile: Vec<_> = start.into_iter().chain(curve).chain(ends).collect();
        let mut top = parts.moved(0.0, self.height(), 0.0);
        top.moulding(width, &profile);
        if top.detail > 1.0 {
            for k in 0..(self.width / 0.2) as usize {
                let x = 0.2 * k as f64 + 0.05;
                top.cuboid((x, -0.2, 0.05), (x + 0.1, -0.07, 0.12), ON_WALL);
            }
        }
        parts.material(IRON);
        let sides = (parts.cells(0.6).clamp(5, 64), parts.cells(self.height()));
        let ends = [(0.0, 0.0, 0.0), (0.0, self.height(), 0.0)];
        parts.moved(0.06, 0.0, 0.07).rod(ends, 0.045, sides);
    }
}
