//! What a reader has to say about its file, in file order and never more than [`MAX_DIAGNOSTICS`] of a kind.

use super::Diagnostic;

/// Errors after which a reader stops; as many warnings are kept.
pub const MAX_DIAGNOSTICS: usize = 20;

/// Characters of the file that a message repeats: a line may be megabytes long.
const QUOTED_CHARS: usize = 40;

/// A span of the text, in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) offset: usize,
    pub(super) length: usize,
}

/// Collects diagnostics and finds the line and column of each.
pub(super) struct Report<'a> {
    text: &'a str,
    errors: Vec<Diagnostic>,
    warnings: Vec<Diagnostic>,
    /// Where the last line was counted to: errors come in file order, so the text is walked once for all of them.
    counted: Counted,
}

#[derive(Clone, Copy)]
struct Counted {
    offset: usize,
    line: usize,
}

const START: Counted = Counted { offset: 0, line: 1 };

impl<'a> Report<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Report {
            text,
            errors: Vec::new(),
            warnings: Vec::new(),
            counted: START,
        }
    }

    /// Adds an error, unless there are enough.
    pub(super) fn error(&mut self, place: Place, message: impl Into<String>) {
        self.push_error(place, message.into(), None);
    }

    /// Adds an error that says what to do about it.
    pub(super) fn error_with_help(
        &mut self,
        place: Place,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.push_error(place, message.into(), Some(help.into()));
    }

    fn push_error(&mut self, place: Place, message: String, help: Option<String>) {
        if !self.is_full() {
            let error = self.diagnostic(place, message, help);
            self.errors.push(error);
        }
    }

    /// Adds a remark that does not stop a render.
    pub(super) fn warning(&mut self, place: Place, message: impl Into<String>) {
        if self.warnings.len() < MAX_DIAGNOSTICS {
            let warning = self.diagnostic(place, message.into(), None);
            self.warnings.push(warning);
        }
    }

    /// Whether reading on is of no use.
    pub(super) fn is_full(&self) -> bool {
        self.errors.len() >= MAX_DIAGNOSTICS
    }

    /// Whether nothing is wrong so far.
    pub(super) fn is_clean(&self) -> bool {
        self.errors.is_empty()
    }

    /// The warnings in file order if nothing is wrong, else the errors.
    pub(super) fn finish(mut self) -> Result<Vec<Diagnostic>, Vec<Diagnostic>> {
        if !self.errors.is_empty() {
            return Err(self.errors);
        }
        self.warnings.sort_by_key(|warning| warning.offset);
        Ok(self.warnings)
    }

    /// The end of the last line that holds anything: where a reader looked for what it did not find.
    pub(super) fn end_of_content(&self) -> Place {
        Place {
            offset: self.text.trim_end().len(),
            length: 0,
        }
    }

    fn diagnostic(&mut self, place: Place, message: String, help: Option<String>) -> Diagnostic {
        let (line, column) = self.line_and_column(place.offset);
        Diagnostic {
            line,
            column,
            offset: place.offset,
            length: place.length,
            message,
            help,
        }
    }

    fn line_and_column(&mut self, offset: usize) -> (usize, usize) {
        let from = if self.counted.offset <= offset {
            self.counted
        } else {
            START
        };
        let breaks = self.text.as_bytes()[from.offset..offset].iter();
        let line = from.line + breaks.filter(|&&b| b == b'\n').count();
        self.counted = Counted { offset, line };
        let start = self.text[..offset].rfind('\n').map_or(0, |at| at + 1);
        // An editor does not show the byte order mark, so it is no column.
        let before = self.text[start..offset].trim_start_matches('\u{feff}');
        (line, before.chars().count() + 1)
    }
}

/// Text of the file as a message may repeat it: short, and without characters that would steer a terminal.
pub(super) fn quoted(text: &str) -> String {
    let mut out = String::from("`");
    for c in text.chars().take(QUOTED_CHARS) {
        if c.is_control() {
            out.extend(c.escape_default());
        } else {
            out.push(c);
        }
    }
    if text.chars().nth(QUOTED_CHARS).is_some() {
        out.push('…');
    }
    out.push('`');
    out
}
