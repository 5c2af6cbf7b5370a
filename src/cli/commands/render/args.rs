//! The arguments of `phalanx render`.

use crate::cli::options::{FrameArgs, GradeArgs, PictureArgs, SceneArgs, TreeArgs, WorkArgs};
use crate::cli::output::ProgressMode;
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct RenderArgs {
    #[arg(
        required_unless_present = "plan",
        help = "Scene file, cache (.phx), standard:NAME[:SIZE], or - for stdin (see --format)"
    )]
    pub scene: Option<PathBuf>,
    /// Picture to write, a PNG, JPEG, OpenEXR, Radiance HDR or PFM file by its ending, or - for
    /// stdout (a PNG, if --format does not say otherwise; the table then goes to stderr) [default:
    /// the scene's `output`, else its stem + .png, in the current folder]
    #[arg(short, long, value_name = "OUT.png")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub picture: PictureArgs,
    #[command(flatten)]
    pub grade: GradeArgs,
    #[command(flatten)]
    pub beside: SceneArgs,
    #[command(flatten)]
    pub tree: TreeArgs,
    #[command(flatten)]
    pub work: WorkArgs,
    #[command(flatten)]
    pub keep: KeepArgs,
    #[command(flatten)]
    pub frames: FrameArgs,
    #[command(flatten)]
    pub sight: SightArgs,
    /// How progress is told
    #[arg(long, value_enum, value_name = "MODE", default_value_t = ProgressMode::Auto)]
    pub progress: ProgressMode,
    /// Write a second picture, of what each pixel's camera ray costs to trace: nodes (visited),
    /// prims (tested), or time
    #[arg(long, num_args = 2, value_names = ["nodes|prims|time", "OUT.png"], conflicts_with = "frames")]
    pub heat: Option<Vec<String>>,
    /// Print one JSON document instead of the table
    #[arg(long)]
    pub json: bool,
}

/// Files that `render` keeps, and their readers.
#[derive(Debug, Args)]
pub struct KeepArgs {
    /// Keep finished tiles in this file: after an interruption, the same command goes on where it
    /// was
    #[arg(long, value_name = "FILE", conflicts_with = "plan")]
    pub checkpoint: Option<PathBuf>,
    /// Render one shard of a plan, as `phalanx plan` has written it, into a file beside it
    #[arg(
        long,
        value_name = "PLAN.json",
        requires = "shard",
        conflicts_with_all = ["scene", "output", "heat", "preview", "snapshot", "FrameArgs", "PictureArgs", "GradeArgs", "SceneArgs"]
    )]
    pub plan: Option<PathBuf>,
    /// Which shard: a number from 0, or auto, which asks Slurm, Kubernetes, AWS Batch or MPI
    #[arg(long, value_name = "I|auto", requires = "plan", value_parser = parse_shard)]
    pub shard: Option<Shard>,
}

#[derive(Debug, Args)]
pub struct SightArgs {
    /// Draw the picture so far in the terminal
    #[arg(long)]
    pub preview: bool,
    /// Write the picture so far to this file, every ten seconds and at the end, 2048 pixels wide or
    /// high at most
    #[arg(long, value_name = "FILE.png")]
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
