//! Words of ascii STL, with blanks and comments between them, and names, which have no terminator.

use crate::diagnostics::Span;
use crate::text::word_at;

/// Returns true if a word that begins like this begins a comment, which ends with its line.
#[inline]
fn is_comment(rest: &[u8]) -> bool {
    matches!(rest, [b'#' | b';', ..] | [b'/', b'/', ..])
}

/// A position in the text, between words.
#[derive(Clone, Copy)]
pub(super) struct StlLexer<'a> {
    pub(super) text: &'a [u8],
    pub(super) position: usize,
}

impl<'a> StlLexer<'a> {
    pub(super) fn new(text: &'a [u8], position: usize) -> StlLexer<'a> {
        StlLexer { text, position }
    }

    /// Moves to the next word, or to the end of the text.
    #[inline]
    pub(super) fn skip_blanks(&mut self) {
        loop {
            while self
                .text
                .get(self.position)
                .is_some_and(|&byte| byte <= b' ')
            {
                self.position += 1;
            }
            if !self.text.get(self.position..).is_some_and(is_comment) {
                return;
            }
            self.skip_line();
        }
    }

    fn skip_line(&mut self) {
        let rest = &self.text[self.position..];
        self.position += memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len());
    }

    /// Takes the next word; none at the end of the text.
    pub(super) fn word(&mut self) -> Option<Span> {
        self.skip_blanks();
        let word = word_at(self.text, self.position);
        self.position = word.end();
        (word.length > 0).then_some(word)
    }

    /// The next word, which stays the next.
    pub(super) fn peek(&self) -> Option<Span> {
        StlLexer { ..*self }.word()
    }

    /// Returns true if a word is this one, in any case.
    #[inline]
    pub(super) fn word_is(&self, word: Span, expected: &[u8]) -> bool {
        self.text[word.range()].eq_ignore_ascii_case(expected)
    }

    /// Takes the next word if it is this one.
    #[inline]
    pub(super) fn take(&mut self, expected: &[u8]) -> Option<Span> {
        let before = self.position;
        let word = self.word().filter(|&word| self.word_is(word, expected));
        if word.is_none() {
            self.position = before;
        }
        word
    }

    /// Takes `end` and a part, written as one word or as two.
    pub(super) fn take_end(&mut self, part: &[u8]) -> Option<Span> {
        let before = self.position;
        let word = self.word()?;
        let bytes = &self.text[word.range()];
        let (end, rest) = bytes.split_at_checked(3).unwrap_or_default();
        let matches = end.eq_ignore_ascii_case(b"end")
            && if rest.is_empty() {
                self.take(part).is_some()
            } else {
                rest.eq_ignore_ascii_case(part)
            };
        if !matches {
            self.position = before;
        }
        matches.then_some(word)
    }

    /// Takes the word that begins or ends a solid; a name may follow.
    pub(super) fn take_solid(&mut self) -> bool {
        self.take(b"solid").is_some() || self.take_end(b"solid").is_some()
    }

    /// Takes the name of a solid, which may hold blanks. It ends with its line, with a comment, or
    /// before a facet: some files are one line.
    pub(super) fn name(&mut self) -> Span {
        let start = self.position;
        loop {
            let is_end = |byte: &u8| matches!(byte, b'\n' | b'\r');
            let blank = |byte: &&u8| **byte <= b' ' && !is_end(byte);
            self.position += self.text[self.position..].iter().take_while(blank).count();
            let (rest, name) = (
                &self.text[self.position..],
                Span::between(start, self.position),
            );
            if rest.first().is_none_or(is_end) {
                return name;
            }
            if is_comment(rest) {
                self.skip_line();
                return name;
            }
            let mut next = *self;
            if next.take(b"facet").is_some()
                && (next.take(b"normal").is_some() || next.take(b"outer").is_some())
            {
                return name;
            }
            self.word();
        }
    }
}

/// Maximum number of bytes that are searched backward to determine whether a word is in a name or
/// in a comment.
const MAX_LINE: usize = 4096;

/// Returns true if the word at this position is in the name of a solid or in a comment.
pub(super) fn is_in_remark(bytes: &[u8], offset: usize) -> bool {
    let from = offset.saturating_sub(MAX_LINE);
    let end = memchr::memrchr2(b'\n', b'\r', &bytes[from..offset]);
    // The line up to the first letter of the word.
    let mut words = StlLexer::new(&bytes[..=offset], end.map_or(from, |end| from + end + 1));
    if words.take_solid() {
        words.name();
    }
    while let Some(word) = words.word() {
        if word.offset == offset {
            return false;
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_end_with_their_line_or_before_a_facet() {
        for (text, rest) in [
            (" a b\n facet", "\n facet"),
            (" a facet b\r\nx", "\r\nx"),
            ("\nfacet normal", "\nfacet normal"),
            (" a b Facet normal 0", "Facet normal 0"),
            (" a  facet outer", "facet outer"),
            (" a # facet normal\nx", "\nx"),
            (" #1 // ; facet outer", ""),
            ("", ""),
        ] {
            let mut words = StlLexer::new(text.as_bytes(), 0);
            words.name();
            assert_eq!(&text[words.position..], rest, "{text:?}");
        }
    }

    #[test]
    fn an_end_is_one_word_or_two() {
        for (text, is_end) in [
            ("endloop x", true),
            ("END\n Loop x", true),
            ("endfacet x", false),
            ("end facet x", false),
            ("loop x", false),
            ("\u{e9}\u{e9} x", false),
            ("", false),
        ] {
            let mut words = StlLexer::new(text.as_bytes(), 0);
            assert_eq!(words.take_end(b"loop").is_some(), is_end, "{text:?}");
            let position = words.position;
            assert_eq!(
                text[position..].trim_start(),
                if is_end { "x" } else { text }
            );
        }
    }

    #[test]
    fn remarks_are_names_and_comments() {
        for (text, remark) in [
            ("solid an endfacet", true),
            ("x\nend solid an endfacet", true),
            ("endsolid # endfacet", true),
            ("vertex 0 0 0 // endfacet", true),
            ("vertex 0 0 0 /endfacet", false),
            ("solid a facet normal 0 0 1 endfacet", false),
            ("# x\nendfacet", false),
            ("solid\r endfacet", false),
            ("endfacet", false),
        ] {
            let offset = text.find("endfacet").unwrap();
            let offset = if text.contains(" /e") { offset - 1 } else { offset };
            assert_eq!(is_in_remark(text.as_bytes(), offset), remark, "{text:?}");
        }
    }
}
