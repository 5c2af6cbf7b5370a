//! lattice (`lattice.c`, by Antonio Costa): shiny spheres joined by dull bars into a cubic lattice.

use super::setup::{SKY, prelude, shiny, surface, view};
use crate::builder::{SceneBuilder, StandardView};
use glam::{DVec3, dvec3};

/// Radius of a ball in a cell of size 1.
const BALL: f64 = 1.0 / 4.0;
/// Radius of a bar in a cell of size 1.
const BAR: f64 = 1.0 / 16.0;

pub(crate) fn generate(size: u32, builder: &mut dyn SceneBuilder) {
    let lights = [
        dvec3(2.0, 0.5, 0.5),
        dvec3(-1.0, 0.5, 0.5),
        dvec3(0.5, 2.0, 0.5),
        dvec3(0.5, -1.0, 0.5),
        dvec3(0.5, 0.5, 2.0),
        dvec3(0.5, 0.5, -1.0),
    ];
    prelude(builder, SKY, &view_of(size), &lights);
    for x in 0..=size {
        for y in 0..=size {
            for z in 0..=size {
                node(builder, size, [x, y, z]);
            }
        }
    }
}

fn view_of(size: u32) -> StandardView {
    let cells = f64::from(size);
    let x = (f64::from(size / 2) + 0.5) / cells;
    let half_cell = 1.0 / (2.0 * cells);
    let (from, target) = (
        dvec3(x, 1.0, 1.0 - half_cell),
        dvec3(x, -1.0, -1.0 - half_cell),
    );
    StandardView {
        up: dvec3(0.2, 1.0, 0.0),
        ..view(from, target, 60.0, 512)
    }
}

/// A ball and the bars that start at it.
fn node(builder: &mut dyn SceneBuilder, size: u32, cell: [u32; 3]) {
    let cells = f64::from(size);
    let [ball, bar] = [BALL, BAR].map(|radius| radius / cells);
    // The bars end a little inside of the balls.
    let inset = ball * (1.0 - (BAR / BALL).sqrt()) * 0.99;
    let center = DVec3::from_array(cell.map(|k| f64::from(k) / cells));
    surface(builder, shiny(DVec3::splat(0.9), [0.5, 0.5], 37.0, 0.0));
    builder.sphere(center, ball);
    for (axis, along) in DVec3::AXES.into_iter().enumerate() {
        if cell[axis] == size {
            continue;
        }
        let rgb = DVec3::splat(0.1) + along * 0.8;
        surface(builder, shiny(rgb, [0.99, 0.0], 0.0, 0.0));
        let far = center + along * (1.0 / cells - inset);
        builder.cone(center + along * inset, bar, far, bar);
    }
}
