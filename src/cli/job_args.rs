//! Arguments of renders that can be interrupted, and of renders that many machines share.

use super::format_args::picture_parser;
use super::output_file::GradeArgs;
use super::picture_args::PictureArgs;
use super::scene_args::SceneArgs;
use clap::{Args, Subcommand, value_parser};
use phalanx::image::ImageFormat;
use phalanx::jobs::MAX_SHARDS;
use std::path::PathBuf;

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

#[derive(Debug, Args)]
pub struct PlanArgs {
    /// Scene file, cache (.phx), or standard:NAME[:SIZE]
    pub scene: PathBuf,
    /// How many shards to cut the picture into
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=i64::from(MAX_SHARDS)))]
    pub shards: u32,
    /// Picture that the shards will be merged into; its ending says what is written. If it lies
    /// outside the plan's folder, merge wants to be told again
    #[arg(short, long, value_name = "OUT.png")]
    pub output: PathBuf,
    /// Plan to write; shards are rendered into files beside it
    #[arg(long, value_name = "PLAN.json")]
    pub plan: PathBuf,
    #[command(flatten)]
    pub picture: PictureArgs,
    #[command(flatten)]
    pub grade: GradeArgs,
    #[command(flatten)]
    pub beside: SceneArgs,
    /// Print one JSON document instead of lines
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct MergeArgs {
    /// Plan whose shards have been rendered
    pub plan: PathBuf,
    /// Picture to write, anywhere, by its ending, or - for stdout
    /// [default: the plan's, which has to lie in the plan's folder]
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// Format of the picture, whatever its name ends in [default for stdout: png]
    #[arg(long, value_name = "NAME", value_parser = picture_parser())]
    pub format: Option<ImageFormat>,
    /// Print one JSON document instead of lines
    #[arg(long)]
    pub json: bool,
}

/// Whom a plan is handed to.
#[derive(Debug, Subcommand)]
pub enum SubmitTo {
    /// Slurm: a job array of the shards that are missing, and a job that merges them
    #[command(
        after_help = "Two scripts are written beside the plan. What stands after -- is for sbatch, in both jobs.\n\n\
                      Example: phalanx submit slurm poster.json --time 2:00:00 --cpus-per-task 16 -- --partition=long"
    )]
    Slurm(SubmitArgs),
}

#[derive(Debug, Args)]
pub struct SubmitArgs {
    /// Plan to render and to merge
    pub plan: PathBuf,
    /// Time limit of a shard, as sbatch takes it; a shard that needs longer saves what it has and
    /// goes back into the queue
    #[arg(long, value_name = "TIME")]
    pub time: Option<String>,
    /// Picture that the merge writes, anywhere
    /// [default: the plan's, which has to lie in the plan's folder]
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// CPUs of a shard [default: those that Slurm gives it]
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..))]
    pub cpus_per_task: Option<u32>,
    /// Write the scripts, and print what would be called
    #[arg(long)]
    pub dry_run: bool,
    /// Print one JSON document instead of lines
    #[arg(long)]
    pub json: bool,
    /// Further options for sbatch
    #[arg(last = true, value_name = "SBATCH OPTIONS")]
    pub sbatch: Vec<String>,
}
