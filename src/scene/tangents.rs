//! Normal maps of materials, and tangents of triangles that have one and whose file gives none.

use crate::prims::{NO_INDEX, Triangles};
use crate::scene::Scene;
use crate::texture_maps::{MapTarget, TextureMap};
use glam::Vec3;

impl Scene {
    /// The normal map of a material, if it has one.
    #[inline]
    pub fn normal_map(&self, material: u32) -> Option<TextureMap> {
        if self.maps.is_empty() {
            return None;
        }
        let mut maps = self.maps.range(self.materials.maps[material as usize]);
        maps.find(|map| map.target == MapTarget::Normal)
    }

    /// Gives a tangent to each triangle that has none and whose material has a normal map: the
    /// direction in which u grows, and the sign of the bitangent by mikktspace's convention.
    /// Triangles whose texture coordinates span no area keep none, and are not bumped.
    pub fn add_missing_tangents(&mut self) {
        if self.maps.is_empty() {
            return;
        }
        let layers: Vec<Option<u32>> = (0..self.materials.len() as u32)
            .map(|material| self.normal_map(material).map(|map| map.uv_layer))
            .collect();
        let t = &mut self.triangles;
        for i in 0..t.len() {
            let Some(layer) = layers[t.material[i] as usize] else {
                continue;
            };
            if t.corner_tangents(i).is_some() {
                continue;
            }
            if let Some((tangent, sign)) = face_tangent(t, i, layer) {
                let row = t.vertex_tangents.len() as u32;
                t.vertex_tangents.push(tangent);
                t.bitangent_signs.push(sign);
                if t.tangents.is_empty() {
                    t.tangents = vec![[NO_INDEX; 3]; t.len()].into();
                }
                t.tangents[i] = [row; 3];
            }
        }
    }
}

/// Direction of growing u on a triangle, and the sign of its bitangent: dP/du, and 1 if normal ×
/// tangent points against growing v.
fn face_tangent(t: &Triangles, i: usize, layer: u32) -> Option<(Vec3, f32)> {
    let [a, b, c] = t.corners(i).map(Vec3::as_dvec3);
    let [ua, ub, uc] = t.corner_uvs(i, layer)?.map(|uv| uv.as_dvec2());
    let (e1, e2, d1, d2) = (b - a, c - a, ub - ua, uc - ua);
    let area = d1.perp_dot(d2);
    let along = (e1 * d2.y - e2 * d1.y) * area.signum();
    let tangent = along.normalize_or_zero().as_vec3();
    if area == 0.0 || tangent == Vec3::ZERO {
        return None;
    }
    // Vertex normals against the winding turn the cross product around.
    let outward = t.corner_normals(i).map_or(1.0, |[na, nb, nc]| {
        (na + nb + nc).as_dvec3().dot(e1.cross(e2))
    });
    let sign = if (area < 0.0) == (outward >= 0.0) { 1.0 } else { -1.0 };
    Some((tangent, sign))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Material, Mesh};
    use glam::Vec2;

    /// Two triangles of a square in the plane z = 0, with v downward if `v` is −1.
    fn square([u, v]: [f32; 2], normal: Option<Vec3>) -> Vec<Option<(Vec3, f32)>> {
        let mut scene = Scene::default();
        let map = TextureMap {
            target: MapTarget::Normal,
            texture: 0,
            channel: 0,
            uv_layer: 1,
            scale: 1.0,
        };
        let maps = scene.maps.push_all(&[map]);
        scene.materials.push(&Material {
            maps,
            ..Material::DEFAULT
        });
        let mut mesh = Mesh {
            corners: vec![[0, 1, 2], [0, 2, 3]].into(),
            // The second triangle's coordinates coincide.
            uvs: vec![[0, 2, 4], [0, 0, 0]].into(),
            ..Mesh::default()
        };
        for [x, y] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
            mesh.vertices.push(Vec3::new(x, y, 0.0));
            mesh.vertex_uvs.push(Vec2::splat(7.0));
            mesh.vertex_uvs.push(Vec2::new(u * x, v * y));
        }
        if let Some(normal) = normal {
            mesh.vertex_normals.push(normal);
            mesh.normals = vec![[0; 3]; 2].into();
        }
        scene.append_mesh(mesh);
        scene.add_missing_tangents();
        let t = &scene.triangles;
        let all = (0..2).map(|i| t.corner_tangents(i).map(|([a, ..], sign)| (a, sign)));
        all.collect()
    }

    #[test]
    fn the_bitangent_points_to_the_upper_edge_of_the_picture() {
        for normal in [None, Some(Vec3::Z)] {
            assert_eq!(square([1.0, -1.0], normal), [Some((Vec3::X, 1.0)), None]);
            assert_eq!(square([1.0, 1.0], normal)[0], Some((Vec3::X, -1.0)));
            assert_eq!(square([-1.0, -1.0], normal)[0], Some((-Vec3::X, -1.0)));
        }
        let inward = square([1.0, -1.0], Some(-Vec3::Z));
        assert_eq!(inward[0], Some((Vec3::X, -1.0)));
    }
}
