//! A trefoil of rope: millions of triangles in a small volume.

use super::mesh_builder::{Grid, MeshBuilder};
use super::noise::fractal3;
use super::props::on_circle;
use glam::{DVec2, DVec3, dvec3};
use libm::{cos, sin};
use std::f64::consts::TAU;

const SEED: u64 = 0x6010_5a7e;
/// Radii of the torus on which the knot winds: from the middle to the tube, and of the tube.
const WINDING: (f64, f64) = (0.31, 0.145);
/// Numbers of turns about the torus' axis and about its tube.
const TURNS: (f64, f64) = (2.0, 3.0);
/// Radius of the rope.
const ROPE: f64 = 0.098;

/// The trefoil: a rope of four strands along a torus knot, hammered a little.
pub(super) fn knot(mesh: &mut MeshBuilder, triangles: f64, middle: DVec3) {
    // The length of the rope is seven times its circumference.
    let around = (triangles / 14.0).max(9.0).sqrt().round() as usize;
    let along = (triangles / 2.0 / around as f64).round().max(8.0) as usize;
    let turn = |i: usize| TAU * i as f64 / around as f64;
    let circle: Vec<_> = (0..around)
        .map(|i| (turn(i), on_circle(i, around)))
        .collect();
    let mut row = usize::MAX;
    let mut points = Vec::new();
    mesh.grid(Grid::torus(around, along), |i, j| {
        if row != j {
            row = j;
            let rope = Rope::at(TAU * j as f64 / along as f64);
            points.clear();
            for circle in circle.chunks(LANES) {
                points.extend(rope.surface(circle).map(|p| middle + p));
            }
        }
        points[i]
    });
}

/// Number of points whose noise is computed at once.
const LANES: usize = 8;

/// A cross-section of the rope.
struct Rope {
    center: DVec3,
    /// Unit vectors: away from the torus, and across that and the rope.
    out: DVec3,
    across: DVec3,
    /// Angle by which the strands are turned.
    twist: f64,
}

impl Rope {
    fn at(turn: f64) -> Rope {
        let (large, small) = WINDING;
        let (p, q) = TURNS;
        let (sp, cp) = (sin(p * turn), cos(p * turn));
        let (sq, cq) = (sin(q * turn), cos(q * turn));
        let radius = large + small * cq;
        // The torus stands upright, its axis toward the eye.
        let center = dvec3(radius * sp, radius * cp, small * sq);
        let out = dvec3(cq * sp, cq * cp, sq);
        let around = dvec3(cp, -sp, 0.0) * (p * radius);
        let over = dvec3(-sq * sp, -sq * cp, cq) * (q * small);
        let along = around + over;
        Rope {
            center,
            out,
            across: along.cross(out) / along.length(),
            twist: turn * 24.0,
        }
    }

    /// Points of the surface, given as parts of a turn about the rope; at most [`LANES`].
    fn surface(&self, circle: &[(f64, DVec2)]) -> impl Iterator<Item = DVec3> {
        let mut round = [DVec3::ZERO; LANES];
        for (round, (_, on)) in round.iter_mut().zip(circle) {
            *round = (self.center + self.outward(*on) * ROPE) * 24.0;
        }
        let hammered = fractal3(SEED, round, 3);
        let points = circle.iter().zip(hammered);
        points.map(|(&turn_and_direction, hammered)| self.point(turn_and_direction, hammered))
    }

    /// The direction from the middle of the cross-section to a point of the circle.
    fn outward(&self, on: DVec2) -> DVec3 {
        self.out * on.x + self.across * on.y
    }

    fn point(&self, (turn, on): (f64, DVec2), hammered: f64) -> DVec3 {
        let outward = self.outward(on);
        // |cos| has its edges in the valleys between the strands.
        let strand = cos(2.0 * turn + self.twist * 0.5).abs();
        let radius = ROPE * (0.78 + 0.27 * strand.sqrt() + 0.022 * hammered);
        let local = self.center + outward * radius;
        // Turned a quarter toward the eye.
        let (sin, cos) = (0.5, 0.866_025_403_784_438_6);
        dvec3(
            local.x * cos + local.z * sin,
            local.y,
            local.z * cos - local.x * sin,
        )
    }
}
