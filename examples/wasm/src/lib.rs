//! Pictures in WebAssembly, through functions that need no bindings: numbers in and out, bytes in
//! the module's memory. `examples/wasm/render.mjs` calls them:
//!
//! ```sh
//! cargo build --release --target wasm32-unknown-unknown -p phalanx-wasm
//! node examples/wasm/render.mjs MODULE.wasm 160 120 -o glass.pfm scenes/glass.test
//! ```
//!
//! WebAssembly has neither threads nor files here. The library works on the only thread, and
//! refuses to open files.
#![allow(
    unsafe_code,
    reason = "JavaScript finds functions by unique, unmangled names"
)]

use phalanx::formats::Options;
use phalanx::frame::{Accel, Control, Engine, Settings, render};
use phalanx::image::{Depth, ImageFormat, PictureFile, PictureHeader, write_bands};
use phalanx::open::{open, open_bytes, standard_name};
use phalanx::scene::Scene;
use std::error::Error;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Bytes that JavaScript writes and reads.
struct Exchange {
    /// Name of the scene, in UTF-8.
    name: Vec<u8>,
    /// Contents of the scene's file; empty for a standard scene.
    file: Vec<u8>,
    /// The picture, or an error message.
    answer: Vec<u8>,
}

static EXCHANGE: Mutex<Exchange> = Mutex::new(Exchange {
    name: Vec::new(),
    file: Vec::new(),
    answer: Vec::new(),
});

fn exchange() -> MutexGuard<'static, Exchange> {
    EXCHANGE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Makes room for the scene's name, and returns its address.
#[unsafe(no_mangle)]
pub extern "C" fn name_buffer(length: usize) -> *mut u8 {
    let name = &mut exchange().name;
    *name = vec![0; length];
    name.as_mut_ptr()
}

/// Makes room for the scene's file, and returns its address.
#[unsafe(no_mangle)]
pub extern "C" fn file_buffer(length: usize) -> *mut u8 {
    let file = &mut exchange().file;
    *file = vec![0; length];
    file.as_mut_ptr()
}

/// Renders the scene, with the packet tracer or the oracle. Returns 1 if the answer is a portable
/// float map, which stores the radiance of every pixel to the last bit, and 0 if it is an error
/// message.
#[unsafe(no_mangle)]
pub extern "C" fn render_pfm(width: u32, height: u32, by_oracle: bool) -> u32 {
    let exchange = &mut *exchange();
    let engine = if by_oracle { Engine::Scalar } else { Engine::Simd };
    let made = scene(&exchange.name, &exchange.file)
        .and_then(|scene| picture(&scene, (width, height), engine));
    let done = made.is_ok();
    exchange.answer = made.unwrap_or_else(|error| error.to_string().into_bytes());
    done.into()
}

/// Address of the answer.
#[unsafe(no_mangle)]
pub extern "C" fn answer() -> *const u8 {
    exchange().answer.as_ptr()
}

/// Length of the answer in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn answer_length() -> usize {
    exchange().answer.len()
}

fn scene(name: &[u8], file: &[u8]) -> Result<Scene, Box<dyn Error>> {
    let name = Path::new(std::str::from_utf8(name)?);
    let options = Options::default();
    let opened = match standard_name(name) {
        Some(_) => open(name, &options)?,
        None => {
            let ending = name.extension().and_then(|ending| ending.to_str());
            open_bytes(name, ending.unwrap_or_default(), file, &options)?
        }
    };
    Ok(opened.scene)
}

fn picture(
    scene: &Scene,
    (width, height): (u32, u32),
    engine: Engine,
) -> Result<Vec<u8>, Box<dyn Error>> {
    let settings = Settings {
        width,
        height,
        engine,
        ..Settings::of(scene)
    };
    let accel = Accel::build(scene, engine);
    let frame = render(scene, &accel, &settings, &Control::default())?;
    let file = PictureFile {
        width,
        height,
        crop: None,
        format: ImageFormat::Pfm,
        aovs: settings.aovs,
        origin: scene.origin,
        exposure: scene.encoding.into(),
        depth: Depth::default(),
        header: PictureHeader::NONE,
    };
    let mut bytes = Vec::new();
    write_bands(&mut bytes, &file, [Ok(frame.film)])?;
    Ok(bytes)
}
