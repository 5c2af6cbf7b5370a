//! Bytes of a file to characters, words and numbers. Nothing here knows what they mean.
//!
//! | file | holds |
//! |---|---|
//! | `bytes` | a file to memory |
//! | `utf16` | text in UTF-16 to UTF-8 |
//! | `workers` | chunks of a file for several threads, and the columns that they make |
//! | `command` | the grammar of NFF and `.test` |
//! | `number` | words to numbers |
//! | `decimal` | numbers of mesh files, parsed where they stand |

pub(crate) mod bytes;
pub(crate) mod command;
pub(crate) mod decimal;
pub(crate) mod number;
pub(crate) mod utf16;
pub(crate) mod workers;

use crate::diagnostics::{Diagnostic, DiagnosticSink, Span};

/// Bytes at the beginning of a file in which a NUL shows that it is binary: headers end here, and
/// are padded.
pub(crate) const HEAD_BYTES: usize = 1024;

/// The text of a file that must be UTF-8.
pub(crate) fn utf8(bytes: &[u8]) -> Result<&str, Vec<Diagnostic>> {
    std::str::from_utf8(bytes).map_err(|error| not_text(bytes, error.valid_up_to()))
}

/// The length of the byte order mark that some editors put before text.
pub(crate) fn mark_length(bytes: &[u8]) -> usize {
    let mark = "\u{feff}".as_bytes();
    if bytes.starts_with(mark) { mark.len() } else { 0 }
}

/// Returns true if a word before this position ends there: at a blank, or at the end of the text.
#[inline]
pub(crate) fn ends_word(text: &[u8], offset: usize) -> bool {
    text.get(offset).is_none_or(|&byte| byte <= b' ')
}

/// The word at a position; empty at a blank or at the end of the text.
#[inline]
pub(crate) fn word_at(text: &[u8], offset: usize) -> Span {
    let rest = text.get(offset..).unwrap_or_default();
    let length = rest.iter().position(|&byte| byte <= b' ');
    Span::new(offset, length.unwrap_or(rest.len()))
}

/// Text for messages about a file that should be UTF-8.
pub(crate) fn lossy(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Text that may not be UTF-8, such as names in old encodings. Each byte that is not UTF-8 becomes
/// `?`, so that all offsets stay the same.
pub(crate) fn lossy_same_length(bytes: &[u8]) -> String {
    let mut out = String::with_capacity(bytes.len());
    for chunk in bytes.utf8_chunks() {
        out.push_str(chunk.valid());
        out.extend(chunk.invalid().iter().map(|_| '?'));
    }
    out
}

/// The error of a text file with a byte at `offset` that is not text.
fn not_text(bytes: &[u8], offset: usize) -> Vec<Diagnostic> {
    let mut report = DiagnosticSink::new(bytes);
    // The span is empty, because a byte of the file is another number of bytes in the text that is
    // shown.
    report.error_with_help(
        Span::at(offset),
        format!("byte 0x{:02X} is not UTF-8", bytes[offset]),
        "save the file as UTF-8 (or plain ASCII) text",
    );
    report.into_errors()
}
