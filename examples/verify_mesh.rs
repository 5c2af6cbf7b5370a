//! Both engines on your own mesh, compared bit for bit, as a test suite would do with the meshes
//! that matter to it. `cargo run --release --example verify_mesh`.

use phalanx::glam::Vec3;
use phalanx::oracle::{Oracle, OracleRay, OracleSearch, TwoLevelBvh};
use phalanx::{Bvh, HitBuffer, Ray, RayBuffer, Scene};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (vertices, indices) = saddle(100);
    let compared = verify(&vertices, &indices, 100_000)?;
    println!(
        "{compared} rays against {} triangles: identical",
        indices.len()
    );
    Ok(())
}

/// Casts rays through the box of a mesh with both engines.
///
/// # Panics
/// If any bit differs.
fn verify(
    vertices: &[[f32; 3]],
    indices: &[[u32; 3]],
    count: usize,
) -> Result<usize, Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    scene.add_mesh(vertices, indices)?;
    let bounds = scene.bounds();
    let mut random = random_numbers();
    let mut point = || bounds.lo + (bounds.hi - bounds.lo) * Vec3::from([0, 1, 2].map(&mut random));
    let rays: Vec<Ray> = (0..count).map(|_| Ray::segment(point(), point())).collect();

    let bvh = Bvh::build(&scene);
    let columns: RayBuffer = rays.iter().copied().collect();
    let mut hits = HitBuffer::new(count);
    bvh.intersect_batch(&columns.columns(), &mut hits.columns(), 0)?;

    // The oracle: one ray at a time, another tree, no code in common with the packets.
    let tree = TwoLevelBvh::build(&scene);
    let oracle = Oracle::new(&scene, OracleSearch::Tree(&tree));
    for (ray, hit) in rays.iter().zip(hits.iter()) {
        let oracle_ray = OracleRay::new(ray.origin.into(), ray.direction.into());
        let expected = oracle.closest(&oracle_ray).filter(|hit| hit.t < ray.tmax);
        let expected = expected.map(|h| ([h.t, h.u, h.v].map(f32::to_bits), h.prim_id));
        let actual = hit.map(|h| ([h.t, h.u, h.v].map(f32::to_bits), h.prim_id));
        assert_eq!(actual, expected, "{ray:?}");
    }
    Ok(count)
}

/// Numbers in \[0, 1), the same in every run.
fn random_numbers() -> impl FnMut(usize) -> f32 {
    let mut state = 1u32;
    move |_| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    }
}

/// A saddle of `side`² squares, two triangles each.
fn saddle(side: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let coordinate = |k: u32| 2.0 * k as f32 / side as f32 - 1.0;
    let vertex = |i: u32| {
        let [x, z] = [coordinate(i % (side + 1)), coordinate(i / (side + 1))];
        [x, x * x - z * z, z]
    };
    let squares = (0..side).flat_map(|z| (0..side).map(move |x| z * (side + 1) + x));
    let halves = |a: u32| {
        let below = a + side + 1;
        [[a, below, a + 1], [a + 1, below, below + 1]]
    };
    let vertices = (0..(side + 1) * (side + 1)).map(vertex).collect();
    (vertices, squares.flat_map(halves).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn my_mesh_is_traced_exactly() {
        let (vertices, indices) = saddle(20);
        assert_eq!(verify(&vertices, &indices, 5000).unwrap(), 5000);
    }
}
