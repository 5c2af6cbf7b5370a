//! Scene errors and warnings on stderr.
//!
//! Each error is one line, `error: file:line:column: message`, that tools can read, followed by the
//! span in the source as rustc draws it. Warnings are one line each.

use super::stderr::{self, error_label, message_raw, takes_color};
use annotate_snippets::{AnnotationKind, Group, Renderer, Snippet, level};
use phalanx::files::{shown_path, steers};
use phalanx::formats::{Diagnostic, LoadError, endings};
use std::ops::Range;
use std::path::Path;

/// Prints the error of a scene file that could not be read.
pub fn print_error(error: &LoadError) {
    match error {
        LoadError::Io { .. } | LoadError::Memory { .. } | LoadError::Options { .. } => {
            stderr::error(&error.to_string());
        }
        LoadError::UnknownFormat { path } => {
            let formats: Vec<String> = endings().map(|e| format!(".{e}")).collect();
            let help = conversion(path).unwrap_or_default();
            stderr::error(&format!(
                "{error} (known: {}; --format overrides the extension){help}",
                formats.join(", ")
            ));
        }
        LoadError::Scene {
            path,
            text,
            diagnostics,
        } => message_raw(draw(path, text, diagnostics, renderer(), &error_label()).trim_end()),
    }
}

/// Extensions of scene formats that are not read, and how to convert such files to glTF.
const CONVERTERS: [(&str, &str); 4] = [
    (
        "3ds 3mf amf dae fbx ifc lwo off x x3d",
        "by assimp export IN OUT.glb, or in Blender",
    ),
    ("abc blend usd usda usdc usdz", "in Blender: File > Export"),
    ("brep iges igs step stp", "in FreeCAD: File > Export"),
    ("3dm c4d ma max mb skp wrl", "in the program that made it"),
];

/// Advice on converting a file to a format that is read, if it is a scene of another.
fn conversion(path: &Path) -> Option<String> {
    let ending = path.extension()?.to_ascii_lowercase();
    let is_one = |names: &str| names.split(' ').any(|name| ending == name);
    let (_, how) = CONVERTERS.iter().find(|(names, _)| is_one(names))?;
    Some(format!("\n  help: convert it to glTF {how}"))
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

/// Prints notes on defaults for what the file lacks.
pub fn print_notes(notes: &[String]) {
    for note in notes {
        stderr::note(&printable(note));
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

/// A renderer with colours if stderr supports them.
fn renderer() -> Renderer {
    if takes_color() { Renderer::styled() } else { Renderer::plain() }
}

/// Longest source line to show. A longer one was not written by hand, and may be the whole file.
const LONGEST_LINE: usize = 240;

fn draw(
    path: &Path,
    text: &str,
    diagnostics: &[Diagnostic],
    renderer: Renderer,
    label: &str,
) -> String {
    let mut out = String::new();
    for d in diagnostics {
        out.push_str(&format!("{label} {}\n", printable(&headline(path, d))));
        let help = d.help.as_deref().map(printable);
        let source = SourceLine::of(text, d);
        if source.is_some() || help.is_some() {
            let drawn = Group::with_level(level::ERROR)
                .elements(source.as_ref().map(SourceLine::snippet))
                .elements(help.map(|help| level::HELP.message(help)));
            out.push_str(&renderer.render(&[drawn]));
            out.push('\n');
        }
    }
    if diagnostics.len() > 1 {
        out.push_str(&format!("{} errors\n", diagnostics.len()));
    }
    out
}

/// A line of a scene file, and the span on it of a diagnostic.
struct SourceLine {
    line: String,
    /// Number of the line, from 1.
    number: usize,
    span: Range<usize>,
}

impl SourceLine {
    /// The line of a diagnostic; `None` for a binary file, or a line too long to show. The span is
    /// always within the line and on character boundaries, even if the diagnostic's numbers are
    /// not.
    fn of(text: &str, d: &Diagnostic) -> Option<SourceLine> {
        if d.line == 0 {
            return None;
        }
        let start = boundary(text, d.offset.min(text.len()), |position| position - 1);
        let first = text[..start].rfind('\n').map_or(0, |i| i + 1);
        let last = text[start..].find(['\r', '\n']);
        let last = last.map_or(text.len(), |i| start + i);
        let end = boundary(
            text,
            d.offset.saturating_add(d.length).min(last),
            |position| position + 1,
        );
        (last - first <= LONGEST_LINE).then(|| SourceLine {
            line: printable(&text[first..last]),
            number: d.line,
            span: start - first..end.max(start) - first,
        })
    }

    fn snippet(&self) -> Snippet<'_, annotate_snippets::Annotation<'_>> {
        let here = AnnotationKind::Primary.span(self.span.clone());
        Snippet::source(&self.line)
            .line_start(self.number)
            .annotation(here.label("here"))
    }
}

/// The nearest character boundary in the direction of `step`; both ends of the text are boundaries.
fn boundary(text: &str, mut position: usize, step: impl Fn(usize) -> usize) -> usize {
    while !text.is_char_boundary(position) {
        position = step(position);
    }
    position
}

/// The text with terminal control characters replaced; its length in bytes does not change.
fn printable(text: &str) -> String {
    let show = |c: char| match c {
        '\n' | '\r' | '\t' => (c, 1),
        c if steers(c) => ('?', c.len_utf8()),
        c => (c, 1),
    };
    let shown = text.chars().map(show);
    shown.flat_map(|(c, n)| std::iter::repeat_n(c, n)).collect()
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
            Renderer::plain(),
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
        assert!(!out.contains('\u{1b}'), "{out:?}");
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
