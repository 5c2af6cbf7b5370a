//! `--max-memory`: memory estimates, made before each step.
//!
//! | step | estimate |
//! |---|---|
//! | reading a file | [`FILE_TIMES`] its size (1) |
//! | files that a scene names | counted by the reader, before each (2) |
//! | faces of an OBJ or PLY, vertices of a PLY | counted by the reader (3) |
//! | environments | 4 to 18 bytes per texel, counted by their reader |
//! | points of a file without faces | 48 bytes each and their materials, counted by the reader |
//! | making smooth normals | 60 bytes per triangle and 16 per vertex, counted by the reader |
//! | opening a cache | its size, all of which is mapped |
//! | generating a standard scene | columns (4) and tree (5), for each shape by its kind |
//! | building a tree | the scene's columns, for each primitive by its kind, each thread (5) |
//! | rendering | columns, trees, films, and the buffers of each thread (6) |
//! | viewing | columns, trees, the buffers of each thread (6), and the pictures of one page |
//!
//! 1. The bytes themselves, and the columns and tables made from them. For glTF: the file, plus
//!    whatever its reader counts. A pipe or device has no size, so reading stops at the limit that
//!    these factors imply.
//! 2. Other files, materials, and decoded textures; for glTF also the document, the triangles of a
//!    mesh, and its columns.
//! 3. 20 bytes per triangle, 12 each for UVs, normals and colours of vertices, and 36 for colours
//!    of faces, minus the bytes already covered by the size of the face in the file. Columns of
//!    vertices likewise. While the largest polygon is cut, 300 bytes per corner and thread.
//! 4. [`COLUMN_BYTES`] per triangle, [`OTHER_COLUMN_BYTES`] per sphere or cone.
//! 5. [`TRIANGLE_BYTES`] per triangle, [`OTHER_BYTES`] per other primitive, [`BUILDER_BYTES`] or
//!    [`BEST_BUILDER_BYTES`] per thread; [`ORACLE_BYTES`] per primitive for the oracle's tree.
//! 6. The actual columns and tree, and [`WIDE_BYTES`] per primitive if the wide tree is not built
//!    yet. The films, of one band each, and their encoded pictures. For each thread:
//!    [`THREAD_BYTES`], [`PIXEL_BYTES`] per pixel of a tile, [`RAY_BYTES`] per ray of a wavefront,
//!    and the queued bounces (`WaveSizes`; for the oracle, [`PATH_BYTES`] per bounce of a path).
//!    With adaptive sampling, [`SAMPLE_BYTES`] per sample that a block of 8x8 pixels may get.
//!
//! Memory for standard scenes and trees is requested from the system on trial first, even without a
//! limit. [`PROGRAM_BYTES`] are added to each estimate. Freed memory counts as free: see `heap`.
//! Estimates err on the high side; `perf/notes/memory.md` compares them with peaks.

use super::format_args::ending_of;
use crate::cli::output::{CliError, bytes, grouped};
#[cfg(feature = "view")]
use phalanx::bvh::Bvh;
use phalanx::formats::LoadError;
use phalanx::frame::{Accel, BuildSettings, Engine, Integrator, Quality, Settings, Tile};
use phalanx::jobs::bands;
use phalanx::open::{OpenError, is_cache};
use phalanx::scene::Scene;
use phalanx::standard::{self, Spec};
use phalanx::thread_count;
use std::path::Path;

/// Factor for text and binary meshes: columns are about as large as the file, and exist twice while
/// they are joined.
const FILE_TIMES: u64 = 3;
/// Bytes per generated triangle: its corners, a vertex or more, and a material.
const COLUMN_BYTES: u64 = 35;
/// Bytes per generated sphere or cone.
const OTHER_COLUMN_BYTES: u64 = 40;
/// Bytes per triangle while the packet engine's BVH is built.
const TRIANGLE_BYTES: u64 = 75;
/// Bytes per other primitive or instance while the packet engine's BVH is built.
const OTHER_BYTES: u64 = 180;
/// Bytes of a thread that builds chunks, which are largest at the best quality.
const BUILDER_BYTES: u64 = 2 << 20;
const BEST_BUILDER_BYTES: u64 = 6 << 20;
/// Bytes per primitive while the oracle's tree is built.
const ORACLE_BYTES: u64 = 100;
/// Bytes per primitive while the wide tree is built.
const WIDE_BYTES: u64 = 140;
/// Bytes per pixel of a tile, with its camera rays.
const PIXEL_BYTES: u64 = 400;
/// Bytes per ray of a wavefront while it is shaded.
const RAY_BYTES: u64 = 800;
/// Bytes per bounce of the oracle while later ones are traced.
const PATH_BYTES: u64 = 256;
/// Bytes per sample that halves a cell until its block is finished: 110 were measured, plus AOVs of
/// light.
const SAMPLE_BYTES: u64 = 160;
/// Minimum number of such samples in memory: several blocks hold them at once.
const SAMPLES: u64 = 1 << 16;
/// Stack and buffers of a thread.
const THREAD_BYTES: u64 = 4 << 20;
/// Code, stacks and buffers of the program.
const PROGRAM_BYTES: u64 = 24 << 20;

/// Memory limit in bytes; `None` for no limit.
#[derive(Clone, Copy, Debug)]
pub struct Budget(pub Option<u64>);

impl Budget {
    /// Checks the memory before a scene file is read or a cache mapped. Returns the bytes left for
    /// files that the scene names and for data that its reader makes; the reader counts both.
    pub fn beside_file(self, name: &Path, file_bytes: u64) -> Result<Option<u64>, CliError> {
        let what = format!("to read a file of {}", bytes(file_bytes));
        let needed = file_bytes.saturating_mul(times(name));
        self.check(needed, &what)
    }

    /// Largest file that [`Budget::beside_file`] accepts, in bytes.
    pub fn most_bytes(self, name: &Path) -> u64 {
        let left = |allowed: u64| allowed.saturating_sub(PROGRAM_BYTES) / times(name);
        self.0.map_or(u64::MAX, left)
    }

    /// The error of a scene that could not be opened. If memory was the reason, it names the limit
    /// that would have sufficed.
    pub fn explain(self, error: OpenError) -> CliError {
        let OpenError::Load(LoadError::Memory {
            what,
            needed,
            allowed,
            ..
        }) = &error
        else {
            return error.into();
        };
        let all = self.0.unwrap_or(*allowed);
        let before = all.saturating_sub(allowed.saturating_add(PROGRAM_BYTES));
        let refused = self.check(before.saturating_add(*needed), what);
        refused.err().unwrap_or_else(|| error.into())
    }

    /// Checks the memory before a standard scene is generated.
    pub fn for_standard(self, spec: Spec) -> Result<(), CliError> {
        let counts = standard::counts(spec);
        let others = counts.spheres + counts.cones;
        let needed = counts.triangles * (COLUMN_BYTES + TRIANGLE_BYTES)
            + others * (OTHER_COLUMN_BYTES + OTHER_BYTES);
        let primitives = grouped(counts.triangles + others);
        let what = format!("for the columns and the BVH of {primitives} primitives");
        self.check(needed, &what)?;
        grantable(needed, &what).map_err(|error| error.with_hint("try a smaller size"))
    }

    /// Checks the memory before the tree of a scene is built.
    pub fn for_tree(
        self,
        scene: &Scene,
        engine: Engine,
        settings: &BuildSettings,
    ) -> Result<(), CliError> {
        let objects = (scene.prim_count() + scene.instances.len()) as u64;
        let triangles = scene.triangles.len() as u64;
        let tree = match engine {
            Engine::Simd => {
                let builder = match settings.quality {
                    Quality::Best => BEST_BUILDER_BYTES,
                    Quality::Fast | Quality::Medium => BUILDER_BYTES,
                };
                // Each thread has a chunk of more than a thousand objects.
                let builders = (thread_count(settings.threads) as u64).min(objects >> 10);
                let others = objects.saturating_sub(triangles);
                triangles * TRIANGLE_BYTES + others * OTHER_BYTES + builders * builder
            }
            Engine::Scalar => objects * ORACLE_BYTES,
        };
        let what = format!("to build the BVH of {} primitives", grouped(objects));
        self.check(scene.memory_bytes() as u64 + tree, &what)?;
        grantable(tree, &what)
    }

    /// Checks the memory before a picture is rendered with `films` films in memory.
    pub fn for_render(
        self,
        scene: &Scene,
        prepared: &Accel,
        settings: &Settings,
        films: u64,
    ) -> Result<(), CliError> {
        let tree = prepared.tree_stats();
        let wide = if prepared.is_ready(settings) {
            tree.wide_bytes as u64
        } else {
            scene.prim_count() as u64 * WIDE_BYTES
        };
        let tree = (tree.node_bytes + tree.prim_bytes) as u64 + wide;
        let Tile { width, height, .. } = settings.window();
        let pictures = films * film_bytes(settings) + thread_bytes(scene, settings);
        let needed = scene.memory_bytes() as u64 + tree + pictures;
        let what = format!("to render {width}x{height} pixels");
        self.check(needed, &what).map(drop)
    }

    /// Checks the memory before a scene is viewed in pictures of at least `least` bytes. Returns
    /// the bytes left for pictures, if there is a limit.
    #[cfg(feature = "view")]
    pub fn for_view(
        self,
        scene: &Scene,
        bvh: &Bvh,
        settings: &Settings,
        least: u64,
    ) -> Result<Option<u64>, CliError> {
        let tree = (scene.memory_bytes() + bvh.node_bytes() + bvh.prim_bytes()) as u64;
        let wide = scene.prim_count() as u64 * WIDE_BYTES;
        let needed = tree + wide + thread_bytes(scene, settings) + least;
        let left = self.check(needed, "to view the scene")?;
        Ok(left.map(|left| left + least))
    }

    /// Returns the bytes left, if there is a limit.
    fn check(self, needed: u64, what: &str) -> Result<Option<u64>, CliError> {
        let needed = needed.saturating_add(PROGRAM_BYTES);
        let left = |allowed: u64| allowed.checked_sub(needed).ok_or(allowed);
        self.0.map(left).transpose().map_err(|allowed| {
            let [needed, allowed] = [needed, allowed].map(bytes);
            CliError::Runtime(format!(
                "about {needed} needed {what}, but --max-memory allows {allowed}"
            ))
        })
    }
}

/// Bytes of all threads while they render.
fn thread_bytes(scene: &Scene, settings: &Settings) -> u64 {
    let Tile { width, height, .. } = settings.window();
    let side = |pixels: u32| u64::from(pixels.min(settings.tile));
    let tile = side(width) * side(height);
    let rays = match settings.engine {
        Engine::Simd => {
            let sizes = settings.wave_sizes(scene);
            let together = tile.min(sizes.rays() as u64);
            together * RAY_BYTES + sizes.bounce_bytes(together as usize) as u64
        }
        Engine::Scalar => u64::from(settings.max_depth) * PATH_BYTES,
    };
    let by_pixels = scene.is_stochastic()
        || settings.lens.is_some()
        || settings.integrator != Integrator::Whitted;
    let samples = match settings.sampling.adaptively() {
        Some(_) if !by_pixels => SAMPLES.max(64 * u64::from(settings.sampling.spp)),
        _ => 0,
    };
    let each = THREAD_BYTES + tile * PIXEL_BYTES + rays + samples * SAMPLE_BYTES;
    settings.threads as u64 * each
}

/// Refuses an amount of memory that the system does not grant, because using it would end the
/// process.
fn grantable(needed: u64, what: &str) -> Result<(), CliError> {
    let mut probe: Vec<u8> = Vec::new();
    let given = probe.try_reserve_exact(usize::try_from(needed).unwrap_or(usize::MAX));
    // Otherwise the compiler may remove the unused allocation.
    std::hint::black_box(&probe);
    given.map_err(|_| {
        let needed = bytes(needed);
        CliError::Runtime(format!(
            "about {needed} needed {what}, but that much memory is not available"
        ))
    })
}

/// Memory needed to read a scene file, as a multiple of its size.
fn times(name: &Path) -> u64 {
    let is_read_once = is_cache(name) || matches!(ending_of(name), Some("gltf" | "glb"));
    if is_read_once { 1 } else { FILE_TIMES }
}

/// Bytes of one film in memory, which is a band of the picture unless hits are recorded: three
/// floats per pixel, four more with hits, and the picture's samples of up to 16 bits, raw and
/// encoded.
pub fn film_bytes(settings: &Settings) -> u64 {
    let window = settings.window();
    let (pixels, floats) = if settings.record_hits {
        (window.pixels(), 7)
    } else {
        let bands = bands(window, settings.tile_side());
        (bands.first().map_or(0, Tile::pixels), 3)
    };
    pixels * (4 * (floats + settings.aovs.channels().count() as u64) + 12)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_names_what_is_needed_and_what_is_allowed() {
        let budget = Budget(Some(100 << 20));
        let (text, cache) = ("a.test", "a.phx");
        let refused = budget.beside_file(text.as_ref(), 50 << 20).unwrap_err();
        assert_eq!(refused.code(), 1);
        let CliError::Runtime(message) = refused else {
            panic!("{refused:?}")
        };
        for part in ["174.0 MiB", "100.0 MiB", "--max-memory", "50.0 MiB"] {
            assert!(message.contains(part), "{part} in {message}");
        }
        budget.beside_file(cache.as_ref(), 50 << 20).unwrap();
        budget.beside_file(text.as_ref(), 20 << 20).unwrap();
        Budget(None).beside_file(text.as_ref(), u64::MAX).unwrap();
    }

    #[test]
    fn every_threads_rays_and_their_bounces_count() {
        let text = "size 64 64\ncamera 0 0 5 0 0 0 0 1 0 45\nmaxdepth 300\nspecular 1 1 1\nsphere 0 0 0 9\n";
        let scene = phalanx::formats::read_test(text).unwrap().scene;
        let prepared = Accel::build(&scene, Engine::Simd);
        let needed = |threads: usize| {
            let settings = Settings {
                threads,
                ..Settings::of(&scene)
            };
            let enough = |mib: &u64| {
                let budget = Budget(Some(mib << 20));
                budget.for_render(&scene, &prepared, &settings, 1).is_ok()
            };
            (0..4096).find(enough).expect("a few MiB")
        };
        let sizes = Settings::of(&scene).wave_sizes(&scene);
        let rays = sizes.rays().min(32 * 32);
        let each = THREAD_BYTES + rays as u64 * RAY_BYTES + sizes.bounce_bytes(rays) as u64;
        assert!(each > THREAD_BYTES + (5 << 20));
        assert!(needed(65) - needed(1) >= (64 * each) >> 20);
    }
}
