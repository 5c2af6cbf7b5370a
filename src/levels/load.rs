//! The level of this process: the best that was compiled and that the CPU can run.

#![allow(unsafe_code, reason = "a library is code from outside of the program")]

use crate::tree::LevelExports;
use phalanx::glam::{DAffine3, dvec3};
use phalanx::{Scene, isa};
use std::sync::OnceLock;

// Levels and their libraries, best first, as the build script has made them.
include!(concat!(env!("OUT_DIR"), "/levels.rs"));

/// The level that rays run on, by name; chosen at the first call.
pub fn chosen() -> (&'static str, &'static LevelExports) {
    static CHOSEN: OnceLock<(&str, &LevelExports)> = OnceLock::new();
    *CHOSEN.get_or_init(|| {
        let wish = std::env::var("PHALANX_LEVEL").unwrap_or_default();
        let mut fit = LIBRARIES
            .iter()
            .filter(|(name, _)| runs_here(name) && (wish.is_empty() || wish == *name));
        let loaded = fit.find_map(|(name, library)| Some((*name, load(library)?)));
        loaded.unwrap_or((isa::compiled_level(), &LevelExports::OWN))
    })
}

/// Loads a library, and compares its types with ours: their sizes, and a scene as it reads them.
fn load(library: &[u8]) -> Option<&'static LevelExports> {
    let (level, own) = (system::open(library)?, &LevelExports::OWN);
    let scene = sample();
    let text = |level: &LevelExports| {
        let mut text = String::new();
        (level.describe)(&scene, &mut |more| text.push_str(more));
        text
    };
    (level.sizes == own.sizes && text(level) == text(own)).then_some(level)
}

/// A scene of several kinds of rows.
fn sample() -> Scene {
    let mut scene = Scene::new();
    let corners = [[0.0, 1.0, 2.0], [4.0, 3.0, 5.0], [6.0, 8.0, 7.0]];
    let mesh = scene.add_prototype(&corners, &[[0, 1, 2]]);
    let place = DAffine3::from_scale(dvec3(2.0, 3.0, 4.0));
    let placed = mesh.and_then(|mesh| scene.add_instance(mesh, place));
    let ball = scene.add_spheres(&[[9.0, 10.0, 11.0]], &[12.0]);
    debug_assert!(placed.is_ok() && ball.is_ok());
    scene
}

#[cfg(target_arch = "x86_64")]
fn runs_here(level: &str) -> bool {
    // Names sort in the order of levels. The system must keep the registers, too.
    let has_registers = match level {
        "x86-64-v4" => is_x86_feature_detected!("avx512f"),
        _ => is_x86_feature_detected!("avx2"),
    };
    has_registers && level <= isa::cpu_level()
}

#[cfg(not(target_arch = "x86_64"))]
fn runs_here(_: &str) -> bool {
    false
}

#[cfg(all(target_os = "linux", target_env = "gnu", target_arch = "x86_64"))]
mod system {
    use crate::tree::LevelExports;
    use std::ffi::CString;
    use std::fs::File;
    use std::io::Write;
    use std::os::fd::{AsRawFd, FromRawFd};

    /// Loads a library for the rest of the process, from a file that exists in memory only.
    pub fn open(library: &[u8]) -> Option<&'static LevelExports> {
        // SAFETY: the name ends with a zero, and a number that is not negative is a new file's.
        let mut file = unsafe {
            let number = libc::memfd_create(c"phalanx".as_ptr(), libc::MFD_CLOEXEC);
            (number >= 0).then(|| File::from_raw_fd(number))?
        };
        file.write_all(library).ok()?;
        let path = CString::new(format!("/proc/self/fd/{}", file.as_raw_fd())).ok()?;
        // SAFETY: names end with zeros. The build script has compiled the library from `level.rs`,
        // whose symbol is a `LevelExports`, and it is never closed.
        unsafe {
            let handle = libc::dlopen(path.as_ptr(), libc::RTLD_NOW | libc::RTLD_LOCAL);
            if handle.is_null() {
                return None;
            }
            let level = libc::dlsym(handle, c"PHALANX_LEVEL".as_ptr());
            level.cast::<LevelExports>().as_ref()
        }
    }
}

#[cfg(not(all(target_os = "linux", target_env = "gnu", target_arch = "x86_64")))]
mod system {
    use crate::tree::LevelExports;

    /// No library is compiled for this system.
    pub fn open(_: &[u8]) -> Option<&'static LevelExports> {
        None
    }
}
