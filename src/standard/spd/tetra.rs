//! tetra (`tetra.c`): the tetrahedron of Mandelbrot and Norton, each of whose corners is a smaller
//! one.

use super::setup::{SKY, matte, prelude, surface, view};
use crate::builder::{SceneBuilder, StandardView};
use glam::{DVec3, dvec3};

/// Directions from a cube's centre to the corners that make a tetrahedron, in the original's order.
const CORNERS: [DVec3; 4] = [
    dvec3(-1.0, -1.0, 1.0),
    dvec3(-1.0, 1.0, -1.0),
    dvec3(1.0, -1.0, -1.0),
    dvec3(1.0, 1.0, 1.0),
];

/// The tetrahedron's faces, counter-clockwise from outside.
const FACES: [[usize; 3]; 4] = [[0, 1, 2], [3, 2, 1], [2, 3, 0], [1, 0, 3]];

pub(crate) fn generate(size: u32, builder: &mut dyn SceneBuilder) {
    let from = dvec3(1.022846, -3.177154, -2.174512);
    let target = dvec3(-0.004103, -0.004103, 0.216539);
    let view = StandardView {
        up: dvec3(-0.816497, -0.816497, 0.816497),
        ..view(from, target, 45.0, 512)
    };
    prelude(builder, SKY, &view, &[dvec3(2.0, -18.0, -5.0)]);
    surface(builder, matte(dvec3(1.0, 0.2, 0.2)));
    grow(builder, size, DVec3::ZERO, 1.0);
}

/// The tetrahedron in the cube of half side `half`.
fn grow(builder: &mut dyn SceneBuilder, levels: u32, center: DVec3, half: f64) {
    if levels <= 1 {
        let corners = CORNERS.map(|corner| center + corner * half);
        for face in FACES {
            builder.polygon(&face.map(|k| corners[k]));
        }
        return;
    }
    for corner in CORNERS {
        let center = center + corner * half / 2.0;
        grow(builder, levels - 1, center, half / 2.0);
    }
}
