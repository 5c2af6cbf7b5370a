//! Fingerprint of a scene: a checksum of everything that rays can hit.

use glam::Vec3;
use phalanx_scene::Scene;

/// CRC-32 over the geometry in the order of its numbers, and over the view and the lights'
/// positions, little-endian.
pub fn fingerprint(scene: &Scene) -> u32 {
    let mut crc = crc32fast::Hasher::new();
    let mut take = |numbers: &[f32]| {
        for number in numbers {
            crc.update(&number.to_le_bytes());
        }
    };
    for prim in scene.prims.iter() {
        let columns = scene.columns_of(prim.kind());
        columns.shape_numbers(prim.index(), &mut take);
    }
    for i in 0..scene.instances.len() {
        vectors(&mut take, &scene.instances.object_columns(i));
    }
    for i in 0..scene.lights.len() {
        // The target of shadow rays, for area lights as for point lights.
        take(&scene.lights.center(i).to_array());
    }
    vectors(
        &mut take,
        &[scene.view.eye, scene.view.center, scene.view.up],
    );
    take(&[scene.view.fovy]);
    // Scenes in older records had no origin; their checksum stays the same.
    if scene.is_moved() {
        let origin = scene.origin.map(f64::to_le_bytes);
        crc.update(origin.as_flattened());
    }
    crc.finalize()
}

fn vectors(take: &mut impl FnMut(&[f32]), vectors: &[Vec3]) {
    vectors.iter().for_each(|v| take(&v.to_array()));
}
