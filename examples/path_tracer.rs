//! A path tracer, one ray per call. Renders a room with 64 samples per pixel, as a binary PPM:
//! `cargo run --release --example path_tracer -- 64 path_tracer.ppm`.

use Finish::{Glass, Light, Matte, Metal, Polished};
use phalanx::glam::{DVec3, Vec3, vec3};
use phalanx::{Bvh, GeometryError, NO_PRIM, Ray, RayFilter, Scene, refine};
use std::f32::consts::{PI, TAU};

const SIZE: [usize; 2] = [640, 480];
/// Corner of the lamp, its sides along x and z, and its radiance.
const LAMP: (Vec3, [f32; 2], Vec3) = (vec3(1.4, 2.99, 1.3), [1.6, 1.2], vec3(15.0, 13.0, 10.5));

#[derive(Clone, Copy, PartialEq)]
#[rustfmt::skip]
enum Finish { Matte, Polished, Metal, Glass, Light }

/// Materials are indexed by `geom_id`: geometries are numbered in the order they are added.
struct World(Bvh, Scene, Vec<(Finish, Vec3)>);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let samples: u32 = args.next().map_or(Ok(64), |text| text.parse())?;
    let path = args.next().unwrap_or("path_tracer.ppm".into());
    let world = furnished_room()?;
    let mut picture = vec![[0; 3]; SIZE[0] * SIZE[1]];
    let rows = std::sync::Mutex::new(picture.chunks_mut(SIZE[0]).enumerate());
    let next_row = || rows.lock().unwrap().next();
    let work = || {
        while let Some((y, row)) = next_row() {
            (0..SIZE[0]).for_each(|x| row[x] = pixel(&world, [x, y], samples));
        }
    };
    let threads = std::thread::available_parallelism()?.get();
    std::thread::scope(|scope| (0..threads).for_each(|_| drop(scope.spawn(work))));
    let header = format!("P6 {} {} 255\n", SIZE[0], SIZE[1]).into_bytes();
    Ok(std::fs::write(path, [header, picture.concat()].concat())?)
}

fn furnished_room() -> Result<World, GeometryError> {
    let (mut scene, mut materials) = (Scene::new(), Vec::new());
    let [x, y, z] = [4.4 * Vec3::X, 3.0 * Vec3::Y, 7.4 * Vec3::Z];
    let (white, high, (lamp, [a, b], radiance)) = (vec3(0.78, 0.75, 0.7), x + y + z, LAMP);
    for (finish, color, corner, a, b) in [
        (Polished, vec3(0.46, 0.4, 0.34), Vec3::ZERO, z, x),
        (Matte, white, high, -x, -z),
        (Matte, white, Vec3::ZERO, x, y),
        (Matte, white, high, -y, -x),
        (Matte, vec3(0.7, 0.24, 0.1), Vec3::ZERO, y, z),
        (Matte, vec3(0.07, 0.3, 0.38), high, -z, -y),
        (Light, radiance, lamp, a * Vec3::X, b * Vec3::Z),
    ] {
        let corners = [corner, corner + a, corner + a + b, corner + b];
        scene.add_mesh(&corners.map(Vec3::into), &[[0, 1, 2], [0, 2, 3]])?;
        materials.push((finish, color));
    }
    let turn = |t: f32| vec3(t.sin(), t.cos(), 0.0);
    let trefoil = |t| turn(t) + 2.0 * turn(PI - 2.0 * t) - (3.0 * t).sin() * Vec3::Z;
    let bead = |k| (vec3(2.2, 1.19, 1.3) + 0.33 * trefoil(k as f32 / 2000.0 * TAU)).into();
    let beads: Vec<[f32; 3]> = (0..2000).map(bead).collect();
    for (finish, color, centers, radius) in [
        (Polished, vec3(0.65, 0.04, 0.03), &beads[..], 0.2),
        (Polished, vec3(0.04, 0.2, 0.45), &[[1.8, 0.25, 3.2]], 0.25),
        (Metal, vec3(0.95, 0.72, 0.4), &[[0.9, 0.55, 2.2]], 0.55),
        (Glass, Vec3::ONE, &[[3.45, 0.5, 2.8]], 0.5),
    ] {
        scene.add_spheres(centers, &vec![radius; centers.len()])?;
        materials.push((finish, color));
    }
    Ok(World(Bvh::build(&scene), scene, materials))
}

/// A pixel in sRGB through Narkowicz's ACES curve. Its random numbers depend on nothing else.
fn pixel(world: &World, pixel: [usize; 2], samples: u32) -> [u8; 3] {
    let mut seed = ((pixel[1] * SIZE[0] + pixel[0]) as u64) << 32;
    let sample = |_| {
        let [right, down] = pixel.map(|k| (k as f32 + random(&mut seed)) / SIZE[1] as f32);
        let along = vec3(0.78 * right - 0.52, 0.315 - 0.78 * down, -1.0).normalize();
        radiance(world, Ray::new([2.2, 1.6, 7.0], along), &mut seed)
    };
    let x = (0..samples).map(sample).sum::<Vec3>() / samples as f32;
    let film = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
    let srgb = |x: f32| (1.055 * x.powf(1.0 / 2.4) - 0.055).max(12.92 * x.min(0.0031));
    film.to_array().map(|x| (255.0 * srgb(x) + 0.5) as u8)
}

/// Light along a ray. Where a surface scatters, its shadow ray alone counts the lamp.
fn radiance(World(bvh, scene, materials): &World, mut ray: Ray, seed: &mut u64) -> Vec3 {
    let (mut sum, mut weight) = (Vec3::ZERO, Vec3::ONE);
    let (mut filter, mut scattered, mut soft) = (RayFilter::default(), false, false);
    while let Some(hit) = bvh.intersect_filtered(&ray, &filter) {
        let mat = materials[hit.geom_id as usize];
        if mat.0 == Light {
            return if scattered { sum } else { sum + weight * mat.1 };
        }
        let [from, along] = [ray.origin, ray.direction].map(|v| v.map(f64::from));
        let normal = DVec3::from(refine(scene, from, along, &hit).normal).as_vec3();
        let (direction, tint);
        (direction, tint, scattered) = bounce(mat, ray.direction.into(), normal, soft, seed);
        weight *= tint;
        soft |= scattered;
        if scattered {
            sum += weight * lamp_light(bvh, ray.at(hit.t).into(), normal, seed);
        }
        // Dim paths end early, at random; survivors make up for their light.
        let survival = weight.max_element().min(0.95);
        if random(seed) > survival {
            return sum;
        }
        weight /= survival;
        // A ray cannot hit the triangle or sphere that it leaves again, except inside glass.
        (filter.tnear, filter.ignore) = (1e-4, if mat.0 == Glass { NO_PRIM } else { hit.prim_id });
        ray = Ray::new(ray.at(hit.t), direction);
    }
    sum
}

/// Light from a random point of the lamp that a white surface scatters.
fn lamp_light(bvh: &Bvh, point: Vec3, normal: Vec3, seed: &mut u64) -> Vec3 {
    let (corner, [a, b], radiance) = LAMP;
    let to_lamp = corner + vec3(a * random(seed), 0.0, b * random(seed)) - point;
    let cosines = normal.dot(to_lamp).max(0.0) * to_lamp.y.max(0.0);
    // Starts above the surface and ends below the lamp, so that neither is in the way.
    let shadow = Ray::segment(point + 1e-4 * normal, point + 0.999 * to_lamp);
    let lit = f32::from(cosines > 0.0 && !bvh.occluded(&shadow));
    lit * radiance * cosines * a * b / (PI * to_lamp.length_squared().powi(2))
}

/// Next direction, tint, and whether it scatters. Mirrors would leave speckles in `soft` paths.
fn bounce(mat: (Finish, Vec3), d: Vec3, n: Vec3, soft: bool, seed: &mut u64) -> (Vec3, Vec3, bool) {
    let side = -d.dot(n).signum();
    let refracted = d.refract(side * n, 1.5f32.powf(-side));
    // Schlick's formula takes the cosine in air. Total reflection: `refracted` is zero.
    let cosine = d.dot(n).abs().min(refracted.dot(n).abs());
    let mirrors = random(seed) < 0.04 + 0.96 * (1.0 - cosine).powi(5);
    let (z, (sin, cos)) = (1.0 - 2.0 * random(seed), (TAU * random(seed)).sin_cos());
    let unit_vector = (1.0 - z * z).sqrt() * vec3(cos, sin, 0.0) + z * Vec3::Z;
    match mat.0 {
        Metal if !soft => (d.reflect(n), mat.1, false),
        Polished | Glass if mirrors && !soft => (d.reflect(n), Vec3::ONE, false),
        Glass => (refracted, Vec3::ONE, false),
        _ => ((n + 0.999 * unit_vector).normalize(), mat.1, true),
    }
}

/// A number in \[0, 1) by SplitMix64.
fn random(seed: &mut u64) -> f32 {
    *seed = seed.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let z = (*seed ^ (*seed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    ((z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB) >> 40) as f32 / (1 << 24) as f32
}
