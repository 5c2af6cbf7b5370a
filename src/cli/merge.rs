//! `phalanx merge`: the shards of a plan become its picture.

use super::failure::Failure;
use super::job_args::MergeArgs;
use super::picture_file::format_of;
use super::progress::{self, Watch};
use super::report::{SCHEMA_VERSION, lines};
use super::{interrupt, output, plan};
use phalanx::frame::Tile;
use phalanx::jobs::{BandsError, Plan, TileFile, TileFileError, merge_bands};
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(Debug, Serialize)]
struct Document<'a> {
    schema_version: u32,
    plan: &'a Path,
    shards: u32,
    width: u32,
    height: u32,
    path: &'a Path,
}

/// Merges what the shards of a plan have rendered; exit code 6 if there is something missing.
pub fn run(args: &MergeArgs) -> Result<(), Failure> {
    let plan = Plan::read(&args.plan)?;
    let path = match &args.output {
        Some(path) => path.clone(),
        None => plan.picture_path(&args.plan)?,
    };
    let format = format_of(&path, args.format, "the picture")?;
    output::check_picture_place(&path)?;
    interrupt::listen()?;
    let target = plan::target(&plan, path, format)?;
    let files = files(&args.plan, &plan)?;
    let window = plan.picture.window();
    progress::watched_writing(&target.path, Watch::of(window.pixels()), |control| {
        target.write_while(control, |take| {
            merge_bands(window, plan.aovs(), &files, control, take)
        })
    })?;
    if args.json {
        return output::print_json(&Document {
            schema_version: SCHEMA_VERSION,
            plan: &args.plan,
            shards: plan.shards,
            width: window.width,
            height: window.height,
            path: &target.path,
        });
    }
    let size = format!(
        "{}x{}, from {} shards",
        window.width, window.height, plan.shards
    );
    output::print(&lines(&[
        ("picture", size),
        ("written", target.path.display().to_string()),
    ]))
}

/// What is wrong with a shard.
struct Missing {
    shard: u32,
    why: String,
}

/// The files of all shards, each of which has all of its tiles.
fn files(path: &Path, plan: &Plan) -> Result<Vec<TileFile>, Failure> {
    let (mut files, mut missing) = (Vec::new(), Vec::new());
    let tiles = plan.tiles();
    for shard in 0..plan.shards {
        match whole(path, plan, &tiles, shard)? {
            Ok(file) => files.push(file),
            Err(why) => missing.push(Missing { shard, why }),
        }
    }
    match missing.is_empty() {
        true => Ok(files),
        false => Err(Failure::Missing(told(path, plan, &missing))),
    }
}

/// The numbers of the shards that cannot be merged yet.
pub fn missing(path: &Path, plan: &Plan) -> Result<Vec<u32>, Failure> {
    let mut missing = Vec::new();
    let tiles = plan.tiles();
    for shard in 0..plan.shards {
        if whole(path, plan, &tiles, shard)?.is_err() {
            missing.push(shard);
        }
    }
    Ok(missing)
}

/// The file of a shard, or why it cannot be merged yet; `tiles` are those of all shards.
fn whole(
    path: &Path,
    plan: &Plan,
    tiles: &[Tile],
    shard: u32,
) -> Result<Result<TileFile, String>, Failure> {
    let name: PathBuf = plan.shard_file(path, shard);
    let file = match TileFile::read(&name, &plan.picture) {
        Ok(file) => file,
        Err(TileFileError::Io { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => {
            return Ok(Err(format!("there is no {}", name.display())));
        }
        Err(TileFileError::Other { .. }) => {
            return Ok(Err(format!("{} holds no tiles", name.display())));
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

/// Which shards are missing, and how to get them.
fn told(path: &Path, plan: &Plan, missing: &[Missing]) -> String {
    const SHOWN: usize = 10;
    let mut text = format!("{} of {} shards are missing", missing.len(), plan.shards);
    for Missing { shard, why } in missing.iter().take(SHOWN) {
        text.push_str(&format!("\n  shard {shard}: {why}"));
    }
    if missing.len() > SHOWN {
        text.push_str(&format!("\n  and {} more", missing.len() - SHOWN));
    }
    let numbers: Vec<u32> = missing.iter().map(|m| m.shard).collect();
    text.push_str(&format!(
        "\n  help: render them, with phalanx render --plan {} --shard I, or as tasks of an array: --array={}",
        path.display(),
        ranges(&numbers)
    ));
    text
}

/// 0, 1, 2, 5, 7, 8 as 0-2,5,7,8, as Slurm takes it.
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
