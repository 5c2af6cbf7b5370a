//! Messages on stderr.

use super::verbosity::{Verbosity, verbosity};
use anstream::{AutoStream, ColorChoice};
use phalanx::files::{escaped, steers};
use std::borrow::Cow;
use std::io::{self, Write};

/// ANSI sequences of a label: bold, in a colour.
const RED: &str = "\u{1b}[1;31m";
const YELLOW: &str = "\u{1b}[1;33m";
const CYAN: &str = "\u{1b}[1;36m";
const RESET: &str = "\u{1b}[0m";

/// Writes the reason why a command failed.
pub fn error(text: &str) {
    labelled("error", RED, text);
}

/// Writes about a result that is probably not what the user intended.
pub fn warning(text: &str) {
    labelled("warning", YELLOW, text);
}

/// Writes a note; suppressed by `--quiet`.
pub fn note(text: &str) {
    if verbosity() != Verbosity::Quiet {
        labelled("note", CYAN, text);
    }
}

/// Writes a status line; suppressed by `--quiet`.
pub fn status(line: &str) {
    if verbosity() != Verbosity::Quiet {
        message(line);
    }
}

/// Writes a line to stderr. A closed stderr is not an error.
pub fn message(line: &str) {
    message_raw(&printable(line));
}

/// Writes a line that may contain control sequences to stderr, for drawings in colour.
pub fn message_raw(line: &str) {
    let _ = writeln!(io::stderr().lock(), "{line}");
}

fn labelled(label: &str, color: &str, text: &str) {
    message_raw(&format!("{} {}", colored(label, color), printable(text)));
}

/// A label and its colon, coloured if stderr supports it.
fn colored(label: &str, color: &str) -> String {
    if takes_color() {
        format!("{color}{label}:{RESET}")
    } else {
        format!("{label}:")
    }
}

/// The label of an error, as [`error`] writes it.
pub fn error_label() -> String {
    colored("error", RED)
}

/// Returns true if stderr gets colours, by the rules of <https://bixense.com/clicolors>: NO_COLOR,
/// CLICOLOR_FORCE, CLICOLOR, and then whether it is a terminal.
pub fn takes_color() -> bool {
    AutoStream::choice(&io::stderr()) != ColorChoice::Never
}

/// Text for people with control characters escaped, except line breaks and tabs: foreign text must
/// not control the terminal. All output for people goes through here. File names also go through
/// [`shown_path`](phalanx::files::shown_path), which keeps them on one line.
pub fn printable(text: &str) -> Cow<'_, str> {
    let steers = |c: char| steers(c) && !matches!(c, '\n' | '\t');
    if text.contains(steers) { escaped(text, steers).into() } else { text.into() }
}

/// Prints a note if this build does not use all instructions of this CPU.
pub fn advise() {
    if let Some(advice) = phalanx::isa::advice() {
        note(&advice.to_string());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_steers_terminals_is_shown_and_the_rest_kept() {
        let harmless = "a\tb\nä…▀";
        assert!(matches!(printable(harmless), Cow::Borrowed(text) if text == harmless));
        let steering = "\u{1b}[2J\r\u{7}\u{9b}\u{7f}é\n";
        let shown = "\\u{1b}[2J\\r\\u{7}\\u{9b}\\u{7f}é\n";
        assert_eq!(printable(steering), shown);
    }
}
