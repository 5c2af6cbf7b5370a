//! Turned and bent work: smooth outlines, surfaces of revolution with carving, rings, and beams.

use crate::modern::mesh_builder::Grid;
use crate::modern::props::{FramePoint, PartBuilder, on_circle};
use glam::{DVec2, DVec3, dvec3};
use std::f64::consts::TAU;

/// The same mesh and frame without detail: walls and boxes have two triangles per side.
pub(super) fn flat<'a, 'b>(parts: &'a mut PartBuilder<'_, 'b>) -> PartBuilder<'a, 'b> {
    parts.with_detail(0.0)
}

/// A radius that is not carved.
pub(super) fn plain(_: f64, _: f64) -> f64 {
    0.0
}

/// Length of a polygon.
pub(super) fn length<P: Copy + Into<DVec2>>(outline: &[P]) -> f64 {
    let sides = outline
        .windows(2)
        .map(|pair| pair[1].into() - pair[0].into());
    sides.map(DVec2::length).sum()
}

/// Points at equal distances on a smooth curve: the quadratic B-spline that a polygon controls. It
/// ends at the polygon's ends, and a corner given twice stays one.
pub(super) fn smooth(outline: &[(f64, f64)], rows: usize) -> Vec<DVec2> {
    const STEPS: usize = 8;
    let p: Vec<DVec2> = outline.iter().map(|&p| p.into()).collect();
    let last = p.len() - 1;
    let mut curve = vec![p[0]];
    for i in 1..last {
        let from = curve[curve.len() - 1];
        let to = if i + 1 == last { p[last] } else { (p[i] + p[i + 1]) / 2.0 };
        curve.extend((1..=STEPS).map(|step| {
            let t = step as f64 / STEPS as f64;
            let s = 1.0 - t;
            from * (s * s) + p[i] * (2.0 * s * t) + to * (t * t)
        }));
    }
    if last == 1 {
        curve.push(p[1]);
    }
    evenly(&curve, rows)
}

/// Points at equal distances on a polygon, its ends included.
fn evenly(curve: &[DVec2], rows: usize) -> Vec<DVec2> {
    let total = length(curve);
    let mut points = Vec::with_capacity(rows + 1);
    let (mut side, mut passed) = (0, 0.0);
    for row in 0..rows {
        let distance = total * row as f64 / rows as f64;
        let mut step = (curve[side + 1] - curve[side]).length();
        while passed + step < distance && side + 2 < curve.len() {
            passed += step;
            side += 1;
            step = (curve[side + 1] - curve[side]).length();
        }
        let t = if step > 0.0 { ((distance - passed) / step).min(1.0) } else { 0.0 };
        points.push(curve[side] + (curve[side + 1] - curve[side]) * t);
    }
    points.push(curve[curve.len() - 1]);
    points
}

/// Cosine and sine of equal parts of a turn.
pub(super) fn circle(around: usize) -> Vec<DVec2> {
    (0..around).map(|i| on_circle(i, around)).collect()
}

/// Draws a surface of revolution about the frame's y axis, from a smooth outline of (radius,
/// height) from the bottom to the top; it has at least `least` quads around and rows. `carved` adds
/// to the radius at (turn, share of the rows). A small top is closed.
pub(super) fn revolve(
    parts: &mut PartBuilder,
    outline: &[(f64, f64)],
    least: (usize, usize),
    carved: impl Fn(f64, f64) -> f64,
) {
    let widest = outline.iter().fold(0.0, |w: f64, p| w.max(p.0));
    let around = parts.cells(TAU * widest).max(least.0);
    let rows = parts.cells(length(outline)).max(least.1);
    let end = outline[outline.len() - 1];
    let closed = end.0 < 0.05;
    let triangles = 2 * around * rows + if closed { around } else { 0 };
    if parts.mesh.counted(triangles as u64) {
        return;
    }
    let (frame, circle) = (parts.frame, circle(around));
    let curve = smooth(outline, rows);
    let ring = |i: usize, j: usize| {
        let turn = TAU * i as f64 / around as f64;
        let radius = curve[j].x + carved(turn, j as f64 / rows as f64);
        let on = circle[i] * radius;
        frame.point(dvec3(on.x, curve[j].y, -on.y))
    };
    parts.mesh.grid(Grid::tube(around, rows), ring);
    if closed {
        let hub = frame.point(dvec3(0.0, end.1 + 0.3 * end.0, 0.0));
        parts.mesh.fan(hub, around, |i| ring(i, rows));
    }
}

/// Draws a ring of wire around the frame's z axis: an ellipse of these half axes in x and y.
pub(super) fn ring(
    parts: &mut PartBuilder,
    (wide, high): (f64, f64),
    wire: f64,
    (around, along): (usize, usize),
) {
    let frame = parts.frame;
    parts.mesh.grid(Grid::torus(around, along), |i, j| {
        let (on, tube) = (on_circle(j, along), on_circle(i, around) * wire);
        let (x, y) = ((wide + tube.x) * on.x, (high + tube.x) * on.y);
        frame.point(dvec3(x, y, -tube.y))
    });
}

/// Draws a beam of twelve triangles between two points, this thick across and this high.
pub(super) fn beam(parts: &mut PartBuilder, ends: [FramePoint; 2], (thick, high): (f64, f64)) {
    let [from, to] = ends.map(|end| parts.frame.point(end.into()));
    let along = (to - from).normalize();
    let side = if along.y.abs() > 0.9 { DVec3::X } else { along.cross(DVec3::Y).normalize() };
    let (side, up) = (side * (thick / 2.0), side.cross(along) * (high / 2.0));
    // Corners of a section, counter-clockwise as seen from the beam's end.
    let section = [side - up, side + up, -side + up, -side - up];
    for k in 0..4 {
        let (a, b) = (section[k], section[(k + 1) % 4]);
        parts.mesh.quad([from + a, to + a, to + b, from + b], 1, 1);
    }
    let [a, b, c, d] = section;
    let caps = [
        [to + d, to + c, to + b, to + a],
        [from + a, from + b, from + c, from + d],
    ];
    for cap in caps {
        parts.mesh.quad(cap, 1, 1);
    }
}

/// Draws a smooth moulding of (out, up) along the frame's x axis: long triangles from end to end.
pub(super) fn long_moulding(
    parts: &mut PartBuilder,
    extent: (f64, f64),
    outline: &[(f64, f64)],
    least: usize,
) {
    let rows = parts.cells(length(outline)).clamp(least, 48);
    if parts.mesh.counted(2 * rows as u64) {
        return;
    }
    let curve: Vec<_> = smooth(outline, rows).iter().map(|p| (p.x, p.y)).collect();
    flat(parts).moulding(extent, &curve);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modern::props::tests::volume;

    #[test]
    fn beams_and_rings_face_outward() {
        let timber = volume(8.0, |parts| {
            beam(parts, [(0.0, 0.0, 0.0), (3.0, 4.0, 0.0)], (0.5, 0.2))
        });
        assert!((timber - 0.5).abs() < 1e-5, "{timber}");
        let post = volume(8.0, |parts| {
            beam(parts, [(1.0, 0.0, 0.0), (1.0, 2.0, 0.0)], (0.5, 0.5))
        });
        assert!((post - 0.5).abs() < 1e-5, "{post}");
        let torus = volume(8.0, |parts| ring(parts, (1.0, 1.0), 0.1, (64, 256)));
        assert!(
            (torus - TAU * std::f64::consts::PI * 0.01).abs() < 1e-3,
            "{torus}"
        );
    }

    #[test]
    fn smooth_outlines_keep_ends_and_doubled_corners() {
        let points = smooth(&[(0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (1.0, 1.0)], 4);
        assert_eq!(points.len(), 5);
        assert_eq!((points[0], points[4]), (DVec2::ZERO, DVec2::ONE));
        assert!((points[2] - DVec2::X).length() < 0.02, "{points:?}");
    }
}
