//! Output to stdout and stderr, and checks of the files that results go to.

use super::error::CliError;
use phalanx::image::{Destination, check_writable};
use serde::Serialize;
use std::borrow::Cow;
use std::ffi::OsStr;
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// The name that stands for stdin and stdout.
pub const DASH: &str = "-";

/// True if a file's bytes go to stdout: other text there would get mixed with them.
static STDOUT_TAKEN: AtomicBool = AtomicBool::new(false);

/// Writes results for people to stdout, or to stderr if stdout is one of the requested files. A
/// reader that has gone away (`phalanx info … | head -1`) is no error.
pub fn print(text: &str) -> Result<(), CliError> {
    print_raw(&printable(text))
}

/// Writes text that is not for people, or that may contain control sequences, to the place of
/// results.
pub fn print_raw(text: &str) -> Result<(), CliError> {
    if STDOUT_TAKEN.load(Ordering::Relaxed) {
        let _ = io::stderr().lock().write_all(text.as_bytes());
        return Ok(());
    }
    let mut stdout = io::stdout().lock();
    match stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush())
    {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(CliError::Runtime(format!(
            "cannot write to stdout: {error}"
        ))),
        _ => Ok(()),
    }
}

/// Writes one JSON document to the place of results.
pub fn print_json(document: &impl Serialize) -> Result<(), CliError> {
    let text = serde_json::to_string_pretty(document)
        .map_err(|e| CliError::Runtime(format!("cannot write JSON: {e}")))?;
    // The texts in it are escaped already, in JSON's own way.
    print_raw(&(text + "\n"))
}

/// Writes a line to stderr. A closed stderr is no error.
pub fn note(line: &str) {
    note_raw(&printable(line));
}

/// Writes a line that may contain control sequences to stderr, for drawings in colour.
pub fn note_raw(line: &str) {
    let _ = writeln!(io::stderr().lock(), "{line}");
}

/// A text for people, with control characters escaped: file names and other foreign text must not
/// control the terminal. All output for people goes through here, so that no message has to handle
/// it.
pub fn printable(text: &str) -> Cow<'_, str> {
    let steers = |c: char| c.is_control() && !matches!(c, '\n' | '\t');
    if !text.contains(steers) {
        return text.into();
    }
    let mut shown = String::with_capacity(text.len() + 8);
    for c in text.chars() {
        match steers(c) {
            true => shown.extend(c.escape_default()),
            false => shown.push(c),
        }
    }
    shown.into()
}

/// Refuses a picture's name that is not `*.png`; `origin` names the option in the message. Pipes
/// and devices may have any name.
pub fn check_png_name(path: &Path, origin: &str) -> Result<(), CliError> {
    let ending = path.extension().and_then(OsStr::to_str);
    if ending.is_some_and(|e| e.eq_ignore_ascii_case("png")) || is_stream(path) {
        return Ok(());
    }
    Err(CliError::Usage(format!(
        "{origin} {}: pictures are written as PNG, so the name must end in .png",
        path.display()
    )))
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
        .map_err(|e| cannot_write(path, &e))
}

fn cannot_write(path: &Path, error: &io::Error) -> CliError {
    CliError::Runtime(format!("cannot write {}: {error}", path.display()))
}

fn place(path: &Path) -> Result<Destination, CliError> {
    let place = check_writable(path).map_err(|e| cannot_write(path, &e))?;
    if place.is_stdout() {
        STDOUT_TAKEN.store(true, Ordering::Relaxed);
    }
    Ok(place)
}

/// Refuses a path that a picture cannot be written to, and a terminal, before any work is done.
pub fn check_picture_place(path: &Path) -> Result<(), CliError> {
    let terminal = match is_dash(path) {
        true => {
            STDOUT_TAKEN.store(true, Ordering::Relaxed);
            io::stdout().is_terminal()
        }
        false => place(path)?.is_terminal(),
    };
    match terminal {
        false => Ok(()),
        true => Err(CliError::Usage(format!(
            "{}: a picture means nothing to a terminal: name a file, or send it on with > or |",
            path.display()
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
                path.display()
            )));
        }
        seen.push((origin, place));
    }
    Ok(())
}

/// Returns true if a name stands for stdin, or for stdout.
pub fn is_dash(path: &Path) -> bool {
    path == Path::new(DASH)
}

/// Returns true if a file of this name is written anew and renamed, and not written into.
pub fn is_replaced(path: &Path) -> bool {
    !is_dash(path) && !is_stream(path)
}

/// Returns true if a name is that of a stream, which is written into.
pub fn is_stream(path: &Path) -> bool {
    matches!(
        Destination::of(path),
        Ok(Destination::Stream(_) | Destination::Open(_))
    )
}

/// 1234567 as 1,234,567.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Bytes in the unit that leaves one to four digits before the point.
pub fn bytes(number: u64) -> String {
    let mut amount = number as f64 / 1024.0;
    let mut unit = "KiB";
    for larger in ["MiB", "GiB"] {
        if amount >= 1024.0 {
            (amount, unit) = (amount / 1024.0, larger);
        }
    }
    format!("{amount:.1} {unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped_by_thousands() {
        let cases = [
            (0, "0"),
            (999, "999"),
            (1000, "1,000"),
            (1_234_567, "1,234,567"),
        ];
        for (number, text) in cases {
            assert_eq!(grouped(number), text);
        }
    }

    #[test]
    fn what_steers_terminals_is_shown_and_the_rest_kept() {
        let kept = "a\tb\nä…▀";
        assert!(matches!(printable(kept), Cow::Borrowed(text) if text == kept));
        let steering = "\u{1b}[2J\r\u{7}\u{9b}\u{7f}é\n";
        let shown = "\\u{1b}[2J\\r\\u{7}\\u{9b}\\u{7f}é\n";
        assert_eq!(printable(steering), shown);
    }

    #[test]
    fn bytes_get_a_fitting_unit() {
        let cases = [
            (512, "0.5 KiB"),
            (3 << 20, "3.0 MiB"),
            (5 << 40, "5120.0 GiB"),
        ];
        for (number, text) in cases {
            assert_eq!(bytes(number), text);
        }
    }

    #[test]
    fn only_png_names_pass() {
        assert!(check_png_name(Path::new("a/b.PNG"), "output").is_ok());
        for name in ["a.jpg", "png", "a", "a.png.gz", ""] {
            assert!(check_png_name(Path::new(name), "output").is_err(), "{name}");
        }
    }
}
