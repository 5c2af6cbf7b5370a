//! Windows and doors of a house, and the parts attached to them.

use super::house::{Area, House, ON_WALL};
use super::stone::leaf;
use super::{IRON, LEAF, LIT, PANE, SHUTTER, TRIM, WOOD};
use crate::standard::modern::mesh_builder::MeshBuilder;
use crate::standard::modern::noise::Dice;
use crate::standard::modern::props::{ALL, STANDING, cells, cuboid, lathe, moulding};
use glam::{DVec2, DVec3};

/// Depth of windows in the wall.
pub(super) const REVEAL: f64 = 0.2;

impl House {
    /// The four sides of a hole in the wall.
    pub(super) fn reveal(&self, mesh: &mut MeshBuilder, hole: Area, detail: f64) {
        mesh.material(TRIM);
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
            mesh.quad([a, b, c, d], cells(length, detail), cells(REVEAL, detail));
        }
    }

    pub(super) fn window(&self, mesh: &mut MeshBuilder, hole: Area, kind: usize, detail: f64) {
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
        for (k, material) in looks.into_iter().enumerate() {
            mesh.material(material);
            let x = hole.x0 + third * k as f64;
            let at = |x: f64, y: f64| frame.point(DVec3::new(x, y, back));
            let corners = [
                at(x, hole.y0),
                at(x + third, hole.y0),
                at(x + third, hole.y1),
                at(x, hole.y1),
            ];
            mesh.quad(corners, 1, 1);
        }
        if detail > 0.5 {
            self.sash(mesh, hole, detail);
        }
        mesh.material(TRIM);
        let sill = (
            DVec3::new(hole.x0 - 0.1, hole.y0 - 0.07, -0.05),
            DVec3::new(hole.x1 + 0.1, hole.y0, 0.09),
        );
        cuboid(mesh, frame, sill, detail, ON_WALL);
        if detail > 0.8 {
            self.surround(mesh, hole, detail);
        }
    }

    /// The wooden frame of a window, its bars, and the glazing bars.
    fn sash(&self, mesh: &mut MeshBuilder, hole: Area, detail: f64) {
        mesh.material(TRIM);
        let bar = |mesh: &mut MeshBuilder, x0: f64, y0: f64, x1: f64, y1: f64, front: f64| {
            let corners = (DVec3::new(x0, y0, -0.16), DVec3::new(x1, y1, front));
            cuboid(mesh, &self.frame, corners, detail, ON_WALL);
        };
        let Area { x0, y0, x1, y1 } = hole;
        let (w, middle) = (0.055, (x0 + x1) / 2.0);
        bar(mesh, x0, y0, x0 + w, y1, -0.09);
        bar(mesh, x1 - w, y0, x1, y1, -0.09);
        bar(mesh, x0 + w, y0, x1 - w, y0 + w, -0.09);
        bar(mesh, x0 + w, y1 - w, x1 - w, y1, -0.09);
        bar(mesh, middle - 0.035, y0 + w, middle + 0.035, y1 - w, -0.10);
        if detail > 1.5 {
            for k in 1..4 {
                let y = y0 + (y1 - y0) * f64::from(k) / 4.0;
                bar(mesh, x0 + w, y - 0.014, middle - 0.035, y + 0.014, -0.125);
                bar(mesh, middle + 0.035, y - 0.014, x1 - w, y + 0.014, -0.125);
            }
        }
    }

    /// The raised border about a window, with a keystone.
    fn surround(&self, mesh: &mut MeshBuilder, hole: Area, detail: f64) {
        mesh.material(TRIM);
        let Area { x0, y0, x1, y1 } = hole;
        let slab = |mesh: &mut MeshBuilder, x0: f64, y0: f64, x1: f64, y1: f64, front: f64| {
            cuboid(
                mesh,
                &self.frame,
                (DVec3::new(x0, y0, -0.01), DVec3::new(x1, y1, front)),
                detail,
                ON_WALL,
            );
        };
        slab(mesh, x0 - 0.13, y0, x0, y1 + 0.13, 0.04);
        slab(mesh, x1, y0, x1 + 0.13, y1 + 0.13, 0.04);
        slab(mesh, x0, y1, x1, y1 + 0.13, 0.04);
        let middle = (x0 + x1) / 2.0;
        slab(
            mesh,
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
            mesh,
            &place,
            (x0 - 0.16, x1 + 0.16),
            &cap.map(DVec2::from),
            detail,
        );
    }

    /// Two open shutters with slats.
    pub(super) fn shutters(
        &self,
        mesh: &mut MeshBuilder,
        hole: Area,
        material: usize,
        detail: f64,
    ) {
        if detail < 0.3 {
            return;
        }
        mesh.material(material);
        let (wide, high) = (0.48, hole.y1 - hole.y0);
        for x in [hole.x0 - 0.15 - wide, hole.x1 + 0.15] {
            let slab =
                |mesh: &mut MeshBuilder, (ax, ay): (f64, f64), (bx, by): (f64, f64), front: f64| {
                    let lo = DVec3::new(x + ax, hole.y0 + ay, 0.02);
                    let hi = DVec3::new(x + bx, hole.y0 + by, front);
                    cuboid(mesh, &self.frame, (lo, hi), detail, ON_WALL);
                };
            slab(mesh, (0.0, 0.0), (0.05, high), 0.06);
            slab(mesh, (wide - 0.05, 0.0), (wide, high), 0.06);
            for y in [0.0, high / 2.0 - 0.03, high - 0.06] {
                slab(mesh, (0.05, y), (wide - 0.05, y + 0.06), 0.06);
            }
            slab(mesh, (0.05, 0.06), (wide - 0.05, high - 0.06), 0.025);
            self.slats(
                mesh,
                (x + 0.05, x + wide - 0.05),
                (hole.y0 + 0.06, hole.y0 + high - 0.06),
                detail,
            );
        }
    }

    fn slats(
        &self,
        mesh: &mut MeshBuilder,
        (x0, x1): (f64, f64),
        (y0, y1): (f64, f64),
        detail: f64,
    ) {
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
            moulding(mesh, &self.frame, (x0, x1), &slat.map(DVec2::from), detail);
        }
    }

    pub(super) fn door(&self, mesh: &mut MeshBuilder, hole: Area, detail: f64) {
        mesh.material(WOOD);
        let Area { x0, y0, x1, y1 } = hole;
        let slab = |mesh: &mut MeshBuilder, x0: f64, y0: f64, x1: f64, y1: f64, front: f64| {
            cuboid(
                mesh,
                &self.frame,
                (DVec3::new(x0, y0, -0.2), DVec3::new(x1, y1, front)),
                detail,
                ON_WALL,
            );
        };
        slab(mesh, x0, y0, x1, y1 - 0.4, -0.13);
        let middle = (x0 + x1) / 2.0;
        for (a, b) in [(x0 + 0.08, middle - 0.05), (middle + 0.05, x1 - 0.08)] {
            for (c, d) in [(0.15, 0.75), (0.87, 1.9)] {
                slab(mesh, a, y0 + c, b, y0 + d, -0.11);
                slab(
                    mesh,
                    a + 0.07,
                    y0 + c + 0.07,
                    b - 0.07,
                    y0 + d - 0.07,
                    -0.095,
                );
            }
        }
        mesh.material(LIT + 1);
        slab(mesh, x0, y1 - 0.36, x1, y1, -0.15);
        if detail > 0.8 {
            self.surround(mesh, Area::new(x0, y0, x1, y1), detail);
        }
        mesh.material(TRIM);
        let step = (
            DVec3::new(x0 - 0.2, 0.0, -0.1),
            DVec3::new(x1 + 0.2, 0.13, 0.4),
        );
        cuboid(mesh, &self.frame, step, detail, STANDING);
    }

    /// A slab on two brackets, with a railing of turned balusters.
    pub(super) fn balcony(&self, mesh: &mut MeshBuilder, hole: Area, detail: f64) {
        mesh.material(TRIM);
        let (x0, x1) = (hole.x0 - 0.3, hole.x1 + 0.3);
        let (floor, out) = (hole.y0 - 0.3, 0.72);
        let slab = |mesh: &mut MeshBuilder, lo: (f64, f64, f64), hi: (f64, f64, f64)| {
            cuboid(mesh, &self.frame, (lo.into(), hi.into()), detail, ALL);
        };
        slab(mesh, (x0, floor - 0.11, 0.0), (x1, floor, out));
        for x in [x0 + 0.12, x1 - 0.26] {
            slab(mesh, (x, floor - 0.36, 0.0), (x + 0.14, floor - 0.11, 0.2));
            slab(mesh, (x, floor - 0.23, 0.2), (x + 0.14, floor - 0.11, 0.45));
        }
        let rail = floor + 0.86;
        slab(mesh, (x0, rail, out - 0.11), (x1, rail + 0.07, out));
        slab(mesh, (x0, rail, 0.0), (x0 + 0.11, rail + 0.07, out - 0.11));
        slab(mesh, (x1 - 0.11, rail, 0.0), (x1, rail + 0.07, out - 0.11));
        if detail < 0.7 {
            return;
        }
        let baluster = |mesh: &mut MeshBuilder, x: f64, z: f64| {
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
            lathe(mesh, &place, &profile.map(DVec2::from), around, detail);
        };
        let count = 11;
        for k in 0..count {
            let x = x0 + 0.055 + (x1 - x0 - 0.11) * f64::from(k) / f64::from(count - 1);
            baluster(mesh, x, out - 0.055);
        }
        for k in 0..4 {
            let z = 0.08 + 0.15 * f64::from(k);
            baluster(mesh, x0 + 0.055, z);
            baluster(mesh, x1 - 0.055, z);
        }
    }

    /// An iron box of plants under a window.
    pub(super) fn flowers(&self, mesh: &mut MeshBuilder, hole: Area, dice: &mut Dice, detail: f64) {
        if dice.below(3) != 0 {
            return;
        }
        mesh.material(IRON);
        let corners = (
            DVec3::new(hole.x0, hole.y0, 0.0),
            DVec3::new(hole.x1, hole.y0 + 0.14, 0.17),
        );
        cuboid(mesh, &self.frame, corners, detail, ALL);
        for _ in 0..cells(40.0, detail) {
            mesh.material(if dice.below(7) == 0 {
                SHUTTER + 2
            } else {
                LEAF + dice.below(2)
            });
            let position = DVec3::new(
                dice.range(hole.x0, hole.x1),
                hole.y0 + 0.12 + 0.2 * dice.unit() * dice.unit(),
                0.1 + dice.range(-0.13, 0.16),
            );
            leaf(mesh, &self.frame, position, dice, 0.055);
        }
    }
}
