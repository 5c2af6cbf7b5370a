//! Sets of rays.
//!
//! | rays | |
//! |---|---|
//! | coherent | a camera's, row of pixels by row of pixels |
//! | random | between two random points of the scene's box |
//! | bounce | from where the camera's hit, in random order, about the normal by the cosine |

use phalanx::{Bvh, Ray, Scene, refine};

/// The sets by name, each with as many rays as a picture of `side` has pixels.
pub fn sets(scene: &Scene, bvh: &Bvh, side: usize) -> [(&'static str, Vec<Ray>); 3] {
    let (bounds, count) = (scene.bounds(), side * side);
    let (center, size) = ((bounds.lo + bounds.hi) / 2.0, bounds.hi - bounds.lo);
    let eye = center + size.length() * glam(0.2, 0.35, 1.0);
    let ahead = (center - eye).normalize();
    let right = ahead.cross(glam(0.0, 1.0, 0.0)).normalize();
    let up = right.cross(ahead);
    let pixel = |k: usize| {
        let [x, y] = [k % side, k / side].map(|c| (c as f32 + 0.5) / side as f32 - 0.5);
        Ray::new(eye, ahead + 0.8 * (x * right - y * up))
    };
    let coherent: Vec<Ray> = (0..count).map(pixel).collect();
    let mut seed = 1u64;
    let mut random = move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (seed >> 40) as f32 / (1u64 << 24) as f32
    };
    let mut point = || glam(random(), random(), random());
    let segment = |_| {
        let from = bounds.lo + size * point();
        let to = bounds.lo + size * point();
        Ray::new(from, to - from)
    };
    let crossing = (0..count).map(segment).collect();
    let starts: Vec<_> = coherent
        .iter()
        .filter_map(|ray| surface((scene, size.length()), bvh, ray))
        .collect();
    let bounce = |_| {
        let row = (point().x * starts.len() as f32) as usize % starts.len();
        let (from, normal) = starts[row];
        let around = loop {
            let around = point() * 2.0 - 1.0;
            if (0.01..1.0).contains(&around.length_squared()) {
                break around.normalize();
            }
        };
        Ray::new(from, normal + 0.999 * around)
    };
    let bounced = (0..count).map(bounce).collect();
    [
        ("coherent", coherent),
        ("random", crossing),
        ("bounce", bounced),
    ]
}

pub fn glam(x: f32, y: f32, z: f32) -> phalanx::glam::Vec3 {
    phalanx::glam::Vec3::new(x, y, z)
}

/// A point just off the surface that a ray hits, and the normal there toward the ray; `size` is the
/// scene's.
pub fn surface(
    (scene, size): (&Scene, f32),
    bvh: &Bvh,
    ray: &Ray,
) -> Option<(phalanx::glam::Vec3, phalanx::glam::Vec3)> {
    let hit = bvh.intersect(ray)?;
    let [origin, direction] = [ray.origin, ray.direction].map(|v| v.map(f64::from));
    let refined = refine(scene, origin, direction, &hit);
    let normal = phalanx::glam::DVec3::from(refined.normal).as_vec3();
    let toward = -normal * normal.dot(ray.direction.into()).signum();
    let point = phalanx::glam::DVec3::from(refined.point).as_vec3();
    Some((point + toward * size * 1e-4, toward))
}
