//! Files of shards, complete or not, and ranges of shard numbers.

use crate::cli::output::{self, CliError};
use phalanx::files::shown_path;
use phalanx::frame::Tile;
use phalanx::jobs::{KeptFileError, RenderKey, TileFile};
use std::io::ErrorKind;
use std::path::Path;

/// The file `name` of a shard; [`CliError::Missing`] if it does not exist, or is of another kind,
/// as `lacks` says.
pub fn open_shard<T>(
    file: Result<T, KeptFileError>,
    name: &Path,
    lacks: &str,
) -> Result<T, CliError> {
    let name = shown_path(name);
    file.map_err(|error| match error {
        KeptFileError::Io { source, .. } if source.kind() == ErrorKind::NotFound => {
            CliError::Missing(format!("{name} does not exist"))
        }
        KeptFileError::Other { .. } => CliError::Missing(format!("{name} {lacks}")),
        error => error.into(),
    })
}

/// The file `name` of a shard's tiles, of a picture with this key; [`CliError::Missing`] if it is
/// not complete.
pub fn complete_tiles(name: &Path, key: &RenderKey, share: &[Tile]) -> Result<TileFile, CliError> {
    output::reads("the tiles", name)?;
    let file = open_shard(TileFile::read(name, key), name, "is not a file of tiles")?;
    let lacks = share.iter().filter(|tile| !file.has(**tile)).count();
    let share = share.len();
    let reason = match (lacks, file.damaged()) {
        (0, _) => return Ok(file),
        (_, 0) => format!("{lacks} of {share} tiles are not rendered yet"),
        (_, damaged) => format!("{lacks} of {share} tiles are missing, {damaged} of them damaged"),
    };
    Err(CliError::Missing(reason))
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
