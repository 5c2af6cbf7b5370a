//! mount (`mount.c`): a fractal mountain by midpoint displacement, and four crystal balls above it.

use super::rotation::{about, about_z};
use super::setup::{SKY, matte, prelude, shiny, surface, view};
use crate::builder::{NffMaterial, SceneBuilder};
use glam::{DVec3, dvec3};
use std::f64::consts::PI;

/// Fractal dimension, between 2 (smooth) and 3 (rugged).
const FRACTAL_DIMENSION: f64 = 2.2;
/// Seed of the mountain.
const MOUNTAIN: i64 = 21;
/// Least x and y coordinate.
const CORNER: f64 = -1.0;
/// Extent along x and y.
const WIDTH: f64 = 2.0;
/// √2 as rounded in the original.
#[expect(
    clippy::approx_constant,
    reason = "the original's number makes the original's mountain"
)]
const DIAGONAL: f64 = 1.4142136;

pub(crate) fn generate(size: u32, builder: &mut dyn SceneBuilder) {
    let view = view(dvec3(-1.6, 1.6, 1.7), DVec3::ZERO, 45.0, 512);
    prelude(builder, SKY, &view, &[dvec3(-100.0, -100.0, 100.0)]);
    let crystal = NffMaterial {
        transmittance: 0.9,
        ..shiny(DVec3::ONE, [0.1, 0.1], 6.7, 1.5)
    };
    surface(builder, crystal);
    crystal_balls(builder, dvec3(-0.8, 0.8, 1.0), 0.17);
    surface(builder, matte(dvec3(0.5, 0.45, 0.35)));
    let ratio = 2.0 / libm::exp(libm::log(2.0) / (FRACTAL_DIMENSION - 1.0));
    let mountain = Mountain {
        size,
        cells: f64::from(1u32 << size),
        roughness: (ratio * ratio - 1.0).sqrt(),
    };
    mountain.grow(builder, 1 << size, [0, 0], [0.0; 4]);
}

/// Four spheres that touch each other, as the corners of a tetrahedron.
fn crystal_balls(builder: &mut dyn SceneBuilder, center: DVec3, radius: f64) {
    let top = dvec3(0.0, 0.0, radius * 1.5f64.sqrt());
    builder.sphere(center + top, radius);
    let axis = dvec3(1.0, 1.0, 0.0).normalize();
    let low = about(axis, libm::acos(-1.0 / 3.0)) * top;
    for third in 0..3 {
        let turn = about_z(f64::from(third) * 2.0 * PI / 3.0);
        builder.sphere(turn * low + center, radius);
    }
}

struct Mountain {
    size: u32,
    /// Number of cells along each side.
    cells: f64,
    /// Rise over half a side's length.
    roughness: f64,
}

impl Mountain {
    /// The square of `width` cells with `[x, y]` as its lower left cell. `z` has the heights of its
    /// corners, from the lower left one counter-clockwise.
    fn grow(&self, builder: &mut dyn SceneBuilder, width: u32, [x, y]: [u32; 2], z: [f64; 4]) {
        if width == 1 {
            return self.cell(builder, [x, y], z);
        }
        let half = width / 2;
        let rise = f64::from(half) * WIDTH / self.cells * self.roughness;
        let [ll, lr, ur, ul] = z;
        let lower = (ll + lr) / 2.0 + rise * self.random(x + half, y);
        let right = (lr + ur) / 2.0 + rise * self.random(x + width, y + half);
        let upper = (ur + ul) / 2.0 + rise * self.random(x + half, y + width);
        let left = (ul + ll) / 2.0 + rise * self.random(x, y + half);
        let middle = (ll + lr + ur + ul) / 4.0 + DIAGONAL * rise * self.random(x + half, y + half);
        let (right_x, upper_y) = (x + half, y + half);
        self.grow(builder, half, [x, y], [ll, lower, middle, left]);
        self.grow(builder, half, [right_x, y], [lower, lr, right, middle]);
        let upper_right = [middle, right, ur, upper];
        self.grow(builder, half, [right_x, upper_y], upper_right);
        self.grow(builder, half, [x, upper_y], [left, middle, upper, ul]);
    }

    /// Two triangles.
    fn cell(&self, builder: &mut dyn SceneBuilder, [x, y]: [u32; 2], z: [f64; 4]) {
        let coordinate = |k: u32| CORNER + f64::from(k) * WIDTH / self.cells;
        let [left, right, lower, upper] = [x, x + 1, y, y + 1].map(coordinate);
        let ll = dvec3(left, lower, z[0]);
        let lr = dvec3(right, lower, z[1]);
        let ur = dvec3(right, upper, z[2]);
        let ul = dvec3(left, upper, z[3]);
        builder.polygon(&[ll, lr, ur]);
        builder.polygon(&[ur, ul, ll]);
    }

    /// A normally distributed number that depends on the position only, so that neighbours agree on
    /// their common edges.
    fn random(&self, x: u32, y: u32) -> f64 {
        gauss(MOUNTAIN + hash(x, y, self.size))
    }
}

/// The hash of the 1987 article's mountain. It shows patterns at some sizes and uses `x` twice, but
/// a better hash would give a different mountain. A negative shift leaves no bits in the lower
/// sixteen, as on the original's 64-bit machines.
fn hash(x: u32, y: u32, size: u32) -> i64 {
    let shifted = |k: u32, shift: u32| {
        let shift = shift.checked_sub(size);
        shift.map_or(0, |shift| u64::from(k) << shift)
    };
    let sum = shifted(x, 23) + shifted(y, 15) + shifted(x, 7);
    (sum & 0xffff) as i64
}

/// A normally distributed number of mean 0 and variance 1 by the polar method over a congruential
/// generator (GASDEV of Numerical Recipes), restarted from each seed.
fn gauss(seed: i64) -> f64 {
    const MODULUS: i64 = 134_456;
    let next = |state: i64| (28_411 + state * 8121) % MODULUS;
    let signed = |state: i64| state as f64 * 2.0 * (1.0 / MODULUS as f64) - 1.0;
    let mut state = seed;
    loop {
        let first = next(state);
        state = next(first);
        let (a, b) = (signed(first), signed(state));
        let r = a * a + b * b;
        if r < 1.0 {
            return a * (-2.0 * libm::log(r) / r).sqrt();
        }
    }
}
