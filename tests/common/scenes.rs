//! Scenes made of random primitives.

use super::rng::Rng;
use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use phalanx::scene::{Cone, Material, Scene};

/// A row of the material table.
#[derive(Clone, Copy, Debug)]
pub struct TestMaterial {
    pub ka: Vec3,
    pub ke: Vec3,
    pub kd: Vec3,
    pub ks: Vec3,
    pub kt: Vec3,
    pub shininess: f32,
    pub ior: f32,
}

pub const GREY: TestMaterial = TestMaterial {
    ka: Vec3::splat(0.2),
    ke: Vec3::ZERO,
    kd: Vec3::splat(0.5),
    ks: Vec3::ZERO,
    kt: Vec3::ZERO,
    shininess: 1.0,
    ior: 1.0,
};

pub fn add_paint(scene: &mut Scene, paint: TestMaterial) -> u32 {
    scene.materials.push(&Material {
        ka: paint.ka,
        ke: paint.ke,
        kd: paint.kd,
        ks: paint.ks,
        kt: paint.kt,
        shininess: paint.shininess,
        ior: paint.ior,
        ..Material::default()
    })
}

/// A scene without primitives and with one grey material.
pub fn bare() -> Scene {
    let mut scene = Scene::default();
    add_paint(&mut scene, GREY);
    scene
}

/// A corner of the cube of half side 1; each bit selects the side along an axis.
pub fn cube_corner(k: usize) -> Vec3 {
    Vec3::from_array([0, 1, 2].map(|bit| if k >> bit & 1 == 1 { 1.0 } else { -1.0 }))
}

/// The cube's twelve triangles by corners, counter-clockwise from outside.
pub fn cube_triangles() -> impl Iterator<Item = [usize; 3]> {
    let faces = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let halves = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]];
    faces.into_iter().flat_map(halves)
}

/// Adds the unit sphere stretched along three rotated axes, as the reader would: maps in f64, then
/// rounded.
pub fn add_ellipsoid(scene: &mut Scene, center: Vec3, axes: Vec3, turn: Vec3, paint: u32) {
    let turn = turn.as_dvec3();
    let rotation = DMat3::from_quat(DQuat::from_scaled_axis(turn));
    let to_world = DAffine3 {
        matrix3: rotation * DMat3::from_diagonal(axes.as_dvec3()),
        translation: center.as_dvec3(),
    };
    let back = DMat3::from_diagonal(DVec3::ONE / axes.as_dvec3()) * rotation.transpose();
    let to_object = DAffine3 {
        matrix3: back,
        translation: -(back * to_world.translation),
    };
    scene.add_ellipsoid(to_world.as_affine3a(), to_object.as_affine3a(), paint);
}

/// One primitive of any kind within `scale` of the origin, including slivers, copies and coplanar
/// overlaps.
pub fn add_random(scene: &mut Scene, rng: &mut Rng, scale: f32, paint: u32) {
    let center = rng.point(scale);
    match rng.below(11) {
        0 | 1 => {
            let radius = scale * rng.magnitude(-2.5, -0.3);
            scene.add_sphere(center, radius, paint);
        }
        2 => {
            let axes = Vec3::from_array([0; 3].map(|_| scale * rng.magnitude(-1.5, -0.3)));
            let turn = rng.direction() * rng.range(0.0, 3.0);
            add_ellipsoid(scene, center, axes, turn, paint);
        }
        3 | 4 => {
            let size = scale * rng.magnitude(-2.0, 0.0);
            let corners = [0; 3].map(|_| center + rng.point(size));
            let normals = rng
                .once_in(2)
                .then(|| [0; 3].map(|_| rng.direction() * rng.range(0.5, 2.0)));
            scene.add_triangle(corners, normals, paint);
        }
        5 => {
            // A sliver: its third corner almost on the edge between the others.
            let end = center + rng.direction() * scale * rng.magnitude(-1.0, 0.0);
            let between = center + (end - center) * rng.unit();
            let off = rng.direction() * scale * rng.magnitude(-7.0, -3.0);
            scene.add_triangle([center, end, between + off], None, paint);
        }
        6 => {
            // Axis-parallel, and in one of a few planes, so that many overlap exactly.
            let plane = scale * [-0.5, 0.0, 0.5][rng.below(3)];
            let axis = rng.below(3);
            let corners = [0; 3].map(|_| {
                let mut p = rng.point(scale);
                p[axis] = plane;
                p
            });
            scene.add_triangle(corners, None, paint);
        }
        7 | 8 => {
            let cone = random_cone(rng, center, scale);
            scene.add_cone(cone, paint);
        }
        _ => copy_of_one(scene, rng, paint),
    }
}

/// A cylinder, or a cone with or without a tip, with either end wider; including thin threads,
/// near-discs, and cones along a world axis.
pub fn random_cone(rng: &mut Rng, base: Vec3, scale: f32) -> Cone {
    let length = scale * rng.magnitude(-2.0, -0.3);
    let radius = scale * rng.magnitude(-2.5, -0.3);
    let other = scale * rng.magnitude(-2.5, -0.3);
    let (base_radius, apex_radius, length) = match rng.below(8) {
        0 | 1 => (radius, radius, length),
        2 => (radius, 0.0, length),
        3 => (0.0, radius, length),
        4 => (0.02 * radius, 0.02 * other, length),
        5 => (radius, other, 0.01 * length),
        _ => (radius, other, length),
    };
    let axis = if rng.once_in(3) {
        rng.pick(&[Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z])
    } else {
        rng.direction()
    };
    Cone {
        base,
        base_radius,
        apex: base + axis * length,
        apex_radius,
        inside: rng.once_in(5),
    }
}

/// A copy of an existing primitive, if there is one.
fn copy_of_one(scene: &mut Scene, rng: &mut Rng, paint: u32) {
    let triangles = scene.triangles.len();
    let (spheres, cones) = (scene.spheres.len(), scene.cones.len());
    if rng.once_in(4) && cones > 0 {
        let Cone {
            base,
            base_radius,
            apex,
            apex_radius,
            inside,
        } = scene.cones.get(rng.below(cones));
        // The same, from the other end.
        let copy = Cone {
            base: apex,
            base_radius: apex_radius,
            apex: base,
            apex_radius: base_radius,
            inside,
        };
        scene.add_cone(copy, paint);
    } else if rng.once_in(2) && triangles > 0 {
        let i = rng.below(triangles);
        let [a, b, c] = scene.triangles.corners(i);
        let corners = if rng.once_in(2) { [a, b, c] } else { [b, c, a] };
        scene.add_triangle(corners, None, paint);
    } else if spheres > 0 {
        let i = rng.below(spheres);
        let (center, radius) = (scene.spheres.center.get(i), scene.spheres.radius[i]);
        scene.add_sphere(center, radius, paint);
    }
}

/// A grey scene of at most `count` random primitives.
pub fn random(rng: &mut Rng, count: usize, scale: f32) -> Scene {
    let mut scene = bare();
    for _ in 0..count {
        add_random(&mut scene, rng, scale, 0);
    }
    scene.validate().expect("a valid random scene");
    scene
}

/// A point on a cone's side, at a share of its length.
pub fn point_at_height(cone: &Cone, share: f32, rng: &mut Rng) -> Vec3 {
    let axis = (cone.apex - cone.base).normalize();
    let (right, up) = axis.any_orthonormal_pair();
    let angle = rng.range(0.0, std::f32::consts::TAU);
    let away = right * angle.cos() + up * angle.sin();
    let radius = cone.base_radius + (cone.apex_radius - cone.base_radius) * share;
    cone.base + (cone.apex - cone.base) * share + away * radius
}

/// A point on a cone: on an end's rim, or anywhere on its side.
pub fn point_on_cone(cone: &Cone, rng: &mut Rng) -> Vec3 {
    let between = rng.unit();
    let share = rng.pick(&[0.0, 1.0, between, between]);
    point_at_height(cone, share, rng)
}

/// A point on some primitive of the scene: a corner, an edge, a face, the surface of a sphere or a
/// cone.
pub fn point_on(scene: &Scene, rng: &mut Rng) -> Vec3 {
    let (triangles, spheres) = (scene.triangles.len(), scene.spheres.len());
    let cones = scene.cones.len();
    if cones > 0 && rng.once_in(3) {
        return point_on_cone(&scene.cones.get(rng.below(cones)), rng);
    }
    if triangles > 0 && (spheres == 0 || rng.once_in(2)) {
        let [a, b, c] = scene.triangles.corners(rng.below(triangles));
        return match rng.below(3) {
            0 => a,
            1 => a + (b - a) * rng.unit(),
            _ => {
                let (u, v) = (rng.unit(), rng.unit());
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                a + (b - a) * u + (c - a) * v
            }
        };
    }
    if spheres > 0 {
        let i = rng.below(spheres);
        return scene.spheres.center.get(i) + rng.direction() * scene.spheres.radius[i];
    }
    Vec3::ZERO
}

/// A random map: rotated, stretched, sometimes mirrored or sheared, or with a scale far from 1.
pub fn random_map(rng: &mut Rng, scale: f32) -> DAffine3 {
    let turn = (rng.direction() * rng.range(0.0, 3.0)).as_dvec3();
    let stretch = match rng.below(4) {
        0 => DVec3::ONE,
        1 => DVec3::splat(f64::from(rng.magnitude(-2.0, 1.0))),
        _ => DVec3::from_array([0; 3].map(|_| f64::from(rng.magnitude(-1.0, 0.5)))),
    };
    let mirror = if rng.once_in(3) { -1.0 } else { 1.0 };
    let mut shear = DMat3::from_diagonal(stretch * DVec3::new(mirror, 1.0, 1.0));
    if rng.once_in(3) {
        shear.y_axis.x += f64::from(rng.range(-1.0, 1.0));
    }
    DAffine3 {
        matrix3: DMat3::from_quat(DQuat::from_scaled_axis(turn)) * shear,
        translation: rng.point(scale).as_dvec3(),
    }
}

/// A map that stretches its axes by factors up to a million times apart, so that its rounding
/// errors are not small compared with the padding of boxes.
pub fn extreme_map(rng: &mut Rng, scale: f32) -> DAffine3 {
    let stretch = DVec3::from_array([0; 3].map(|_| f64::from(rng.magnitude(-3.0, 3.0))));
    let turn = (rng.direction() * rng.range(0.0, 3.0)).as_dvec3();
    let turned = DQuat::from_scaled_axis((rng.direction() * rng.range(0.0, 3.0)).as_dvec3());
    DAffine3 {
        matrix3: DMat3::from_quat(DQuat::from_scaled_axis(turn))
            * DMat3::from_diagonal(stretch)
            * DMat3::from_quat(turned),
        translation: rng.point(scale).as_dvec3(),
    }
}

/// Meshes of random primitives, and instances of them, some in the same place.
pub fn add_instances(scene: &mut Scene, rng: &mut Rng, scale: f32, paint: u32) {
    for _ in 0..1 + rng.below(2) {
        let mesh = scene.begin_mesh();
        for _ in 0..1 + rng.below(30) {
            add_random(scene, rng, scale, paint);
        }
        scene.end_mesh(mesh);
        let mut map = DAffine3::IDENTITY;
        for _ in 0..1 + rng.below(6) {
            if !rng.once_in(4) {
                map = random_map(rng, scale);
            }
            scene.add_instance(mesh, map).expect("an invertible map");
        }
        if rng.once_in(2) {
            // Splits the world's primitives into several runs.
            add_random(scene, rng, scale, paint);
        }
    }
}
