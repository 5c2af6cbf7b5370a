//! A standard scene as an NFF file.

use super::decimal::{Decimal, Decimals, push_vector};
use super::latched::LatchedWriter;
use super::outcome::{DroppedFeatures, SceneWriteError};
use crate::builder::{
    DocumentMaterial, MaterialDesc, NffMaterial, SceneBuilder, StandardLight, StandardView,
};
use crate::mesh_slice::{MeshSlice, Prepare, PreparedMesh};
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
    /// [`SceneBuilder::threads`].
    pub threads: usize,
}

impl<W: Write> NffWriter<W> {
    /// Writes to `out`, buffered.
    pub fn new(out: W) -> Self {
        NffWriter {
            out: LatchedWriter::new(out),
            fading: false,
            reduced: false,
            threads: 0,
        }
    }

    /// Ends the file; returns the features it does not hold.
    ///
    /// # Errors
    /// The first error that occurred.
    pub fn finish(self) -> Result<DroppedFeatures, SceneWriteError> {
        self.out.finish()?;
        let fading = "NFF's lights do not fade with distance";
        let reduced = "NFF's surfaces have no colours of their own for ambient, emitted, mirrored and transmitted light";
        let lost = [
            self.fading.then_some(fading),
            self.reduced.then_some(reduced),
        ];
        Ok(lost.into_iter().flatten().collect())
    }

    fn corners(&mut self, points: impl ExactSizeIterator<Item = DVec3>) {
        writeln!(self.out, "p {}", points.len());
        for point in points {
            writeln!(self.out, "{}", Decimals(point));
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
        // The angle is not a coordinate. It is written and read with enough precision to restore
        // the vertical angle bit for bit.
        let angle = (view.angle_of_pixel_centres() * 1e9).round() / 1e9;
        let [from, center, up] = [view.from, view.at, view.up].map(Decimals);
        writeln!(
            self.out,
            "v\nfrom {from}\nat {center}\nup {up}\nangle {angle}\nhither 1\nresolution {} {}",
            view.width, view.height
        );
    }

    fn background(&mut self, rgb: DVec3) {
        writeln!(self.out, "b {}", Decimals(rgb));
    }

    fn light(&mut self, light: &StandardLight) {
        self.fading |= light.attenuation != DVec3::X;
        write!(self.out, "l {}", Decimals(light.position));
        if let Some(color) = light.color {
            write!(self.out, " {}", Decimals(color));
        }
        writeln!(self.out);
    }

    fn material(&mut self, material: &MaterialDesc) {
        let material = match material {
            MaterialDesc::Nff(material) => *material,
            MaterialDesc::Document(material) => {
                self.reduced = true;
                nff_material(material)
            }
        };
        writeln!(
            self.out,
            "f {} {} {} {} {} {}",
            Decimals(material.rgb),
            Decimal(material.kd),
            Decimal(material.ks),
            Decimal(material.shine),
            Decimal(material.transmittance),
            Decimal(material.ior)
        );
    }

    fn sphere(&mut self, center: DVec3, radius: f64) {
        writeln!(self.out, "s {} {}", Decimals(center), Decimal(radius));
    }

    fn cone(&mut self, base: DVec3, base_radius: f64, apex: DVec3, apex_radius: f64) {
        let [base, apex] = [base, apex].map(Decimals);
        let [base_radius, apex_radius] = [base_radius, apex_radius].map(Decimal);
        writeln!(self.out, "c {base} {base_radius} {apex} {apex_radius}");
    }

    fn polygon(&mut self, points: &[DVec3]) {
        self.corners(points.iter().copied());
    }

    fn patch(&mut self, points: &[(DVec3, DVec3)]) {
        writeln!(self.out, "pp {}", points.len());
        for &(point, normal) in points {
            writeln!(self.out, "{} {}", Decimals(point), Decimals(normal));
        }
    }

    fn threads(&self) -> usize {
        self.threads
    }

    fn preparation(&self) -> Box<Prepare> {
        Box::new(|parts, _| prepare(parts))
    }

    fn prepared(&mut self, mesh: PreparedMesh) {
        self.out.bytes(&mesh.bytes);
    }
}

/// The polygons of a mesh. Each vertex is written once, and copied from there.
fn prepare(parts: &[MeshSlice]) -> PreparedMesh {
    let mut prepared = PreparedMesh::sized(parts);
    let (mut lines, mut ends) = (Vec::new(), Vec::new());
    for part in parts {
        lines.clear();
        ends.clear();
        ends.push(0);
        for &vertex in part.vertices {
            push_vector(&mut lines, vertex);
            lines.push(b'\n');
            ends.push(lines.len());
        }
        for triangle in part.triangles {
            prepared.bytes.extend_from_slice(b"p 3\n");
            for corner in triangle.map(|v| (v - part.base) as usize) {
                let line = &lines[ends[corner]..ends[corner + 1]];
                prepared.bytes.extend_from_slice(line);
            }
        }
    }
    prepared
}
