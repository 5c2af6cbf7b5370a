//! rings (`rings.c`): a pyramid of dodecahedral knots, each of six pentagonal rings of cylinders
//! and spheres.

use super::rotation::{about_x, about_z};
use super::setup::{SKY, matte, prelude, shiny, surface, view};
use crate::builder::SceneBuilder;
use glam::{DVec3, dvec3};
use std::f64::consts::PI;

/// Radius of cylinders and spheres, so that linked rings touch (the original gives no derivation).
const RADIUS: f64 = 0.07412;

/// Red, green, blue and their complements.
const COLORS: [DVec3; 6] = [
    DVec3::X,
    DVec3::Y,
    DVec3::Z,
    dvec3(0.0, 1.0, 1.0),
    dvec3(1.0, 0.0, 1.0),
    dvec3(1.0, 1.0, 0.0),
];

pub(crate) fn generate(size: u32, builder: &mut dyn SceneBuilder) {
    let spread = 1.0 / libm::sin(PI / 8.0);
    let from = dvec3(-1.0, -spread, 0.5);
    let lights = [
        dvec3(3.0, -spread, 3.0),
        dvec3(-4.0, -spread, 1.0),
        dvec3(2.0, -spread, -4.0),
    ];
    let view = view(from, from + DVec3::Y, 45.0, 512);
    prelude(builder, SKY, &view, &lights);
    surface(builder, matte(DVec3::ONE));
    wall(builder, from, spread * f64::from(size + 1));
    let knot = knot();
    for depth in 0..size {
        // Positions of a layer are two apart and lie about the axis.
        let across = |k: u32| 2.0 * f64::from(k) - f64::from(depth);
        for z in 0..=depth {
            for x in 0..=depth {
                let offset = dvec3(across(x), spread * f64::from(depth + 1), across(z));
                build_knot(builder, &knot, offset);
            }
        }
    }
}

/// The backdrop at `y`: as large as the view of 45 degrees, plus one percent.
fn wall(builder: &mut dyn SceneBuilder, from: DVec3, y: f64) {
    let half = 1.01 * (y - from.y) * libm::tan(PI / 8.0);
    let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
    builder.polygon(&corners.map(|(x, z)| dvec3(x * half + from.x, y, z * half + from.z)));
}

/// The corners of six pentagons that join the midpoints of a dodecahedron's edges, within a sphere
/// of radius 1.
fn knot() -> [DVec3; 30] {
    let scale = 1.0 / (1.0 + RADIUS);
    let corner = |k: usize| {
        let (sin, cos) = libm::sincos(k as f64 * 2.0 * PI / 5.0);
        dvec3(scale * cos, scale * sin, 0.0)
    };
    // The angle between adjacent faces of a dodecahedron.
    let tilt = about_x(2.0 * libm::acos(libm::cos(PI / 3.0) / libm::sin(PI / 5.0)));
    std::array::from_fn(|k| match k / 5 {
        0 => corner(k),
        ring => about_z(PI * (2.0 * (ring - 1) as f64 + 1.0) / 5.0) * (tilt * corner(k % 5)),
    })
}

fn build_knot(builder: &mut dyn SceneBuilder, knot: &[DVec3; 30], offset: DVec3) {
    for (ring, color) in knot.chunks_exact(5).zip(COLORS) {
        surface(builder, shiny(color, [0.5, 0.2], 37.0, 0.0));
        for (k, &corner) in ring.iter().enumerate() {
            let (base, apex) = (corner + offset, ring[(k + 4) % 5] + offset);
            builder.cone(base, RADIUS, apex, RADIUS);
            builder.sphere(base, RADIUS);
        }
    }
}
