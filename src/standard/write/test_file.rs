//! A standard scene as a `.test` file.

use super::decimal::{Decimal, Decimals, push_vector};
use super::latched::LatchedWriter;
use super::outcome::{DroppedFeatures, SceneWriteError};
use crate::builder::{MaterialDesc, SceneBuilder, StandardLight, StandardView};
use crate::mesh_slice::{MeshSlice, Prepare, PreparedMesh};
use glam::{DVec3, Vec3};
use phalanx_formats::nff_level;
use phalanx_formats::polygon::triangulate;
use std::io::Write;

/// A builder that writes the course's format: spheres and triangles, but no cones, and a black
/// background.
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
    /// [`SceneBuilder::threads`].
    pub threads: usize,
}

impl<W: Write> TestWriter<W> {
    /// Writes to `out`, buffered; the file requests `max_depth` bounces.
    pub fn new(out: W, max_depth: u32) -> Self {
        TestWriter {
            out: LatchedWriter::new(out),
            max_depth,
            lights: Vec::new(),
            lights_written: false,
            vertices: 0,
            normal_vertices: 0,
            background: false,
            threads: 0,
        }
    }

    /// Ends the file; returns the features it does not hold.
    ///
    /// # Errors
    /// The first error that occurred.
    pub fn finish(mut self) -> Result<DroppedFeatures, SceneWriteError> {
        self.write_lights();
        self.out.finish()?;
        let black = "the background of a .test file is black";
        Ok(self.background.then_some(black).into_iter().collect())
    }

    fn write_lights(&mut self) {
        if self.lights_written {
            return;
        }
        self.lights_written = true;
        let level = DVec3::splat(nff_level(self.lights.len()));
        for light in &self.lights {
            let color = light.color.unwrap_or(level);
            let [fading, position, color] =
                [light.attenuation, light.position, color].map(Decimals);
            writeln!(self.out, "attenuation {fading}\npoint {position} {color}");
        }
    }
}

impl<W: Write> SceneBuilder for TestWriter<W> {
    fn view(&mut self, view: &StandardView) {
        writeln!(self.out, "size {} {}", view.width, view.height);
        writeln!(self.out, "maxdepth {}", self.max_depth);
        let [from, center, up] = [view.from, view.at, view.up].map(Decimals);
        writeln!(
            self.out,
            "camera {from} {center} {up} {}",
            Decimal(view.fovy)
        );
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
            writeln!(self.out, "{command} {}", Decimals(color));
        }
        let [shininess, ior] = [material.shininess, material.ior].map(Decimal);
        writeln!(self.out, "shininess {shininess}\nior {ior}");
    }

    fn sphere(&mut self, center: DVec3, radius: f64) {
        writeln!(self.out, "sphere {} {}", Decimals(center), Decimal(radius));
    }

    fn cone(&mut self, _: DVec3, _: f64, _: DVec3, _: f64) {
        self.out.cannot_hold("a .test file", "cones or cylinders");
    }

    fn polygon(&mut self, points: &[DVec3]) {
        let rounded: Vec<Vec3> = points.iter().map(|p| p.as_vec3()).collect();
        self.mesh(points, &triangulate(&rounded));
    }

    fn patch(&mut self, points: &[(DVec3, DVec3)]) {
        let first = self.normal_vertices;
        for &(point, normal) in points {
            let [point, normal] = [point, normal].map(Decimals);
            writeln!(self.out, "vertexnormal {point} {normal}");
        }
        self.normal_vertices += points.len() as u64;
        let rounded: Vec<Vec3> = points.iter().map(|(p, _)| p.as_vec3()).collect();
        for corners in triangulate(&rounded) {
            let [a, b, c] = corners.map(|k| first + u64::from(k));
            writeln!(self.out, "trinormal {a} {b} {c}");
        }
    }

    fn threads(&self) -> usize {
        self.threads
    }

    fn preparation(&self) -> Box<Prepare> {
        let vertices = self.vertices;
        Box::new(move |parts, before| prepare(parts, vertices + before))
    }

    fn prepared(&mut self, mesh: PreparedMesh) {
        self.vertices += mesh.vertices as u64;
        self.out.bytes(&mesh.bytes);
    }
}

/// The vertices of a mesh, the first of which has the number `first`, and its triangles.
fn prepare(parts: &[MeshSlice], first: u64) -> PreparedMesh {
    let mut prepared = PreparedMesh::sized(parts);
    let out = &mut prepared.bytes;
    for &vertex in parts.iter().flat_map(MeshSlice::vertices) {
        out.extend_from_slice(b"vertex ");
        push_vector(out, vertex);
        out.push(b'\n');
    }
    let mut digits = itoa::Buffer::new();
    for part in parts {
        for corners in part.triangles(0) {
            out.extend_from_slice(b"tri");
            for corner in corners {
                out.push(b' ');
                let number = digits.format(first + u64::from(corner));
                out.extend_from_slice(number.as_bytes());
            }
            out.push(b'\n');
        }
    }
    prepared
}
