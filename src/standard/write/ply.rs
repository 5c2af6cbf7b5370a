//! A standard scene as a PLY file, binary little-endian: its polygons, without lights and
//! materials.
//!
//! The header has counts, then come all vertices, then all faces, which a scene mixes. Instead of
//! keeping them in memory, the scene is built three times with the same result.

use super::latched::LatchedWriter;
use super::outcome::{DroppedFeatures, SceneWriteError};
use crate::builder::{MaterialDesc, SceneBuilder, StandardLight, StandardView};
use crate::mesh_slice::{MeshSlice, Prepare, PreparedMesh};
use glam::DVec3;
use std::io::Write;

/// Maximum number of vertices, as some readers treat indices as signed.
const MAX_VERTICES: u64 = i32::MAX as u64;
/// Maximum number of corners that fit a count of one byte.
const SHORT_LIST: usize = 255;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Pass {
    Count,
    Vertices,
    Faces,
    Done,
}

/// A builder that writes PLY. The scene must be built into it three times, with
/// [`PlyWriter::end_pass`] after each.
///
/// If any shape has vertex normals, all vertices get normals: those of polygons and meshes are
/// perpendicular to their faces, and such triangles do not share vertices.
pub struct PlyWriter<W: Write> {
    out: LatchedWriter<W>,
    pass: Pass,
    vertices: u64,
    /// Number of vertices if none had to be split for its normal.
    shared_vertices: u64,
    faces: u64,
    most_corners: usize,
    normals: bool,
    /// The first vertex of the next shape, in the pass over faces.
    first: u64,
    /// [`SceneBuilder::threads`].
    pub threads: usize,
}

impl<W: Write> PlyWriter<W> {
    /// Writes to `out`, buffered.
    pub fn new(out: W) -> Self {
        PlyWriter {
            out: LatchedWriter::new(out),
            pass: Pass::Count,
            vertices: 0,
            shared_vertices: 0,
            faces: 0,
            most_corners: 0,
            normals: false,
            first: 0,
            threads: 0,
        }
    }

    /// Ends a pass after the scene has been built. Returns true if it must be built again.
    pub fn end_pass(&mut self) -> bool {
        self.pass = match self.pass {
            Pass::Count => {
                self.header();
                Pass::Vertices
            }
            Pass::Vertices => Pass::Faces,
            Pass::Faces | Pass::Done => Pass::Done,
        };
        // After an error nothing more can be written, so another pass is useless.
        self.pass != Pass::Done && !self.out.failed()
    }

    /// Ends the file.
    ///
    /// # Errors
    /// The first error that occurred: [`SceneWriteError::CannotHold`] for spheres and cones, before
    /// anything is written.
    pub fn finish(self) -> Result<DroppedFeatures, SceneWriteError> {
        self.out.finish()?;
        Ok(vec!["PLY holds no camera, lights or surfaces"])
    }

    fn header(&mut self) {
        if !self.normals {
            self.vertices = self.shared_vertices;
        }
        if self.vertices > MAX_VERTICES {
            return self.out.fail(SceneWriteError::TooMany(self.vertices));
        }
        let normals = if self.normals {
            "property float nx\nproperty float ny\nproperty float nz\n"
        } else {
            ""
        };
        let count = if self.short_lists() { "uchar" } else { "uint" };
        writeln!(
            self.out,
            "ply\nformat binary_little_endian 1.0\nelement vertex {}\n\
             property float x\nproperty float y\nproperty float z\n{normals}\
             element face {}\nproperty list {count} int vertex_indices\nend_header",
            self.vertices, self.faces
        );
    }

    fn short_lists(&self) -> bool {
        self.most_corners <= SHORT_LIST
    }

    fn vector(&mut self, v: DVec3) {
        self.out.bytes(&vector(v));
    }

    fn face(&mut self, corners: impl ExactSizeIterator<Item = u64>) {
        let count = corners.len() as u32;
        if self.short_lists() {
            self.out.bytes(&[count as u8]);
        } else {
            self.out.bytes(&count.to_le_bytes());
        }
        for corner in corners {
            // The header has rejected more than i32::MAX of them.
            self.out.bytes(&(corner as u32).to_le_bytes());
        }
    }

    /// A polygon with vertices of its own; normals are used only if the file has them.
    fn lone_face(&mut self, corners: usize, point: impl Fn(usize) -> (DVec3, DVec3)) {
        match self.pass {
            Pass::Count => {
                self.vertices += corners as u64;
                self.faces += 1;
                self.most_corners = self.most_corners.max(corners);
            }
            Pass::Vertices => {
                for k in 0..corners {
                    let (point, normal) = point(k);
                    self.vector(point);
                    if self.normals {
                        self.vector(normal);
                    }
                }
            }
            Pass::Faces => self.next_face(corners),
            Pass::Done => {}
        }
    }

    /// The face of the next vertices, which it does not share.
    fn next_face(&mut self, corners: usize) {
        let first = self.first;
        self.face((0..corners).map(|k| first + k as u64));
        self.first += corners as u64;
    }
}

/// A vector in single precision.
fn vector(v: DVec3) -> [u8; 12] {
    bytemuck::cast(v.to_array().map(|number| (number as f32).to_le_bytes()))
}

fn prepare_vertices(parts: &[MeshSlice]) -> PreparedMesh {
    let mut prepared = PreparedMesh::sized(parts);
    prepared.bytes.reserve(12 * prepared.vertices);
    for &vertex in parts.iter().flat_map(MeshSlice::vertices) {
        prepared.bytes.extend_from_slice(&vector(vertex));
    }
    prepared
}

/// The vertices of a mesh with normals: three for each triangle.
fn prepare_flat(parts: &[MeshSlice]) -> PreparedMesh {
    let mut prepared = PreparedMesh::sized(parts);
    for corners in parts.iter().flat_map(MeshSlice::corners) {
        let normal = vector(normal(&corners));
        let rows = corners
            .into_iter()
            .flat_map(|point| [vector(point), normal]);
        prepared.bytes.extend(rows.flatten());
    }
    prepared
}

/// The faces of a mesh whose first vertex has the number `first`. The header has rejected larger
/// numbers than i32::MAX.
fn prepare_faces(parts: &[MeshSlice], first: u32, short: bool) -> PreparedMesh {
    let mut prepared = PreparedMesh::sized(parts);
    let count = 3u32.to_le_bytes();
    let count = if short { &count[..1] } else { &count };
    prepared
        .bytes
        .reserve((count.len() + 12) * prepared.triangles);
    for corners in parts.iter().flat_map(|part| part.triangles(first)) {
        let corners: [u8; 12] = bytemuck::cast(corners.map(u32::to_le_bytes));
        prepared.bytes.extend_from_slice(count);
        prepared.bytes.extend_from_slice(&corners);
    }
    prepared
}

/// The unit normal of a polygon by Newell's sum, which is correct with concave corners, too; z if
/// it has no area.
fn normal(points: &[DVec3]) -> DVec3 {
    let origin = points.first().copied().unwrap_or_default();
    let pairs = points.iter().zip(points.iter().cycle().skip(1));
    let sum = pairs.fold(DVec3::ZERO, |sum, (&a, &b)| {
        sum + (a - origin).cross(b - origin)
    });
    sum.try_normalize().unwrap_or(DVec3::Z)
}

impl<W: Write> SceneBuilder for PlyWriter<W> {
    fn view(&mut self, _: &StandardView) {}

    fn background(&mut self, _: DVec3) {}

    fn light(&mut self, _: &StandardLight) {}

    fn material(&mut self, _: &MaterialDesc) {}

    fn sphere(&mut self, _: DVec3, _: f64) {
        self.out.cannot_hold("PLY", "spheres");
    }

    fn cone(&mut self, _: DVec3, _: f64, _: DVec3, _: f64) {
        self.out.cannot_hold("PLY", "cones or cylinders");
    }

    fn polygon(&mut self, points: &[DVec3]) {
        if self.pass == Pass::Count {
            self.shared_vertices += points.len() as u64;
        }
        let normal = normal(points);
        self.lone_face(points.len(), |k| (points[k], normal));
    }

    fn patch(&mut self, points: &[(DVec3, DVec3)]) {
        self.normals = true;
        self.lone_face(points.len(), |k| points[k]);
    }

    fn threads(&self) -> usize {
        self.threads
    }

    fn preparation(&self) -> Box<Prepare> {
        let (first, short) = (self.first, self.short_lists());
        match self.pass {
            Pass::Vertices if self.normals => Box::new(|parts, _| prepare_flat(parts)),
            Pass::Vertices => Box::new(|parts, _| prepare_vertices(parts)),
            Pass::Faces if !self.normals => {
                Box::new(move |parts, before| prepare_faces(parts, (first + before) as u32, short))
            }
            _ => Box::new(|parts, _| PreparedMesh::sized(parts)),
        }
    }

    fn prepared(&mut self, mesh: PreparedMesh) {
        let (vertices, faces) = (mesh.vertices as u64, mesh.triangles as u64);
        match self.pass {
            Pass::Count => {
                self.shared_vertices += vertices;
                self.vertices += 3 * faces;
                self.faces += faces;
                self.most_corners = self.most_corners.max(3);
            }
            Pass::Vertices | Pass::Done => {}
            Pass::Faces if self.normals => (0..faces).for_each(|_| self.next_face(3)),
            Pass::Faces => self.first += vertices,
        }
        self.out.bytes(&mesh.bytes);
    }
}
