//! A standard scene as an NFF file.

use super::out::{Number, Numbers, Out};
use super::{Losses, WriteError};
use crate::standard::sink::{DocumentLook, Look, NffLook, Sink, StandardLight, StandardView};
use glam::DVec3;
use std::io::Write;

/// A sink that writes NFF, every shape of which it can hold; meshes become triangles.
///
/// Of the document's looks NFF holds Kd, the means of Ks and Kt, the exponent and the index of refraction.
pub struct NffSink<W: Write> {
    out: Out<W>,
    fading: bool,
    reduced: bool,
}

impl<W: Write> NffSink<W> {
    /// Writes to `out`, buffered.
    pub fn new(out: W) -> Self {
        NffSink {
            out: Out::new(out),
            fading: false,
            reduced: false,
        }
    }

    /// Ends the file and says what it does not hold.
    ///
    /// # Errors
    /// The first error there was.
    pub fn finish(self) -> Result<Losses, WriteError> {
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
            self.out.text(format_args!("{}\n", Numbers(point)));
        }
    }
}

/// The closest NFF look: diffuse with Kd 1, the rest white.
fn nff_look(look: &DocumentLook) -> NffLook {
    let mean = |c: DVec3| (c.x + c.y + c.z) / 3.0;
    NffLook {
        rgb: look.kd,
        kd: 1.0,
        ks: mean(look.ks),
        shine: look.shininess,
        transmittance: mean(look.kt),
        ior: look.ior,
    }
}

impl<W: Write> Sink for NffSink<W> {
    fn view(&mut self, view: &StandardView) {
        // The angle is no coordinate: it is written as precisely as it can be had, and read likewise, so that the
        // vertical angle comes back to the bit.
        let angle = (view.angle_of_pixel_centres() * 1e9).round() / 1e9;
        self.out.text(format_args!(
            "v\nfrom {}\nat {}\nup {}\nangle {angle}\nhither 1\nresolution {} {}\n",
            Numbers(view.from),
            Numbers(view.at),
            Numbers(view.up),
            view.width,
            view.height,
        ));
    }

    fn background(&mut self, rgb: DVec3) {
        self.out.text(format_args!("b {}\n", Numbers(rgb)));
    }

    fn light(&mut self, light: &StandardLight) {
        self.fading |= light.attenuation != DVec3::X;
        self.out.text(format_args!("l {}", Numbers(light.position)));
        if let Some(color) = light.color {
            self.out.text(format_args!(" {}", Numbers(color)));
        }
        self.out.bytes(b"\n");
    }

    fn surface(&mut self, look: &Look) {
        let look = match look {
            Look::Nff(look) => *look,
            Look::Document(look) => {
                self.reduced = true;
                nff_look(look)
            }
        };
        self.out.text(format_args!(
            "f {} {} {} {} {} {}\n",
            Numbers(look.rgb),
            Number(look.kd),
            Number(look.ks),
            Number(look.shine),
            Number(look.transmittance),
            Number(look.ior),
        ));
    }

    fn sphere(&mut self, center: DVec3, radius: f64) {
        self.out
            .text(format_args!("s {} {}\n", Numbers(center), Number(radius)));
    }

    fn cone(&mut self, base: DVec3, base_radius: f64, apex: DVec3, apex_radius: f64) {
        self.out.text(format_args!(
            "c {} {} {} {}\n",
            Numbers(base),
            Number(base_radius),
            Numbers(apex),
            Number(apex_radius),
        ));
    }

    fn polygon(&mut self, points: &[DVec3]) {
        self.corners(points.iter().copied());
    }

    fn patch(&mut self, points: &[(DVec3, DVec3)]) {
        self.out.text(format_args!("pp {}\n", points.len()));
        for &(point, normal) in points {
            self.out
                .text(format_args!("{} {}\n", Numbers(point), Numbers(normal)));
        }
    }

    fn mesh(&mut self, vertices: &[DVec3], triangles: &[[u32; 3]]) {
        for triangle in triangles {
            self.corners(triangle.iter().map(|&k| vertices[k as usize]));
        }
    }
}
