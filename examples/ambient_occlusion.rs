//! The share of the sky that each vertex of a mesh sees, as baked by a modelling tool:
//! `cargo run --release --example ambient_occlusion`.

use phalanx::glam::Vec3;
use phalanx::{Bvh, RayColumns, Scene, TMax};

/// Vertices along each side of the bowl, and rays per vertex.
const SIDE: u32 = 65;
const RAYS: usize = 64;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (vertices, triangles) = bowl();
    let mut scene = Scene::new();
    scene.add_mesh(&vertices, &triangles)?;
    let bvh = Bvh::build(&scene);

    let normals = vertex_normals(&vertices, &triangles);
    let count = vertices.len() * RAYS;
    let mut columns = [(); 6].map(|()| Vec::with_capacity(count));
    for (&vertex, &normal) in vertices.iter().zip(&normals) {
        // Off the surface, so that rays do not hit the triangles they start on.
        let origin = Vec3::from(vertex) + 1e-3 * normal;
        for k in 0..RAYS {
            let numbers = origin
                .to_array()
                .into_iter()
                .chain(cosine_ray(normal, k).to_array());
            columns
                .iter_mut()
                .zip(numbers)
                .for_each(|(column, x)| column.push(x));
        }
    }
    let [x, y, z, dx, dy, dz] = columns.each_ref().map(Vec::as_slice);
    let rays = RayColumns {
        origin: [x, y, z],
        direction: [dx, dy, dz],
        // Occluders farther away than this have no effect.
        tmax: TMax::All(2.0),
    };
    let mut blocked = vec![false; count];
    bvh.occluded_batch(&rays, &mut blocked, 0)?;

    let open = |rays: &[bool]| rays.iter().filter(|&&dark| !dark).count() as f32 / RAYS as f32;
    let sky: Vec<f32> = blocked.chunks(RAYS).map(open).collect();
    println!(
        "{count} rays for {} vertices; the sky along the middle of the bowl:",
        sky.len()
    );
    let middle = (SIDE / 2 * SIDE) as usize;
    for (vertex, sky) in vertices
        .iter()
        .zip(&sky)
        .skip(middle)
        .take(SIDE as usize)
        .step_by(8)
    {
        println!(
            "x = {:5.2}  {:3.0} %  {}",
            vertex[0],
            100.0 * sky,
            "#".repeat((40.0 * sky) as usize)
        );
    }
    Ok(())
}

/// A parabolic hollow in a plain, from −1 to 1.
fn bowl() -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let coordinate = |k: u32| 2.0 * k as f32 / (SIDE - 1) as f32 - 1.0;
    let vertex = |i: u32| {
        let (x, z) = (coordinate(i % SIDE), coordinate(i / SIDE));
        [x, -1.2 * (0.64 - x * x - z * z).max(0.0), z]
    };
    let quads = (0..SIDE - 1).flat_map(|z| (0..SIDE - 1).map(move |x| z * SIDE + x));
    let halves = |a: u32| [[a, a + SIDE, a + 1], [a + 1, a + SIDE, a + SIDE + 1]];
    (
        (0..SIDE * SIDE).map(vertex).collect(),
        quads.flat_map(halves).collect(),
    )
}

/// Normalised sums of the normals of the triangles around each vertex.
fn vertex_normals(vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; vertices.len()];
    for corners in triangles {
        let [a, b, c] = corners.map(|i| Vec3::from(vertices[i as usize]));
        let normal = (b - a).cross(c - a);
        corners.iter().for_each(|&i| normals[i as usize] += normal);
    }
    normals.into_iter().map(Vec3::normalize_or_zero).collect()
}

/// The k-th of [`RAYS`] directions about a normal, dense where the cosine is large: a point of a
/// Fibonacci spiral on the unit sphere, added to the normal (Lambert's law).
fn cosine_ray(normal: Vec3, k: usize) -> Vec3 {
    let z = 1.0 - (2 * k + 1) as f32 / RAYS as f32;
    let (sin, cos) = (2.399_963 * k as f32).sin_cos();
    let r = (1.0 - z * z).sqrt();
    normal + 0.999 * Vec3::new(r * cos, r * sin, z)
}
