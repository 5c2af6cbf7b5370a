//! A standard scene as an NFF file.

use super::latched::{DisplayNumber, DisplayVec3, LatchedWriter};
use super::outcome::{DroppedFeatures, SceneWriteError};
use crate::standard::builder::{
    DocumentMaterial, MaterialDesc, NffMaterial, SceneBuilder, StandardLight, StandardView,
};
use glam::DVec3;
use std::io::Write;

/// A builder that writes NFF, which can hold every shape; meshes become triangles.
///
/// The document's materials are reduced: NFF holds Kd, the means of Ks and Kt, the exponent and the
/// index of refraction.
pub struct NffWriter<W: Write> {
    out: LatchedWriter<W>,
    fading: bool,
    reduced: bool,
}

impl<W: Write> NffWriter<W> {
    /// Writes to `out`, buffered.
    pub fn new(out: W) -> Self {
        NffWriter {
            out: LatchedWriter::new(out),
            fading: false,
            reduced: false,
        }
    }

    /// Ends the file; returns the features it does not hold.
    ///
    /// # Errors
    /// The first error that occurred.
    pub fn finish(self) -> Result<DroppedFeatures, SceneWriteError> {
        self.out.finish()?;
        let losses = [
            (self.fading, "NFF's lights do not fade with distance"),
            (
                self.reduced,
                "NFF's surfaces have no colours of their own for ambient, emitted, mirrored and transmitted light",
            ),
        ];
        let told = losses.into_iter().filter(|&(lost, _)| lost);
        Ok(told.map(|(_, what)| what).collect())
    }

    fn corners(&mut self, points: impl ExactSizeIterator<Item = DVec3>) {
        self.out.text(format_args!("p {}\n", points.len()));
        for point in points {
            self.out.text(format_args!("{}\n", DisplayVec3(point)));
        }
    }
}

/// The closest NFF material: diffuse with Kd 1, the rest white.
fn nff_material(material: &DocumentMaterial) -> NffMaterial {
    let mean = |c: DVec3| (c.x + c.y + c.z) / 3.0;
    NffMaterial {
        rgb: material.kd,
        kd: 1.0,
        ks: mean(material.ks),
        shine: material.shininess,
        transmittance: mean(material.kt),
        ior: material.ior,
    }
}

impl<W: Write> SceneBuilder for NffWriter<W> {
    fn view(&mut self, view: &StandardView) {
        // The angle is no coordinate. It is written with the precision needed, and read likewise,
        // so that the vertical angle comes back to the bit.
        let angle = (view.angle_of_pixel_centres() * 1e9).round() / 1e9;
        self.out.text(format_args!(
            "v\nfrom {}\nat {}\nup {}\nangle {angle}\nhither 1\nresolution {} {}\n",
            DisplayVec3(view.from),
            DisplayVec3(view.at),
            DisplayVec3(view.up),
            view.width,
            view.height,
        ));
    }

    fn background(&mut self, rgb: DVec3) {
        self.out.text(format_args!("b {}\n", DisplayVec3(rgb)));
    }

    fn light(&mut self, light: &StandardLight) {
        self.fading |= light.attenuation != DVec3::X;
        self.out
            .text(format_args!("l {}", DisplayVec3(light.position)));
        if let Some(color) = light.color {
            self.out.text(format_args!(" {}", DisplayVec3(color)));
        }
        self.out.bytes(b"\n");
    }

    fn material(&mut self, material: &MaterialDesc) {
        let material = match material {
            MaterialDesc::Nff(material) => *material,
            MaterialDesc::Document(material) => {
                self.reduced = true;
                nff_material(material)
            }
        };
        self.out.text(format_args!(
            "f {} {} {} {} {} {}\n",
            DisplayVec3(material.rgb),
            DisplayNumber(material.kd),
            DisplayNumber(material.ks),
            DisplayNumber(material.shine),
            DisplayNumber(material.transmittance),
            DisplayNumber(material.ior),
        ));
    }

    fn sphere(&mut self, center: DVec3, radius: f64) {
        self.out.text(format_args!(
            "s {} {}\n",
            DisplayVec3(center),
            DisplayNumber(radius)
        ));
    }

    fn cone(&mut self, base: DVec3, base_radius: f64, apex: DVec3, apex_radius: f64) {
        self.out.text(format_args!(
            "c {} {} {} {}\n",
            DisplayVec3(base),
            DisplayNumber(base_radius),
            DisplayVec3(apex),
            DisplayNumber(apex_radius),
        ));
    }

    fn polygon(&mut self, points: &[DVec3]) {
        self.corners(points.iter().copied());
    }

    fn patch(&mut self, points: &[(DVec3, DVec3)]) {
        self.out.text(format_args!("pp {}\n", points.len()));
        for &(point, normal) in points {
            self.out.text(format_args!(
                "{} {}\n",
                DisplayVec3(point),
                DisplayVec3(normal)
            ));
        }
    }

    fn mesh(&mut self, vertices: &[DVec3], triangles: &[[u32; 3]]) {
        for triangle in triangles {
            self.corners(triangle.iter().map(|&k| vertices[k as usize]));
        }
    }
}
