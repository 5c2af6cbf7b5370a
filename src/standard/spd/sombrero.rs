//! sombrero (`sombrero.c`, by Alexander Enzmann): a damped cosine as a height field of triangles.

use super::setup::{SKY, prelude, shiny, surface, view};
use crate::builder::SceneBuilder;
use glam::{DVec3, dvec3};

/// Half extent of the field along x and z.
const HALF: f64 = 4.0;
/// The height of a value of 0.
const GROUND: f64 = -3.0;
/// 2π as rounded in the original.
#[expect(clippy::approx_constant, reason = "the original's number")]
const TURN: f64 = 2.0 * 3.14159265358;

pub(crate) fn generate(size: u32, builder: &mut dyn SceneBuilder) {
    let view = view(dvec3(0.0, 5.0, -8.0), DVec3::ZERO, 40.0, 512);
    prelude(builder, SKY, &view, &[dvec3(10.0, 10.0, -10.0)]);
    surface(builder, shiny(dvec3(1.0, 0.1, 0.1), [0.8, 0.0], 40.0, 1.0));
    let side = 16usize << size;
    let mut near = row(side, 0);
    for z in 1..side {
        let far = row(side, z);
        strip(builder, &near, &far);
        near = far;
    }
}

/// The points of a row of the grid. As in the original, heights are sampled slightly closer
/// together than they are placed, and rounded to single precision.
fn row(side: usize, z: usize) -> Vec<DVec3> {
    let sample = |k: usize| -HALF + k as f64 * (2.0 * HALF / side as f64);
    let coordinate = |k: usize| -HALF + k as f64 * (2.0 * HALF / (side - 1) as f64);
    let height = |x: usize| {
        let (a, b) = (sample(x), sample(z));
        let r = (a * a + b * b).sqrt();
        (libm::cos(TURN * r) * libm::exp(-r)) as f32
    };
    let point = |x| dvec3(coordinate(x), GROUND + f64::from(height(x)), coordinate(z));
    (0..side).map(point).collect()
}

/// The triangles between two rows.
fn strip(builder: &mut dyn SceneBuilder, near: &[DVec3], far: &[DVec3]) {
    for (near, far) in near.windows(2).zip(far.windows(2)) {
        builder.polygon(&[near[0], far[1], near[1]]);
        builder.polygon(&[near[0], far[0], far[1]]);
    }
}
