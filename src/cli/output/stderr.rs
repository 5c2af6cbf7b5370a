//! Messages on stderr.

use phalanx::scene::escaped;
use std::borrow::Cow;
use std::io::{self, Write};

/// Writes a line to stderr. A closed stderr is no error.
pub fn note(line: &str) {
    note_raw(&printable(line));
}

/// Writes a line that may contain control sequences to stderr, for drawings in colour.
pub fn note_raw(line: &str) {
    let _ = writeln!(io::stderr().lock(), "{line}");
}

/// A text for people, with all control characters escaped but those of lines and columns: foreign
/// text must not control the terminal. All output for people goes through here. A file name also
/// goes through [`shown_path`](phalanx::scene::shown_path), which keeps it on its line.
pub fn printable(text: &str) -> Cow<'_, str> {
    let steers = |c: char| c.is_control() && !matches!(c, '\n' | '\t');
    match text.contains(steers) {
        true => escaped(text, steers).into(),
        false => text.into(),
    }
}

/// Prints a line on stderr if this build leaves instructions of this CPU unused.
pub fn advise() {
    if let Some(advice) = phalanx::isa::advice() {
        note(&format!("note: {advice}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_steers_terminals_is_shown_and_the_rest_kept() {
        let kept = "a\tb\nä…▀";
        assert!(matches!(printable(kept), Cow::Borrowed(text) if text == kept));
        let steering = "\u{1b}[2J\r\u{7}\u{9b}\u{7f}é\n";
        let shown = "\\u{1b}[2J\\r\\u{7}\\u{9b}\\u{7f}é\n";
        assert_eq!(printable(steering), shown);
    }
}
