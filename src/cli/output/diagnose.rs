//! Scene errors and warnings on stderr.
//!
//! Each error is one line, `error: file:line:column: message`, that tools can read, followed by the
//! span in the source as miette draws it. Warnings are one line each.

use super::stderr::{self, error_label, message_raw, takes_color};
use miette::{
    Diagnostic as Drawable, GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteError,
    MietteSpanContents, Severity, SourceCode, SourceSpan, SpanContents,
};
use phalanx::formats::{Diagnostic, LoadError, endings};
use phalanx::scene::{shown_path, steers};
use std::fmt;
use std::io::IsTerminal;
use std::path::Path;

/// Prints the reason why a file gave no scene.
pub fn print_error(error: &LoadError) {
    match error {
        LoadError::Io { .. } | LoadError::Memory { .. } => stderr::error(&error.to_string()),
        LoadError::UnknownFormat { .. } => {
            let known: Vec<String> = endings().map(|e| format!(".{e}")).collect();
            stderr::error(&format!(
                "{error} (known: {}; --format chooses one)",
                known.join(", ")
            ));
        }
        LoadError::Scene {
            path,
            text,
            diagnostics,
        } => message_raw(draw(path, text, diagnostics, theme(), &error_label()).trim_end()),
    }
}

/// Prints the warnings of a reader.
pub fn print_warnings(path: &Path, warnings: &[Diagnostic]) {
    for warning in warnings {
        let help = warning.help.as_deref();
        let help = help.map_or(String::new(), |h| format!(" ({h})"));
        let line = format!("{}{help}", headline(path, warning));
        stderr::warning(&printable(&line));
    }
}

/// Prints notes on what was added because the file has none.
pub fn print_notes(notes: &[String]) {
    for made_up in notes {
        stderr::note(&printable(made_up));
    }
}

/// The line of a diagnostic. In a binary file its position is a byte offset.
fn headline(path: &Path, d: &Diagnostic) -> String {
    let (path, message) = (shown_path(path), &d.message);
    match d.line {
        0 => format!("{path}: byte {}: {message}", d.offset),
        line => format!("{path}:{line}:{}: {message}", d.column),
    }
}

/// Lines only on a terminal, and colours where stderr takes them.
fn theme() -> GraphicalTheme {
    match (std::io::stderr().is_terminal(), takes_color()) {
        (_, true) => GraphicalTheme::unicode(),
        (true, false) => GraphicalTheme::unicode_nocolor(),
        (false, false) => GraphicalTheme::none(),
    }
}

/// Longest line of source that is shown. A longer one was not written by hand, and may be the whole
/// file.
const LONGEST_LINE: usize = 240;

fn draw(
    path: &Path,
    text: &str,
    diagnostics: &[Diagnostic],
    theme: GraphicalTheme,
    label: &str,
) -> String {
    // Unwrapped, so that `file:line:column` stays in one piece.
    let handler = GraphicalReportHandler::new_themed(theme)
        .with_wrap_lines(false)
        .with_links(false);
    let mut out = String::new();
    for d in diagnostics {
        out.push_str(&format!("{label} {}\n", printable(&headline(path, d))));
        let problem = DrawnDiagnostic {
            place: SourceLine::of(path, text, d),
            help: d.help.as_deref().map(printable),
        };
        let mut drawn = String::new();
        // A span that cannot be drawn has been named on the line above.
        if handler.render_report(&mut drawn, &problem).is_ok() {
            let title = |l: &&str| l.trim().is_empty() || l.contains(TITLE);
            let body = drawn.lines().skip_while(title);
            body.for_each(|line| out.extend([line, "\n"]));
        }
    }
    if diagnostics.len() > 1 {
        out.push_str(&format!("{} errors\n", diagnostics.len()));
    }
    out
}

/// A line of a scene file, and the span on it of a diagnostic.
#[derive(Debug)]
struct SourceLine {
    name: String,
    line: String,
    /// Byte offset of the line in the file.
    offset: usize,
    /// Line and column, from 0.
    at: (usize, usize),
    span: (usize, usize),
}

impl SourceLine {
    /// The line of a diagnostic; `None` for a binary file, and for a line too long to show.
    /// Whatever the diagnostic's numbers are, the span is within the line, and on character
    /// boundaries.
    fn of(path: &Path, text: &str, d: &Diagnostic) -> Option<SourceLine> {
        if d.line == 0 {
            return None;
        }
        let start = boundary(text, d.offset.min(text.len()), |at| at - 1);
        let first = text[..start].rfind('\n').map_or(0, |i| i + 1);
        let last = text[start..].find(['\r', '\n']);
        let last = last.map_or(text.len(), |i| start + i);
        let end = boundary(text, d.offset.saturating_add(d.length).min(last), |at| {
            at + 1
        });
        (last - first <= LONGEST_LINE).then(|| SourceLine {
            name: shown_path(path),
            line: printable(&text[first..last]),
            offset: first,
            at: (d.line.saturating_sub(1), d.column.saturating_sub(1)),
            span: (start, end.saturating_sub(start)),
        })
    }
}

impl SourceCode for SourceLine {
    /// miette calls this twice: without context, for the line and column in its heading, and with
    /// context, for the text it shows.
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        lines_before: usize,
        _lines_after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let column = if lines_before == 0 { self.at.1 } else { 0 };
        let (shown, span) = match lines_before {
            0 => (&[][..], *span),
            _ => (self.line.as_bytes(), (self.offset, self.line.len()).into()),
        };
        let name = self.name.clone();
        let contents = MietteSpanContents::new_named(name, shown, span, self.at.0, column, 1);
        Ok(Box::new(contents))
    }
}

/// The nearest character boundary in the direction of `step`; both ends of the text are boundaries.
fn boundary(text: &str, mut at: usize, step: impl Fn(usize) -> usize) -> usize {
    while !text.is_char_boundary(at) {
        at = step(at);
    }
    at
}

/// The text with characters that steer the terminal made visible, byte for byte as long as before.
fn printable(text: &str) -> String {
    let show = |c: char| match c {
        '\n' | '\r' | '\t' => (c, 1),
        c if steers(c) => ('?', c.len_utf8()),
        c => (c, 1),
    };
    let shown = text.chars().map(show);
    shown.flat_map(|(c, n)| std::iter::repeat_n(c, n)).collect()
}

/// Marks the title of a drawn report, to distinguish it from the rest.
const TITLE: &str = "\u{2060}";

/// One diagnostic as miette draws it.
#[derive(Debug)]
struct DrawnDiagnostic {
    place: Option<SourceLine>,
    help: Option<String>,
}

impl fmt::Display for DrawnDiagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(TITLE)
    }
}

impl std::error::Error for DrawnDiagnostic {}

impl Drawable for DrawnDiagnostic {
    fn severity(&self) -> Option<Severity> {
        Some(Severity::Error)
    }

    fn help<'b>(&'b self) -> Option<Box<dyn fmt::Display + 'b>> {
        let help = self.help.as_ref()?;
        Some(Box::new(help))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.place.as_ref().map(|place| place as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let (start, length) = self.place.as_ref()?.span;
        let label = LabeledSpan::new(Some("here".to_owned()), start, length);
        Some(Box::new(std::iter::once(label)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn diagnostic(line: usize, column: usize, offset: usize, length: usize) -> Diagnostic {
        Diagnostic {
            line,
            column,
            offset,
            length,
            message: "unknown command `spere`".to_owned(),
            help: Some("did you mean `sphere`?".to_owned()),
        }
    }

    fn drawn(text: &str, diagnostics: &[Diagnostic]) -> String {
        draw(
            Path::new("a/b.test"),
            text,
            diagnostics,
            GraphicalTheme::none(),
            "error:",
        )
    }

    #[test]
    fn place_source_and_help_are_shown_without_colour() {
        let text = "size 4 4\nspere 0 0 0 1\ncamera\n";
        let out = drawn(text, &[diagnostic(2, 1, 9, 5), diagnostic(3, 1, 23, 6)]);
        for part in [
            "error: a/b.test:2:1: unknown command `spere`\n",
            "error: a/b.test:3:1:",
            "spere 0 0 0 1",
            "did you mean `sphere`?",
            "2 errors",
        ] {
            assert!(out.contains(part), "{part:?} in\n{out}");
        }
        assert!(!out.contains('\u{1b}') && !out.contains(TITLE), "{out:?}");
    }

    #[test]
    fn control_characters_do_not_reach_the_terminal() {
        let mut bad = diagnostic(1, 1, 0, 4);
        bad.message = "unknown \u{1b}[2J and \u{9b}".to_owned();
        let out = drawn("\u{1b}[2J\u{9b}x\n", &[bad]);
        assert!(!out.contains(['\u{1b}', '\u{9b}']), "{out:?}");
        assert!(out.contains("?[2J"));
    }

    #[test]
    fn a_line_too_long_to_show_is_only_named() {
        let text = "x".repeat(1_000_000);
        let out = drawn(&text, &[diagnostic(1, 500_000, 499_999, 3)]);
        assert!(out.contains("error: a/b.test:1:500000: "), "{out:.300}");
        assert!(out.len() < 1000, "{}", out.len());
    }

    #[test]
    fn places_outside_the_text_or_inside_a_character_do_no_harm() {
        let text = "é size\nü";
        for offset in 0..text.len() + 3 {
            for length in [0, 1, 2, 100, usize::MAX] {
                let out = drawn(text, &[diagnostic(1, 1, offset, length)]);
                assert!(
                    out.contains("error: a/b.test:1:1: "),
                    "{offset} {length}: {out}"
                );
            }
        }
        assert!(drawn("", &[diagnostic(1, 1, 0, 1)]).contains("a/b.test:1:1"));
    }
}
