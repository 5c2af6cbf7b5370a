//! Colours of vertices, from all chunks.

use crate::mesh;
use crate::mesh::vertex_colors::{MeshColors, linear_of_byte, linear_of_share};
use crate::text::workers;
use phalanx_scene::Vec3s;

/// Colours of a chunk's vertices, as they are in the file. A chunk without any takes no memory.
#[derive(Debug, Default)]
pub(super) struct ChunkColors {
    /// One row for each vertex up to the last with a colour; NaN for one without.
    rgb: [Vec<f32>; 3],
    /// Largest finite channel.
    largest: f32,
    /// Colours of ZBrush's comments, for the vertices of the file in their order.
    pub(super) painted: Vec<[u8; 3]>,
}

/// Largest channel of a colour from 0 to 1; rounding may take one a little above 1.
const MAX_SHARE: f32 = 1.5;

impl ChunkColors {
    /// Adds the colour of the vertex of this number. One that is not finite is missing.
    pub(super) fn add(&mut self, vertex: usize, rgb: [f32; 3]) {
        let finite = rgb.iter().all(|channel| channel.is_finite());
        for (column, channel) in self.rgb.iter_mut().zip(rgb) {
            column.resize(vertex, f32::NAN);
            column.push(if finite { channel } else { f32::NAN });
            self.largest = self.largest.max(if finite { channel } else { 0.0 });
        }
    }
}

/// The colours of all vertices; none if no vertex has one. Chunks are their numbers of vertices and
/// their colours.
pub(super) fn merge(chunks: Vec<(usize, ChunkColors)>, threads: usize) -> MeshColors {
    if chunks.iter().all(|(_, colors)| colors.rgb[0].is_empty()) {
        return painted(chunks);
    }
    let largest = chunks.iter().map(|(_, colors)| colors.largest);
    let bytes = largest.fold(0.0, f32::max) > MAX_SHARE;
    let scale = if bytes { 255.0 } else { 1.0 };
    let decoded = workers::map(threads, chunks, |(vertices, colors)| {
        colors.rgb.map(|mut column| {
            column.resize(vertices, f32::NAN);
            let channels = column.iter_mut();
            channels.for_each(|channel| *channel = decode(*channel, scale));
            column
        })
    });
    of_vertices(mesh::merge_floats(threads, decoded))
}

/// The linear value of a channel; NaN is white.
fn decode(channel: f32, scale: f32) -> f32 {
    if channel.is_nan() { 1.0 } else { linear_of_share(channel / scale) }
}

/// Colours of ZBrush's comments. Vertices beyond the last colour are white.
fn painted(chunks: Vec<(usize, ChunkColors)>) -> MeshColors {
    let vertices = chunks.iter().map(|(vertices, _)| vertices).sum();
    let painted = chunks.into_iter().map(|(_, colors)| colors.painted);
    let painted = workers::join(painted.collect());
    if painted.is_empty() {
        return MeshColors::default();
    }
    of_vertices([0, 1, 2].map(|channel| {
        let channels = painted.iter().map(|color| linear_of_byte(color[channel]));
        let all = channels.chain(std::iter::repeat(1.0)).take(vertices);
        all.collect::<Vec<f32>>().into()
    }))
}

fn of_vertices([x, y, z]: [phalanx_scene::Column<f32>; 3]) -> MeshColors {
    MeshColors {
        rgb: Vec3s { x, y, z },
        ..MeshColors::default()
    }
}
