//! Names in OBJ and MTL files, which may hold blanks and `#`, and may be followed by a comment.

/// Most spellings of a name beside the whole text.
const MAX_CUTS: usize = 8;

/// The names that a text may stand for, the most likely first: all of it, and what comes before a
/// blank and a `#`, the last one first. A comment is cut off if the name with it is not known.
pub(super) fn spellings(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    std::iter::successors(Some(text), |name| before_comment(name)).take(1 + MAX_CUTS)
}

/// The spellings of a texture's name, and at last what comes before a blank and a `-`: some
/// programs write options behind the name.
pub(super) fn texture_spellings(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut marks = memchr::memchr_iter(b'-', text);
    let options = marks.find(|&offset| offset > 0 && text[offset - 1] <= b' ');
    spellings(text).chain(options.map(|offset| text[..offset].trim_ascii_end()))
}

/// A name without its last comment, if it has one.
fn before_comment(name: &[u8]) -> Option<&[u8]> {
    let mut marks = memchr::memrchr_iter(b'#', name);
    let comment = marks.find(|&offset| offset > 0 && name[offset - 1] <= b' ')?;
    Some(name[..comment].trim_ascii_end())
}

/// The shortest spelling: the text without its comments.
pub(super) fn without_comment(text: &[u8]) -> &[u8] {
    let mut marks = memchr::memchr_iter(b'#', text);
    let comment = marks.find(|&offset| offset == 0 || text[offset - 1] <= b' ');
    text[..comment.unwrap_or(text.len())].trim_ascii_end()
}

/// A name as text. A `\` and the line end behind it, which continue the line, become a blank.
pub(super) fn text_of(name: &[u8]) -> String {
    let text = String::from_utf8_lossy(name);
    if text.contains(['\n', '\r']) {
        text.replace("\\\r\n", " ")
            .replace(['\n', '\r'], "\n")
            .replace("\\\n", " ")
    } else {
        text.into_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(text: &str) -> Vec<&str> {
        let names = spellings(text.as_bytes());
        names
            .map(|name| std::str::from_utf8(name).unwrap())
            .collect()
    }

    #[test]
    fn a_comment_begins_behind_a_blank() {
        assert_eq!(all("red"), ["red"]);
        assert_eq!(all("a#1"), ["a#1"]);
        assert_eq!(all("red #1\t# e"), ["red #1\t# e", "red #1", "red"]);
        assert_eq!(all("#x"), ["#x"]);
        assert_eq!(all(&"a # ".repeat(100)).len(), 1 + MAX_CUTS);
        for (text, name) in [
            ("red # e # f", "red"),
            ("# e", ""),
            ("a#1", "a#1"),
            ("", ""),
        ] {
            assert_eq!(without_comment(text.as_bytes()), name.as_bytes());
        }
    }

    #[test]
    fn a_continued_name_is_one() {
        assert_eq!(text_of(b"a.mtl \\\r\nb.mtl"), "a.mtl  b.mtl");
        assert_eq!(text_of(b"a\\b.png"), "a\\b.png");
    }
}
