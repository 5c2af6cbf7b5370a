//! Drapes: banners over the balustrades, curtains in the arches, and cloths across the court.

use super::layout::{BAY, GROUND, HALF, SEED, Storey, THICK, UPPER, Wing};
use super::palette::{CLOTH, CLOTHS};
use crate::modern::mesh_builder::{Grid, MeshBuilder};
use crate::modern::noise::{blend, fractal2, smoothstep};
use crate::modern::props::LocalFrame;
use glam::{DVec3, dvec2, dvec3};
use libm::{cos, sin};
use std::f64::consts::{PI, TAU};

/// A cloth with its place: its frame's x runs across it.
pub(super) struct Drape {
    frame: LocalFrame,
    fall: Fall,
    wide: f64,
    high: f64,
    colour: usize,
}

/// Shape in which a cloth falls.
#[derive(Clone, Copy)]
enum Fall {
    /// Down from a rail.
    Banner,
    /// Down from a rod and drawn aside, to the left (1) or to the right (-1).
    Curtain(f64),
    /// From wall to wall along the frame's z, sagging; the far end is this much higher.
    Swag(f64),
}

/// All drapes of a court.
pub(super) fn drapes(wings: &[Wing; 4]) -> Vec<Drape> {
    let mut all = Vec::new();
    for wing in wings {
        for bay in 0..wing.bays {
            let number = 3 * wing.number as usize + bay as usize;
            let x = BAY * f64::from(bay);
            // On the near wing they would hang before the eye.
            if bay % 2 == 0 && wing.number != 2 {
                let rail = wing
                    .frame
                    .moved(x + BAY / 2.0, UPPER.floor + 1.03, THICK - 0.1);
                all.push(banner(rail, number / 2));
            }
            let arch = wing.frame.moved(x, 0.0, -0.05);
            match bay % 2 {
                1 => all.extend(curtains(arch, &GROUND, number)),
                _ => all.extend(curtains(arch, &UPPER, number + 1)),
            }
        }
    }
    let long = wings[1].length();
    let swags = [(0u32, 0.7), (1, -0.6), (2, 0.8)];
    for (k, slant) in swags.into_iter().take(wings[1].bays as usize / 2 - 1) {
        let z = -long / 2.0 + 2.2 + 2.9 * f64::from(k);
        let corner = dvec3(-HALF + THICK, 8.35, z);
        all.push(Drape {
            frame: LocalFrame::upright(corner, DVec3::NEG_Z, DVec3::X),
            fall: Fall::Swag(slant),
            wide: 1.7,
            high: 2.0 * (HALF - THICK),
            colour: k as usize,
        });
    }
    all
}

fn banner(frame: LocalFrame, colour: usize) -> Drape {
    Drape {
        frame,
        fall: Fall::Banner,
        wide: 1.5,
        high: 2.7,
        colour,
    }
}

/// The two curtains of an arch.
fn curtains(arch: LocalFrame, storey: &Storey, colour: usize) -> [Drape; 2] {
    let edge = BAY / 2.0 - storey.arch + 0.02;
    let high = storey.spring - storey.floor + 0.1 - if storey.floor > 0.0 { 0.9 } else { 0.0 };
    [(edge, 1.0), (BAY - edge, -1.0)].map(|(x, side)| Drape {
        frame: arch.moved(x, storey.spring + 0.15, 0.0),
        fall: Fall::Curtain(side),
        wide: storey.arch,
        high,
        colour,
    })
}

impl Drape {
    /// Area of its cloth, which is wider than the opening.
    fn area(&self) -> f64 {
        1.6 * self.wide * self.high
    }

    /// Draws it with about this many triangles. Folds are at most as many as its quads can show.
    fn draw(&self, mesh: &mut MeshBuilder, triangles: f64) {
        let quads = (triangles / 2.0).max(4.0);
        let across = (quads * 1.6 * self.wide / self.high)
            .sqrt()
            .round()
            .max(2.0);
        let rows = (quads / across).round().max(1.0);
        mesh.material(CLOTH + self.colour % CLOTHS);
        let most = (across / 5.0).floor().max(1.0);
        mesh.grid(Grid::open(across as usize, rows as usize), |i, j| {
            let (u, v) = (i as f64 / across, j as f64 / rows);
            let p = match self.fall {
                Fall::Banner => self.banner(u, v, most.min(4.0)),
                Fall::Curtain(side) => self.curtain(side, u, v, most.min(7.0)),
                Fall::Swag(slant) => self.swag(slant, u, v, most.min(5.0)),
            };
            self.frame.point(p)
        });
    }

    /// Irregularity of this cloth, about -1/2 to 1/2.
    fn waver(&self, x: f64, y: f64) -> f64 {
        let o = self.frame.origin;
        let p = dvec2(x + o.x * 3.1 + o.z * 1.7, y + o.y);
        fractal2(SEED + 3, p, 3)
    }

    /// Over the rail, then down in folds that deepen; the lower edge ends in a point.
    fn banner(&self, u: f64, v: f64, folds: f64) -> DVec3 {
        let down = 1.0 - v;
        let turn = TAU * folds * u + 1.6 * self.waver(2.0 * u, 1.5 * down);
        let deep = 0.012 + 0.075 * smoothstep(0.08, 1.0, down);
        let over = smoothstep(0.0, 0.1, down);
        let x = self.wide * (u - 0.5) * (1.0 - 0.08 * down);
        let point = 0.38 * (1.0 - (2.0 * u - 1.0).abs()) * smoothstep(0.5, 1.0, down);
        let y = -self.high * (down - 0.06).max(0.0) - point - 0.03 * over;
        let clear = 0.26 * over + 0.36 * smoothstep(0.1, 0.32, down);
        let z = clear + deep * (1.0 + sin(turn)) + 0.1 * self.waver(u, down) * down;
        dvec3(x, y, z)
    }

    /// From a rod down to a cord that holds it aside, and wider again below.
    fn curtain(&self, side: f64, u: f64, v: f64, folds: f64) -> DVec3 {
        let down = 1.0 - v;
        let cord = 0.6;
        let drawn = if down < cord {
            blend(1.0, 0.2, smoothstep(-0.15, cord, down))
        } else {
            blend(0.2, 0.42, smoothstep(cord, 1.0, down))
        };
        // Right and left change places, so that both curtains face the court.
        let u = if side > 0.0 { u } else { 1.0 - u };
        let turn = TAU * folds * u + 1.8 * self.waver(2.0 * u, 1.3 * down);
        let deep = 0.05 + 0.075 * (1.0 - drawn);
        let x = side * self.wide * drawn * (u + 0.25 * (0.5 - u) * sin(PI * drawn).abs() * 0.2);
        // Toward the middle of the arch the cloth is longer above the cord: it sags.
        let sag = 0.22 * u * sin(PI * (down / cord).min(1.0)) * (1.0 - drawn);
        dvec3(x, -self.high * down - sag, deep * sin(turn))
    }

    /// A chain's curve from wall to wall with folds along it.
    fn swag(&self, slant: f64, u: f64, v: f64, folds: f64) -> DVec3 {
        let middle = 4.0 * v * (1.0 - v);
        let turn = TAU * folds * u + 1.4 * self.waver(2.0 * u, 3.0 * v);
        let wide = self.wide * (0.45 + 0.55 * sin(PI * v).max(0.0).sqrt());
        let edge = cos(PI * (u - 0.5));
        let y = slant * (v - 0.5) - middle * (0.75 + 0.3 * edge) + 0.11 * sin(turn);
        let x = wide * (u - 0.5) + 0.3 * self.waver(v * 2.0, 0.0);
        dvec3(x, y + 0.1 * self.waver(4.0 * v, 2.0 * u), self.high * v)
    }
}

/// Draws the drapes with this many triangles in all, each by its area.
pub(super) fn hang(mesh: &mut MeshBuilder, drapes: &[Drape], triangles: u64) {
    let end = mesh.triangles() + triangles;
    let mut area: f64 = drapes.iter().map(Drape::area).sum();
    for drape in drapes {
        let left = end.saturating_sub(mesh.triangles()) as f64;
        drape.draw(mesh, left * drape.area() / area);
        area -= drape.area();
    }
}
