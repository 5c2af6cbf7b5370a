//! Polygons to triangles.

use earcut::Earcut;
use earcut::utils3d::project3d_to_2d;
use glam::Vec3;

/// Triangles of a polygon, as indices into its corners, in its own winding. Concave and slightly non-planar polygons
/// are cut by ears; what has no area at all is fanned out, so that degenerate faces stay the file's own.
pub fn triangulate(points: &[Vec3]) -> Vec<[u32; 3]> {
    match points.len() {
        0..=2 => return Vec::new(),
        3 => return vec![[0, 1, 2]],
        4 if is_convex_quad(points) => return vec![[0, 1, 2], [0, 2, 3]],
        _ => {}
    }
    let corners: Vec<[f64; 3]> = points.iter().map(|p| p.as_dvec3().to_array()).collect();
    let mut flat = Vec::with_capacity(points.len());
    let mut indices: Vec<u32> = Vec::with_capacity((points.len() - 2) * 3);
    if project3d_to_2d(&corners, corners.len(), &mut flat) {
        Earcut::new().earcut(flat, &[], &mut indices);
    }
    if indices.is_empty() {
        return (2..points.len() as u32).map(|k| [0, k - 1, k]).collect();
    }
    let mut triangles: Vec<[u32; 3]> = indices
        .chunks_exact(3)
        .map(|t| [t[0], t[1], t[2]])
        .collect();
    // The cutter has a winding of its own.
    if area(points, &triangles).dot(newell(points)) < 0.0 {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    triangles
}

/// Whether the quad may be cut from its first corner: its two halves face the same way, and so do the other two.
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

    fn lifted(flat: &[(f32, f32)]) -> Vec<Vec3> {
        // A slanted plane, not through the origin.
        let (u, v) = (Vec3::new(1.0, 0.5, 0.0), Vec3::new(-0.2, 0.4, 1.0));
        flat.iter()
            .map(|&(x, y)| Vec3::splat(3.0) + u * x + v * y)
            .collect()
    }

    /// The triangles face the polygon's way, and their areas sum up to its own: nothing overlaps, nothing is missing.
    fn check(points: &[Vec3]) {
        let triangles = triangulate(points);
        let whole = newell(points);
        let mut sum = 0.0;
        for t in &triangles {
            let part = area(points, std::slice::from_ref(t));
            assert!(part.dot(whole) >= 0.0, "{t:?} faces away");
            sum += part.length();
        }
        assert!(
            (sum / whole.length() - 1.0).abs() < 1e-5,
            "{sum} of {whole}"
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
