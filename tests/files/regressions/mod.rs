//! Values that a reader once got wrong, each named for the right one, with the report that showed
//! the wrong one. Input files are beside this one; those with messages are in
//! `tests/files/awkward`.
//!
//! Files of other programs that were read wrongly before this module was made are in
//! `mesh_readers/obj_exporters`, `mesh_readers/obj_others` and `gltf_reader/tolerated`.

mod materials;

use crate::folders::folder;
use phalanx::formats::{Loaded, Options, load};

/// A file of one of the folders of `tests/files`.
fn loaded(name: &str) -> Loaded {
    let path = folder("tests/files").join(name);
    load(&path, &Options::default()).unwrap_or_else(|error| panic!("{error}"))
}
