//! Output of the writers: buffered, and silent after the first error.

use super::outcome::SceneWriteError;
use std::fmt;
use std::io::{BufWriter, Write};

/// Bytes that are buffered before they are written.
const BUFFER: usize = 1 << 16;

/// A buffered output that keeps its first error for the end.
pub(super) struct LatchedWriter<W: Write> {
    to: BufWriter<W>,
    error: Option<SceneWriteError>,
}

impl<W: Write> LatchedWriter<W> {
    pub(super) fn new(to: W) -> Self {
        LatchedWriter {
            to: BufWriter::with_capacity(BUFFER, to),
            error: None,
        }
    }

    pub(super) fn bytes(&mut self, bytes: &[u8]) {
        if self.error.is_none() {
            let written = self.to.write_all(bytes);
            self.error = written.err().map(SceneWriteError::Io);
        }
    }

    /// Writes text, for `write!` and `writeln!`.
    pub(super) fn write_fmt(&mut self, text: fmt::Arguments<'_>) {
        if self.error.is_none() {
            let written = self.to.write_fmt(text);
            self.error = written.err().map(SceneWriteError::Io);
        }
    }

    /// Stops all further writing because of an error.
    pub(super) fn fail(&mut self, error: SceneWriteError) {
        self.error.get_or_insert(error);
    }

    /// Stops all further writing because `format` has no such shapes.
    pub(super) fn cannot_hold(&mut self, format: &'static str, shape: &'static str) {
        self.fail(SceneWriteError::CannotHold { format, shape });
    }

    pub(super) fn failed(&self) -> bool {
        self.error.is_some()
    }

    /// Writes the rest of the buffer; returns the first error.
    pub(super) fn finish(mut self) -> Result<(), SceneWriteError> {
        match self.error {
            Some(error) => Err(error),
            None => Ok(self.to.flush()?),
        }
    }
}
