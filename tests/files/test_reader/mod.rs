//! The `.test` reader: meaning of files, messages about bad ones, and no panics.

mod bad;
mod course;
mod mangled;
mod origin;
mod range;
mod semantics;

use phalanx::formats::{Loaded, read_test};

/// A valid beginning, two lines long.
const HEAD: &str = "size 4 4\ncamera 0 0 5 0 0 0 0 1 0 45\n";

/// Reads [`HEAD`] and `body`, which must be a scene.
fn scene(body: &str) -> phalanx::scene::Scene {
    read(body).scene
}

fn read(body: &str) -> Loaded {
    read_test(&format!("{HEAD}{body}")).unwrap_or_else(|errors| panic!("{body:?}: {errors:#?}"))
}
