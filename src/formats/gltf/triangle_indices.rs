//! Triangles of a primitive, by the indices of their vertices.

use super::accessor::Accessor;
use super::document::Primitive;
use super::source::GltfSource;
use crate::text::workers;
use phalanx_scene::huge_pages::zeroed;

/// Topologies of triangles, by their numbers in the file.
const TRIANGLES: u32 = 4;
const STRIP: u32 = 5;
const FAN: u32 = 6;

/// Returns true if a mode means triangles; 0 to 3 are points and lines.
pub(super) fn is_surface(mode: u32) -> bool {
    (TRIANGLES..=FAN).contains(&mode)
}

/// The triangles of a primitive, of indices below `vertices`: no more than `most`, and only if
/// `room` grants memory for their number.
pub(super) fn triangles(
    source: &GltfSource,
    primitive: &Primitive,
    vertices: usize,
    most: u64,
    threads: usize,
    room: impl FnOnce(u64) -> Result<(), String>,
) -> Result<Vec<[u32; 3]>, String> {
    let indices = primitive.indices;
    let indices = indices
        .map(|row| Accessor::open(source, row, 1))
        .transpose()?;
    if indices.is_some_and(|indices| !indices.holds_indices()) {
        return Err("its indices are not unsigned integers".into());
    }
    let steps = indices.map_or(vertices, |indices| indices.count);
    let count = match primitive.mode {
        TRIANGLES => steps / 3,
        _ => steps.saturating_sub(2),
    };
    if count as u64 > most || vertices as u64 > u64::from(u32::MAX) {
        return Err(format!(
            "{count} more triangles are too many for a file of this size"
        ));
    }
    room(count as u64)?;
    let mode = primitive.mode;
    let mut corners = zeroed(count);
    let blocks = (0..).step_by(BLOCK).zip(corners.chunks_mut(BLOCK));
    let outside = workers::map(threads, blocks.collect(), |(first, block)| {
        fill(block, first, mode, indices.as_ref());
        let outside = |&&corner: &&u32| corner as usize >= vertices;
        block.as_flattened().iter().find(outside).copied()
    });
    match outside.into_iter().flatten().next() {
        Some(corner) => Err(format!(
            "its index {corner} is not below its {vertices} vertices"
        )),
        None => Ok(corners),
    }
}

/// Number of triangles that a thread takes at a time.
const BLOCK: usize = 1 << 14;

/// The triangles of a block, whose first one has this number.
fn fill(block: &mut [[u32; 3]], first: usize, mode: u32, indices: Option<&Accessor>) {
    if let (TRIANGLES, Some(indices)) = (mode, indices) {
        return indices.fill_indices(3 * first, block.as_flattened_mut());
    }
    let corner = |step: usize| indices.map_or(step as u32, |indices| indices.index(step));
    for (k, triangle) in (first..).zip(block) {
        let steps = match mode {
            TRIANGLES => [3 * k, 3 * k + 1, 3 * k + 2],
            // Every other triangle of a strip runs the other way round.
            STRIP => [k, k + 1 + k % 2, k + 2 - k % 2],
            _ => [k + 1, k + 2, 0],
        };
        *triangle = steps.map(corner);
    }
}
