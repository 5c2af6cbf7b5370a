//! shells (`shells.c`): a seashell of overlapping spheres by Pickover's method (IEEE CG&A, November
//! 1989).

use super::setup::{SKY, prelude, shiny, surface, view};
use crate::builder::SceneBuilder;
use glam::dvec3;
use std::f64::consts::PI;

/// Growth of the radius with the angle.
const EXPONENT: f64 = 0.15;
/// Height over radius.
const BETA: f64 = -2.0;

pub(crate) fn generate(size: u32, builder: &mut dyn SceneBuilder) {
    let view = view(dvec3(-6.0, -60.0, 35.0), dvec3(0.0, 8.0, -15.0), 45.0, 512);
    prelude(builder, SKY, &view, &[dvec3(-100.0, -100.0, 100.0)]);
    surface(builder, shiny(dvec3(1.0, 0.8, 0.4), [0.8, 0.2], 10.0, 1.0));
    let steps = 180i32 << size;
    for step in -steps * 2 / 3..=steps / 3 {
        let angle = 18.0 * PI * f64::from(step) / f64::from(steps);
        let r = libm::exp(EXPONENT * angle);
        let (sin, cos) = libm::sincos(angle);
        builder.sphere(dvec3(r * sin, r * cos, BETA * r), r);
    }
}
