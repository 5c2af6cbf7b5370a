//! Files of shards, complete or not, and ranges of shard numbers.

use crate::cli::output::{self, CliError};
use phalanx::files::shown_path;
use phalanx::frame::Tile;
use phalanx::jobs::{KeptFileError, RenderKey, TileFile};
use std::io::ErrorKind;
use std::path::Path;

/// A shard's file, or the reason why it cannot be merged yet: it does not exist, or is of another
/// kind, which `lacks` says.
pub fn found<T>(
    file: Result<T, KeptFileError>,
    name: &Path,
    lacks: &str,
) -> Result<Result<T, String>, CliError> {
    let name = shown_path(name);
    match file {
        Ok(file) => Ok(Ok(file)),
        Err(KeptFileError::Io { source, .. }) if source.kind() == ErrorKind::NotFound => {
            Ok(Err(format!("{name} does not exist")))
        }
        Err(KeptFileError::Other { .. }) => Ok(Err(format!("{name} {lacks}"))),
        Err(error) => Err(error.into()),
    }
}

/// The file `name` of a shard's tiles, of a picture with this key, or the reason why it cannot be
/// merged yet.
pub fn whole(
    name: &Path,
    key: &RenderKey,
    share: &[Tile],
) -> Result<Result<TileFile, String>, CliError> {
    output::reads("the tiles", name)?;
    let file = match found(TileFile::read(name, key), name, "is not a file of tiles")? {
        Ok(file) => file,
        Err(why) => return Ok(Err(why)),
    };
    let lacks = share.iter().filter(|tile| !file.has(**tile)).count();
    let share = share.len();
    Ok(match (lacks, file.damaged()) {
        (0, _) => Ok(file),
        (_, 0) => Err(format!("{lacks} of {share} tiles are not rendered yet")),
        (_, damaged) => Err(format!(
            "{lacks} of {share} tiles are missing, {damaged} of them damaged"
        )),
    })
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
