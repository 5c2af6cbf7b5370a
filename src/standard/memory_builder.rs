//! A standard scene as a [`Scene`].

use super::builder::{DocumentMaterial, MaterialDesc, SceneBuilder, StandardLight, StandardView};
use super::mesh_slice::{MeshSlice, Prepare, PreparedMesh};
use glam::{DVec3, Vec3};
use phalanx_formats::nff_level;
use phalanx_formats::polygon::triangulate;
use phalanx_scene::{
    Column, Cone, Material, MaterialTable, Mesh, MeshMaterial, NO_TEXTURE, Scene, View,
};

/// A builder that fills a [`Scene`]'s columns.
#[derive(Debug, Default)]
pub struct MemoryBuilder {
    scene: Scene,
    lights: Vec<StandardLight>,
    table: MaterialTable,
    material: u32,
    /// [`SceneBuilder::threads`].
    pub threads: usize,
}

impl MemoryBuilder {
    /// The scene, not yet validated. Lights of NFF's level get their level here, now that their
    /// number is known.
    pub fn finish(mut self) -> Scene {
        let vertices = &mut self.scene.triangles.vertices;
        vertices
            .parts_mut()
            .into_iter()
            .for_each(Column::shrink_to_fit);
        let level = DVec3::splat(nff_level(self.lights.len()));
        for light in &self.lights {
            self.scene.lights.add_point(
                light.position.as_vec3(),
                light.color.unwrap_or(level).as_vec3(),
                light.attenuation.as_vec3(),
            );
        }
        self.scene
    }
}

fn material_of(material: &DocumentMaterial) -> Material {
    Material {
        ka: material.ka.as_vec3(),
        ke: material.ke.as_vec3(),
        kd: material.kd.as_vec3(),
        ks: material.ks.as_vec3(),
        kt: material.kt.as_vec3(),
        shininess: material.shininess as f32,
        ior: material.ior as f32,
        texture: NO_TEXTURE,
        ..Material::DEFAULT
    }
}

impl SceneBuilder for MemoryBuilder {
    fn view(&mut self, view: &StandardView) {
        self.scene.width = view.width;
        self.scene.height = view.height;
        self.scene.view = View {
            eye: view.from.as_vec3(),
            center: view.at.as_vec3(),
            up: view.up.as_vec3(),
            fovy: view.fovy as f32,
            ortho: None,
        };
    }

    fn background(&mut self, rgb: DVec3) {
        self.scene.background = rgb.as_vec3();
    }

    fn light(&mut self, light: &StandardLight) {
        self.lights.push(*light);
    }

    fn material(&mut self, material: &MaterialDesc) {
        let surface = material_of(&material.to_document(nff_level(self.lights.len())));
        self.material = self.table.intern(&surface, &mut self.scene.materials);
    }

    fn sphere(&mut self, center: DVec3, radius: f64) {
        self.scene
            .add_sphere(center.as_vec3(), radius as f32, self.material);
    }

    fn cone(&mut self, base: DVec3, base_radius: f64, apex: DVec3, apex_radius: f64) {
        let cone = Cone {
            base: base.as_vec3(),
            base_radius: base_radius as f32,
            apex: apex.as_vec3(),
            apex_radius: apex_radius as f32,
            inside: false,
        };
        self.scene.add_cone(cone, self.material);
    }

    fn polygon(&mut self, points: &[DVec3]) {
        let points: Vec<Vec3> = points.iter().map(|p| p.as_vec3()).collect();
        for triangle in triangulate(&points) {
            let corners = triangle.map(|k| points[k as usize]);
            self.scene.add_triangle(corners, None, self.material);
        }
    }

    fn patch(&mut self, points: &[(DVec3, DVec3)]) {
        let positions: Vec<Vec3> = points.iter().map(|(p, _)| p.as_vec3()).collect();
        for triangle in triangulate(&positions) {
            let corners = triangle.map(|k| positions[k as usize]);
            let normals = triangle.map(|k| points[k as usize].1.as_vec3());
            self.scene
                .add_triangle(corners, Some(normals), self.material);
        }
    }

    fn takes_count(&mut self, triangles: u64) -> bool {
        let (columns, rows) = (&mut self.scene.triangles, triangles as usize);
        columns.corners.reserve(rows);
        columns.material.reserve(rows);
        self.scene.prims.reserve(rows);
        // Their number is not known yet; what is not used is given back in the end.
        (columns.vertices.parts_mut().into_iter()).for_each(|part| part.reserve(rows));
        false
    }

    fn threads(&self) -> usize {
        self.threads
    }

    fn preparation(&self) -> Box<Prepare> {
        Box::new(|parts, _| prepare(parts))
    }

    fn prepared(&mut self, prepared: PreparedMesh) {
        self.scene.append_mesh(Mesh {
            material: MeshMaterial::One(self.material),
            ..prepared.mesh
        });
    }
}

/// The columns of a mesh, without a material.
fn prepare(parts: &[MeshSlice]) -> PreparedMesh {
    let mut prepared = PreparedMesh::sized(parts);
    let Mesh {
        vertices, corners, ..
    } = &mut prepared.mesh;
    let column = |axis: usize| {
        let mut column = Vec::with_capacity(prepared.vertices);
        for part in parts {
            column.extend(part.vertices().iter().map(|v| v[axis] as f32));
        }
        column.into()
    };
    (vertices.x, vertices.y, vertices.z) = (column(0), column(1), column(2));
    let mut rows = Vec::with_capacity(prepared.triangles);
    parts.iter().for_each(|part| rows.extend(part.triangles(0)));
    *corners = rows.into();
    prepared
}
