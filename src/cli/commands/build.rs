//! `phalanx build`.

use crate::cli::options::{
    MACHINE, OUTPUT, SceneArgs, SceneInput, TreeArgs, WantedPicture, parse_thread_count,
};
use crate::cli::output::{
    self, CliError, MemoryStats, Output, PrimitiveCounts, TreeFigures, bytes, interrupt, lines,
};
use clap::Args;
use phalanx::cache::{self, CacheWriteError};
use phalanx::files::shown_path;
use phalanx::frame::TreeStats;
use phalanx::open::is_cache;
use serde::Serialize;
use std::io;
use std::path::PathBuf;
use std::time::Instant;

#[derive(Debug, Args)]
pub struct BuildArgs {
    #[arg(
        help = "Scene file, standard:NAME[:SIZE], or -",
        long_help = "Scene file, standard scene (standard:NAME[:SIZE]), or - for stdin (see --format)"
    )]
    pub scene: PathBuf,
    /// Cache to write (.phx)
    #[arg(short, long, value_name = "OUT.phx", help_heading = OUTPUT)]
    pub output: PathBuf,
    #[command(flatten)]
    pub scene_args: SceneArgs,
    #[command(flatten)]
    pub tree: TreeArgs,
    /// Number of threads [default: one per available CPU]
    #[arg(long, value_name = "N", help_heading = MACHINE, value_parser = parse_thread_count)]
    pub threads: Option<usize>,
    /// Print the report as JSON
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,
}

#[derive(Debug, Serialize)]
struct BuildDocument {
    scene: String,
    path: String,
    file_bytes: u64,
    primitives: PrimitiveCounts,
    bvh: TreeFigures,
    seconds: BuildSeconds,
    memory: MemoryStats,
}

#[derive(Clone, Copy, Debug, Serialize)]
struct BuildSeconds {
    load: f64,
    build: f64,
    write: f64,
}

/// Builds the BVH of a scene and stores both.
pub fn run(args: &BuildArgs) -> Result<(), CliError> {
    let path = &args.output;
    if !is_cache(path) {
        return Err(CliError::Usage(format!(
            "--output {}: the name of a scene cache must end in .{}",
            shown_path(path),
            cache::ENDING
        )));
    }
    output::check_place(path, Some("--output"))?;
    args.scene_args.no_picture()?;
    interrupt::listen()?;
    let threads = args.threads.unwrap_or(0);
    let start = Instant::now();
    let picture = WantedPicture::default();
    let mut scene_input = SceneInput::load(&args.scene, &args.scene_args, picture, threads)?;
    let load = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let bvh = scene_input.tree(&args.tree, threads)?;
    let build = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let mut file_bytes = 0;
    interrupt::write_file(path, |out| {
        let written = cache::write(out, &scene_input.scene, &bvh);
        file_bytes = written.map_err(|error| match error {
            CacheWriteError::Io(error) => error,
            other => io::Error::other(other),
        })?;
        Ok(())
    })?;
    let write = start.elapsed().as_secs_f64();
    let tree = TreeStats::of(&bvh);
    let document = BuildDocument {
        scene: args.scene.to_string_lossy().into_owned(),
        path: path.to_string_lossy().into_owned(),
        file_bytes,
        primitives: PrimitiveCounts::of(&scene_input.scene),
        bvh: tree.into(),
        seconds: BuildSeconds { load, build, write },
        memory: MemoryStats::of(&scene_input.scene, &tree, 0, scene_input.mapped_bytes),
    };
    output::print_output(&document, args.json)
}

impl Output for BuildDocument {
    fn table(&self) -> String {
        let BuildSeconds { load, build, write } = self.seconds;
        let tree = format!("{}, cost {:.2}", self.bvh.words(), self.bvh.sah);
        let seconds = format!("load {load:.3}, build {build:.3}, write {write:.3}");
        let mut rows = vec![
            ("scene", self.scene.clone()),
            ("primitives", self.primitives.words()),
            ("tree", tree),
            ("seconds", seconds),
        ];
        rows.extend(self.memory.rows());
        let size = bytes(self.file_bytes);
        rows.push(("written", format!("{}, {size}", self.path)));
        lines(&rows)
    }
}
