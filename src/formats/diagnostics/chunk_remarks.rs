//! Remarks about a chunk of a file: errors, and warnings about many places, of which each kind is
//! given once.

use super::diagnostic_sink::{DiagnosticSink, MAX_DIAGNOSTICS, Span};

/// An error in a chunk of the file.
#[derive(Debug)]
pub(crate) struct ParseError {
    pub(crate) span: Span,
    pub(crate) message: String,
    help: Option<&'static str>,
}

impl ParseError {
    pub(crate) fn new(span: Span, message: impl Into<String>) -> ParseError {
        ParseError {
            span,
            message: message.into(),
            help: None,
        }
    }

    pub(crate) fn with_help(self, help: &'static str) -> ParseError {
        ParseError {
            help: Some(help),
            ..self
        }
    }
}

/// Number of places that share a warning, and the span of the first.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct WarningTally {
    pub(crate) count: usize,
    pub(crate) first: Option<Span>,
}

impl WarningTally {
    pub(crate) fn add(&mut self, span: Span) {
        self.count += 1;
        self.first.get_or_insert(span);
    }

    /// Adds the places of a later chunk.
    pub(crate) fn merge(&mut self, later: WarningTally) {
        self.count += later.count;
        self.first = self.first.or(later.first);
    }
}

/// Remarks about a chunk.
#[derive(Debug, Default)]
pub(crate) struct ChunkRemarks {
    errors: Vec<ParseError>,
    /// Warnings in the order of their first places: in the words for one place and for several.
    warnings: Vec<([&'static str; 2], WarningTally)>,
}

impl ChunkRemarks {
    /// Adds an error, unless there are as many as will be reported.
    pub(crate) fn error(&mut self, error: ParseError) {
        if !self.is_full() {
            self.errors.push(error);
        }
    }

    /// Counts a place of a warning: `one` for a single place, and `several` behind the number of
    /// more.
    pub(crate) fn warn(&mut self, span: Span, one: &'static str, several: &'static str) {
        self.tally_mut([one, several]).add(span);
    }

    /// The places of the warning with this text for one.
    pub(crate) fn tally(&self, one: &str) -> WarningTally {
        let warning = self.warnings.iter().find(|(words, _)| words[0] == one);
        warning.map_or(WarningTally::default(), |(_, tally)| *tally)
    }

    fn tally_mut(&mut self, words: [&'static str; 2]) -> &mut WarningTally {
        // The words of equal warnings mostly have the same address.
        let is_same = |one: &str| std::ptr::eq(one, words[0]) || one == words[0];
        let row = (self.warnings.iter()).position(|(words, _)| is_same(words[0]));
        let row = row.unwrap_or_else(|| {
            self.warnings.push((words, WarningTally::default()));
            self.warnings.len() - 1
        });
        &mut self.warnings[row].1
    }

    /// Returns true if there is no point in reading on.
    pub(crate) fn is_full(&self) -> bool {
        self.errors.len() >= MAX_DIAGNOSTICS
    }

    pub(crate) fn has_errors(&self) -> bool {
        !self.errors.is_empty()
    }

    /// Adds the remarks about a later chunk.
    pub(crate) fn merge(&mut self, later: ChunkRemarks) {
        self.errors.extend(later.errors);
        for (words, tally) in later.warnings {
            self.tally_mut(words).merge(tally);
        }
    }

    /// Reports all of them.
    pub(crate) fn emit(self, report: &mut DiagnosticSink) {
        for error in self.errors {
            match error.help {
                Some(help) => report.error_with_help(error.span, error.message, help),
                None => report.error(error.span, error.message),
            }
        }
        for ([one, several], tally) in self.warnings {
            if let Some(span) = tally.first {
                report.warning(span, counted(tally.count, one, several));
            }
        }
    }
}

/// `one`, or the count and `several`.
pub(crate) fn counted(count: usize, one: &str, several: &str) -> String {
    match count {
        1 => one.to_owned(),
        _ => format!("{count} {several}"),
    }
}
