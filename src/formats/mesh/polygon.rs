//! Triangulation of polygons.

use super::large_polygon;
use earcut::Earcut;
use earcut::utils3d::project3d_to_2d;
use glam::Vec3;

/// Number of corners beyond which ear clipping is not used, because it may take quadratic time.
const MAX_EARS: usize = 256;

/// Triangles of a polygon, as indices into its corners, in its own winding. Concave and slightly
/// non-planar polygons are cut by ears. Polygons of more than 256 corners are cut by a Delaunay
/// triangulation. A polygon without area is cut into a fan, so that degenerate faces stay as in the
/// file.
pub fn triangulate(points: &[Vec3]) -> Vec<[u32; 3]> {
    match points.len() {
        0..=2 => return Vec::new(),
        3 => return vec![[0, 1, 2]],
        4 if is_convex_quad(points) => return vec![[0, 1, 2], [0, 2, 3]],
        _ => {}
    }
    let mut triangles = if points.len() > MAX_EARS {
        large_polygon::triangulate(&flattened(points)).unwrap_or_default()
    } else {
        ears(points)
    };
    if triangles.is_empty() {
        return (2..points.len() as u32).map(|k| [0, k - 1, k]).collect();
    }
    // The ear cutter has a winding of its own.
    if area(points, &triangles).dot(newell(points)) < 0.0 {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    triangles
}

/// Triangles by cutting ears.
fn ears(points: &[Vec3]) -> Vec<[u32; 3]> {
    let corners: Vec<[f64; 3]> = points.iter().map(|p| p.as_dvec3().to_array()).collect();
    let mut flat = Vec::with_capacity(points.len());
    let mut indices: Vec<u32> = Vec::with_capacity((points.len() - 2) * 3);
    if project3d_to_2d(&corners, corners.len(), &mut flat) {
        Earcut::new().earcut(flat, &[], &mut indices);
    }
    let triangles = indices.chunks_exact(3);
    triangles.map(|t| [t[0], t[1], t[2]]).collect()
}

/// The polygon projected along the axis that it faces most. Unlike a rotation, this rounds nothing:
/// collinear corners stay collinear.
fn flattened(points: &[Vec3]) -> Vec<[f64; 2]> {
    let facing = newell(points).abs();
    let axis = facing.max_position();
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let flat = |p: &Vec3| [f64::from(p[u]), f64::from(p[v])];
    points.iter().map(flat).collect()
}

/// Returns true if the quad may be cut from its first corner: its two halves face the same way, and
/// so do the two halves of the other cut.
fn is_convex_quad(p: &[Vec3]) -> bool {
    let half = |a: usize, b: usize, c: usize| {
        let [a, b, c] = [p[a], p[b], p[c]].map(|p| p.as_dvec3());
        (b - a).cross(c - a)
    };
    half(0, 1, 2).dot(half(0, 2, 3)) > 0.0 && half(1, 2, 3).dot(half(1, 3, 0)) > 0.0
}

/// Twice the vector area (Newell).
fn newell(points: &[Vec3]) -> glam::DVec3 {
    let next = points.iter().cycle().skip(1);
    let origin = points[0].as_dvec3();
    points
        .iter()
        .zip(next)
        .map(|(a, b)| (a.as_dvec3() - origin).cross(b.as_dvec3() - origin))
        .sum()
}

fn area(points: &[Vec3], triangles: &[[u32; 3]]) -> glam::DVec3 {
    let corner = |k: u32| points[k as usize].as_dvec3();
    triangles
        .iter()
        .map(|&[a, b, c]| (corner(b) - corner(a)).cross(corner(c) - corner(a)))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::full_or::full_or;

    fn lifted(flat: &[(f32, f32)]) -> Vec<Vec3> {
        // A slanted plane that does not pass through the origin.
        let (u, v) = (Vec3::new(1.0, 0.5, 0.0), Vec3::new(-0.2, 0.4, 1.0));
        flat.iter()
            .map(|&(x, y)| Vec3::splat(3.0) + u * x + v * y)
            .collect()
    }

    /// Checks that the triangles face the same way as the polygon, and that their areas add up to
    /// its area, without overlaps or gaps.
    fn check(points: &[Vec3]) {
        let triangles = triangulate(points);
        let total = newell(points);
        let mut sum = 0.0;
        for t in &triangles {
            let part = area(points, std::slice::from_ref(t));
            // Slivers may face any way once their corners are rounded.
            let facing = part.dot(total) / total.length_squared();
            assert!(facing > -1e-9, "{t:?} faces away");
            sum += part.length();
        }
        assert!(
            (sum / total.length() - 1.0).abs() < 1e-5,
            "{sum} of {total}"
        );
    }

    #[test]
    fn concave_polygons_keep_their_area_and_side() {
        let arrow = [(0.0, 0.0), (4.0, 0.0), (1.0, 1.0), (0.0, 4.0)];
        check(&lifted(&arrow));
        let turned: Vec<_> = arrow.iter().cycle().skip(2).take(4).copied().collect();
        check(&lifted(&turned));
        let backward: Vec<_> = arrow.iter().rev().copied().collect();
        check(&lifted(&backward));
        let star: Vec<_> = (0..24)
            .map(|k| {
                let angle = f64::from(k) * std::f64::consts::TAU / 24.0;
                let r = if k % 2 == 0 { 1.0 } else { 0.4 };
                ((libm::cos(angle) * r) as f32, (libm::sin(angle) * r) as f32)
            })
            .collect();
        check(&lifted(&star));
        check(&lifted(&[(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)]));
    }

    fn ring(corners: usize, radius: impl Fn(usize) -> f64) -> Vec<(f32, f32)> {
        let place = |k: usize| {
            let angle = k as f64 * std::f64::consts::TAU / corners as f64;
            let r = radius(k);
            ((libm::cos(angle) * r) as f32, (libm::sin(angle) * r) as f32)
        };
        (0..corners).map(place).collect()
    }

    /// Outlines of about `many` corners each.
    fn outlines(many: usize) -> Vec<Vec<(f32, f32)>> {
        let all = |place: fn(usize) -> (f32, f32)| (0..many).map(place);
        let width = many as f32;
        let circle = ring(many, |_| 1.0);
        let star = ring(many, |k| if k % 2 == 0 { 1.0 } else { 0.4 });
        let arm = |r: f64| {
            (0..many / 2).map(move |k| {
                let (turn, r) = (k as f64 / 50.0, r + k as f64);
                ((libm::sin(turn) * r) as f32, (libm::cos(turn) * r) as f32)
            })
        };
        let spiral: Vec<_> = arm(100.0).chain(arm(200.0).rev()).collect();
        let comb = all(|k| (k as f32, if k % 4 < 2 { 0.0 } else { 9.0 }));
        let comb: Vec<_> = comb.chain([(width, -1.0), (0.0, -1.0)]).collect();
        let teeth = all(|k| (k as f32, (k % 2) as f32 / 64.0));
        let teeth: Vec<_> = teeth.chain([(width / 2.0, width)]).collect();
        let row: Vec<_> = all(|k| (k as f32, 0.0)).chain([(0.0, width)]).collect();
        let third = many / 3;
        let stacked = (0..many).map(|k| ((k / third) as f32, (k / (2 * third)) as f32));
        // A ring, cut open: the inner circle runs backward.
        let inside = ring(many, |_| 0.5).into_iter().chain([(0.5, 0.0)]);
        let inside: Vec<_> = inside.collect();
        let inside = inside.into_iter().rev();
        let open = circle.iter().chain(&circle[..1]).copied().chain(inside);
        let open = open.collect();
        vec![
            circle,
            star,
            spiral,
            comb,
            teeth,
            row,
            stacked.collect(),
            open,
        ]
    }

    /// Number of corners at which a time that grows with its square is noticed.
    fn many_corners() -> usize {
        full_or(30_000, 6000)
    }

    #[test]
    fn polygons_of_many_corners_are_cut() {
        for polygon in outlines(many_corners()) {
            check(&lifted(&polygon));
            let backward: Vec<_> = polygon.into_iter().rev().collect();
            check(&lifted(&backward));
        }
    }

    #[test]
    fn many_corners_without_area_or_in_a_tangle_come_to_an_end() {
        let mut seed = 1u32;
        let mut unit = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / (1 << 24) as f32
        };
        let many = many_corners();
        let tangle: Vec<(f32, f32)> = (0..many).map(|_| (unit(), unit())).collect();
        let line: Vec<_> = (0..many).map(|_| (unit(), 0.0)).collect();
        let few: Vec<_> = (0..many)
            .map(|_| ((unit() * 2.0).floor(), (unit() * 2.0).floor()))
            .collect();
        let one = vec![(1.0, 1.0); many];
        let spokes: Vec<_> = ring(many, |k| if k % 2 == 0 { 1.0 } else { 0.0 });
        for polygon in [tangle, line, few, one, spokes] {
            let triangles = triangulate(&lifted(&polygon));
            assert!((1..=many - 2).contains(&triangles.len()));
        }
    }

    /// Checks that each crossing costs a little of the outline and nothing else.
    #[test]
    fn small_crossings_of_a_large_outline_stay_small() {
        let mut coast = ring(20_000, |k| 1.0 + 0.1 * libm::sin(k as f64 * 0.01));
        for k in (100..20_000).step_by(400) {
            coast.swap(k, k + 1);
        }
        let points = lifted(&coast);
        let triangles = triangulate(&points);
        let parts = triangles
            .iter()
            .map(|t| area(&points, std::slice::from_ref(t)).length());
        let (sum, total) = (parts.sum::<f64>(), newell(&points).length());
        assert!((sum / total - 1.0).abs() < 1e-2, "{sum} of {total}");
    }

    #[test]
    fn what_has_no_area_is_fanned_out() {
        let line: Vec<Vec3> = (0..5).map(|k| Vec3::X * k as f32).collect();
        assert_eq!(triangulate(&line).len(), 3);
        assert_eq!(triangulate(&line[..2]), Vec::<[u32; 3]>::new());
    }

    #[test]
    fn a_quad_that_is_not_flat_keeps_its_corners() {
        let mut quad = lifted(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]);
        quad[2] += Vec3::Y * 0.2;
        assert_eq!(triangulate(&quad), [[0, 1, 2], [0, 2, 3]]);
    }
}
