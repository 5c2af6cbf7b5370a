//! jacks (`jacks.c`): a jack of three bars with balls at their ends, and a smaller copy in each
//! octant.

use super::rotation::{about_x, about_y};
use super::setup::{prelude, shiny, surface, view};
use crate::builder::{SceneBuilder, StandardView};
use glam::{DAffine3, DVec3, dvec3};

/// Size of a jack in its cell, so that it does not touch its neighbours.
const FIT: f64 = 0.75;
/// Radius of the bars of a jack of size 1.
const BAR: f64 = 0.1;
/// Radius of the balls of a jack of size 1.
const BALL: f64 = 0.2;

pub(crate) fn generate(size: u32, builder: &mut dyn SceneBuilder) {
    let view = StandardView {
        up: DVec3::Y,
        ..view(dvec3(0.0, 0.0, -8.0), DVec3::ZERO, 25.0, 256)
    };
    let light = dvec3(-10.0, 3.0, -20.0);
    prelude(builder, dvec3(0.2, 0.05, 0.2), &view, &[light]);
    let pink = dvec3(0.737, 0.561, 0.561);
    surface(builder, shiny(pink, [0.7, 0.7], 20.0, 1.0));
    let turn = about_x((-30f64).to_radians()) * about_y((-20f64).to_radians());
    grow(builder, size, DAffine3::from_mat3(turn), 1.0);
}

/// Adds a jack and its eight copies, `levels` deep; `scale` is the factor of `frame` on lengths.
fn grow(builder: &mut dyn SceneBuilder, levels: u32, frame: DAffine3, scale: f64) {
    jack(builder, frame, scale);
    if levels <= 1 {
        return;
    }
    let halves = [-0.5, 0.5];
    for x in halves {
        for y in halves {
            for z in halves {
                let octant = DAffine3::from_translation(dvec3(x, y, z))
                    * DAffine3::from_scale(DVec3::splat(0.5));
                grow(builder, levels - 1, frame * octant, scale * 0.5);
            }
        }
    }
}

fn jack(builder: &mut dyn SceneBuilder, frame: DAffine3, scale: f64) {
    let axes = DVec3::AXES.map(|axis| axis * FIT);
    let scale = scale * FIT;
    for axis in axes {
        let ends = [-axis, axis].map(|end| frame.transform_point3(end));
        builder.cone(ends[0], BAR * scale, ends[1], BAR * scale);
    }
    for side in [1.0, -1.0] {
        for axis in axes {
            builder.sphere(frame.transform_point3(axis * side), BALL * scale);
        }
    }
}
