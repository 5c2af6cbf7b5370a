//! A house of the street: its facade, and a body behind it.

use super::opening::REVEAL;
use super::stone::{stone, stone_triangles};
use super::{BRICK, IRON, ROOF, SEED, SHUTTER, SHUTTERS, STUCCO, STUCCOS, TRIM, cafe};
use crate::standard::modern::mesh_builder::{Grid, MeshBuilder};
use crate::standard::modern::noise::{Dice, fractal2};
use crate::standard::modern::props::{LocalFrame, cells, cuboid, moulding, rod};
use glam::{DVec2, DVec3};
use libm::{cos, sin};
use std::f64::consts::{PI, TAU};

/// Height of the ground floor, then of the floors above.
pub(super) const GROUND: f64 = 3.4;
const FLOOR: f64 = 3.05;
/// All sides of a box but its back, where it meets the wall.
pub(super) const ON_WALL: [bool; 6] = [true, true, true, true, false, true];

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
    cafe: bool,
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
        GROUND + FLOOR * (self.floors - 1) as f64
    }

    pub(super) fn build(&self, mesh: &mut MeshBuilder, detail: f64) {
        self.body(mesh, detail);
        for floor in 1..self.floors {
            for bay in 0..self.bays {
                self.bay(mesh, floor, bay, detail);
            }
        }
        self.ledges(mesh, detail);
        match self.cafe {
            true => cafe::front(mesh, self, detail),
            false => (0..self.bays).for_each(|bay| self.bay(mesh, 0, bay, detail)),
        }
    }

    /// Side and back walls and the roof.
    fn body(&self, mesh: &mut MeshBuilder, detail: f64) {
        mesh.material(self.wall);
        let from = if self.cafe { GROUND } else { 0.0 };
        let top = self.height();
        let corners = (
            DVec3::new(0.0, from, -7.0),
            DVec3::new(self.width, top, -REVEAL),
        );
        cuboid(
            mesh,
            &self.frame,
            corners,
            detail * 0.25,
            [true, true, self.cafe, true, true, true],
        );
        mesh.material(ROOF);
        let (eaves, ridge) = (DVec2::new(0.42, top + 0.22), DVec2::new(-3.4, top + 2.9));
        let (across, rows) = (cells(self.width, detail), cells(4.6, detail * 0.6));
        let frame = &self.frame;
        mesh.grid(Grid::open(across, rows), |i, j| {
            let (u, v) = (i as f64 / across as f64, j as f64 / rows as f64);
            let p = eaves + (ridge - eaves) * v;
            let wave = 0.03 * sin(u * self.width * TAU / 0.3);
            frame.point(DVec3::new(u * self.width, p.y + wave, p.x))
        });
        mesh.material(self.wall);
        for x in [0.0, self.width] {
            let at = |p: DVec2| frame.point(DVec3::new(x, p.y, p.x));
            let gable = [
                at(DVec2::new(0.0, top)),
                at(ridge),
                at(DVec2::new(-7.0, top)),
            ];
            mesh.triangle(1, |i, j| gable[i + 2 * j]);
        }
    }

    /// One window, or the door, with the wall around it.
    fn bay(&self, mesh: &mut MeshBuilder, floor: usize, bay: usize, detail: f64) {
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
        self.wall_around(mesh, Area::new(x0, y0, x1, y1), opening, detail);
        self.reveal(mesh, opening, detail);
        let mut dice = Dice::of(self.seed, (floor * 16 + bay) as u64);
        if door {
            self.door(mesh, opening, detail);
        } else {
            let kind = dice.below(10);
            let balcony = self.balconies && floor > 0 && (bay + floor) % 2 == 1;
            self.window(mesh, opening, kind, detail);
            if let Some(shutter) = self.shutter.filter(|_| !balcony) {
                self.shutters(mesh, opening, shutter, detail);
            }
            if balcony {
                self.balcony(mesh, opening, detail);
            } else if detail > 1.2 {
                self.flowers(mesh, opening, &mut dice, detail);
            }
        }
    }

    /// The parts of a wall around an opening.
    pub(super) fn wall_around(&self, mesh: &mut MeshBuilder, wall: Area, hole: Area, detail: f64) {
        self.masonry(mesh, Area::new(wall.x0, wall.y0, hole.x0, wall.y1), detail);
        self.masonry(mesh, Area::new(hole.x1, wall.y0, wall.x1, wall.y1), detail);
        if hole.y0 > wall.y0 {
            self.masonry(mesh, Area::new(hole.x0, wall.y0, hole.x1, hole.y0), detail);
        }
        self.masonry(mesh, Area::new(hole.x0, hole.y1, hole.x1, wall.y1), detail);
    }

    /// A part of a wall: stucco, or bricks if there is detail enough for them.
    pub(super) fn masonry(&self, mesh: &mut MeshBuilder, area: Area, detail: f64) {
        let (wide, high) = (area.x1 - area.x0, area.y1 - area.y0);
        if self.brick && detail > 3.0 + 0.01 * (self.seed % 100) as f64 {
            self.bricks(mesh, area, detail);
            return;
        }
        mesh.material(self.wall);
        let (across, rows) = (cells(wide, detail), cells(high, detail));
        mesh.grid(Grid::open(across, rows), |i, j| {
            let x = area.x0 + wide * (i as f64 / across as f64);
            let y = area.y0 + high * (j as f64 / rows as f64);
            let rough = 0.008 * fractal2(self.seed, DVec2::new(x, y) * 5.0, 2);
            self.frame.point(DVec3::new(x, y, rough))
        });
    }

    fn bricks(&self, mesh: &mut MeshBuilder, area: Area, detail: f64) {
        let (wide, high) = (area.x1 - area.x0, area.y1 - area.y0);
        let (columns, courses) = (cells(wide, 1.0 / 0.24), cells(high, 1.0 / 0.08));
        let inner = cells(0.5, detail * 0.1);
        if mesh.counted((columns * courses) as u64 * stone_triangles(inner)) {
            return;
        }
        let size = DVec2::new(wide / columns as f64, high / courses as f64);
        let mut dice = Dice::of(
            self.seed,
            (area.x0 * 64.0) as u64 * 4096 + (area.y0 * 64.0) as u64,
        );
        for course in 0..courses {
            for column in 0..columns {
                mesh.material(BRICK + dice.below(3));
                let corner = DVec3::new(
                    area.x0 + size.x * column as f64,
                    area.y0 + size.y * course as f64,
                    0.0,
                );
                let depth = dice.range(0.012, 0.022);
                stone(mesh, &self.frame, corner, size, (0.07, depth), inner);
            }
        }
    }

    /// The lines between the floors, and the cornice with its dentils.
    fn ledges(&self, mesh: &mut MeshBuilder, detail: f64) {
        mesh.material(TRIM);
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
                mesh,
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
        moulding(mesh, &top, whole, &profile, detail);
        if detail > 1.0 {
            for k in 0..(self.width / 0.2) as usize {
                let x = 0.2 * k as f64 + 0.05;
                let dentil = (DVec3::new(x, -0.2, 0.05), DVec3::new(x + 0.1, -0.07, 0.12));
                cuboid(mesh, &top, dentil, detail, ON_WALL);
            }
        }
        mesh.material(IRON);
        let gutter = self.frame.moved(0.06, 0.0, 0.07);
        let ends = (
            gutter.point(DVec3::ZERO),
            gutter.point(DVec3::Y * self.height()),
        );
        rod(
            mesh,
            ends,
            0.045,
            cells(0.6, detail).clamp(5, 64),
            cells(self.height(), detail),
        );
    }
}
