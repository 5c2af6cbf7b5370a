//! Reads a whole file into memory. For a large file most of the time is spent on copying it and on
//! touching pages for the first time, so several threads share that work.

use super::workers;
use phalanx_scene::huge_pages::{room, zeroed};
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

/// Bytes that a thread reads at a time; a file of less than a few such blocks is read by one.
const BLOCK: usize = 1 << 23;

/// All bytes of an open file with this path.
pub(crate) fn read(mut file: File, path: &Path, threads: usize) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let metadata = file.metadata()?;
    let length = usize::try_from(metadata.len()).unwrap_or(0);
    let threads = workers::thread_count(threads);
    // A failed allocation is returned as an error. `room` and `zeroed` would end the program.
    let fits = metadata.is_file() && Vec::<u8>::new().try_reserve_exact(length).is_ok();
    if fits && (threads == 1 || length < 2 * BLOCK) {
        bytes = room(length);
    } else if fits {
        bytes = zeroed(length);
        let blocks = bytes.chunks_mut(BLOCK).enumerate().collect();
        let read = workers::map(threads, blocks, |(k, block): (usize, &mut [u8])| {
            let mut file = File::open(path)?;
            file.seek(SeekFrom::Start((k * BLOCK) as u64))?;
            file.read_exact(block)
        });
        read.into_iter().collect::<io::Result<()>>()?;
        file.seek(SeekFrom::Start(length as u64))?;
    }
    // Small files, pipes, and bytes appended in the meantime.
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_read_the_same_bytes() {
        let scratch = tempfile::tempdir().unwrap();
        let path = scratch.path().join("large");
        let expected: Vec<u8> = (0..2 * BLOCK as u64 + 12_345)
            .map(|k| ((k * k) >> 7) as u8)
            .collect();
        std::fs::write(&path, &expected).unwrap();
        for threads in [1, 3] {
            let bytes = read(File::open(&path).unwrap(), &path, threads).unwrap();
            assert!(bytes == expected, "{threads} threads");
        }
    }
}
