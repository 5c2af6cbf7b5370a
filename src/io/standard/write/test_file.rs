//! A standard scene as a `.test` file.

use super::latched::{DisplayNumber, DisplayVec3, LatchedWriter};
use super::outcome::{DroppedFeatures, SceneWriteError};
use crate::polygon::triangulate;
use crate::standard::builder::{
    MaterialDesc, SceneBuilder, StandardLight, StandardView, nff_level,
};
use glam::{DVec3, Vec3};
use std::io::Write;

/// A builder that writes the course's format: spheres and triangles; no cones. The background is
/// black in it.
pub struct TestWriter<W: Write> {
    out: LatchedWriter<W>,
    max_depth: u32,
    /// Lights to be written before the first surface, when their number, and so their level, is
    /// known.
    lights: Vec<StandardLight>,
    lights_written: bool,
    vertices: u64,
    normal_vertices: u64,
    background: bool,
}

impl<W: Write> TestWriter<W> {
    /// Writes to `out`, buffered; the file asks for `max_depth` bounces.
    pub fn new(out: W, max_depth: u32) -> Self {
        TestWriter {
            out: LatchedWriter::new(out),
            max_depth,
            lights: Vec::new(),
            lights_written: false,
            vertices: 0,
            normal_vertices: 0,
            background: false,
        }
    }

    /// Ends the file; returns the features it does not hold.
    ///
    /// # Errors
    /// The first error that occurred.
    pub fn finish(mut self) -> Result<DroppedFeatures, SceneWriteError> {
        self.write_lights();
        self.out.finish()?;
        let lost = self.background;
        Ok(lost
            .then_some("the background of a .test file is black")
            .into_iter()
            .collect())
    }

    fn write_lights(&mut self) {
        if self.lights_written {
            return;
        }
        self.lights_written = true;
        let level = DVec3::splat(nff_level(self.lights.len()));
        for light in &self.lights {
            let color = light.color.unwrap_or(level);
            self.out.text(format_args!(
                "attenuation {}\npoint {} {}\n",
                DisplayVec3(light.attenuation),
                DisplayVec3(light.position),
                DisplayVec3(color),
            ));
        }
    }

    fn vertex(&mut self, point: DVec3) {
        self.out
            .text(format_args!("vertex {}\n", DisplayVec3(point)));
    }

    /// A triangle of the vertices from `first` on.
    fn triangle(&mut self, command: &str, first: u64, corners: [u32; 3]) {
        let [a, b, c] = corners.map(|k| first + u64::from(k));
        self.out.text(format_args!("{command} {a} {b} {c}\n"));
    }
}

impl<W: Write> SceneBuilder for TestWriter<W> {
    fn view(&mut self, view: &StandardView) {
        self.out.text(format_args!(
            "size {} {}\nmaxdepth {}\ncamera {} {} {} {}\n",
            view.width,
            view.height,
            self.max_depth,
            DisplayVec3(view.from),
            DisplayVec3(view.at),
            DisplayVec3(view.up),
            DisplayNumber(view.fovy),
        ));
    }

    fn background(&mut self, rgb: DVec3) {
        self.background = rgb != DVec3::ZERO;
    }

    fn light(&mut self, light: &StandardLight) {
        self.lights.push(*light);
    }

    fn material(&mut self, material: &MaterialDesc) {
        self.write_lights();
        let material = material.to_document(nff_level(self.lights.len()));
        let colors = [
            ("ambient", material.ka),
            ("emission", material.ke),
            ("diffuse", material.kd),
            ("specular", material.ks),
            ("transmission", material.kt),
        ];
        for (command, color) in colors {
            self.out
                .text(format_args!("{command} {}\n", DisplayVec3(color)));
        }
        self.out.text(format_args!(
            "shininess {}\nior {}\n",
            DisplayNumber(material.shininess),
            DisplayNumber(material.ior)
        ));
    }

    fn sphere(&mut self, center: DVec3, radius: f64) {
        self.out.text(format_args!(
            "sphere {} {}\n",
            DisplayVec3(center),
            DisplayNumber(radius)
        ));
    }

    fn cone(&mut self, _: DVec3, _: f64, _: DVec3, _: f64) {
        self.out.fail(SceneWriteError::CannotHold {
            format: "a .test file",
            shape: "cones or cylinders",
        });
    }

    fn polygon(&mut self, points: &[DVec3]) {
        let rounded: Vec<Vec3> = points.iter().map(|p| p.as_vec3()).collect();
        let first = self.vertices;
        points.iter().for_each(|&point| self.vertex(point));
        self.vertices += points.len() as u64;
        for corners in triangulate(&rounded) {
            self.triangle("tri", first, corners);
        }
    }

    fn patch(&mut self, points: &[(DVec3, DVec3)]) {
        let first = self.normal_vertices;
        for &(point, normal) in points {
            self.out.text(format_args!(
                "vertexnormal {} {}\n",
                DisplayVec3(point),
                DisplayVec3(normal)
            ));
        }
        self.normal_vertices += points.len() as u64;
        let rounded: Vec<Vec3> = points.iter().map(|(p, _)| p.as_vec3()).collect();
        for corners in triangulate(&rounded) {
            self.triangle("trinormal", first, corners);
        }
    }

    fn mesh(&mut self, vertices: &[DVec3], triangles: &[[u32; 3]]) {
        let first = self.vertices;
        vertices.iter().for_each(|&point| self.vertex(point));
        self.vertices += vertices.len() as u64;
        for &corners in triangles {
            self.triangle("tri", first, corners);
        }
    }
}
