//! The arguments of `phalanx render`.

use crate::cli::options::{
    FrameArgs, LONG_RENDERS, OUTPUT, SceneArgs, TileArgs, TreeArgs, WorkArgs,
};
use crate::cli::output::ProgressMode;
use clap::Args;
use phalanx::jobs::{EncodingSpec, PixelSpec};
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(mut_arg("headlight", |arg| arg.hide_short_help(false)))]
pub struct RenderArgs {
    #[arg(
        required_unless_present = "plan",
        help = "Scene file, cache (.phx), standard:NAME[:SIZE], or -",
        long_help = "Scene file, scene cache (.phx), standard scene (standard:NAME[:SIZE]), or - for stdin (see --format)"
    )]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub scene_args: SceneArgs,
    #[command(flatten)]
    pub pixels: PixelSpec,
    #[command(flatten)]
    pub tiles: TileArgs,
    /// PNG, JPEG, EXR, HDR or PFM file; - for stdout
    ///
    /// Picture to write: PNG, JPEG, OpenEXR, Radiance HDR or PFM, by its extension; or - for
    /// stdout, as PNG unless --format is given (the report then goes to stderr). [default: the
    /// scene's `output`, else the scene's name with .png, in the current folder]
    #[arg(short, long, value_name = "FILE", help_heading = OUTPUT, display_order = 0)]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub encoding: EncodingSpec,
    /// Also write a heat map of the cost of each pixel
    ///
    /// Shows the cost of tracing each pixel's camera ray. KIND is nodes (BVH nodes visited), prims
    /// (primitives tested) or time.
    #[arg(long, num_args = 2, value_names = ["KIND", "OUT.png"], help_heading = OUTPUT, hide_short_help = true, conflicts_with = "path")]
    pub heat: Option<Vec<String>>,
    /// Print the report as JSON
    #[arg(long, help_heading = OUTPUT, display_order = 900)]
    pub json: bool,
    #[command(flatten)]
    pub frames: FrameArgs,
    #[command(flatten)]
    pub kept: CheckpointArgs,
    #[command(flatten)]
    pub preview: PreviewArgs,
    /// Progress: auto (a bar on a terminal), bar, json, none
    ///
    /// Type of progress display. [default: auto]
    #[arg(long, value_enum, value_name = "MODE", help_heading = LONG_RENDERS, hide_short_help = true, default_value_t = ProgressMode::Auto, hide_default_value = true)]
    pub progress: ProgressMode,
    #[command(flatten)]
    pub tree: TreeArgs,
    #[command(flatten)]
    pub work: WorkArgs,
}

/// Options for files of finished tiles.
#[derive(Debug, Args)]
#[command(next_help_heading = LONG_RENDERS)]
pub struct CheckpointArgs {
    /// Keep finished tiles in this file, to resume
    ///
    /// Takes 12 bytes per pixel or more. After an interruption, the same command resumes from the
    /// file. It remains after the render, so that writing the picture in another format or exposure
    /// traces nothing.
    #[arg(long, value_name = "FILE", conflicts_with = "plan")]
    pub checkpoint: Option<PathBuf>,
    /// Render a shard of a plan
    ///
    /// The plan is a file made by `phalanx plan`; the shard is written next to it.
    #[arg(
        long,
        hide_short_help = true,
        value_name = "PLAN.json",
        requires = "shard",
        conflicts_with_all = ["scene", "output", "heat", "preview", "snapshot", "FrameArgs", "PixelSpec", "EncodingSpec", "ToneSpec", "SceneArgs", "SceneOverrides"]
    )]
    pub plan: Option<PathBuf>,
    /// Shard to render: a number from 0, or auto
    ///
    /// With auto, the number is the task index set by Slurm, Kubernetes, AWS Batch or MPI.
    #[arg(long, value_name = "I|auto", hide_short_help = true, requires = "plan", value_parser = parse_shard)]
    pub shard: Option<Shard>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = LONG_RENDERS)]
pub struct PreviewArgs {
    /// Show the unfinished picture in the terminal
    #[arg(long, hide_short_help = true)]
    pub preview: bool,
    /// Write the unfinished picture to this file at intervals
    ///
    /// Every ten seconds and at the end, at most 2048 pixels wide or high.
    #[arg(long, value_name = "FILE.png", hide_short_help = true)]
    pub snapshot: Option<PathBuf>,
}

/// A shard of a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shard {
    /// The one that the scheduler assigned to this process.
    Auto,
    Number(u32),
}

fn parse_shard(text: &str) -> Result<Shard, String> {
    match (text, text.parse()) {
        ("auto", _) => Ok(Shard::Auto),
        (_, Ok(number)) => Ok(Shard::Number(number)),
        _ => Err("expected a number from 0, or auto".to_owned()),
    }
}
