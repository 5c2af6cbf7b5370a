//! A standard scene as a `.test` file.

use super::out::{Number, Numbers, Out};
use super::{Losses, WriteError};
use crate::standard::sink::{Look, Sink, StandardLight, StandardView, nff_level};
use glam::{DVec3, Vec3};
use phalanx_scene::triangulate;
use std::io::Write;

/// A sink that writes the course's format: spheres and triangles; no cones. The background is black there.
pub struct TestSink<W: Write> {
    out: Out<W>,
    max_depth: u32,
    /// Written before the first surface, where their number, and with it their level, is known.
    lights: Vec<StandardLight>,
    lights_written: bool,
    vertices: u64,
    normal_vertices: u64,
    background: bool,
}

impl<W: Write> TestSink<W> {
    /// Writes to `out`, buffered; the file asks for `max_depth` bounces.
    pub fn new(out: W, max_depth: u32) -> Self {
        TestSink {
            out: Out::new(out),
            max_depth,
            lights: Vec::new(),
            lights_written: false,
            vertices: 0,
            normal_vertices: 0,
            background: false,
        }
    }

    /// Ends the file and says what it does not hold.
    ///
    /// # Errors
    /// The first error there was.
    pub fn finish(mut self) -> Result<Losses, WriteError> {
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
                Numbers(light.attenuation),
                Numbers(light.position),
                Numbers(color),
            ));
        }
    }

    fn vertex(&mut self, point: DVec3) {
        self.out.text(format_args!("vertex {}\n", Numbers(point)));
    }

    /// A triangle of the vertices from `first` on.
    fn triangle(&mut self, command: &str, first: u64, corners: [u32; 3]) {
        let [a, b, c] = corners.map(|k| first + u64::from(k));
        self.out.text(format_args!("{command} {a} {b} {c}\n"));
    }
}

impl<W: Write> Sink for TestSink<W> {
    fn view(&mut self, view: &StandardView) {
        self.out.text(format_args!(
            "size {} {}\nmaxdepth {}\ncamera {} {} {} {}\n",
            view.width,
            view.height,
            self.max_depth,
            Numbers(view.from),
            Numbers(view.at),
            Numbers(view.up),
            Number(view.fovy),
        ));
    }

    fn background(&mut self, rgb: DVec3) {
        self.background = rgb != DVec3::ZERO;
    }

    fn light(&mut self, light: &StandardLight) {
        self.lights.push(*light);
    }

    fn surface(&mut self, look: &Look) {
        self.write_lights();
        let look = look.document(nff_level(self.lights.len()));
        let colors = [
            ("ambient", look.ka),
            ("emission", look.ke),
            ("diffuse", look.kd),
            ("specular", look.ks),
            ("transmission", look.kt),
        ];
        for (command, color) in colors {
            self.out
                .text(format_args!("{command} {}\n", Numbers(color)));
        }
        self.out.text(format_args!(
            "shininess {}\nior {}\n",
            Number(look.shininess),
            Number(look.ior)
        ));
    }

    fn sphere(&mut self, center: DVec3, radius: f64) {
        self.out.text(format_args!(
            "sphere {} {}\n",
            Numbers(center),
            Number(radius)
        ));
    }

    fn cone(&mut self, _: DVec3, _: f64, _: DVec3, _: f64) {
        self.out.fail(WriteError::CannotHold {
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
                Numbers(point),
                Numbers(normal)
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
