//! Output files: checks of their names and locations.

use super::ledger;
use super::stdout::{is_dash, reserve_stdout};
use crate::cli::output::error::CliError;
use phalanx::files::{Destination, check_writable, shown_path};
use std::ffi::OsStr;
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};

/// Refuses a name that does not end in `.png`; messages name the option by `origin`. Pipes and
/// devices may have any name.
fn check_png_name(path: &Path, origin: &str) -> Result<(), CliError> {
    let ending = path.extension().and_then(OsStr::to_str);
    if ending.is_some_and(|e| e.eq_ignore_ascii_case("png")) || is_stream(path) {
        return Ok(());
    }
    Err(CliError::Usage(format!(
        "{origin} {}: written as PNG, so the name must end in .png",
        shown_path(path)
    )))
}

/// Refuses a path that a PNG cannot be written to; messages name the option by `origin`.
pub fn check_png_place(path: &Path, origin: &'static str) -> Result<(), CliError> {
    check_png_name(path, origin)?;
    check_picture_place(path, Some(origin))
}

/// Refuses a path that cannot be written, before any work is done. With an `origin`, which names
/// the option in messages, it also refuses inputs and other outputs.
pub fn check_place(path: &Path, origin: Option<&'static str>) -> Result<(), CliError> {
    refuse_stdout(path, origin)?;
    place(path, origin).map(drop)
}

/// Refuses `-` where output to stdout is impossible, instead of creating a file of that name.
pub fn refuse_stdout(path: &Path, origin: Option<&'static str>) -> Result<(), CliError> {
    if is_dash(path) {
        Err(CliError::Usage(format!(
            "{} -: cannot be written to stdout: give a file name",
            origin.unwrap_or("the output")
        )))
    } else {
        Ok(())
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

/// Refuses folders, other kinds of files that cannot be written, and inputs. Cheap enough for every
/// frame.
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

/// As [`check_place`], and refuses terminals.
pub fn check_picture_place(path: &Path, origin: Option<&'static str>) -> Result<(), CliError> {
    let terminal = if is_dash(path) {
        reserve_stdout();
        io::stdout().is_terminal()
    } else {
        place(path, origin)?.is_terminal()
    };
    if terminal {
        Err(CliError::Usage(format!(
            "{}: a picture cannot be written to a terminal: give a file name, or redirect with > or |",
            shown_path(path)
        )))
    } else {
        Ok(())
    }
}

/// The absolute path, for processes with another working directory.
pub fn absolute_path(path: &Path) -> Result<PathBuf, CliError> {
    std::path::absolute(path).map_err(|e| CliError::not_located(path, e))
}

/// Returns true if output to this path replaces the file by a rename instead of writing into it.
pub fn is_replaced(path: &Path) -> bool {
    !is_dash(path) && !is_stream(path)
}

/// Returns true if the path is a stream, such as a pipe or a device.
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
