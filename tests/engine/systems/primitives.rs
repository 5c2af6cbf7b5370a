//! "Ray-sphere intersection" and "Ray-triangle intersection".

use super::{assert_near, scene, shot};
use crate::common::rays::{Engines, toward};
use crate::common::rng::Rng;
use crate::common::scenes;
use crate::common::tolerances::{
    BARYCENTRIC, ELLIPSOID_DISTANCE, FAR_SPHERE, ON_AN_ELLIPSOID, RADIANCE,
};
use glam::{DVec3, Vec3};
use phalanx::bvh::Bvh;
use phalanx::oracle::{OracleHit, OracleRay, TwoLevelBvh};
use phalanx::scene::Scene;

/// The hit on which brute force, the oracle's tree and the packet engine agree.
fn closest(scene: &Scene, ray: &OracleRay) -> Option<OracleHit> {
    let (tree, bvh) = (TwoLevelBvh::build(scene), Bvh::build(scene));
    Engines::new(scene, &tree, &bvh).closest(ray)
}

fn ball(center: Vec3, radius: f32) -> Scene {
    let mut scene = scenes::bare();
    scene.add_sphere(center, radius, 0);
    scene
}

fn distance(scene: &Scene, ray: &OracleRay) -> Option<f32> {
    closest(scene, ray).map(|hit| hit.t)
}

#[test]
fn ray_sphere() {
    let unit = ball(Vec3::ZERO, 1.0);
    let down = |x: f32, z: f32| OracleRay::new(Vec3::new(x, 0.0, z), -Vec3::Z);
    assert_eq!(distance(&unit, &down(0.0, 5.0)), Some(4.0));
    assert_eq!(distance(&unit, &down(0.6, 5.0)), Some(4.2));
    // A direction twice as long: half the distance. Away from it: nothing.
    assert_eq!(
        distance(&unit, &OracleRay::new(Vec3::Z * 5.0, -Vec3::Z * 2.0)),
        Some(2.0)
    );
    assert_eq!(
        distance(&unit, &OracleRay::new(Vec3::Z * 5.0, Vec3::Z)),
        None
    );
    // From inside, the far side.
    assert_eq!(distance(&unit, &down(0.0, 0.5)), Some(1.5));
    assert_eq!(distance(&unit, &down(0.0, 0.0)), Some(1.0));
    // Tangent, and just past it.
    assert_eq!(distance(&unit, &down(1.0, 5.0)), Some(5.0));
    assert_eq!(distance(&unit, &down(1.0 + 1e-6, 5.0)), None);
    // Behind the origin.
    assert_eq!(distance(&unit, &down(0.0, -5.0)), None);
    far_and_small_spheres();
    ellipsoid_distances_and_normals();
}

/// Cancellation of b² − 4ac: a sphere a hundred to 300,000 radii away, hit off-centre.
fn far_and_small_spheres() {
    let mut rng = Rng::new(43);
    for _ in 0..500 {
        let radius = rng.magnitude(-3.0, 1.0);
        let away = radius * rng.magnitude(2.0, 5.5);
        let center = rng.direction() * away;
        let sphere = ball(center, radius);
        // Through a point half a radius off the centre.
        let across = rng.direction().cross(center).normalize();
        let ray = toward(Vec3::ZERO, center + across * 0.5 * radius);
        let (c, d) = (center.as_dvec3(), ray.dir.as_dvec3());
        let along = c.dot(d) / d.length();
        let apart = c.length_squared() - along * along;
        let r = f64::from(radius);
        let allowed = FAR_SPHERE * c.length();
        let want = along - (r * r - apart).sqrt();
        let t = distance(&sphere, &ray);
        let error = t.map(|t| (f64::from(t) * d.length() - want).abs());
        assert!(
            error.is_some_and(|e| e <= allowed),
            "{ray:?}, {center} {radius}: {t:?}, {error:?}"
        );
    }
}

/// An ellipsoid of axes 2, 1, 0.5 under a rotation: its normal is the rotated gradient (x/a², y/b²,
/// z/c²).
fn ellipsoid_distances_and_normals() {
    let axes = DVec3::new(2.0, 1.0, 0.5);
    let mut rng = Rng::new(44);
    for _ in 0..50 {
        // Seen from a point 4 away, along the gradient's plane or not: any direction through a
        // point inside.
        let eye = rng.direction() * 4.0;
        let center = rng.point(0.3);
        let light = rng.direction();
        let body = format!(
            "ambient 0 0 0\ndiffuse 1 1 1\ndirectional {} {} {} 1 1 1\nrotate 0 0 1 90\nscale 2 1 0.5\nsphere 0 0 0 1\n",
            light.x, light.y, light.z
        );
        let text = |v: Vec3| format!("{} {} {}", v.x, v.y, v.z);
        let scene = scene(&text(eye), &text(center), &body);
        assert_eq!(scene.ellipsoids.len(), 1);
        // Into the ellipsoid's own frame: a quarter turn back.
        let turn = |v: Vec3| DVec3::new(f64::from(v.y), f64::from(-v.x), f64::from(v.z));
        let (org, dir) = (turn(eye), (turn(center) - turn(eye)).normalize());
        let (o, d) = (org / axes, dir / axes);
        let (a, b, c) = (d.dot(d), o.dot(d), o.dot(o) - 1.0);
        let t = (-b - (b * b - a * c).sqrt()) / a;
        let point = org + dir * t;
        let normal = (point / (axes * axes)).normalize();
        let hit = closest(&scene, &OracleRay::new(eye, (center - eye).normalize()));
        let error = hit.map(|hit| (f64::from(hit.t) - t).abs());
        assert!(
            error.is_some_and(|e| e < ELLIPSOID_DISTANCE),
            "{eye} {center}: {hit:?}, not {t}"
        );
        let lit = normal.dot(turn(light).normalize()).max(0.0);
        if lit > 0.05 {
            let (radiance, _) = shot(&scene);
            // The eye's rounding moves the point along a surface of curvature up to 8.
            assert_near(
                radiance,
                DVec3::splat(lit),
                ON_AN_ELLIPSOID,
                "an ellipsoid's normal",
            );
        }
    }
}

#[test]
fn ray_triangle() {
    let mut rng = Rng::new(45);
    let mut tested = 0;
    while tested < 500 {
        let corners = [0; 3].map(|_| rng.point(1.0));
        let [a, b, c] = corners;
        let eye = rng.direction() * 3.0;
        let normal = (b - a).cross(c - a);
        // Well-shaped, and not seen from the edge.
        if normal.length() < 0.5 || normal.normalize().dot(eye.normalize()).abs() < 0.2 {
            continue;
        }
        tested += 1;
        let mut scene = scenes::bare();
        scene.add_triangle(corners, None, 0);
        // Weights that may lie outside.
        let (beta, gamma) = (rng.range(-0.5, 1.2), rng.range(-0.5, 1.2));
        let alpha = 1.0 - beta - gamma;
        let inside = alpha.min(beta).min(gamma);
        if inside.abs() < 1e-4 {
            continue;
        }
        let point = a * alpha + b * beta + c * gamma;
        let hit = closest(&scene, &toward(eye, point));
        assert_eq!(
            hit.is_some(),
            inside > 0.0,
            "{corners:?} {alpha} {beta} {gamma}"
        );
        if let Some(hit) = hit {
            let near = |got: f32, want: f32| (f64::from(got) - f64::from(want)).abs();
            assert!(near(hit.t, 1.0) < 4.0 * BARYCENTRIC, "{hit:?}");
            assert!(near(hit.u, beta) < 4.0 * BARYCENTRIC, "{hit:?}, not {beta}");
            assert!(
                near(hit.v, gamma) < 4.0 * BARYCENTRIC,
                "{hit:?}, not {gamma}"
            );
        }
    }
    orientation();
    interpolated_normals();
}

/// Counter-clockwise is the front: at 45° light enters glass from the front and is totally
/// reflected at its back.
fn orientation() {
    let glass = "ambient 0 0 0\ntransmission 1 1 1\nior 1.5\n";
    let face = "vertex -9 -9 0\nvertex 9 -9 0\nvertex 0 9 0\ntri 0 1 2\n";
    let (_, front) = shot(&scene("-2 0 2", "0 0 0", &format!("{glass}{face}")));
    assert_eq!((front.refraction, front.reflection), (1, 0));
    let (_, back) = shot(&scene("-2 0 -2", "0 0 0", &format!("{glass}{face}")));
    assert_eq!((back.refraction, back.reflection), (0, 1));
    // Shading is two-sided: from below, a light below shines as one above does from above.
    let lit = |z: i32| {
        let light = format!("ambient 0 0 0\ndiffuse 1 0.5 0.25\ndirectional 0 0 {z} 1 1 1\n");
        shot(&scene(
            &format!("-2 0 {}", 2 * z),
            "0 0 0",
            &format!("{light}{face}"),
        ))
        .0
    };
    assert_eq!(lit(1), Vec3::new(1.0, 0.5, 0.25));
    assert_eq!(lit(-1), lit(1));
}

/// Vertex normals are interpolated with the weights of the hit, then normalised.
fn interpolated_normals() {
    let body = "ambient 0 0 0\ndiffuse 1 1 1\ndirectional 0 0 1 1 1 1\n\
        vertexnormal 0 0 0 0 0 1\nvertexnormal 4 0 0 3 0 4\nvertexnormal 0 4 0 0 -4 3\ntrinormal 0 1 2\n";
    // At α = 0.25, β = 0.5, γ = 0.25.
    let (radiance, _) = shot(&scene("2 1 5", "2 1 0", body));
    let n = DVec3::Z * 0.25 + DVec3::new(0.6, 0.0, 0.8) * 0.5 + DVec3::new(0.0, -0.8, 0.6) * 0.25;
    assert_near(
        radiance,
        DVec3::splat(n.normalize().z),
        RADIANCE,
        "interpolated normals",
    );
}
