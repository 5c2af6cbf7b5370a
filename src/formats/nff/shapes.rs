//! Shapes, and the materials that they have.

use super::lexer::is_numeric;
use super::reader::NffReader;
use super::records::NffRecord;
use crate::mesh::faces::MAX_CORNERS;
use crate::mesh::polygon::triangulate;
use crate::text::number::count;
use glam::{DVec3, Vec3};
use phalanx_scene::Cone;

/// Minimum number of bytes that a number takes: a digit and the separator from the next number.
const BYTES_PER_NUMBER: u64 = 2;

impl NffReader<'_> {
    pub(super) fn fill(&mut self, record: &NffRecord<'_>) {
        let Some(fill) = self.numbers::<8>(record) else {
            return;
        };
        let [r, g, b, kd, _, shine, _, ior] = fill;
        let diffuse = [r, g, b].map(|part| (f64::from(part) * f64::from(kd)) as f32);
        if shine < 0.0 {
            let message = "the shininess of a surface must not be negative";
            self.report.error(record.span(), message);
        } else if ior < 0.0 {
            let message = "the index of refraction must not be negative";
            self.report.error(record.span(), message);
        } else if !diffuse.iter().all(|part| part.is_finite()) {
            let message = "this colour times its kd is beyond the range of single precision";
            self.report.error(record.span(), message);
        } else {
            self.materials.push(fill);
        }
        self.pass_over_texture();
    }

    /// Passes over a file name after the numbers, which some readers take. Haines' format has no
    /// textures.
    fn pass_over_texture(&mut self) {
        let name = self.tokens.peek_in_line();
        let name = name.filter(|token| !is_numeric(token) && token.text.contains('.'));
        if let Some(name) = name {
            self.tokens.next();
            self.report.warning(
                name.span(),
                "NFF has no textures: the surface keeps its colour",
            );
        }
    }

    pub(super) fn sphere(&mut self, record: &NffRecord<'_>) {
        self.seen.shape = true;
        let Some([x, y, z, radius]) = self.coordinates(record) else {
            return;
        };
        let radius = radius as f32;
        if radius == 0.0 {
            let message = "the radius of a sphere must not be zero";
            return self.report.error(record.span(), message);
        }
        if radius < 0.0 {
            let message =
                "a negative radius shows only a sphere's inside: here both sides are seen";
            self.report.warning(record.span(), message);
        }
        let center = self.to_scene([x, y, z]);
        self.scene
            .add_sphere(center, radius.abs(), self.materials.current());
    }

    pub(super) fn cone(&mut self, record: &NffRecord<'_>) {
        self.seen.shape = true;
        let Some([bx, by, bz, br, ax, ay, az, ar]) = self.coordinates(record) else {
            return;
        };
        let (base, apex) = (self.to_scene([bx, by, bz]), self.to_scene([ax, ay, az]));
        let (br, ar) = (br as f32, ar as f32);
        let wrong = if base == apex {
            "the ends of a cone must not be at the same place"
        } else if br == 0.0 && ar == 0.0 {
            "one radius of a cone must not be zero"
        } else if br.min(ar) < 0.0 && br.max(ar) > 0.0 {
            "the radii of a cone must both be positive, or both negative (for its inside)"
        } else {
            let cone = Cone {
                base,
                base_radius: br.abs(),
                apex,
                apex_radius: ar.abs(),
                inside: br.min(ar) < 0.0,
            };
            self.scene.add_cone(cone, self.materials.current());
            return;
        };
        self.report.error(record.span(), wrong);
    }

    pub(super) fn polygon(&mut self, record: &NffRecord<'_>) {
        let Some(corners) = self.corners::<3>(record) else {
            return;
        };
        let points = corners.into_iter().map(|position| self.to_scene(position));
        let points: Vec<Vec3> = points.collect();
        for triangle in triangulate(&points) {
            let corners = triangle.map(|k| points[k as usize]);
            self.scene
                .add_triangle(corners, None, self.materials.current());
        }
    }

    pub(super) fn patch(&mut self, record: &NffRecord<'_>) {
        let Some(corners) = self.corners::<6>(record) else {
            return;
        };
        let position = |&[x, y, z, ..]: &[f64; 6]| self.to_scene([x, y, z]);
        let normal = |&[.., x, y, z]: &[f64; 6]| DVec3::new(x, y, z).as_vec3();
        let points: Vec<Vec3> = corners.iter().map(position).collect();
        let normals: Vec<Vec3> = corners.iter().map(normal).collect();
        if normals.contains(&Vec3::ZERO) {
            let message = "the normal of a corner must not be zero";
            return self.report.error(record.span(), message);
        }
        for triangle in triangulate(&points) {
            let corners = triangle.map(|k| points[k as usize]);
            let normals = triangle.map(|k| normals[k as usize]);
            self.scene
                .add_triangle(corners, Some(normals), self.materials.current());
        }
    }

    /// A count, and that many corners of `N` numbers each. After the first fault the rest is passed
    /// over.
    fn corners<const N: usize>(&mut self, record: &NffRecord<'_>) -> Option<Vec<[f64; N]>> {
        self.seen.shape = true;
        let corners = self.checked_corners(record);
        if corners.is_none() {
            self.skip_to_record();
        }
        corners
    }

    fn checked_corners<const N: usize>(&mut self, record: &NffRecord<'_>) -> Option<Vec<[f64; N]>> {
        let count = self.corner_count(record, N as u64)?;
        let mut corners = Vec::with_capacity(count);
        for k in 0..count {
            if self.at_record() {
                let message = format!("only {k} of its {count} corners are there");
                self.report.error(record.span(), message);
                return None;
            }
            corners.push(self.coordinates::<N>(record)?);
        }
        Some(corners)
    }

    /// The count of corners. It is checked against the bytes that are left before memory is
    /// reserved.
    fn corner_count(&mut self, record: &NffRecord<'_>, numbers_each: u64) -> Option<usize> {
        let Some(token) = self.operand() else {
            self.breaks_off(record, 0, 1);
            return None;
        };
        let left = self.tokens.left() as u64;
        let wrong = match count(token.text) {
            Ok(count) if count < 3 => String::from("a polygon has at least three corners"),
            Ok(count) if left / (numbers_each * BYTES_PER_NUMBER) < count => {
                format!("{count} corners are more than the rest of the file can hold")
            }
            Ok(count) if count > MAX_CORNERS as u64 => {
                format!("a polygon of {count} corners: at most {MAX_CORNERS}")
            }
            Ok(count) => return Some(count as usize),
            Err(message) => message,
        };
        self.report.error(token.span(), wrong);
        None
    }
}
