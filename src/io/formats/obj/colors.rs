//! Colours of vertices: three numbers behind the position, or ZBrush's comments.

use super::chunk::{ObjChunk, ObjReader};
use crate::formats::diagnostics::Span;
use crate::formats::mesh::{self, Occurrences, ParseError};
use crate::formats::vertex_colors::{COLOR_BYTES, MeshColors, linear_of_byte, linear_of_share};
use crate::formats::workers;
use phalanx_scene::Vec3s;

/// Colours of a chunk's vertices, as they are in the file. A chunk without any takes no memory.
#[derive(Debug, Default)]
pub(super) struct ChunkColors {
    /// One row for each vertex up to the last with a colour; NaN for one without.
    rgb: [Vec<f32>; 3],
    /// Largest finite channel.
    largest: f32,
    /// Colours of ZBrush's comments, for the vertices of the file in their order.
    painted: Vec<[u8; 3]>,
    /// Colours that are not finite: white is used instead.
    pub(super) bad: Occurrences,
}

/// Largest channel of a colour from 0 to 1; rounding may take one a little above 1.
const MAX_SHARE: f32 = 1.5;

impl ObjReader<'_> {
    /// Reads the numbers after a position: a weight, or a colour and perhaps its opacity.
    pub(super) fn weight_or_color(&mut self) -> Result<(), ParseError> {
        let start = self.cursor.at;
        let mut numbers = [0.0; 3];
        let mut count = 0;
        while !self.cursor.at_statement_end() {
            let number = self.cursor.float()?;
            if let Some(slot) = numbers.get_mut(count) {
                *slot = number;
            }
            count += 1;
        }
        match count {
            1 => {}
            2 => self.note_surplus(start),
            _ => self.add_color(numbers, start),
        }
        Ok(())
    }

    fn add_color(&mut self, rgb: [f32; 3], start: usize) {
        if !self.share.take(COLOR_BYTES) {
            return;
        }
        let vertex = self.chunk.counts()[0] - 1;
        let colors = &mut self.chunk.colors;
        let finite = rgb.iter().all(|channel| channel.is_finite());
        if !finite {
            colors.bad.add(Span::between(start, self.cursor.at));
        }
        for (column, channel) in colors.rgb.iter_mut().zip(rgb) {
            column.resize(vertex, f32::NAN);
            column.push(if finite { channel } else { f32::NAN });
            colors.largest = colors.largest.max(if finite { channel } else { 0.0 });
        }
    }

    /// Reads ZBrush's `#MRGB` and the colours after it, each of which is a mask, red, green and blue
    /// in hexadecimal digits.
    #[cold]
    pub(super) fn painted_colors(&mut self) {
        let rest = &self.cursor.text[self.cursor.at + b"#MRGB".len()..];
        let digits = rest.trim_ascii_start();
        let digit = |at: usize| {
            let digit = digits.get(at).map(|&digit| char::from(digit));
            digit.and_then(|digit| digit.to_digit(16))
        };
        let byte = |at: usize| Some((digit(at)? << 4 | digit(at + 1)?) as u8);
        let color = |at: usize| Some([byte(at + 2)?, byte(at + 4)?, byte(at + 6)?]);
        let colors = (0..).step_by(8).map_while(color);
        for color in colors {
            if self.share.take(COLOR_BYTES) {
                self.chunk.colors.painted.push(color);
            }
        }
    }
}

/// The colours of all vertices; none if no vertex has one.
pub(super) fn merge(chunks: &mut [ObjChunk], threads: usize) -> MeshColors {
    let colors = |chunk: &ObjChunk| !chunk.colors.rgb[0].is_empty();
    if !chunks.iter().any(colors) {
        return painted(chunks);
    }
    let largest = chunks.iter().map(|chunk| chunk.colors.largest);
    let bytes = largest.fold(0.0, f32::max) > MAX_SHARE;
    let scale = if bytes { 255.0 } else { 1.0 };
    let parts = chunks.iter_mut().map(|chunk| {
        let rgb = std::mem::take(&mut chunk.colors.rgb);
        (chunk.counts()[0], rgb)
    });
    let decoded = workers::map(threads, parts.collect(), |(vertices, rgb)| {
        rgb.map(|mut column: Vec<f32>| {
            column.resize(vertices, f32::NAN);
            column
                .iter_mut()
                .for_each(|channel| *channel = decode(*channel, scale));
            column
        })
    });
    let mut columns: [Vec<Vec<f32>>; 3] = Default::default();
    for part in decoded {
        for (column, part) in columns.iter_mut().zip(part) {
            column.push(part);
        }
    }
    of_vertices(mesh::merge_floats(threads, columns))
}

/// The linear value of a channel; NaN is white.
fn decode(channel: f32, scale: f32) -> f32 {
    match channel.is_nan() {
        true => 1.0,
        false => linear_of_share(channel / scale),
    }
}

/// Colours of ZBrush's comments. Vertices beyond the last colour are white.
fn painted(chunks: &mut [ObjChunk]) -> MeshColors {
    let vertices: usize = chunks.iter().map(|chunk| chunk.counts()[0]).sum();
    let painted = chunks
        .iter_mut()
        .map(|chunk| std::mem::take(&mut chunk.colors.painted));
    let painted = workers::joined(painted.collect());
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
