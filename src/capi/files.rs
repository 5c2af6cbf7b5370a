//! Scenes out of files.

use crate::scene::{SCENES, check_version, text};
use crate::status::{ApiError, PhxStatus, first_answer};
use crate::table::Opaque;
use phalanx::formats::Options;
use phalanx::open::open;
use std::error::Error;
use std::ffi::c_char;
use std::path::Path;
use std::sync::RwLock;

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_scene_open_for(
    version: u32,
    name: *const c_char,
    scene: *mut *mut Opaque,
) -> PhxStatus {
    // SAFETY: the caller's.
    unsafe {
        first_answer("scene", scene, || {
            check_version(version)?;
            let opened = open(Path::new(text("name", name)?), &Options::default());
            let opened = opened.map_err(|error| ApiError(PhxStatus::File, words(&error)))?;
            SCENES.insert(RwLock::new(opened.scene))
        })
    }
}

/// An error and its causes, in one line.
fn words(error: &dyn Error) -> String {
    let mut words = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let more = error.to_string();
        if !words.contains(&more) {
            words = format!("{words}: {more}");
        }
        cause = error.source();
    }
    words
}
