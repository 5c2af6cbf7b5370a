//! Text in UTF-16, as some editors and shells save it, made UTF-8 for all readers.

use super::HEAD_BYTES;
use crate::diagnostics::{Diagnostic, DiagnosticSink, Span};
use crate::memory::MemoryLedger;

/// The text of a file that a byte order mark declares to be UTF-16, without the mark, as UTF-8.
/// `None` for all other files, binary ones that begin alike included.
///
/// # Errors
/// One error: at the first invalid character, or because there is not enough memory.
pub(crate) fn to_utf8(
    bytes: &[u8],
    memory: &MemoryLedger,
) -> Result<Option<Vec<u8>>, Vec<Diagnostic>> {
    let (unit, rest): (fn([u8; 2]) -> u16, _) = match bytes {
        [0xff, 0xfe, rest @ ..] => (u16::from_le_bytes, rest),
        [0xfe, 0xff, rest @ ..] => (u16::from_be_bytes, rest),
        _ => return Ok(None),
    };
    let (pairs, odd) = rest.as_chunks::<2>();
    let units = || pairs.iter().map(|&pair| unit(pair));
    // All text formats begin with plain characters, and none has a NUL.
    let plain = units().next().is_some_and(|first| first < 0x80);
    if !plain || units().take(HEAD_BYTES / 2).any(|unit| unit == 0) {
        return Ok(None);
    }
    let mut offset = 2;
    let mut length = 0;
    for character in char::decode_utf16(units()) {
        let Ok(character) = character else {
            return Err(broken(offset));
        };
        offset += 2 * character.len_utf16();
        length += character.len_utf8();
    }
    if !odd.is_empty() {
        return Err(broken(offset));
    }
    memory.take(length as u64, "for the file's text in UTF-8")?;
    let mut text = String::with_capacity(length);
    text.extend(char::decode_utf16(units()).flatten());
    Ok(Some(text.into_bytes()))
}

/// The error of a byte that is not part of a character.
fn broken(offset: usize) -> Vec<Diagnostic> {
    let mut report = DiagnosticSink::binary();
    report.error_with_help(
        Span::at(offset),
        "the file is marked as text in UTF-16, and no character begins here",
        "save the file as UTF-8 (or plain ASCII) text",
    );
    report.into_errors()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8], most: Option<u64>) -> Result<Option<Vec<u8>>, (usize, String)> {
        to_utf8(bytes, &MemoryLedger::of(most)).map_err(|all| {
            assert_eq!(all.len(), 1);
            (all[0].offset, all[0].message.clone())
        })
    }

    fn encoded(text: &str, bytes: fn(u16) -> [u8; 2]) -> Vec<u8> {
        let marked = format!("\u{feff}{text}");
        marked.encode_utf16().flat_map(bytes).collect()
    }

    #[test]
    fn both_orders_become_utf8() {
        let text = "# ü 模型 🦀\nv 0 0 0\n";
        for order in [u16::to_le_bytes, u16::to_be_bytes] {
            let utf16 = encoded(text, order);
            let most = Some(text.len() as u64);
            assert_eq!(read(&utf16, most), Ok(Some(text.as_bytes().to_vec())));
            assert!(read(&utf16, Some(text.len() as u64 - 1)).is_err());
        }
    }

    #[test]
    fn other_files_are_left_as_they_are() {
        for bytes in [
            &b""[..],
            b"v 0 0 0",
            b"\xff\xfe",
            b"\xfe\xffv",
            b"\xff\xfe\0\0v\0",
            b"\xff\xfea\0\0\0\0\0",
            b"\xff\xfe\xd8\xff",
        ] {
            assert_eq!(read(bytes, None), Ok(None), "{bytes:?}");
        }
    }

    #[test]
    fn broken_characters_are_errors() {
        let lone = encoded("v 1", u16::to_le_bytes);
        assert_eq!(
            read(&[&lone[..], b"\x3d\xd8v\0"].concat(), None)
                .unwrap_err()
                .0,
            8
        );
        assert_eq!(read(&[&lone[..], b"\n"].concat(), None).unwrap_err().0, 8);
    }
}
