//! `phalanx merge`: joins the shards of a plan into its picture.

use super::plan;
use crate::cli::options::name_parser;
use crate::cli::output::{
    self, CliError, Output, ProgressOptions, format_of, interrupt, lines, progress,
};
use clap::Args;
use phalanx::frame::Tile;
use phalanx::image::ImageFormat;
use phalanx::jobs::{BandsError, RenderPlan, TileFile, TileFileError, merge_bands};
use phalanx::scene::shown_path;
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub struct MergeArgs {
    /// Plan whose shards have been rendered
    pub plan: PathBuf,
    /// Picture to write, anywhere, by its ending, or - for stdout
    /// [default: the plan's, which has to lie in the plan's folder]
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// Format of the picture, whatever its name ends in [default for stdout: png]
    #[arg(long, value_name = "NAME", value_parser = name_parser(&ImageFormat::ENDINGS))]
    pub format: Option<ImageFormat>,
    /// Print one JSON document instead of lines
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Serialize)]
struct MergeDocument<'a> {
    plan: &'a Path,
    shards: u32,
    width: u32,
    height: u32,
    path: &'a Path,
}

/// Merges the rendered shards of a plan; exit code 6 if there is something missing.
pub fn run(args: &MergeArgs) -> Result<(), CliError> {
    let plan = RenderPlan::read(&args.plan)?;
    let path = match &args.output {
        Some(path) => path.clone(),
        None => plan.picture_path(&args.plan)?,
    };
    let format = format_of(&path, args.format, "the picture")?;
    output::check_picture_place(&path)?;
    interrupt::listen()?;
    let output = plan::target(&plan, path, format)?;
    let files = files(&args.plan, &plan)?;
    let window = plan.picture.window();
    progress::with_progress(
        Some(&output.path),
        ProgressOptions::of(window.pixels()),
        |control| {
            output.write_while(control, |take| {
                merge_bands(window, plan.aovs(), &files, control, take)
            })
        },
    )?;
    let document = MergeDocument {
        plan: &args.plan,
        shards: plan.shards,
        width: window.width,
        height: window.height,
        path: &output.path,
    };
    output::print_output(&document, args.json)
}

impl Output for MergeDocument<'_> {
    fn table(&self) -> String {
        let size = format!(
            "{}x{}, from {} shards",
            self.width, self.height, self.shards
        );
        let path = shown_path(self.path);
        lines(&[("picture", size), ("written", path)])
    }
}

/// A shard that cannot be merged yet, and the reason.
struct IncompleteShard {
    shard: u32,
    why: String,
}

/// The files of all shards, each of which has all of its tiles.
fn files(path: &Path, plan: &RenderPlan) -> Result<Vec<TileFile>, CliError> {
    let (files, missing) = shards(path, plan)?;
    match missing.is_empty() {
        true => Ok(files),
        false => Err(CliError::Missing(describe_missing(path, plan, &missing))),
    }
}

/// The numbers of the shards that cannot be merged yet.
pub fn missing(path: &Path, plan: &RenderPlan) -> Result<Vec<u32>, CliError> {
    let (_, missing) = shards(path, plan)?;
    Ok(missing.iter().map(|missing| missing.shard).collect())
}

/// The files of the shards that can be merged, and the other shards.
fn shards(
    path: &Path,
    plan: &RenderPlan,
) -> Result<(Vec<TileFile>, Vec<IncompleteShard>), CliError> {
    let (mut files, mut missing) = (Vec::new(), Vec::new());
    let tiles = plan.tiles();
    for shard in 0..plan.shards {
        match whole(path, plan, &tiles, shard)? {
            Ok(file) => files.push(file),
            Err(why) => missing.push(IncompleteShard { shard, why }),
        }
    }
    Ok((files, missing))
}

/// The file of a shard, or the reason why it cannot be merged yet; `tiles` are those of all shards.
fn whole(
    path: &Path,
    plan: &RenderPlan,
    tiles: &[Tile],
    shard: u32,
) -> Result<Result<TileFile, String>, CliError> {
    let name: PathBuf = plan.shard_file(path, shard);
    let file = match TileFile::read(&name, &plan.picture) {
        Ok(file) => file,
        Err(TileFileError::Io { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => {
            return Ok(Err(format!("there is no {}", shown_path(name))));
        }
        Err(TileFileError::Other { .. }) => {
            return Ok(Err(format!("{} holds no tiles", shown_path(name))));
        }
        Err(error) => return Err(BandsError::from(error).into()),
    };
    let share = plan.share_of(tiles, shard).count();
    let lacks = plan.share_of(tiles, shard);
    let lacks = lacks.filter(|tile| !file.has(*tile)).count();
    Ok(match (lacks, file.damaged()) {
        (0, _) => Ok(file),
        (_, 0) => Err(format!("{lacks} of {share} tiles are not rendered yet")),
        (_, damaged) => Err(format!(
            "{lacks} of {share} tiles are missing, {damaged} of them damaged"
        )),
    })
}

/// Message that names the missing shards, and how to render them.
fn describe_missing(path: &Path, plan: &RenderPlan, missing: &[IncompleteShard]) -> String {
    const SHOWN: usize = 10;
    let mut text = format!("{} of {} shards are missing", missing.len(), plan.shards);
    for IncompleteShard { shard, why } in missing.iter().take(SHOWN) {
        text.push_str(&format!("\n  shard {shard}: {why}"));
    }
    if missing.len() > SHOWN {
        text.push_str(&format!("\n  and {} more", missing.len() - SHOWN));
    }
    let numbers: Vec<u32> = missing.iter().map(|m| m.shard).collect();
    text.push_str(&format!(
        "\n  help: render them, with phalanx render --plan {} --shard I, or as tasks of an array: --array={}",
        shown_path(path),
        ranges(&numbers)
    ));
    text
}

/// 0, 1, 2, 5, 7, 8 as 0-2,5,7,8, in Slurm's notation.
pub fn ranges(numbers: &[u32]) -> String {
    let mut parts: Vec<(u32, u32)> = Vec::new();
    for &number in numbers {
        match parts.last_mut() {
            Some((_, last)) if *last + 1 == number => *last = number,
            _ => parts.push((number, number)),
        }
    }
    let part = |(first, last): (u32, u32)| match last - first {
        0 => first.to_string(),
        1 => format!("{first},{last}"),
        _ => format!("{first}-{last}"),
    };
    parts.into_iter().map(part).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_a_row_are_a_range() {
        assert_eq!(ranges(&[0, 1, 2, 5, 7, 8]), "0-2,5,7,8");
        assert_eq!(ranges(&[3]), "3");
        assert_eq!(ranges(&[0, 1]), "0,1");
        assert_eq!(ranges(&[9, 10, 11, 12]), "9-12");
    }
}
