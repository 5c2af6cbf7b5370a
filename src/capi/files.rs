//! Scenes out of files.

use crate::rows::OutPointer;
use crate::scene::{SCENES, check_build, text};
use crate::status::{ApiError, PhxStatus, guarded};
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
    guarded(|| {
        let place = OutPointer::of("scene", scene)?;
        check_build(version)?;
        // SAFETY: the caller's.
        let name = unsafe { text("name", name) }?;
        let opened = open(Path::new(name), &Options::default());
        let opened = opened.map_err(|error| ApiError(PhxStatus::File, words(&error)))?;
        let scene = SCENES.insert(RwLock::new(opened.scene))?;
        // SAFETY: the caller's.
        unsafe { place.write(scene) };
        Ok(())
    })
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
