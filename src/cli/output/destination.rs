//! The files that results go to: checks of their names and places.

use super::error::CliError;
use super::ledger;
use super::stdout::{is_dash, reserve_stdout};
use phalanx::files::{Destination, check_writable};
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
pub fn check_png_place(path: &Path, origin: &'static str) -> Result<(), CliError> {
    check_png_name(path, origin)?;
    check_picture_place(path, Some(origin))
}

/// Refuses a path that cannot be written, before any work is done. If it is that of a file itself,
/// `origin` names its option in messages, and inputs and other results are refused, too.
pub fn check_place(path: &Path, origin: Option<&'static str>) -> Result<(), CliError> {
    refuse_stdout(path, origin)?;
    place(path, origin).map(drop)
}

/// Refuses `-` where a file of that name must not be made, and stdout cannot be written.
pub fn refuse_stdout(path: &Path, origin: Option<&'static str>) -> Result<(), CliError> {
    match is_dash(path) {
        true => Err(CliError::Usage(format!(
            "{} -: this cannot go to stdout, name a file",
            origin.unwrap_or("the output")
        ))),
        false => Ok(()),
    }
}

/// As [`check_place`], for a report, which may go to stdout.
pub fn check_report_place(path: &Path, origin: &'static str) -> Result<(), CliError> {
    if !is_dash(path) {
        return check_place(path, Some(origin));
    }
    reserve_stdout();
    ledger::writes(origin, path)
}

/// Refuses a folder, and any other kind of file that cannot be written or is an input. It is quick
/// enough to be called for every frame.
pub fn check_kind(path: &Path, origin: &'static str) -> Result<(), CliError> {
    Destination::of(path).map_err(|e| CliError::cannot_write(path, e))?;
    ledger::writes(origin, path)
}

fn place(path: &Path, origin: Option<&'static str>) -> Result<Destination, CliError> {
    origin.map_or(Ok(()), |origin| ledger::writes(origin, path))?;
    let place = check_writable(path).map_err(|e| CliError::cannot_write(path, e))?;
    if place.is_stdout() {
        reserve_stdout();
    }
    Ok(place)
}

/// As [`check_place`], and refuses a terminal.
pub fn check_picture_place(path: &Path, origin: Option<&'static str>) -> Result<(), CliError> {
    let terminal = match is_dash(path) {
        true => {
            reserve_stdout();
            io::stdout().is_terminal()
        }
        false => place(path, origin)?.is_terminal(),
    };
    match terminal {
        false => Ok(()),
        true => Err(CliError::Usage(format!(
            "{}: a picture means nothing to a terminal: name a file, or send it on with > or |",
            shown_path(path)
        ))),
    }
}

/// The path from the root, for processes that run elsewhere.
pub fn absolute_path(path: &Path) -> Result<PathBuf, CliError> {
    std::path::absolute(path).map_err(|e| CliError::not_located(path, e))
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
