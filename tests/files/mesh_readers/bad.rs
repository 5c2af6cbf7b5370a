//! Bad meshes and what is said about them: `tests/files/bad_meshes/x.obj` (or another ending) and
//! beside it `x.obj.expected`.
//!
//! After a change of wording, `PHALANX_BLESS=1 cargo test --test files mesh_readers::bad::` writes
//! what is said now: read the difference before committing it.

use crate::bad_files::{assert_messages, folder};
use std::path::{Path, PathBuf};

#[test]
fn every_bad_file_gets_its_message() {
    let expected = |path: &Path| PathBuf::from(format!("{}.expected", path.display()));
    assert_messages(
        &folder("tests/files/bad_meshes"),
        &["obj", "ply", "stl"],
        expected,
        20,
    );
}
