//! Sections in the order of the scene become chunks: meshes of one material and of bounded size.

use super::section::{SceneSection, Strip};
use crate::mesh_slice::MeshSlice;
use std::ops::Range;
use std::sync::Arc;

/// Approximate number of triangles in a chunk: it ends with the step that fills it.
const CHUNK: usize = 8192;

/// A mesh of one material, in the strips of sections.
#[derive(Debug, Default)]
pub(super) struct MaterialChunk {
    pub(super) material: usize,
    /// Number of vertices of all chunks before.
    pub(super) first_vertex: u64,
    vertices: usize,
    triangles: usize,
    parts: Vec<ChunkPart>,
}

#[derive(Debug)]
struct ChunkPart {
    strip: Arc<Strip>,
    vertices: Range<usize>,
    triangles: Range<usize>,
    shared: usize,
    before: usize,
}

impl ChunkPart {
    fn borrowed(&self) -> MeshSlice<'_> {
        MeshSlice {
            vertices: &self.strip.vertices[self.vertices.clone()],
            shared: self.shared,
            triangles: &self.strip.triangles[self.triangles.clone()],
            base: self.vertices.start as u32,
            before: self.before,
        }
    }
}

impl MaterialChunk {
    fn add(&mut self, strip: &Arc<Strip>, from: StripEnd, to: StripEnd) {
        self.parts.push(ChunkPart {
            strip: Arc::clone(strip),
            vertices: from.vertices..to.vertices,
            triangles: from.triangles..to.triangles,
            shared: from.shared,
            before: self.vertices,
        });
        self.vertices += to.vertices - from.vertices - from.shared;
        self.triangles += to.triangles - from.triangles;
    }

    /// The parts, as builders prepare them.
    pub(super) fn parts(&self) -> Vec<MeshSlice<'_>> {
        self.parts.iter().map(ChunkPart::borrowed).collect()
    }
}

/// The end of what has been taken from a strip.
#[derive(Clone, Copy, Debug, Default)]
struct StripEnd {
    vertices: usize,
    triangles: usize,
    /// Vertices from there on that the chunk already has.
    shared: usize,
}

/// The chunks that are not full yet, one for each material.
#[derive(Debug, Default)]
pub(super) struct OpenChunks {
    chunks: Vec<MaterialChunk>,
    /// Number of vertices of all full chunks.
    vertices: u64,
}

impl OpenChunks {
    /// Adds the next section of the scene; the chunks that it fills go to `full`.
    pub(super) fn add(&mut self, section: SceneSection, full: &mut impl Extend<MaterialChunk>) {
        let strips: Vec<_> = section.strips.into_iter().map(Arc::new).collect();
        let most = self.chunks.len().max(strips.len());
        self.chunks.resize_with(most, MaterialChunk::default);
        let start = |strip: &Arc<Strip>| StripEnd {
            shared: strip.shared,
            ..StripEnd::default()
        };
        let mut taken: Vec<_> = strips.iter().map(start).collect();
        for step in &section.steps {
            let material = step.material as usize;
            let from = taken[material];
            let to = StripEnd {
                vertices: step.vertices as usize,
                triangles: step.triangles as usize,
                shared: 0,
            };
            let chunk = &mut self.chunks[material];
            if chunk.triangles + (to.triangles - from.triangles) >= CHUNK {
                chunk.add(&strips[material], from, to);
                full.extend([self.close(material)]);
                taken[material].vertices = to.vertices - step.shared as usize;
                (taken[material].triangles, taken[material].shared) = (to.triangles, 0);
            }
        }
        for ((strip, from), chunk) in strips.iter().zip(taken).zip(&mut self.chunks) {
            let to = StripEnd {
                vertices: strip.vertices.len(),
                triangles: strip.triangles.len(),
                shared: 0,
            };
            if from.vertices + from.shared < to.vertices {
                chunk.add(strip, from, to);
            }
        }
    }

    /// Closes all chunks, by material.
    pub(super) fn finish(&mut self, last: &mut impl Extend<MaterialChunk>) {
        for material in 0..self.chunks.len() {
            if self.chunks[material].triangles > 0 {
                last.extend([self.close(material)]);
            }
        }
    }

    fn close(&mut self, material: usize) -> MaterialChunk {
        let mut chunk = std::mem::take(&mut self.chunks[material]);
        (chunk.material, chunk.first_vertex) = (material, self.vertices);
        self.vertices += chunk.vertices as u64;
        chunk
    }
}
