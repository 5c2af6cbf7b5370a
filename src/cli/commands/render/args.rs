//! The arguments of `phalanx render`.

use crate::cli::options::{
    FrameArgs, LONG_RENDERS, OUTPUT, SceneArgs, TileArgs, TreeArgs, WorkArgs,
};
use crate::cli::output::ProgressMode;
use clap::Args;
use phalanx::jobs::{EncodingSpec, PixelSpec};
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct RenderArgs {
    #[arg(
        required_unless_present = "plan",
        help = "Scene file, cache (.phx), standard:NAME[:SIZE], or -",
        long_help = "Scene file, scene cache (.phx), standard scene as standard:NAME[:SIZE], or - for stdin (see --format)."
    )]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub scene_args: SceneArgs,
    #[command(flatten)]
    pub pixels: PixelSpec,
    #[command(flatten)]
    pub tiles: TileArgs,
    /// PNG, JPEG, EXR, HDR or PFM; - for stdout
    ///
    /// Picture to write, a PNG, JPEG, OpenEXR, Radiance HDR or PFM file by its ending, or - for
    /// stdout (a PNG, if --format does not say otherwise; the report then goes to stderr).
    /// [default: the scene's `output`, else its stem + .png, in the current folder]
    #[arg(short, long, value_name = "FILE", help_heading = OUTPUT, display_order = 0)]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub encoding: EncodingSpec,
    /// A second picture, of the cost of each pixel
    ///
    /// Write a second picture, of what each pixel's camera ray costs to trace. KIND is nodes (that
    /// are visited), prims (that are tested), or time.
    #[arg(long, num_args = 2, value_names = ["KIND", "OUT.png"], help_heading = OUTPUT, hide_short_help = true, conflicts_with = "path")]
    pub heat: Option<Vec<String>>,
    /// Print one JSON document, not three lines
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
    /// How progress is told. [default: auto]
    #[arg(long, value_enum, value_name = "MODE", help_heading = LONG_RENDERS, hide_short_help = true, default_value_t = ProgressMode::Auto, hide_default_value = true)]
    pub progress: ProgressMode,
    #[command(flatten)]
    pub tree: TreeArgs,
    #[command(flatten)]
    pub work: WorkArgs,
}

/// Files in which finished tiles are kept.
#[derive(Debug, Args)]
#[command(next_help_heading = LONG_RENDERS)]
pub struct CheckpointArgs {
    /// Keep finished tiles here, to resume
    ///
    /// Keep finished tiles in this file: after an interruption, the same command goes on where it
    /// was. The file stays when the picture is written, 12 bytes a pixel and more: the same
    /// picture in another format or exposure then traces nothing.
    #[arg(long, value_name = "FILE", conflicts_with = "plan")]
    pub checkpoint: Option<PathBuf>,
    /// Render a shard of a plan
    ///
    /// Render one shard of a plan, as `phalanx plan` has written it, into a file beside it.
    #[arg(
        long,
        hide_short_help = true,
        value_name = "PLAN.json",
        requires = "shard",
        conflicts_with_all = ["scene", "output", "heat", "preview", "snapshot", "FrameArgs", "PixelSpec", "EncodingSpec", "ToneSpec", "SceneArgs", "SceneOverrides"]
    )]
    pub plan: Option<PathBuf>,
    /// Which shard: a number from 0, or auto
    ///
    /// Which shard: a number from 0, or auto, which asks Slurm, Kubernetes, AWS Batch or MPI.
    #[arg(long, value_name = "I|auto", hide_short_help = true, requires = "plan", value_parser = parse_shard)]
    pub shard: Option<Shard>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = LONG_RENDERS)]
pub struct PreviewArgs {
    /// Draw the picture so far in the terminal
    #[arg(long)]
    pub preview: bool,
    /// Write the picture so far here, now and then
    ///
    /// Write the picture so far to this file, every ten seconds and at the end, 2048 pixels wide or
    /// high at most.
    #[arg(long, value_name = "FILE.png", hide_short_help = true)]
    pub snapshot: Option<PathBuf>,
}

/// A shard of a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shard {
    /// The one that the scheduler has given to this process.
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
