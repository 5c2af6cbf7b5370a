//! What a command takes where it takes a scene: a file, or a standard scene by name.

use super::diagnose;
use super::failure::Failure;
use phalanx::formats::{self, Options};
use phalanx::scene::Scene;
use phalanx::standard::{self, PREFIX, StandardError};
use std::ffi::OsStr;
use std::path::Path;

/// The scene of this name; what its reader has to say goes to stderr.
pub fn load(name: &Path, options: &Options) -> Result<Scene, Failure> {
    if let Some(spec) = standard_name(name) {
        return standard::parse_spec(spec)
            .and_then(standard::scene)
            .map_err(Failure::from);
    }
    let loaded = formats::load(name, options)?;
    diagnose::tell_warnings(name, &loaded.warnings);
    diagnose::tell_notes(&loaded.notes);
    Ok(loaded.scene)
}

/// The name, if it is that of a standard scene. A file called so can still be meant, as `./standard:…`.
fn standard_name(name: &Path) -> Option<&str> {
    name.to_str().filter(|text| text.starts_with(PREFIX))
}

/// What files made from a scene are called, without an ending.
pub fn stem(name: &Path) -> &OsStr {
    let standard = standard_name(name).and_then(|text| text.split(':').nth(1));
    match standard {
        Some(stem) => OsStr::new(stem),
        None => name.file_stem().unwrap_or("picture".as_ref()),
    }
}

impl From<StandardError> for Failure {
    fn from(error: StandardError) -> Failure {
        match error {
            StandardError::Scene(_) => Failure::Runtime(error.to_string()),
            _ => Failure::Usage(format!(
                "{error}\n\nTo see all standard scenes and their sizes: phalanx scenes"
            )),
        }
    }
}
