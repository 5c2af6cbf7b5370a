//! Objects in the lane, and its pavement.

use super::stone::{leaf, stone, stone_triangles};
use super::{BULB, COBBLE, HALF, IRON, KERB, LEAF, SEED, START, TABLE, WOOD};
use crate::standard::modern::geodesic;
use crate::standard::modern::mesh_builder::MeshBuilder;
use crate::standard::modern::noise::{Dice, fractal2};
use crate::standard::modern::props::{ALL, LocalFrame, STANDING, cells, cuboid, lathe, rod};
use glam::{DVec2, DVec3};

/// A lamp post.
pub(super) struct Post {
    x: f64,
    z: f64,
}

pub(super) const LAMPS: [Post; 3] = [
    Post { x: 2.75, z: 2.6 },
    Post { x: -2.75, z: -4.4 },
    Post { x: 2.75, z: -11.5 },
];

/// Height of a lantern's middle.
const LANTERN: f64 = 3.32;
/// Distance of the kerbs from the middle of the lane.
const KERB_AT: f64 = 2.3;
/// Height of the footways above the road.
const STEP: f64 = 0.1;

impl Post {
    /// Position of its light: under the lantern's roof, with nothing below.
    pub(super) fn light(&self) -> DVec3 {
        DVec3::new(self.x, LANTERN, self.z)
    }

    fn build(&self, mesh: &mut MeshBuilder, detail: f64) {
        let place = LocalFrame::at(DVec3::new(self.x, STEP, self.z));
        let around = cells(0.8, detail).clamp(6, 96);
        mesh.material(IRON);
        let profile = [
            (0.16, 0.0),
            (0.16, 0.1),
            (0.11, 0.16),
            (0.1, 0.5),
            (0.13, 0.54),
            (0.06, 0.62),
            (0.05, 1.4),
            (0.075, 1.44),
            (0.045, 1.5),
            (0.035, 2.7),
            (0.06, 2.75),
            (0.03, 2.8),
            (0.03, 2.95),
            (0.11, 3.02),
        ];
        lathe(mesh, &place, &profile.map(DVec2::from), around, detail);
        let roof = [
            (0.24, 3.42),
            (0.18, 3.5),
            (0.06, 3.56),
            (0.03, 3.66),
            (0.0, 3.68),
        ];
        lathe(mesh, &place, &roof.map(DVec2::from), 6, detail);
        for k in 0..6 {
            let side = place.turned(60.0 * f64::from(k) + 30.0);
            let (foot, head) = (DVec3::new(0.11, 3.02, 0.0), DVec3::new(0.21, 3.42, 0.0));
            rod(
                mesh,
                (side.point(foot), side.point(head)),
                0.011,
                4,
                cells(0.4, detail),
            );
        }
        mesh.material(BULB);
        let frequency = cells(0.15, detail).max(1);
        // Below the light, so that light reaches the ground at a distance and all sides.
        let center = place.point(DVec3::new(0.0, LANTERN - STEP - 0.14, 0.0));
        geodesic::sphere(mesh, frequency, |p| center + p * 0.085);
    }
}

pub(super) fn furnish(mesh: &mut MeshBuilder, length: f64, detail: f64) {
    let end = START - length;
    for post in LAMPS.iter().filter(|post| post.z > end) {
        post.build(mesh, detail);
    }
    kerbs(mesh, end, detail);
    garland(mesh, 0.6, detail);
    if length > 8.0 {
        garland(mesh, -6.0, detail);
    }
    bed(mesh, end);
    bench(
        mesh,
        &LocalFrame::at(DVec3::new(3.1, STEP, -1.0)).turned(-90.0),
        detail,
    );
    for (x, z) in [(-3.05, 0.35), (-3.05, 6.6), (3.15, -3.2)] {
        if z > end {
            shrub(mesh, DVec3::new(x, STEP, z), detail);
        }
    }
}

/// The earth under everything, visible between the stones.
fn bed(mesh: &mut MeshBuilder, end: f64) {
    mesh.material(IRON);
    let at = |x: f64, z: f64| DVec3::new(x, -0.04, z);
    let (wide, near) = (HALF + 0.3, START + 4.2);
    mesh.quad(
        [
            at(-wide, near),
            at(wide, near),
            at(wide, end),
            at(-wide, end),
        ],
        1,
        1,
    );
}

/// Kerbs and footways.
fn kerbs(mesh: &mut MeshBuilder, end: f64, detail: f64) {
    mesh.material(KERB);
    let near = START + 4.0;
    for side in [-1.0, 1.0] {
        let (inner, outer) = (KERB_AT * side, (HALF + 0.3) * side);
        let (lo, hi) = (f64::min(inner, outer), f64::max(inner, outer));
        let slabs = cells((near - end) / 1.2, 1.0);
        let step = (near - end) / slabs as f64;
        for k in 0..slabs {
            let z = end + step * k as f64;
            let corners = (
                DVec3::new(lo, -0.05, z + 0.006),
                DVec3::new(hi, STEP, z + step - 0.006),
            );
            cuboid(
                mesh,
                &LocalFrame::at(DVec3::ZERO),
                corners,
                detail,
                STANDING,
            );
        }
    }
}

/// A string of small lamps across the lane.
fn garland(mesh: &mut MeshBuilder, z: f64, detail: f64) {
    let spans = 14;
    let at = |k: i32| {
        let t = f64::from(k) / f64::from(spans);
        let sag = 4.0 * t * (1.0 - t) * 0.75;
        DVec3::new(HALF * (2.0 * t - 1.0), 5.15 - sag, z + 0.5 * t)
    };
    for k in 0..spans {
        mesh.material(IRON);
        rod(mesh, (at(k), at(k + 1)), 0.008, 4, cells(0.5, detail));
        if k > 0 {
            mesh.material(BULB);
            let frequency = cells(0.1, detail).max(1);
            geodesic::sphere(mesh, frequency, |p| at(k) - DVec3::Y * 0.06 + p * 0.05);
        }
    }
}

fn bench(mesh: &mut MeshBuilder, place: &LocalFrame, detail: f64) {
    mesh.material(IRON);
    let slab = |mesh: &mut MeshBuilder, lo: (f64, f64, f64), hi: (f64, f64, f64)| {
        cuboid(mesh, place, (lo.into(), hi.into()), detail, ALL);
    };
    for x in [-0.75, 0.69] {
        slab(mesh, (x, 0.0, -0.22), (x + 0.06, 0.42, -0.16));
        slab(mesh, (x, 0.0, 0.16), (x + 0.06, 0.42, 0.22));
        slab(mesh, (x, 0.42, -0.26), (x + 0.06, 0.86, -0.2));
    }
    mesh.material(WOOD);
    for k in 0..4 {
        let z = -0.2 + 0.115 * f64::from(k);
        slab(mesh, (-0.85, 0.42, z), (0.85, 0.455, z + 0.085));
    }
    for k in 0..3 {
        let y = 0.53 + 0.12 * f64::from(k);
        slab(mesh, (-0.85, y, -0.2), (0.85, y + 0.085, -0.17));
    }
}

/// A round bush in a tub.
fn shrub(mesh: &mut MeshBuilder, foot: DVec3, detail: f64) {
    let place = LocalFrame::at(foot);
    mesh.material(TABLE);
    let tub = [
        (0.17, 0.0),
        (0.23, 0.4),
        (0.25, 0.4),
        (0.25, 0.45),
        (0.21, 0.45),
        (0.21, 0.41),
        (0.0, 0.4),
    ];
    lathe(
        mesh,
        &place,
        &tub.map(DVec2::from),
        cells(1.5, detail).clamp(8, 96),
        detail,
    );
    let mut dice = Dice::of(SEED + 5, (foot.z * 16.0) as i64 as u64);
    for _ in 0..cells(260.0, detail) {
        let mut side = || dice.range(-1.0, 1.0);
        let p = DVec3::new(side(), side(), side());
        let outward = p / (p.length() + 1e-9);
        let reach = 0.33 * (1.0 + 0.35 * fractal2(SEED, DVec2::new(p.x + p.z, p.y) * 2.0, 2));
        mesh.material(LEAF + dice.below(2));
        let center = DVec3::new(0.0, 0.78, 0.0) + outward * (reach * dice.range(0.75, 1.0));
        leaf(mesh, &place, center, &mut dice, 0.05);
    }
}

/// Paves the road with stones of about this many triangles in all.
pub(super) fn pave(mesh: &mut MeshBuilder, length: f64, triangles: u64) {
    let (wide, near) = (2.0 * KERB_AT, START + 4.0);
    let long = length + 4.0;
    // Stones have a least size; beyond it they become rounder instead.
    let most = wide * long / (0.11 * 0.13);
    let inner = (1..200).find(|inner| triangles as f64 / stone_triangles(*inner) as f64 <= most);
    let inner = inner.unwrap_or(200);
    let count = (triangles as f64 / stone_triangles(inner) as f64).max(1.0);
    let columns = (count * wide / long * 1.18).sqrt().round().max(1.0);
    let rows = (count / columns).round().max(1.0);
    if mesh.counted((columns * rows) as u64 * stone_triangles(inner)) {
        return;
    }
    let size = DVec2::new(wide / columns, long / rows);
    // The road's x and z, and z up.
    let road = LocalFrame {
        origin: DVec3::new(-KERB_AT, 0.0, near),
        axes: [DVec3::X, DVec3::NEG_Z, DVec3::Y],
    };
    for row in 0..rows as u64 {
        let mut dice = Dice::of(SEED + 3, row);
        let shift = if row % 2 == 0 { 0.25 } else { -0.25 };
        for column in 0..columns as u64 {
            let x = size.x * (column as f64 + shift);
            let y = size.y * row as f64;
            mesh.material(COBBLE + dice.below(3));
            let sunk = 0.012 * fractal2(SEED + 4, DVec2::new(x, y) * 0.9, 2) - 0.006 * dice.unit();
            let depth = 0.22 * size.x.min(0.12);
            stone(
                mesh,
                &road,
                DVec3::new(x, y, sunk - depth),
                size,
                (0.16, depth),
                inner,
            );
        }
    }
}
