//! The chunks of a file, which several threads read, and the columns that they make.

use phalanx_scene::huge_pages::room;
pub(crate) use phalanx_scene::thread_count;
pub(crate) use phalanx_scene::workers::map;
use std::ops::Range;

/// Cuts a text of `range` into chunks of about `size` bytes. Each ends where `end_after` says: at
/// the first possible offset at or after the given one.
pub(crate) fn chunk_ranges(
    range: Range<usize>,
    size: usize,
    end_after: impl Fn(usize) -> usize,
) -> Vec<Range<usize>> {
    let mut chunks = Vec::new();
    let mut start = range.start;
    while start < range.end {
        let least_end = start.saturating_add(size);
        let end = if least_end < range.end {
            end_after(least_end).clamp(least_end, range.end)
        } else {
            range.end
        };
        chunks.push(start..end);
        start = end;
    }
    chunks
}

/// One vector of all parts, each of which is dropped as soon as it has been copied.
pub(crate) fn join<T: Copy>(mut parts: Vec<Vec<T>>) -> Vec<T> {
    parts.retain(|part| !part.is_empty());
    if parts.len() == 1 {
        return parts.swap_remove(0);
    }
    let mut all = room(parts.iter().map(Vec::len).sum());
    for part in parts {
        all.extend_from_slice(&part);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_follow_each_other_without_gaps() {
        let text = b"aaaa\nb\n\ncccccccccccccccccc\nd";
        for size in 1..=text.len() + 1 {
            let after = |offset: usize| {
                let rest = memchr::memchr(b'\n', &text[offset..]);
                rest.map_or(text.len(), |i| offset + i + 1)
            };
            let chunks = chunk_ranges(0..text.len(), size, after);
            let ends: Vec<usize> = chunks.iter().map(|p| p.end).collect();
            assert!(
                chunks
                    .iter()
                    .skip(1)
                    .map(|p| p.start)
                    .eq(ends[..ends.len() - 1].iter().copied())
            );
            assert_eq!((chunks[0].start, ends[ends.len() - 1]), (0, text.len()));
            assert!(chunks.iter().skip(1).all(|p| text[p.start - 1] == b'\n'));
        }
    }
}
