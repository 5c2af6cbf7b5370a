//! Numbers of threads.

/// Number of threads to use: the one asked for, or one per CPU available to this process for 0.
pub fn thread_count(asked: usize) -> usize {
    match asked {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        some => some,
    }
}
