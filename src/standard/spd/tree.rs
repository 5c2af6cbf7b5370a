//! tree (`tree.c`): Aono and Kunii's tree, each branch of which carries two more, on a green field.

use super::rotation::{about_x, about_z};
use super::setup::{SKY, matte, prelude, rectangle, surface, view};
use crate::builder::SceneBuilder;
use glam::{DAffine3, DVec3, dvec3};

/// Angle between a branch and its parent's axis, turn about that axis (degrees), and length over
/// the parent's.
const BRANCHES: [[f64; 3]; 2] = [[40.0, 90.0, 0.65], [25.0, 140.0 + 90.0, 0.70]];
/// Width of a branch's end over that of its start.
const TAPER: f64 = 0.67;
/// Radius of the trunk at its foot over its height.
const GIRTH: f64 = 0.15;

pub(crate) fn generate(size: u32, builder: &mut dyn SceneBuilder) {
    let view = view(dvec3(4.5, 0.4, 2.0), dvec3(0.0, 0.0, 1.5), 45.0, 512);
    let lights = [
        dvec3(-5.0, 5.0, 50.0),
        dvec3(30.0, -30.0, 30.0),
        dvec3(-40.0, -30.0, 20.0),
        dvec3(10.0, 30.0, 40.0),
        dvec3(-30.0, 40.0, 10.0),
        dvec3(50.0, 25.0, 20.0),
        dvec3(-10.0, -60.0, 30.0),
    ];
    prelude(builder, SKY, &view, &lights);
    surface(builder, matte(dvec3(0.2, 0.7, 0.2)));
    builder.polygon(&rectangle(50.0, 50.0, 0.0));
    surface(builder, matte(dvec3(0.55, 0.4, 0.2)));
    let forks = BRANCHES.map(|[bend, turn, length]| {
        let branch = about_z(turn.to_radians()) * about_x(bend.to_radians());
        DAffine3::from_mat3_translation(branch * length, DVec3::Z)
    });
    grow(builder, &forks, size, DAffine3::IDENTITY, 1.0);
}

/// A branch along the z axis of `frame`, and the branches on it.
fn grow(
    builder: &mut dyn SceneBuilder,
    forks: &[DAffine3; 2],
    levels: u32,
    frame: DAffine3,
    scale: f64,
) {
    let apex = frame.transform_point3(DVec3::Z);
    let radius = scale * GIRTH;
    builder.cone(frame.translation, radius, apex, radius * TAPER);
    builder.sphere(apex, radius * TAPER);
    if levels > 0 {
        for &fork in forks {
            grow(builder, forks, levels - 1, frame * fork, scale * TAPER);
        }
    }
}
