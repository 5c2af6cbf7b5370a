//! Cones and cylinders as in NFF; the design document has only spheres and triangles.

use super::{assert_near, shot};
use crate::common::rays::{Engines, toward};
use crate::common::rng::Rng;
use crate::common::scenes::{self, GREY, TestMaterial};
use crate::common::tolerances::{ON_A_CONE, RADIANCE};
use glam::{DVec3, Vec3};
use phalanx::bvh::Bvh;
use phalanx::oracle::{OracleRay, TwoLevelBvh};
use phalanx::scene::{Cone, Scene};

/// A cone along z from 0 to `length`.
fn upright(base_radius: f32, apex_radius: f32, length: f32, inside: bool) -> Cone {
    Cone {
        base: Vec3::ZERO,
        base_radius,
        apex: Vec3::Z * length,
        apex_radius,
        inside,
    }
}

fn alone(cone: Cone) -> Scene {
    let mut scene = scenes::bare();
    scene.add_cone(cone, 0);
    scene
}

/// Distances on which brute force, the oracle's tree and the packet engine agree.
fn distances(cone: Cone, rays: &[OracleRay]) -> Vec<Option<f32>> {
    let scene = alone(cone);
    let (tree, bvh) = (TwoLevelBvh::build(&scene), Bvh::build(&scene));
    let mut engines = Engines::new(&scene, &tree, &bvh);
    rays.chunks(8)
        .flat_map(|rays| engines.closest_of(rays))
        .map(|hit| hit.map(|hit| hit.t))
        .collect()
}

fn distance(cone: Cone, org: [f32; 3], dir: [f32; 3]) -> Option<f32> {
    distances(cone, &[OracleRay::new(org.into(), dir.into())])[0]
}

#[test]
fn a_cylinder_is_a_tube() {
    let tube = upright(1.0, 1.0, 4.0, false);
    // Across: the outside, from within the far wall, twice the direction half the distance.
    assert_eq!(distance(tube, [5.0, 0.0, 2.0], [-1.0, 0.0, 0.0]), Some(4.0));
    assert_eq!(distance(tube, [0.6, -5.0, 2.0], [0.0, 1.0, 0.0]), Some(4.2));
    assert_eq!(distance(tube, [5.0, 0.0, 2.0], [-2.0, 0.0, 0.0]), Some(2.0));
    assert_eq!(distance(tube, [0.5, 0.0, 2.0], [1.0, 0.0, 0.0]), Some(0.5));
    assert_eq!(distance(tube, [0.0, 0.0, 2.0], [0.0, -1.0, 0.0]), Some(1.0));
    // Away from it, past it, below and above it.
    assert_eq!(distance(tube, [5.0, 0.0, 2.0], [1.0, 0.0, 0.0]), None);
    assert_eq!(distance(tube, [5.0, 1.5, 2.0], [-1.0, 0.0, 0.0]), None);
    assert_eq!(distance(tube, [5.0, 0.0, -0.01], [-1.0, 0.0, 0.0]), None);
    assert_eq!(distance(tube, [5.0, 0.0, 4.01], [-1.0, 0.0, 0.0]), None);
    // Open ends: through it along the axis, beside the axis, and along the wall itself.
    for x in [0.0, 0.3, 0.99, 1.0, 1.01] {
        assert_eq!(distance(tube, [x, 0.0, 9.0], [0.0, 0.0, -1.0]), None, "{x}");
        assert_eq!(distance(tube, [x, 0.0, 2.0], [0.0, 0.0, 1.0]), None, "{x}");
    }
    // In at one end at a slant, onto the wall from inside: the outside's root lies above the end.
    let t = distance(tube, [0.0, 0.0, 5.0], [0.5, 0.0, -1.0]);
    assert_eq!(t, Some(2.0));
    assert_eq!(distance(tube, [0.0, 0.0, 5.0], [0.1, 0.0, -1.0]), None);
    // In at one end and out at the other, across the axis.
    assert_eq!(distance(tube, [-0.9, 0.0, 4.5], [0.3, 0.0, -1.0]), None);
}

#[test]
fn cones_have_one_nappe() {
    for (cone, flipped) in [
        (upright(2.0, 0.0, 2.0, false), false),
        (
            Cone {
                base: Vec3::Z * 2.0,
                base_radius: 0.0,
                apex: Vec3::ZERO,
                apex_radius: 2.0,
                inside: false,
            },
            true,
        ),
    ] {
        let hit = |org: [f32; 3], dir: [f32; 3]| distance(cone, org, dir);
        assert_eq!(
            hit([5.0, 0.0, 1.0], [-1.0, 0.0, 0.0]),
            Some(4.0),
            "{flipped}"
        );
        // From above beside the axis, and from below onto the inside.
        assert_eq!(hit([0.5, 0.0, 5.0], [0.0, 0.0, -1.0]), Some(3.5));
        assert_eq!(hit([0.5, 0.0, -5.0], [0.0, 0.0, 1.0]), Some(6.5));
        assert_eq!(hit([0.0, 0.5, 1.0], [0.0, 0.0, 1.0]), Some(0.5));
        // Not the mirrored cone above the tip, not the base disc.
        assert_eq!(hit([5.0, 0.0, 3.0], [-1.0, 0.0, 0.0]), None);
        assert_eq!(hit([3.0, 0.0, 5.0], [0.0, 0.0, -1.0]), None);
        assert_eq!(hit([0.0, 0.0, 3.0], [1.0, 0.0, 0.5]), None);
        // Parallel to a line of the surface, which leaves one root: met from outside opposite, and
        // from inside.
        assert_eq!(hit([-1.0, 0.0, -1.0], [1.0, 0.0, 1.0]), Some(2.0));
        assert_eq!(hit([-3.0, 0.0, 0.0], [1.0, 0.0, 1.0]), None);
        let t = hit([-1.0, 0.0, 0.0], [1.0, 0.0, 1.0]);
        assert!(t.is_some_and(|t| f64::from((t - 1.5).abs()) < ON_A_CONE));
        // Along that line itself all of it is the surface; both engines say the same.
        let t = hit([-4.0, 0.0, -2.0], [1.0, 0.0, 1.0]);
        assert!(t.is_none_or(|t| (1.9..4.1).contains(&t)), "{t:?}");
    }
    // The wider end above, the far root on the frustum where the near one is on the mirrored side.
    let funnel = upright(1.0, 3.0, 2.0, false);
    assert_eq!(
        distance(funnel, [2.0, 0.0, 9.0], [0.0, 0.0, -1.0]),
        Some(8.0)
    );
    assert_eq!(
        distance(funnel, [2.0, 0.0, -9.0], [0.0, 0.0, 1.0]),
        Some(10.0)
    );
    assert_eq!(distance(funnel, [0.5, 0.0, 9.0], [0.0, 0.0, -1.0]), None);
}

#[test]
fn an_inside_is_seen_from_inside_alone() {
    for (radii, height) in [([1.0, 1.0], 1.0), ([2.0, 0.0], 1.5), ([0.5, 1.0], 0.625)] {
        let (outer, inner) = (
            upright(radii[0], radii[1], 4.0, false),
            upright(radii[0], radii[1], 4.0, true),
        );
        let across = |cone| distance(cone, [5.0, 0.0, 1.0], [-1.0, 0.0, 0.0]);
        let near = |got: Option<f32>, want: f32| {
            let error = got.map(|t| f64::from((t - want).abs()));
            assert!(error.is_some_and(|e| e < ON_A_CONE), "{got:?}, not {want}");
        };
        near(across(outer), 5.0 - height);
        // The near wall is not there; the far one is met from inside.
        near(across(inner), 5.0 + height);
        let outward = |cone| distance(cone, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
        near(outward(outer), height);
        near(outward(inner), height);
        // Out of it again there is nothing.
        let away = distance(inner, [-5.0, 0.0, 1.0], [-1.0, 0.0, 0.0]);
        assert_eq!(away, None);
    }
    // Down onto a pointed cone: outside only.
    let down = |inside| {
        let cone = upright(2.0, 0.0, 2.0, inside);
        distance(cone, [0.5, 0.0, 5.0], [0.0, 0.0, -1.0])
    };
    assert_eq!((down(false), down(true)), (Some(3.5), None));
}

/// The silhouette of a cylinder is where it should be, to the last few digits.
#[test]
fn silhouettes() {
    let mut rng = Rng::new(51);
    for _ in 0..300 {
        let axis = rng.direction();
        let across = rng.direction().cross(axis).normalize();
        let toward_eye = across.cross(axis);
        let radius = rng.magnitude(-2.0, 0.0);
        let cone = Cone {
            base: -axis,
            base_radius: radius,
            apex: axis,
            apex_radius: radius,
            inside: false,
        };
        let eye = toward_eye * 3.0;
        for (share, seen) in [(1.0 - 1e-4, true), (1.0 + 1e-4, false)] {
            let org = eye + across * (radius * share) + axis * rng.range(-0.9, 0.9);
            let got = distances(cone, &[OracleRay::new(org, -toward_eye)])[0];
            assert_eq!(got.is_some(), seen, "{cone:?} {share}");
        }
    }
}

/// Lambert's cosine reveals the normal: radial, and against the slope.
#[test]
fn normals() {
    let mut rng = Rng::new(52);
    let mut lit_ones = 0;
    for _ in 0..400 {
        let base = rng.point(1.0);
        let cone = Cone {
            base,
            base_radius: rng.pick(&[1.0, 0.5, 0.0]),
            apex: base + rng.direction() * 2.0,
            apex_radius: rng.pick(&[1.0, 0.5, 0.25]),
            inside: rng.once_in(4),
        };
        let mut scene = Scene::default();
        let paint = TestMaterial {
            ka: Vec3::ZERO,
            kd: Vec3::ONE,
            ..GREY
        };
        let paint = scenes::add_paint(&mut scene, paint);
        scene.add_cone(cone, paint);
        let light = rng.direction();
        scene.lights.add_directional(light, Vec3::ONE);
        scene.view.eye = rng.direction() * 5.0;
        let share = rng.range(0.05, 0.95);
        scene.view.center = scenes::point_at_height(&cone, share, &mut rng);
        scene.view.up = rng.direction();
        (scene.width, scene.height, scene.max_depth) = (1, 1, 0);
        let ray = toward(scene.view.eye, scene.view.center);
        let Some(t) = distances(cone, &[ray])[0] else {
            continue;
        };
        let point = (ray.org + ray.dir * t).as_dvec3();
        let Some(normal) = exact_normal(&cone, point, ray.dir.as_dvec3()) else {
            continue;
        };
        let lit = normal.dot(light.as_dvec3().normalize());
        let (radiance, rays) = shot(&scene);
        if lit < -0.05 {
            assert_eq!((radiance, rays.shadow), (Vec3::ZERO, 0), "{cone:?}");
        }
        if lit > 0.05 && radiance != Vec3::ZERO {
            lit_ones += 1;
            let want = DVec3::splat(lit);
            assert_near(radiance, want, 40.0 * RADIANCE, &format!("{cone:?}"));
        }
    }
    assert!(lit_ones > 50, "only {lit_ones} were lit");
}

/// The unit normal toward the viewer in f64; none near the tip and the rims, or at grazing angles.
fn exact_normal(cone: &Cone, point: DVec3, dir: DVec3) -> Option<DVec3> {
    let along = (cone.apex - cone.base).as_dvec3();
    let f = point - cone.base.as_dvec3();
    let share = f.dot(along) / along.length_squared();
    let away = f - along * share;
    if away.length() < 0.1 || !(0.01..0.99).contains(&share) {
        return None;
    }
    let wider = f64::from(cone.apex_radius) - f64::from(cone.base_radius);
    let normal = away.normalize() - along * (wider / along.length_squared());
    let normal = normal.normalize();
    let facing = normal.dot(dir.normalize());
    (facing.abs() > 0.2).then_some(normal * -facing.signum())
}

/// Light enters at an open end: a view through a tube, and a shadow with a bright spot.
#[test]
fn open_ends_let_light_through() {
    let mut scene = Scene::default();
    let paint = scenes::add_paint(&mut scene, GREY);
    scene.add_cone(
        Cone {
            base: Vec3::Z,
            base_radius: 0.5,
            apex: Vec3::Z * 3.0,
            apex_radius: 0.5,
            inside: false,
        },
        paint,
    );
    let corner = |x, y| Vec3::new(x, y, 0.0);
    let corners = [corner(-9.0, -9.0), corner(9.0, -9.0), corner(0.0, 9.0)];
    scene.add_triangle(corners, None, paint);
    scene.lights.add_directional(Vec3::Z, Vec3::ONE);
    (scene.width, scene.height, scene.max_depth) = (1, 1, 0);
    let mut look = |eye: Vec3, center: Vec3| {
        (scene.view.eye, scene.view.center, scene.view.up) = (eye, center, Vec3::X);
        shot(&scene).0
    };
    let lit = Vec3::splat(0.2 + 0.5);
    // Straight through, onto the lit floor; and onto the floor below the tube, from the side.
    assert_eq!(look(Vec3::Z * 9.0, Vec3::ZERO), lit);
    assert_eq!(look(Vec3::new(4.0, 3.0, 0.5), Vec3::ZERO), lit);
    // With a light at a slant, the tube shades the floor.
    scene.lights.position.set(0, Vec3::new(0.6, 0.0, 0.8));
    let mut look = |eye: Vec3, center: Vec3| {
        (scene.view.eye, scene.view.center, scene.view.up) = (eye, center, Vec3::X);
        shot(&scene).0
    };
    let shaded = Vec3::splat(0.2);
    assert_eq!(look(Vec3::new(-5.0, 3.0, 3.0), Vec3::X * -1.5), shaded);
    let far = look(Vec3::new(-5.0, 3.0, 3.0), Vec3::X * -4.0);
    assert_near(
        far,
        DVec3::splat(0.2 + 0.5 * 0.8),
        RADIANCE,
        "the floor beside",
    );
}

/// A ray straight through a thick glass tube is refracted twice and leaves in its original
/// direction, displaced.
#[test]
fn a_glass_cylinder_refracts() {
    for ior in [1.0f32, 1.5, 2.0] {
        for height in [0.0, 0.3, 0.7, 0.9f32] {
            let mut scene = Scene::default();
            let glass = TestMaterial {
                ka: Vec3::ZERO,
                kd: Vec3::ZERO,
                kt: Vec3::ONE,
                ior,
                ..GREY
            };
            let glass = scenes::add_paint(&mut scene, glass);
            let lamp = TestMaterial {
                ka: Vec3::ZERO,
                ke: Vec3::new(1.0, 0.5, 0.25),
                kd: Vec3::ZERO,
                ..GREY
            };
            let lamp = scenes::add_paint(&mut scene, lamp);
            scene.add_cone(
                Cone {
                    base: Vec3::Z * -2.0,
                    base_radius: 1.0,
                    apex: Vec3::Z * 2.0,
                    apex_radius: 1.0,
                    inside: false,
                },
                glass,
            );
            // Snell in the plane across the axis: the ray along +x at y = height leaves turned by
            // 2(i − r).
            let i = f64::from(height).asin();
            let r = (f64::from(height) / f64::from(ior)).asin();
            let turn = 2.0 * (i - r);
            let exit_angle = 2.0 * r - i;
            let exit = DVec3::new(exit_angle.cos(), exit_angle.sin(), 0.0);
            let out = DVec3::new(turn.cos(), -turn.sin(), 0.0);
            let position = (exit + out * 5.0).as_vec3();
            scene.add_sphere(position, 1e-3, lamp);
            (scene.width, scene.height, scene.max_depth) = (1, 1, 2);
            scene.view.eye = Vec3::new(-5.0, height, 0.0);
            scene.view.center = Vec3::new(0.0, height, 0.0);
            scene.view.up = Vec3::Z;
            let (radiance, rays) = shot(&scene);
            assert_eq!(radiance, Vec3::new(1.0, 0.5, 0.25), "ior {ior} at {height}");
            assert_eq!((rays.refraction, rays.reflection), (2, 0));
        }
    }
}

/// Rays that leave a cone's surface do not hit it again there: the offset is sufficient at every
/// size, slope and distance.
#[test]
fn no_cone_shades_its_own_surface() {
    let mut rng = Rng::new(53);
    let mut shots = 0;
    for _ in 0..4000 {
        let scale = rng.pick(&[1e-3, 1.0, 1e4]);
        let base = rng.point(scale);
        let cone = Cone {
            inside: false,
            ..scenes::random_cone(&mut rng, base, scale)
        };
        let mut scene = alone(cone);
        scene.materials.ka.set(0, Vec3::ZERO);
        // From far away onto it; the light stands behind the eye, so that nothing but the surface
        // itself could shade it.
        let eye = base + rng.direction() * scale * rng.pick(&[2.0, 100.0]);
        let share = rng.unit();
        let point = scenes::point_at_height(&cone, share, &mut rng);
        // As seen from the eye, f32 must be able to tell the near side from the far one.
        let radius = cone.base_radius + (cone.apex_radius - cone.base_radius) * share;
        if radius < 1e-3 * (eye - point).length() {
            continue;
        }
        scene
            .lights
            .add_directional((eye - point).normalize(), Vec3::ONE);
        (scene.view.eye, scene.view.center) = (eye, point);
        scene.view.up = rng.direction();
        (scene.width, scene.height, scene.max_depth) = (1, 1, 0);
        let (radiance, rays) = shot(&scene);
        if rays.shadow == 1 {
            shots += 1;
            assert_ne!(radiance, Vec3::ZERO, "{cone:?} from {eye} at {point}");
        }
    }
    assert!(shots > 1000, "only {shots} were lit");
}

/// A hit point on a cone is on it, from every viewpoint.
#[test]
fn far_cones_are_met_on_their_surface() {
    let mut rng = Rng::new(54);
    for _ in 0..2000 {
        let axis = rng.direction();
        let cone = Cone {
            base: Vec3::ZERO,
            base_radius: 1.0,
            apex: axis * 2.0,
            apex_radius: rng.pick(&[1.0, 0.5, 2.0]),
            inside: false,
        };
        let away = rng.pick(&[10.0, 1e3, 1e4]);
        let ray = toward(
            rng.direction() * away,
            scenes::point_on_cone(&cone, &mut rng),
        );
        let Some(t) = distances(cone, &[ray])[0] else {
            continue;
        };
        let p = ray.org.as_dvec3() + ray.dir.as_dvec3() * f64::from(t);
        let along = cone.apex.as_dvec3();
        let share = p.dot(along) / along.length_squared();
        let apart = (p - along * share).length();
        let wider = f64::from(cone.apex_radius) - 1.0;
        let error = (apart - (1.0 + wider * share)).abs();
        let allowed = ON_A_CONE + f64::from(away) * 2.0 * f64::from(f32::EPSILON);
        assert!(error <= allowed, "{ray:?}, {cone:?}: {error:e}");
    }
}
