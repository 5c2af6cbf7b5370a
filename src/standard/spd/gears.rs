//! gears (`gears.c`): layers of meshing gears, whose faces are concave polygons of 144 corners.

use super::rotation::about_z;
use super::setup::{SKY, matte, prelude, rectangle, shiny, surface, view};
use crate::builder::{NffMaterial, SceneBuilder};
use glam::{DVec3, dvec3};
use std::f64::consts::PI;

/// Teeth of a gear.
const TEETH: usize = 36;
/// Angle of one tooth and the gap after it.
const TOOTH: f64 = 2.0 * PI / TEETH as f64;
/// Corners of a gear's face.
const CORNERS: usize = 4 * TEETH;
/// Ratio of a gear's radius to its space: less than 1, so that meshing gears do not touch.
const OUTER_EDGE: f64 = 0.995;
/// Part of the radius that the teeth take up.
const TOOTH_DEPTH: f64 = 1.0 - 0.9;
/// Largest thickness of a gear.
const THICKNESS: f64 = 0.1;

struct Gear {
    /// Center of the upper face.
    center: DVec3,
    /// Angle of the first tooth, radians.
    angle: f64,
    outer: f64,
    inner: f64,
    thickness: f64,
}

pub(crate) fn generate(size: u32, builder: &mut dyn SceneBuilder) {
    let view = view(dvec3(-1.1, -2.1, 2.6), DVec3::ZERO, 45.0, 512);
    let lights = [
        dvec3(2.0, 4.0, 4.0),
        dvec3(-2.0, 4.0, 3.0),
        dvec3(2.0, -2.5, 2.5),
        dvec3(-1.0, -4.0, 2.0),
        // A light just behind the eye.
        dvec3(-1.111, -2.121, 2.626),
    ];
    prelude(builder, SKY, &view, &lights);
    surface(builder, shiny(dvec3(1.0, 0.85, 0.7), [0.3, 0.6], 37.0, 0.0));
    builder.polygon(&rectangle(2.0, 2.0, 0.0));
    for z in 0..size {
        for y in 0..size {
            for x in 0..size {
                surface(builder, gear_material(x, y, z));
                gear_at(size, x, y, z).build(builder);
            }
        }
    }
}

/// The gear at a position of the grid, from the lower left of the top layer.
fn gear_at(size: u32, x: u32, y: u32, z: u32) -> Gear {
    let across = f64::from(size);
    let radius = 1.0 / (across - (across - 1.0) * TOOTH_DEPTH / 2.0);
    let first = -1.0 + radius;
    let step = radius * (2.0 - TOOTH_DEPTH);
    Gear {
        center: dvec3(
            first + f64::from(x) * step,
            first + f64::from(y) * step,
            1.0 - f64::from(z) / across,
        ),
        // Neighbours are turned by half a tooth, so that they mesh.
        angle: PI * f64::from((x + y + z) % 2) / TEETH as f64,
        outer: OUTER_EDGE * radius,
        inner: (1.0 - TOOTH_DEPTH) * radius,
        thickness: THICKNESS.min(1.0 / (2.0 * across)),
    }
}

/// A pseudorandom colour; about every fifth gear is of glass.
fn gear_material(x: u32, y: u32, z: u32) -> NffMaterial {
    let fraction = |number: u32, factor: f64| {
        let product = f64::from(number + 1) * factor / 7.0;
        0.01 + (product - product.floor())
    };
    let rgb = dvec3(
        fraction(x * 3 + y * 2 + z, 5.0),
        fraction(y * 3 + z * 2 + x, 3.0),
        fraction(z * 3 + x * 2 + y, 2.0),
    );
    let rgb = rgb / rgb.max_element();
    if !(x * 4 + y * 2 + z).is_multiple_of(5) {
        return matte(rgb);
    }
    NffMaterial {
        transmittance: 0.8,
        ..shiny(rgb, [0.2, 0.0], 0.0, 1.1)
    }
}

impl Gear {
    /// Upper face, sides, lower face.
    fn build(&self, builder: &mut dyn SceneBuilder) {
        let top = self.face(1.0, 0.0);
        builder.polygon(&top);
        let down = dvec3(0.0, 0.0, -self.thickness);
        for (k, &here) in top.iter().enumerate() {
            let next = top[(k + 1) % CORNERS];
            builder.polygon(&[here, here + down, next + down, next]);
        }
        builder.polygon(&self.face(-1.0, -self.thickness));
    }

    /// The corners, counter-clockwise (`turn` 1) or clockwise (−1) from above.
    fn face(&self, turn: f64, z: f64) -> [DVec3; CORNERS] {
        let outer = dvec3(self.outer, 0.0, z);
        let inner = dvec3(self.inner, 0.0, z);
        // The two corners of a tooth's tip and the two at the foot of the gap after it, in teeth
        // from its middle.
        let corners = [(-0.19, outer), (0.19, outer), (0.3, inner), (0.7, inner)];
        std::array::from_fn(|k| {
            let tooth = self.angle + turn * TOOTH * (k / 4) as f64;
            let (teeth, point) = corners[k % 4];
            about_z(tooth + teeth * turn * TOOTH) * point + self.center
        })
    }
}
