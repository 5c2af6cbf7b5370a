//! The NFF reader: meaning of files, messages about bad ones, and no panics.

mod bad;
mod mangled;
mod origin;
mod others;
mod semantics;

use phalanx::formats::{Loaded, read_nff};

/// A valid beginning, nine lines long.
const HEAD: &str = "b 0.1 0.2 0.3\nv\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 45\nhither 1\nresolution 4 4\nl 4 4 4\n";

/// Reads [`HEAD`] and `body`, which must be a scene.
fn scene(body: &str) -> phalanx::scene::Scene {
    let loaded = read(&format!("{HEAD}{body}"));
    assert!(
        loaded.warnings.is_empty(),
        "{body:?}: {:?}",
        loaded.warnings
    );
    assert!(loaded.notes.is_empty(), "{body:?}: {:?}", loaded.notes);
    loaded.scene
}

fn read(text: &str) -> Loaded {
    read_nff(text).unwrap_or_else(|errors| panic!("{text:?}: {errors:#?}"))
}
