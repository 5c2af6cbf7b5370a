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
    /// Any folder is allowed, and - for stdout; the extension gives the format. For a sequence, it
    /// is the pattern for the names of the frames. The default is only available if the plan's
    /// picture is in the plan's folder.
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// Picture format: png, jpg, exr, hdr, pfm
    ///
    /// Overrides the extension. [default for stdout: png]
    #[arg(long, value_name = "NAME", hide_possible_values = true, value_parser = name_parser(&ImageFormat::ENDINGS))]
    pub format: Option<ImageFormat>,
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
}
