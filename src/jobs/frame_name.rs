//! Names of a sequence's files.

use std::ffi::OsString;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Minimum number of digits of a frame's number in a name that does not specify it.
const MIN_DIGITS: usize = 4;

/// Maximum number of digits that a name may request.
const MAX_DIGITS: usize = 20;

/// A file name with the number of a frame in it, for a sequence that ends with frame `last`:
/// instead of the last run of `#`, with as many digits; or of `%d` or `%04d`, as in C's printf; or
/// else before the ending, with as many digits as the last frame has, at least four.
pub fn frame_name(path: &Path, last: u32, frame: u32) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    if let Some((place, digits)) = number_place(&name) {
        let (before, after) = (&name[..place.start], &name[place.end..]);
        return path.with_file_name(format!("{before}{frame:0digits$}{after}"));
    }
    let mut stem = OsString::from(path.file_stem().unwrap_or_default());
    stem.push(format!(".{}", frame_digits(last, frame)));
    if let Some(ending) = path.extension() {
        stem.push(".");
        stem.push(ending);
    }
    path.with_file_name(stem)
}

/// The bytes of a name that are replaced by a number, and its digits.
fn number_place(name: &str) -> Option<(Range<usize>, usize)> {
    if let Some(last) = name.rfind('#') {
        let first = name[..last].trim_end_matches('#').len();
        return Some((first..last + 1, last + 1 - first));
    }
    let first = name.rfind('%')?;
    let (width, _) = name[first + 1..].split_once('d')?;
    let digits = match width {
        "" => 1,
        width => width.parse().ok().filter(|digits| *digits <= MAX_DIGITS)?,
    };
    Some((first..first + width.len() + 2, digits))
}

/// The number of a frame with as many digits as the last frame has, four at least.
pub(super) fn frame_digits(last: u32, frame: u32) -> String {
    let digits = last.to_string().len().max(MIN_DIGITS);
    format!("{frame:0digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_the_number_where_it_is_asked_for() {
        let name = |path: &str, frame| frame_name(Path::new(path), 119, frame);
        assert_eq!(name("a/b.png", 7), Path::new("a/b.0007.png"));
        assert_eq!(name("a/b.c.exr", 119), Path::new("a/b.c.0119.exr"));
        assert_eq!(name("a/b-##.png", 7), Path::new("a/b-07.png"));
        assert_eq!(name("a/###x.png", 1234), Path::new("a/1234x.png"));
        for (pattern, named) in [
            ("out%04d.png", "out0007.png"),
            ("a%b%d.png", "a%b7.png"),
            ("a%3dx.png", "a007x.png"),
            ("a#b##.png", "a#b07.png"),
            ("%99d.png", "%99d.0007.png"),
        ] {
            assert_eq!(name(pattern, 7), Path::new(named));
        }
        let long = frame_name(Path::new("b.png"), 123_456, 7);
        assert_eq!(long, Path::new("b.000007.png"));
    }
}
