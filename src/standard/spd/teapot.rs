//! teapot (`teapot.c`): Newell's teapot with Crow's bottom, on a checkerboard meshed as finely as
//! each of its patches.

use super::setup::{SKY, prelude, shiny, surface, view};
use super::teapot_data::{PATCHES, VERTICES};
use crate::builder::SceneBuilder;
use glam::{DVec3, dvec3};

/// Half extent of the checkerboard along x and y.
const BOARD: f64 = 4.0;
/// Distance from the z axis below which a vertex counts as the middle of the lid or of the bottom.
const CUSP: f64 = 0.0001;

/// Control points; the first index goes with s, the second with t.
type Patch = [[DVec3; 4]; 4];

pub(crate) fn generate(size: u32, builder: &mut dyn SceneBuilder) {
    let view = view(dvec3(4.86, 7.2, 5.4), DVec3::ZERO, 45.0, 512);
    let lights = [dvec3(-3.1, 9.8, 12.1), dvec3(11.3, 5.1, 8.8)];
    prelude(builder, SKY, &view, &lights);
    checkerboard(builder, size);
    let orange = dvec3(1.0, 0.5, 0.1);
    surface(builder, shiny(orange, [0.75, 0.25], 37.0, 0.0));
    for indices in PATCHES {
        let patch = indices.map(|row| row.map(|k| DVec3::from_array(VERTICES[k as usize])));
        build_patch(builder, &patch, size);
    }
}

/// All white squares, then all grey ones.
fn checkerboard(builder: &mut dyn SceneBuilder, size: u32) {
    for (odd, grey) in [(1, 1.0), (0, 0.5)] {
        surface(builder, shiny(DVec3::splat(grey), [0.5, 0.5], 30.0, 0.0));
        for x in 0..size {
            for y in (0..size).filter(|y| (x + y) % 2 == odd) {
                builder.polygon(&square(size, x, y));
            }
        }
    }
}

fn square(size: u32, x: u32, y: u32) -> [DVec3; 4] {
    let coordinate = |k: u32| BOARD * (2.0 * f64::from(k) / f64::from(size) - 1.0);
    let [left, right, low, high] = [x, x + 1, y, y + 1].map(coordinate);
    [(left, low), (right, low), (right, high), (left, high)].map(|(x, y)| dvec3(x, y, 0.0))
}

fn build_patch(builder: &mut dyn SceneBuilder, patch: &Patch, size: u32) {
    for s in 0..size {
        for t in 0..size {
            let corners = [[s, t], [s, t + 1], [s + 1, t + 1], [s + 1, t]];
            let point = corners.map(|corner| {
                let [s, t] = corner.map(|k| f64::from(k) / f64::from(size));
                point_and_normal(patch, s, t)
            });
            for [a, b, c] in [[0, 1, 2], [2, 3, 0]] {
                let mut triangle = [point[a], point[b], point[c]];
                if mend_cusp(&mut triangle) {
                    builder.patch(&triangle);
                }
            }
        }
    }
}

/// The surface at (s, t) in \[0, 1\]² and its unit normal; zero if the patch has none.
fn point_and_normal(patch: &Patch, s: f64, t: f64) -> (DVec3, DVec3) {
    let along_t = |basis: [f64; 4]| patch.map(|row| combine(row, basis));
    let at_t = along_t(bernstein(t));
    let point = combine(at_t, bernstein(s));
    let s_tangent = combine(at_t, bernstein_slope(s));
    let t_tangent = combine(along_t(bernstein_slope(t)), bernstein(s));
    (point, t_tangent.cross(s_tangent).normalize_or_zero())
}

fn combine(points: [DVec3; 4], weights: [f64; 4]) -> DVec3 {
    let [a, b, c, d] = points;
    a * weights[0] + b * weights[1] + c * weights[2] + d * weights[3]
}

/// The cubic Bernstein polynomials.
fn bernstein(t: f64) -> [f64; 4] {
    let u = 1.0 - t;
    [u * u * u, 3.0 * t * u * u, 3.0 * t * t * u, t * t * t]
}

/// The derivatives of the cubic Bernstein polynomials.
fn bernstein_slope(t: f64) -> [f64; 4] {
    let u = 1.0 - t;
    let (first, middle, last) = (3.0 * u * u, 6.0 * t * u, 3.0 * t * t);
    [-first, first - middle, middle - last, last]
}

/// Assigns a vertical normal to the middle of the lid or the bottom, where the patches have none.
/// Returns false for a triangle that has collapsed there.
fn mend_cusp(triangle: &mut [(DVec3, DVec3); 3]) -> bool {
    let on_axis = |p: DVec3| p.x.abs() <= CUSP && p.y.abs() <= CUSP;
    let mut cusps = triangle.iter_mut().filter(|(point, _)| on_axis(*point));
    if let Some((point, normal)) = cusps.next() {
        *normal = if point.z > 1.5 { DVec3::Z } else { -DVec3::Z };
    }
    cusps.next().is_none()
}
