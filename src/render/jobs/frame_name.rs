//! Names of a sequence's files.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Fewest digits of a frame's number in a name that does not say how many.
const MIN_DIGITS: usize = 4;

/// A file name with the number of a frame in it, for a sequence that ends with frame `last`: in
/// place of `#`s, or else before the ending. It has as many digits as there are `#`s, or else as
/// the last frame has, four at least.
pub fn frame_name(path: &Path, last: u32, frame: u32) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    if let (Some(first), Some(end)) = (name.find('#'), name.rfind('#')) {
        let digits = end + 1 - first;
        let name = format!("{}{frame:0digits$}{}", &name[..first], &name[end + 1..]);
        return path.with_file_name(name);
    }
    let mut stem = OsString::from(path.file_stem().unwrap_or_default());
    stem.push(format!(".{}", frame_digits(last, frame)));
    if let Some(ending) = path.extension() {
        stem.push(".");
        stem.push(ending);
    }
    path.with_file_name(stem)
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
        let long = frame_name(Path::new("b.png"), 123_456, 7);
        assert_eq!(long, Path::new("b.000007.png"));
    }
}
