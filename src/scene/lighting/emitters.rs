//! Surfaces that emit light: their materials, and their triangles.

use super::luminance;
use crate::environment::EnvironmentLight;
use crate::materials::SINGLE_SIDED;
use crate::prims::PrimKind;
use crate::sampling::linear_of_srgb;
use crate::scene::Scene;
use crate::texture_maps::MapTarget;
use crate::textures::Texture;
use glam::{DVec3, Vec3};
use std::collections::HashMap;
use std::f64::consts::PI;

/// Light of a unit of area of each material: the mean luminance of its emission, times its sides
/// and its opacity, as if the alpha of textures and vertices were 1. Zero for all where emission
/// lights nothing.
pub(super) fn emissions(scene: &Scene) -> Vec<f64> {
    let materials = &scene.materials;
    let mut means = HashMap::new();
    let mut emission = |material: usize| {
        let mut ke = materials.ke.get(material).max(Vec3::ZERO);
        if !scene.emission_lights || luminance(ke) == 0.0 {
            return 0.0;
        }
        for map in scene.maps.range(materials.maps[material]) {
            if map.target == MapTarget::Emission {
                let texture = &scene.textures[map.texture as usize];
                ke *= *means.entry(map.texture).or_insert_with(|| mean(texture));
            }
        }
        let sides = if materials.flags[material] & SINGLE_SIDED != 0 { 1.0 } else { 2.0 };
        luminance(ke) * sides * f64::from(materials.opacity[material])
    };
    (0..materials.len()).map(&mut emission).collect()
}

/// Mean luminance of the environment over all directions: that of a white Lambert surface which
/// faces it.
pub(super) fn surroundings(scene: &Scene) -> f64 {
    let Some(environment) = &scene.environment else {
        return 0.0;
    };
    let mean = match &environment.light {
        &EnvironmentLight::Gradient { nadir, zenith } => luminance(nadir + zenith) / 2.0,
        EnvironmentLight::Map(map) => {
            // A row's share of the sphere is that of its height (Archimedes).
            let height = |row: usize| libm::cos(PI * row as f64 / f64::from(map.height)) / 2.0;
            let width = map.width as usize;
            let row_mean = |row: usize| {
                let texels = row * width..(row + 1) * width;
                let sum: f64 = texels.map(|k| luminance(map.texels.get(k))).sum();
                sum / width as f64 * (height(row) - height(row + 1))
            };
            (0..map.height as usize).map(row_mean).sum()
        }
    };
    mean * f64::from(environment.scale)
}

/// Mean of a texture's texels, decoded from sRGB.
fn mean(texture: &Texture) -> Vec3 {
    let linear = linear_of_srgb();
    let decoded = |texel: &[u8; 3]| DVec3::from_array(texel.map(|c| linear[usize::from(c)].into()));
    let sum: DVec3 = texture.texels.iter().map(decoded).sum();
    (sum / texture.texels.len() as f64).as_vec3()
}

/// Passes every visible triangle whose material emits light to `add`: its `prim_id`, its material
/// and its area in the world.
pub(super) fn for_each_triangle(
    scene: &Scene,
    emissions: &[f64],
    mut add: impl FnMut(u32, u32, f64),
) {
    if emissions.iter().all(|&emission| emission == 0.0) {
        return;
    }
    let emits = |&prim: &u32| {
        let is_triangle = scene.prims[prim as usize].kind() == PrimKind::Triangle;
        is_triangle && emissions[scene.prim_material(prim) as usize] > 0.0
    };
    let mut add_prim = |prim: u32, id: u32, [x, y, z, _]: [DVec3; 4]| {
        let triangle = scene.prims[prim as usize].index();
        let [a, b, c] = scene.triangles.corners(triangle).map(Vec3::as_dvec3);
        let [e, f] = [b - a, c - a].map(|edge| x * edge.x + y * edge.y + z * edge.z);
        add(id, scene.prim_material(prim), e.cross(f).length() / 2.0);
    };
    for prim in scene.world_runs().into_iter().flatten().filter(emits) {
        add_prim(prim, prim, [DVec3::X, DVec3::Y, DVec3::Z, DVec3::ZERO]);
    }
    let of_mesh = |mesh| Vec::from_iter(scene.meshes.prims(mesh).filter(emits));
    let meshes: Vec<Vec<u32>> = (0..scene.meshes.len()).map(of_mesh).collect();
    for instance in scene.visible_instances() {
        let mesh = scene.instances.mesh[instance] as usize;
        let to_world = scene.instances.world_columns(instance).map(Vec3::as_dvec3);
        for &prim in &meshes[mesh] {
            let offset = prim - scene.meshes.first[mesh];
            add_prim(prim, scene.instance_first_id(instance) + offset, to_world);
        }
    }
}
