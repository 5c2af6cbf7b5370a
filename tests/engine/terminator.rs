//! Shadow terminator of smooth surfaces of few triangles: without steps, without leaks, and the
//! same bits from both engines.

mod standing;

use crate::common::frames::frame_of;
use crate::common::scenes::{cube_corner, cube_triangles};
use crate::coverage::assert_same_everywhere;
use glam::{DAffine3, DVec3, Vec3};
use phalanx::frame::{Accel, Engine, Settings};
use phalanx::scene::{Material, Scene, View};
use std::f32::consts::{PI, TAU};

/// Pixels across a picture.
const SIDE: u32 = 200;

/// A scene seen along −z by parallel rays from z = `from`, `height` units high, with smooth shadows
/// and a white material without ambient light.
fn seen_from(from: f32, height: f32) -> Scene {
    let mut scene = Scene {
        width: SIDE,
        height: SIDE,
        max_depth: 0,
        smooth_shadows: true,
        view: View {
            eye: Vec3::new(0.0, 0.0, from),
            center: Vec3::ZERO,
            up: Vec3::Y,
            fovy: 45.0,
            ortho: Some(height),
        },
        ..Scene::default()
    };
    scene.materials.push(&Material {
        ka: Vec3::ZERO,
        kd: Vec3::ONE,
        ..Material::DEFAULT
    });
    scene
}

/// Point of the unit sphere in row `i` of 8 and column `k` of 16. The poles are not at the axes, so
/// that no edges lie along the terminator.
fn globe_point(i: usize, k: usize) -> Vec3 {
    let (polar, round) = (i as f32 / 8.0 * PI, k as f32 / 16.0 * TAU);
    let (x, y, z) = (
        polar.sin() * round.cos(),
        polar.cos(),
        polar.sin() * round.sin(),
    );
    glam::Quat::from_rotation_x(0.7) * (glam::Quat::from_rotation_z(0.4) * Vec3::new(x, y, z))
}

/// Adds the unit sphere of 8 × 16 facets with exact normals.
fn add_globe(scene: &mut Scene) {
    for (i, k) in (0..8).flat_map(|i| (0..16).map(move |k| (i, k))) {
        let [a, b] = [globe_point(i, k), globe_point(i, k + 1)];
        let [c, d] = [globe_point(i + 1, k + 1), globe_point(i + 1, k)];
        for corners in [[a, b, c], [a, c, d]] {
            let [e1, e2] = [corners[1] - corners[0], corners[2] - corners[0]];
            if e1.cross(e2).length() > 1e-6 {
                scene.add_triangle(corners, Some(corners), 0);
            }
        }
    }
}

/// Adds a box without vertex normals.
fn add_box(scene: &mut Scene, low: Vec3, high: Vec3) {
    let corner = |k: usize| {
        let corner_along = |axis: usize| if k >> axis & 1 == 1 { high } else { low }[axis];
        Vec3::new(corner_along(0), corner_along(1), corner_along(2))
    };
    for triangle in cube_triangles() {
        scene.add_triangle(triangle.map(corner), None, 0);
    }
}

/// Red of every pixel, row by row, once both engines agree.
fn picture(scene: &Scene) -> Vec<f32> {
    let small = Scene {
        width: 24,
        height: 24,
        ..scene.clone()
    };
    assert_same_everywhere(&small, "terminator");
    let frame = frame_of(
        scene,
        &Accel::build(scene, Engine::Simd),
        Settings::of(scene),
    );
    frame.film.planes[0].clone()
}

/// The same scene, whose shadows follow its facets.
fn faceted(scene: &Scene) -> Scene {
    Scene {
        smooth_shadows: false,
        ..scene.clone()
    }
}

/// Position of a pixel's centre in a picture of this height.
fn place(pixel: usize, height: f32) -> [f32; 2] {
    let (x, y) = (pixel as u32 % SIDE, pixel as u32 / SIDE);
    let coordinate = |k: u32| ((k as f32 + 0.5) / SIDE as f32 - 0.5) * height;
    [coordinate(x), -coordinate(y)]
}

/// Pixels of the unit sphere that are lit on the dark side of the true sphere or dark on its lit
/// side, more than two pixels from its terminator.
fn wrong_pixels(scene: &Scene, toward: Vec3) -> usize {
    let mut wrong = 0;
    for (pixel, red) in picture(scene).into_iter().enumerate() {
        let [x, y] = place(pixel, 2.2);
        let across = x * x + y * y;
        // The outline itself has corners.
        if across < 0.8 {
            let normal = Vec3::new(x, y, (1.0 - across).sqrt());
            let margin = 2.0 * 2.2 / SIDE as f32;
            let cos = normal.dot(toward);
            wrong += usize::from(cos.abs() > margin && (cos > 0.0) != (red > 0.0));
        }
    }
    wrong
}

#[test]
fn coarse_spheres_have_the_terminator_of_the_sphere() {
    for toward in [[0.8, 0.5, 0.1], [-0.3, 0.9, -0.3], [0.5, -0.5, 0.2]] {
        let toward = Vec3::from(toward).normalize();
        for stretch in [
            None,
            Some(DAffine3::IDENTITY),
            Some(DAffine3::from_scale(-DVec3::ONE)),
        ] {
            let mut scene = seen_from(4.0, 2.2);
            scene.lights.add_directional(toward, Vec3::ONE);
            match stretch {
                None => add_globe(&mut scene),
                Some(map) => {
                    let mesh = scene.begin_mesh();
                    add_globe(&mut scene);
                    scene.end_mesh(mesh);
                    scene.add_instance(mesh, map).expect("invertible");
                }
            }
            let steps = wrong_pixels(&faceted(&scene), toward);
            assert!(steps > 250, "{toward}: {steps} pixels");
            let wrong = wrong_pixels(&scene, toward);
            assert_eq!(wrong, 0, "{toward} {stretch:?}: {steps} with facets");
        }
    }
}

/// Lamps outside of a closed box light nothing in it, although the smooth surface of the globe is
/// partly outside.
#[test]
fn no_light_passes_a_wall_between_facets_and_smooth_surface() {
    let mut scene = seen_from(4.0, 2.2);
    (scene.view.eye, scene.view.ortho, scene.view.fovy) = (Vec3::new(1.0, 1.5, 0.6), None, 80.0);
    scene.view.center = Vec3::new(0.9, 0.0, 0.0);
    add_globe(&mut scene);
    scene
        .lights
        .add_point(Vec3::new(5.0, 1.0, 0.3), Vec3::ONE, Vec3::X);
    scene.lights.add_directional(Vec3::X, Vec3::ONE);
    (scene.lights).add_sphere(Vec3::new(4.0, -1.0, 0.3), 0.5, Vec3::ONE, Vec3::X);
    let lit = |scene: &Scene| picture(scene).iter().filter(|&&red| red > 0.0).count();
    assert!(lit(&scene) > 2000);
    let mut closed = scene.clone();
    add_box(&mut closed, Vec3::splat(-2.0), Vec3::new(1.004, 2.0, 2.0));
    assert_eq!(lit(&closed), 0);
    // A wall without thickness, and nothing else.
    let corners = [[-9.0, -9.0], [9.0, -9.0], [0.0, 9.0]];
    scene.add_triangle(corners.map(|[y, z]| Vec3::new(1.004, y, z)), None, 0);
    assert_eq!(lit(&scene), 0);
}

#[test]
fn what_stands_on_a_smooth_surface_keeps_its_shadow() {
    let mut scene = seen_from(4.0, 2.2);
    add_globe(&mut scene);
    add_box(
        &mut scene,
        Vec3::new(-0.1, -0.1, 0.9),
        Vec3::new(0.1, 0.1, 1.4),
    );
    scene
        .lights
        .add_directional(Vec3::new(0.9, 0.0, 0.45).normalize(), Vec3::ONE);
    for scene in [faceted(&scene), scene] {
        let picture = picture(&scene);
        let shade = |pixel: &usize| {
            let [x, y] = place(*pixel, 2.2);
            (-0.5..-0.1).contains(&x) && y.abs() < 0.09
        };
        let shade: Vec<usize> = (0..picture.len()).filter(shade).collect();
        assert!(shade.len() > 500 && shade.iter().all(|&pixel| picture[pixel] == 0.0));
    }
}

/// Asserts that shadows follow the facets of a scene although its triangles have vertex normals.
fn assert_faceted(scene: &Scene) {
    let smooth = picture(scene);
    assert!(smooth.iter().any(|&red| red > 0.0));
    assert!(smooth == picture(&faceted(scene)));
}

#[test]
fn hollows_have_the_shadows_of_their_facets() {
    let mut scene = seen_from(0.5, 2.2);
    (scene.view.ortho, scene.view.fovy) = (None, 100.0);
    add_globe(&mut scene);
    (scene.lights).add_point(Vec3::new(0.5, 0.3, 0.0), Vec3::ONE, Vec3::X);
    assert_faceted(&scene);
}

/// A cube whose normals have four decimals, in light that faces one of them and not its face.
#[test]
fn flat_faces_have_the_shadows_of_their_facets() {
    let mut scene = seen_from(4.0, 2.2);
    scene.lights.add_directional(Vec3::Z, Vec3::ONE);
    let slanted = glam::Quat::from_euler(glam::EulerRot::XYZ, 0.5, 0.4, 0.0);
    for triangle in cube_triangles() {
        let corners = triangle.map(|k| slanted * cube_corner(k) * 0.5);
        let [a, b, c] = corners;
        let exact = (b - a).cross(c - a).normalize();
        let normal = (exact * 1e4).round() / 1e4;
        scene.add_triangle(corners, Some([normal; 3]), 0);
        let along = (normal - exact).reject_from_normalized(exact).normalize();
        (scene.lights).add_directional((along - exact * 1e-5).normalize(), Vec3::ONE);
    }
    assert_faceted(&scene);
}
