//! The files that results go to: checks of their names and places.

use super::error::CliError;
use super::stdout::reserve_stdout;
use phalanx::image::{Destination, check_writable};
use phalanx::scene::shown_path;
use std::ffi::OsStr;
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};

/// Refuses a picture's name that is not `*.png`; `origin` names the option in the message. Pipes
/// and devices may have any name.
fn check_png_name(path: &Path, origin: &str) -> Result<(), CliError> {
    let ending = path.extension().and_then(OsStr::to_str);
    if ending.is_some_and(|e| e.eq_ignore_ascii_case("png")) || is_stream(path) {
        return Ok(());
    }
    Err(CliError::Usage(format!(
        "{origin} {}: pictures are written as PNG, so the name must end in .png",
        shown_path(path)
    )))
}

/// Refuses a path that a PNG cannot be written to; `origin` names the option in the message.
pub fn check_png_place(path: &Path, origin: &str) -> Result<(), CliError> {
    check_png_name(path, origin)?;
    check_picture_place(path)
}

/// Refuses a path that cannot be written, before any work is done.
pub fn check_place(path: &Path) -> Result<(), CliError> {
    place(path).map(drop)
}

/// Refuses a folder, and any other kind of file that cannot be written. It is quick enough to be
/// called for every frame.
pub fn check_kind(path: &Path) -> Result<(), CliError> {
    Destination::of(path)
        .map(drop)
        .map_err(|e| CliError::cannot_write(path, e))
}

fn place(path: &Path) -> Result<Destination, CliError> {
    let place = check_writable(path).map_err(|e| CliError::cannot_write(path, e))?;
    if place.is_stdout() {
        reserve_stdout();
    }
    Ok(place)
}

/// Refuses a path that a picture cannot be written to, and a terminal, before any work is done.
pub fn check_picture_place(path: &Path) -> Result<(), CliError> {
    let terminal = match is_dash(path) {
        true => {
            reserve_stdout();
            io::stdout().is_terminal()
        }
        false => place(path)?.is_terminal(),
    };
    match terminal {
        false => Ok(()),
        true => Err(CliError::Usage(format!(
            "{}: a picture means nothing to a terminal: name a file, or send it on with > or |",
            shown_path(path)
        ))),
    }
}

/// Refuses two results in one file, of which the later would replace the earlier. Each path comes
/// with the option that names it.
pub fn check_distinct(places: &[(&str, Option<&Path>)]) -> Result<(), CliError> {
    let mut seen: Vec<(&str, Destination)> = Vec::new();
    for (origin, path) in places {
        let Some(path) = path.filter(|path| !is_dash(path)) else {
            continue;
        };
        let Ok(place @ Destination::File(_)) = Destination::of(path) else {
            continue;
        };
        if let Some((first, _)) = seen.iter().find(|(_, other)| *other == place) {
            return Err(CliError::Usage(format!(
                "{first} and {origin} are the same file, {}: name another one",
                shown_path(path)
            )));
        }
        seen.push((origin, place));
    }
    Ok(())
}

/// The path from the root, for processes that run elsewhere.
pub fn absolute_path(path: &Path) -> Result<PathBuf, CliError> {
    std::path::absolute(path).map_err(|e| CliError::not_located(path, e))
}

/// Returns true if a name stands for stdin, or for stdout.
pub fn is_dash(path: &Path) -> bool {
    path == Path::new("-")
}

/// Returns true if a file of this name is written anew and renamed, and not written into.
pub fn is_replaced(path: &Path) -> bool {
    !is_dash(path) && !is_stream(path)
}

/// Returns true if a name is that of a stream, which is written into.
fn is_stream(path: &Path) -> bool {
    matches!(
        Destination::of(path),
        Ok(Destination::Stream(_) | Destination::Open(_))
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_png_names_pass() {
        assert!(check_png_name(Path::new("a/b.PNG"), "output").is_ok());
        for name in ["a.jpg", "png", "a", "a.png.gz", ""] {
            assert!(check_png_name(Path::new(name), "output").is_err(), "{name}");
        }
    }
}
