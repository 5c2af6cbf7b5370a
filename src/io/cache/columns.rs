//! Every column of a scene, twice, because a scene that is written is shared and one that is mapped
//! is not: as the sections of a file to be written or checked, and as the columns that sections are
//! mapped to.

use super::check::Check;
use super::mapping::Mapping;
use bytemuck::Pod;
use phalanx_scene::{Column, NO_COLORS, NO_NORMALS, NO_UVS, Scene, Vec3s};
use std::ops::Range;
use std::sync::Arc;

/// A column to be written, or to be checked once it is mapped.
pub(super) struct ColumnBytes<'a> {
    pub(super) name: &'static str,
    pub(super) row_bytes: usize,
    pub(super) bytes: &'a [u8],
    pub(super) check: Check,
}

/// Columns as the rows of a table.
#[derive(Default)]
struct ColumnTable<'a>(Vec<ColumnBytes<'a>>);

impl<'a> ColumnTable<'a> {
    fn add<T: Pod>(&mut self, name: &'static str, column: &'a [T], check: Check) {
        self.0.push(ColumnBytes {
            name,
            row_bytes: size_of::<T>(),
            bytes: bytemuck::cast_slice(column),
            check,
        });
    }

    /// Adds the components of vectors, which are finite.
    fn add_vectors<const N: usize>(&mut self, name: &'static str, vectors: [&'a Vec3s; N]) {
        for part in vectors.into_iter().flat_map(|v| v.parts()) {
            self.add(name, part, Check::Finite);
        }
    }
}

/// A column that a section is mapped to.
pub(super) trait MapColumn {
    /// Maps the column to the rows in this part of the file; false if the bytes are no rows.
    fn map(&mut self, mapping: &Arc<Mapping>, range: Range<usize>) -> bool;
}

impl<T: Pod> MapColumn for Column<T> {
    fn map(&mut self, mapping: &Arc<Mapping>, range: Range<usize>) -> bool {
        let column = mapping.column(range);
        let found = column.is_some();
        *self = column.unwrap_or_default();
        found
    }
}

/// The columns of a scene except its texels, with the condition on every row of each.
///
/// These conditions are those that [`Scene::validate`] checks for every row, so that only
/// [`Scene::validate_settings`] is left to call.
pub(super) fn columns(scene: &Scene) -> Vec<ColumnBytes<'_>> {
    use Check::{Any, Below, Color, Corners, Finite, Positive, Prims, UnitInterval};
    let (s, e, t, c) = (
        &scene.spheres,
        &scene.ellipsoids,
        &scene.triangles,
        &scene.cones,
    );
    let (i, m, l) = (&scene.instances, &scene.materials, &scene.lights);
    let prims = Prims(scene.counts());
    let corners = |count, none| Corners { count, none };
    let vertices = corners(t.vertices.len(), None);
    let normals = corners(t.vertex_normals.len(), Some(NO_NORMALS));
    let uvs = corners(t.vertex_uvs.len(), Some(NO_UVS));
    let colors = corners(t.vertex_colors.len(), Some(NO_COLORS));
    let material = Below(m.len());
    let mut all = ColumnTable::default();
    all.add("primitive list", &scene.prims, prims);
    all.add_vectors("vertices", [&t.vertices]);
    all.add("triangle corners", &t.corners, vertices);
    all.add("triangle normals", &t.normals, normals);
    all.add_vectors("vertex normals", [&t.vertex_normals]);
    all.add("triangle texture places", &t.uvs, uvs);
    all.add("texture places", &t.vertex_uvs.x, Finite);
    all.add("texture places", &t.vertex_uvs.y, Finite);
    all.add("triangle colours", &t.colors, colors);
    for part in t.vertex_colors.parts() {
        all.add("vertex colours", part, Color);
    }
    all.add("vertex opacity", &t.vertex_opacity, UnitInterval);
    all.add("triangle materials", &t.material, material);
    all.add_vectors("sphere centres", [&s.center]);
    all.add("sphere radii", &s.radius, Positive);
    all.add("sphere materials", &s.material, material);
    all.add_vectors("ellipsoid maps", e.to_world.each_ref());
    all.add_vectors("ellipsoid maps", e.to_object.each_ref());
    all.add("ellipsoid materials", &e.material, material);
    // Cones, geometries, instances, materials and lights are checked in `Scene::validate_settings`.
    all.add_vectors("cones", [&c.base, &c.apex]);
    all.add("cone radii", &c.base_radius, Any);
    all.add("cone radii", &c.apex_radius, Any);
    all.add("cone sides", &c.inside, Any);
    all.add("cone materials", &c.material, material);
    all.add("meshes", &scene.meshes.first, Any);
    all.add("meshes", &scene.meshes.count, Any);
    all.add("geometries", &scene.geometries.first, Any);
    all.add("geometries", &scene.geometries.count, Any);
    all.add("instances", &i.mesh, Below(scene.meshes.len()));
    all.add("instances", &i.first, Any);
    all.add_vectors("instance maps", i.to_world.each_ref());
    all.add_vectors("instance maps", i.to_object.each_ref());
    all.add_vectors("materials", [&m.ka, &m.ke, &m.kd, &m.ks, &m.kt]);
    all.add("materials", &m.shininess, Any);
    all.add("materials", &m.ior, Any);
    all.add("materials", &m.texture, Any);
    all.add("material gloss", &m.gloss, Any);
    all.add("material opacity", &m.opacity, Any);
    all.add("material opacity", &m.opacity_texture, Any);
    all.add("material opacity", &m.alpha_cutoff, Any);
    all.add("material flags", &m.flags, Any);
    all.add_vectors("lights", [&l.position, &l.color, &l.attenuation]);
    all.add_vectors("light edges", l.edges.each_ref());
    all.add("light radii", &l.radius, Any);
    all.add_vectors("light cones", [&l.axis]);
    all.add("light cones", &l.cone.x, Any);
    all.add("light cones", &l.cone.y, Any);
    all.0
}

/// The columns of [`columns`], in the same order, to be mapped.
pub(super) fn columns_mut(scene: &mut Scene) -> Vec<&mut dyn MapColumn> {
    let (s, e, t, c) = (
        &mut scene.spheres,
        &mut scene.ellipsoids,
        &mut scene.triangles,
        &mut scene.cones,
    );
    let (i, m, l) = (
        &mut scene.instances,
        &mut scene.materials,
        &mut scene.lights,
    );
    let mut all: Vec<&mut dyn MapColumn> = vec![&mut scene.prims];
    push_maps(&mut all, [&mut t.vertices]);
    all.push(&mut t.corners);
    all.push(&mut t.normals);
    push_maps(&mut all, [&mut t.vertex_normals]);
    all.push(&mut t.uvs);
    all.push(&mut t.vertex_uvs.x);
    all.push(&mut t.vertex_uvs.y);
    all.push(&mut t.colors);
    push_maps(&mut all, [&mut t.vertex_colors]);
    all.push(&mut t.vertex_opacity);
    all.push(&mut t.material);
    push_maps(&mut all, [&mut s.center]);
    all.push(&mut s.radius);
    all.push(&mut s.material);
    push_maps(&mut all, e.to_world.each_mut());
    push_maps(&mut all, e.to_object.each_mut());
    all.push(&mut e.material);
    push_maps(&mut all, [&mut c.base, &mut c.apex]);
    all.push(&mut c.base_radius);
    all.push(&mut c.apex_radius);
    all.push(&mut c.inside);
    all.push(&mut c.material);
    all.push(&mut scene.meshes.first);
    all.push(&mut scene.meshes.count);
    all.push(&mut scene.geometries.first);
    all.push(&mut scene.geometries.count);
    all.push(&mut i.mesh);
    all.push(&mut i.first);
    push_maps(&mut all, i.to_world.each_mut());
    push_maps(&mut all, i.to_object.each_mut());
    push_maps(
        &mut all,
        [&mut m.ka, &mut m.ke, &mut m.kd, &mut m.ks, &mut m.kt],
    );
    all.push(&mut m.shininess);
    all.push(&mut m.ior);
    all.push(&mut m.texture);
    all.push(&mut m.gloss);
    all.push(&mut m.opacity);
    all.push(&mut m.opacity_texture);
    all.push(&mut m.alpha_cutoff);
    all.push(&mut m.flags);
    push_maps(
        &mut all,
        [&mut l.position, &mut l.color, &mut l.attenuation],
    );
    push_maps(&mut all, l.edges.each_mut());
    all.push(&mut l.radius);
    push_maps(&mut all, [&mut l.axis]);
    all.push(&mut l.cone.x);
    all.push(&mut l.cone.y);
    all
}

fn push_maps<'a, const N: usize>(
    all: &mut Vec<&'a mut dyn MapColumn>,
    vectors: [&'a mut Vec3s; N],
) {
    for vector in vectors {
        all.extend(vector.parts_mut().map(|part| part as &mut dyn MapColumn));
    }
}
