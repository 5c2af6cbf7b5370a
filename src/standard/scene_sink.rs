//! A standard scene as a [`Scene`].

use super::sink::{Look, Sink, StandardLight, StandardView, nff_level};
use crate::scene::{Scene, View};
use glam::DVec3;

/// A sink that fills a [`Scene`]'s columns.
#[derive(Debug, Default)]
pub struct SceneSink {
    scene: Scene,
    lights: Vec<StandardLight>,
    material: u32,
}

impl SceneSink {
    /// The scene. Lights of NFF's level get it here, where their number is known.
    pub fn finish(mut self) -> Scene {
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

impl Sink for SceneSink {
    fn view(&mut self, view: &StandardView) {
        self.scene.width = view.width;
        self.scene.height = view.height;
        self.scene.view = View {
            eye: view.from.as_vec3(),
            center: view.at.as_vec3(),
            up: view.up.as_vec3(),
            fovy: view.fovy as f32,
        };
    }

    fn background(&mut self, rgb: DVec3) {
        self.scene.background = rgb.as_vec3();
    }

    fn light(&mut self, light: &StandardLight) {
        self.lights.push(*light);
    }

    fn surface(&mut self, look: &Look) {
        // TODO(core): one row per distinct surface by scene::Palette.
        let look = look.document(nff_level(self.lights.len()));
        let m = &mut self.scene.materials;
        self.material = m.len() as u32;
        m.ka.push(look.ka.as_vec3());
        m.ke.push(look.ke.as_vec3());
        m.kd.push(look.kd.as_vec3());
        m.ks.push(look.ks.as_vec3());
        m.kt.push(look.kt.as_vec3());
        m.shininess.push(look.shininess as f32);
        m.ior.push(look.ior as f32);
    }

    fn sphere(&mut self, center: DVec3, radius: f64) {
        self.scene
            .add_sphere(center.as_vec3(), radius as f32, self.material);
    }

    fn cone(&mut self, _: DVec3, _: f64, _: DVec3, _: f64) {
        // TODO(core): scene.add_cone.
    }

    fn polygon(&mut self, points: &[DVec3]) {
        // TODO(core): scene::triangulate for concave ones.
        for i in 2..points.len() {
            let corners = [points[0], points[i - 1], points[i]].map(|p| p.as_vec3());
            self.scene.add_triangle(corners, None, self.material);
        }
    }

    fn patch(&mut self, points: &[(DVec3, DVec3)]) {
        for i in 2..points.len() {
            let corners = [points[0], points[i - 1], points[i]];
            let normals = corners.map(|(_, normal)| normal.as_vec3());
            let corners = corners.map(|(point, _)| point.as_vec3());
            self.scene
                .add_triangle(corners, Some(normals), self.material);
        }
    }

    fn mesh(&mut self, vertices: &[DVec3], triangles: &[[u32; 3]]) {
        // TODO(core): indexed columns.
        for triangle in triangles {
            let corners = triangle.map(|i| vertices[i as usize].as_vec3());
            self.scene.add_triangle(corners, None, self.material);
        }
    }
}
