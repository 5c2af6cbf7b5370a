//! Folders used by tests.

use std::path::{Path, PathBuf};

/// A folder of the repository.
pub fn folder(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// A folder of third-party scenes, if it exists next to the repository.
pub fn shared_scenes(name: &str) -> Option<PathBuf> {
    let folder = folder("../shared/scenes").join(name);
    let there = folder.is_dir();
    if !there {
        println!("skipped: {} is not there", folder.display());
    }
    there.then_some(folder)
}
