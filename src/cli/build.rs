//! `phalanx build`.

use super::args::BuildArgs;
use super::counts::{Primitives, Tree};
use super::failure::Failure;
use super::input::Input;
use super::memory::Memory;
use super::output::{bytes, grouped};
use super::report::{SCHEMA_VERSION, lines};
use super::{interrupt, output};
use phalanx::cache::{self, WriteError};
use phalanx::frame::TreeStats;
use phalanx::image::replace_file;
use phalanx::open::is_cache;
use serde::Serialize;
use std::io;
use std::path::Path;
use std::time::Instant;

#[derive(Debug, Serialize)]
struct Document {
    schema_version: u32,
    scene: String,
    path: String,
    file_bytes: u64,
    primitives: Primitives,
    bvh: Tree,
    seconds: Seconds,
    memory: Memory,
}

#[derive(Clone, Copy, Debug, Serialize)]
struct Seconds {
    load: f64,
    build: f64,
    write: f64,
}

/// Builds the tree of a scene and stores both.
pub fn run(args: &BuildArgs) -> Result<(), Failure> {
    let path = &args.output;
    if !is_cache(path) {
        return Err(Failure::Usage(format!(
            "--output {}: the name of a scene cache must end in .{}",
            path.display(),
            cache::ENDING
        )));
    }
    output::check_place(path)?;
    args.beside.no_picture()?;
    interrupt::listen()?;
    let threads = args.threads.unwrap_or(0);
    let start = Instant::now();
    let mut input = Input::load(&args.scene, &args.beside, threads)?;
    let load = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let bvh = input.tree(&args.tree, threads)?;
    let build = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let mut file_bytes = 0;
    let written = interrupt::undisturbed(path, || {
        replace_file(path, |out| {
            let written = cache::write(out, &input.scene, &bvh);
            file_bytes = written.map_err(|error| match error {
                WriteError::Io(error) => error,
                other => io::Error::other(other),
            })?;
            Ok(())
        })
    })?;
    written.map_err(|e| Failure::Runtime(format!("cannot write {}: {e}", path.display())))?;
    let write = start.elapsed().as_secs_f64();
    let tree = TreeStats::of(&bvh);
    let document = Document {
        schema_version: SCHEMA_VERSION,
        scene: args.scene.to_string_lossy().into_owned(),
        path: path.to_string_lossy().into_owned(),
        file_bytes,
        primitives: Primitives::of(&input.scene),
        bvh: tree.into(),
        seconds: Seconds { load, build, write },
        memory: Memory::of(&input.scene, &tree, 0, input.mapped_bytes),
    };
    match args.json {
        true => output::print_json(&document),
        false => output::print(&document.table(path)),
    }
}

impl Document {
    fn table(&self, path: &Path) -> String {
        let (bvh, seconds) = (&self.bvh, self.seconds);
        let mut rows = vec![
            ("scene", self.scene.clone()),
            ("primitives", self.primitives.words()),
            (
                "tree",
                format!(
                    "{} nodes, depth {}, cost {:.2}",
                    grouped(bvh.nodes as u64),
                    bvh.depth,
                    bvh.sah
                ),
            ),
            (
                "seconds",
                format!(
                    "load {:.3}, build {:.3}, write {:.3}",
                    seconds.load, seconds.build, seconds.write
                ),
            ),
        ];
        rows.extend(self.memory.rows());
        let size = bytes(self.file_bytes);
        rows.push(("written", format!("{}, {size}", path.display())));
        lines(&rows)
    }
}
