//! Diagnostics of a reader about its file, in file order and never more than [`MAX_DIAGNOSTICS`] of
//! a kind.

use phalanx_files::{QUOTED_CHARS, quoted, quoted_up_to, steers};

/// Number of errors after which a reader stops; equally many warnings are kept.
pub const MAX_DIAGNOSTICS: usize = 20;

/// Characters of a file's name that a message repeats, more because their ends tell them apart.
const FILE_NAME_CHARS: usize = 300;

/// A span of the text, in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Span {
    pub(crate) offset: usize,
    pub(crate) length: usize,
}

impl Span {
    /// The beginning of a file: the span of an error that concerns all of it.
    pub(crate) const START: Span = Span::at(0);

    pub(crate) const fn new(offset: usize, length: usize) -> Span {
        Span { offset, length }
    }

    /// An empty span.
    pub(crate) const fn at(offset: usize) -> Span {
        Span::new(offset, 0)
    }

    /// The span of the bytes from `start` to before `end`.
    pub(crate) const fn between(start: usize, end: usize) -> Span {
        Span::new(start, end - start)
    }

    pub(crate) const fn end(self) -> usize {
        self.offset + self.length
    }

    /// The span as an index of the text.
    pub(crate) fn range(self) -> std::ops::Range<usize> {
        self.offset..self.end()
    }
}

/// One message about a span of a scene file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Line, from 1; 0 in a binary file, where only the offset gives the position.
    pub line: usize,
    /// Column in characters, from 1; a byte order mark counts as none. 0 in a binary file.
    pub column: usize,
    /// Byte offset of the span in the file, byte order mark included.
    pub offset: usize,
    /// Length of the span in bytes.
    pub length: usize,
    /// The error or remark.
    pub message: String,
    /// Advice on how to mend it, if there is any.
    pub help: Option<String>,
}

impl Diagnostic {
    /// An error of a file as a whole, which may be text or binary.
    pub fn of_file(is_text: bool, message: String, help: Option<&str>) -> Diagnostic {
        let line = usize::from(is_text);
        Diagnostic {
            line,
            column: line,
            offset: 0,
            length: 0,
            message,
            help: help.map(str::to_owned),
        }
    }
}

/// Collects diagnostics and finds the line and column of each.
pub(crate) struct DiagnosticSink<'a> {
    /// The file, if it is text with meaningful lines.
    text: Option<&'a [u8]>,
    errors: Vec<Diagnostic>,
    warnings: Vec<Diagnostic>,
    /// Names of textures that are left out for a reason, and the span of the first.
    left_out: Vec<(String, Span, Vec<String>)>,
    /// Position up to which lines have been counted. Errors come in file order, so the text is
    /// walked once for all of them.
    counted: LineCursor,
}

#[derive(Clone, Copy)]
struct LineCursor {
    offset: usize,
    line: usize,
}

const BYTE_ORDER_MARK: &[u8] = "\u{feff}".as_bytes();

const START: LineCursor = LineCursor { offset: 0, line: 1 };

impl<'a> DiagnosticSink<'a> {
    /// A sink for a text file: spans become lines and columns.
    pub(crate) fn new(text: &'a [u8]) -> Self {
        DiagnosticSink::with(Some(text))
    }

    /// A sink for a binary file: spans are byte offsets.
    pub(crate) fn binary() -> Self {
        DiagnosticSink::with(None)
    }

    fn with(text: Option<&'a [u8]>) -> Self {
        DiagnosticSink {
            text,
            errors: Vec::new(),
            warnings: Vec::new(),
            left_out: Vec::new(),
            counted: START,
        }
    }

    /// Adds an error, unless there are [`MAX_DIAGNOSTICS`] already.
    pub(crate) fn error(&mut self, span: Span, message: impl Into<String>) {
        self.push_error(span, message.into(), None);
    }

    /// Adds an error with advice on how to mend it.
    pub(crate) fn error_with_help(
        &mut self,
        span: Span,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.push_error(span, message.into(), Some(help.into()));
    }

    fn push_error(&mut self, span: Span, message: String, help: Option<String>) {
        if !self.is_full() {
            let error = self.diagnostic(span, message, help);
            self.errors.push(error);
        }
    }

    /// Adds a remark that does not stop a render.
    pub(crate) fn warning(&mut self, span: Span, message: impl Into<String>) {
        if self.warnings.len() < MAX_DIAGNOSTICS {
            let warning = self.diagnostic(span, message.into(), None);
            self.warnings.push(warning);
        }
    }

    /// Adds a remark that a texture is left out: one for all with this reason.
    pub(crate) fn texture_left_out(&mut self, span: Span, name: &str, reason: String) {
        let mut groups = self.left_out.iter_mut();
        match groups.find(|(other, ..)| *other == reason) {
            Some((.., names)) => names.push(name.to_owned()),
            None => self.left_out.push((reason, span, vec![name.to_owned()])),
        }
    }

    /// Returns true if the file is text.
    pub(crate) fn is_text(&self) -> bool {
        self.text.is_some()
    }

    /// Returns true if there is no point in reading on.
    pub(crate) fn is_full(&self) -> bool {
        self.errors.len() >= MAX_DIAGNOSTICS
    }

    /// Returns true if nothing is wrong so far.
    pub(crate) fn is_clean(&self) -> bool {
        self.errors.is_empty()
    }

    /// The warnings in file order if nothing is wrong, else the errors.
    pub(crate) fn finish(mut self) -> Result<Vec<Diagnostic>, Vec<Diagnostic>> {
        if !self.errors.is_empty() {
            return Err(in_order(self.errors));
        }
        for (reason, span, names) in std::mem::take(&mut self.left_out) {
            let message = match &names[..] {
                [name] => format!("the texture {name} is left out: {reason}"),
                names => {
                    let (shown, more) = names.split_at(names.len().min(MAX_DIAGNOSTICS));
                    let more = if more.is_empty() { "" } else { ", …" };
                    let (count, list) = (names.len(), shown.join(", "));
                    format!("{count} textures are left out: {reason}: {list}{more}")
                }
            };
            self.warning(span, message);
        }
        Ok(in_order(self.warnings))
    }

    /// The errors, of which there are some.
    pub(crate) fn into_errors(self) -> Vec<Diagnostic> {
        self.finish().err().unwrap_or_default()
    }

    /// The errors, with one more that ends the reading.
    pub(crate) fn refuse(mut self, span: Span, message: impl Into<String>) -> Vec<Diagnostic> {
        self.error(span, message);
        self.into_errors()
    }

    /// Reports the errors, or else the warnings, as those of another file, which is named at
    /// `span`.
    pub(crate) fn emit_for_file(self, name: &str, span: Span, report: &mut DiagnosticSink) {
        let name = without_control(name);
        let line = |d: &Diagnostic| format!("{name}:{}:{}: {}", d.line, d.column, d.message);
        match self.finish() {
            Ok(warnings) => warnings.iter().for_each(|w| report.warning(span, line(w))),
            Err(errors) => errors.iter().for_each(|e| report.error(span, line(e))),
        }
    }

    /// The end of the last line that is not blank: the span of an error about something missing.
    pub(crate) fn end_of_content(&self) -> Span {
        let text = self.text.unwrap_or_default();
        Span::at(text.trim_ascii_end().len())
    }

    fn diagnostic(&mut self, span: Span, message: String, help: Option<String>) -> Diagnostic {
        let (line, column) = self.line_and_column(span.offset);
        Diagnostic {
            line,
            column,
            offset: span.offset,
            length: span.length,
            message,
            help,
        }
    }

    fn line_and_column(&mut self, offset: usize) -> (usize, usize) {
        let Some(text) = self.text else {
            return (0, 0);
        };
        let offset = offset.min(text.len());
        let from = if self.counted.offset <= offset { self.counted } else { START };
        let breaks = text[from.offset..offset].iter();
        let line = from.line + breaks.filter(|&&b| b == b'\n').count();
        self.counted = LineCursor { offset, line };
        let start = text[..offset].iter().rposition(|&b| b == b'\n');
        let before = &text[start.map_or(0, |newline| newline + 1)..offset];
        // An editor does not show the byte order mark, so it does not count as a column.
        let before = before.strip_prefix(BYTE_ORDER_MARK).unwrap_or(before);
        let characters = before.iter().filter(|&b| b & 0xc0 != 0x80).count();
        (line, characters + 1)
    }
}

fn in_order(mut diagnostics: Vec<Diagnostic>) -> Vec<Diagnostic> {
    diagnostics.sort_by_key(|diagnostic| diagnostic.offset);
    diagnostics
}

/// A file's name for the beginning of a message, without characters that a terminal would obey.
fn without_control(name: &str) -> String {
    let shown = |c: char| if steers(c) { '?' } else { c };
    name.chars().map(shown).collect()
}

/// The name of a file, like [`quoted`] but whole unless it is very long.
pub(crate) fn quoted_file(name: &str) -> String {
    quoted_up_to(name, FILE_NAME_CHARS)
}

/// Like [`quoted`], for text that need not be UTF-8.
pub(crate) fn quoted_bytes(bytes: &[u8]) -> String {
    // Characters have at most four bytes.
    let shown = &bytes[..bytes.len().min(4 * QUOTED_CHARS + 4)];
    quoted(&String::from_utf8_lossy(shown))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_are_whole() {
        let name = "photogrammetry of the old town hall, seen from the market.jpg";
        assert_eq!(quoted_file(name), format!("`{name}`"));
        assert_eq!(quoted(name).chars().count(), QUOTED_CHARS + 3);
        let long = quoted_file(&"\u{1b}é".repeat(1000));
        assert!(long.contains("\\u{1b}é") && long.ends_with("…`"));
        assert!(long.len() < 10 * FILE_NAME_CHARS);
    }
}
