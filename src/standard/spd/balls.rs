//! balls, the sphereflake (`balls.c`): nine spheres of a third of the radius stand on each sphere.

use super::rotation::{about, about_y, about_z};
use super::setup::{SKY, prelude, rectangle, shiny, surface, view};
use crate::builder::SceneBuilder;
use glam::{DMat3, DVec3, dvec3};
use std::f64::consts::PI;

/// A child's radius over its parent's.
const SHRINK: f64 = 1.0 / 3.0;

/// Cosine beyond which a direction counts as an axis; children's directions are shorter than 1 by
/// rounding.
const ALONG_Z: f64 = 0.9999;

pub(crate) fn generate(size: u32, builder: &mut dyn SceneBuilder) {
    let view = view(dvec3(2.1, 1.3, 1.7), DVec3::ZERO, 45.0, 512);
    let lights = [
        dvec3(4.0, 3.0, 2.0),
        dvec3(1.0, -4.0, 4.0),
        dvec3(-3.0, 1.0, 5.0),
    ];
    prelude(builder, SKY, &view, &lights);
    surface(builder, shiny(dvec3(1.0, 0.75, 0.33), [0.8, 0.0], 0.0, 1.0));
    builder.polygon(&rectangle(12.0, 12.0, -0.5));
    surface(builder, shiny(dvec3(1.0, 0.9, 0.7), [0.5, 0.5], 37.0, 1.0));
    let sphere = (DVec3::ZERO, 0.5);
    grow(builder, &directions(), size, sphere, DVec3::Z);
}

/// Adds a sphere that stands in `direction` on its parent, and all spheres that stand on it.
/// `children` are their directions where it stands along z.
fn grow(
    builder: &mut dyn SceneBuilder,
    children: &[DVec3; 9],
    levels: u32,
    (center, radius): (DVec3, f64),
    direction: DVec3,
) {
    builder.sphere(center, radius);
    if levels == 0 {
        return;
    }
    let turn = from_z_to(direction);
    let reach = radius * (1.0 + SHRINK);
    for &child in children {
        let child_center = turn * child * reach + center;
        let toward = (child_center - center) / reach;
        let sphere = (child_center, radius * SHRINK);
        grow(builder, children, levels - 1, sphere, toward);
    }
}

/// The rotation that takes +z to `direction`.
fn from_z_to(direction: DVec3) -> DMat3 {
    if direction.z >= ALONG_Z {
        DMat3::IDENTITY
    } else if direction.z <= -ALONG_Z {
        about_y(PI)
    } else {
        let axis = DVec3::Z.cross(direction).normalize();
        about(axis, libm::acos(direction.z))
    }
}

/// Directions from a sphere that stands along z to its nine children, unit vectors: three trios,
/// each a third of a turn from the last.
fn directions() -> [DVec3; 9] {
    let d = 1.0 / 2f64.sqrt();
    let trio = [dvec3(d, d, 0.0), dvec3(d, 0.0, -d), dvec3(0.0, d, -d)];
    let axis = dvec3(1.0, -1.0, 0.0).normalize();
    let raise = about(axis, libm::asin(2.0 / 6f64.sqrt()));
    std::array::from_fn(|k| {
        let turn = about_z((k / 3) as f64 * 2.0 * PI / 3.0);
        turn * (raise * trio[k % 3])
    })
}
