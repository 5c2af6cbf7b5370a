//! The arguments of `phalanx merge`.

use crate::cli::options::name_parser;
use clap::Args;
use phalanx::image::ImageFormat;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct MergeArgs {
    /// Plan whose shards have been rendered
    pub plan: PathBuf,
    /// Picture to write [default: the plan's]
    ///
    /// Picture to write, anywhere, by its ending, or - for stdout; of a sequence, the name that
    /// frames get their numbers in.
    /// [default: the plan's, which has to lie in the plan's folder]
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// Format of the picture: png, jpg, exr, hdr, pfm
    ///
    /// Format of the picture, whatever its name ends in: png, jpg, jpeg, exr, hdr or pfm.
    /// [default for stdout: png]
    #[arg(long, value_name = "NAME", hide_possible_values = true, value_parser = name_parser(&ImageFormat::ENDINGS))]
    pub format: Option<ImageFormat>,
    /// Print one JSON document instead of lines
    #[arg(long)]
    pub json: bool,
}
