//! Threads that share items of work. The results do not depend on the number of threads.

use std::sync::Mutex;

/// Runs `work` on each item, on as many threads as can be used; the results are in the items'
/// order.
pub fn map<T: Send, R: Send>(
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
}
