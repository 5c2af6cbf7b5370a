//! Several threads over the chunks of a file. The result does not depend on the number of threads.

use phalanx_scene::huge_pages::room;
pub(super) use phalanx_scene::thread_count;
use std::ops::Range;
use std::sync::Mutex;

/// Runs `work` on each item, on as many threads as can be used; the results are in the items'
/// order.
pub(super) fn map<T: Send, R: Send>(
    threads: usize,
    items: Vec<T>,
    work: impl Fn(T) -> R + Sync,
) -> Vec<R> {
    let threads = threads.min(items.len());
    let mut results: Vec<Option<R>> = items.iter().map(|_| None).collect();
    // An idle thread takes the next item, together with the slot of its result.
    let queue = Mutex::new(items.into_iter().zip(&mut results));
    let next = || queue.lock().ok()?.next();
    run_on(threads, &|| {
        while let Some((item, slot)) = next() {
            *slot = Some(work(item));
        }
    });
    drop(queue);
    results.into_iter().flatten().collect()
}

/// Runs a function on several threads, the present one among them. It is not generic, so that
/// threads are compiled once for all maps.
fn run_on(threads: usize, run: &(dyn Fn() + Sync)) {
    std::thread::scope(|scope| {
        for _ in 1..threads {
            // If the system has no more threads, the existing ones do the rest.
            if std::thread::Builder::new()
                .spawn_scoped(scope, run)
                .is_err()
            {
                break;
            }
        }
        run();
    });
}

/// Cuts a text of `range` into chunks of about `size` bytes. Each ends where `end_after` says: at
/// the first possible offset at or after the given one.
pub(super) fn cut(
    range: Range<usize>,
    size: usize,
    end_after: impl Fn(usize) -> usize,
) -> Vec<Range<usize>> {
    let mut chunks = Vec::new();
    let mut start = range.start;
    while start < range.end {
        let wanted = start.saturating_add(size);
        let end = if wanted < range.end {
            end_after(wanted).clamp(wanted, range.end)
        } else {
            range.end
        };
        chunks.push(start..end);
        start = end;
    }
    chunks
}

/// One vector of all parts, each of which is dropped as soon as it has been copied.
pub(super) fn joined<T: Copy>(mut parts: Vec<Vec<T>>) -> Vec<T> {
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
    fn results_stand_in_order_for_any_number_of_threads() {
        for threads in [1, 2, 3, 16] {
            let doubled = map(threads, (0..100).collect(), |k: u32| k * 2);
            assert!(doubled.iter().copied().eq((0..100).map(|k| k * 2)));
        }
        assert!(map(4, Vec::new(), |k: u32| k).is_empty());
    }

    #[test]
    fn pieces_follow_each_other_without_gaps() {
        let text = b"aaaa\nb\n\ncccccccccccccccccc\nd";
        for size in 1..=text.len() + 1 {
            let after = |at: usize| {
                let rest = memchr::memchr(b'\n', &text[at..]);
                rest.map_or(text.len(), |i| at + i + 1)
            };
            let chunks = cut(0..text.len(), size, after);
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
