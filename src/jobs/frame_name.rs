//! Names of a sequence's files.

use phalanx_files::shell_word;
use std::ffi::OsString;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Minimum number of digits of a frame's number in a name that does not specify it.
const MIN_DIGITS: usize = 4;

/// Frames per second of a video, where nobody says otherwise.
pub const VIDEO_RATE: u32 = 24;

/// Maximum number of digits that a name may request.
const MAX_DIGITS: usize = 20;

/// A file name with the number of a frame in it, for a sequence that ends with frame `last`:
/// instead of the last run of `#`, with as many digits; or of `%d` or `%04d`, as in C's printf; or
/// else before the ending, with as many digits as the last frame has, at least four.
pub fn frame_name(path: &Path, last: u32, frame: u32) -> PathBuf {
    let (mut name, digits, after) = name_parts(path, last);
    name.push(format!("{frame:0digits$}"));
    name.push(after);
    path.with_file_name(name)
}

/// Parts of a frame's name: the text before the number, the number's digits, and the text after.
fn name_parts(path: &Path, last: u32) -> (OsString, usize, OsString) {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    if let Some((place, digits)) = number_place(&name) {
        return (name[..place.start].into(), digits, name[place.end..].into());
    }
    let mut before = path.file_stem().unwrap_or_default().to_owned();
    before.push(".");
    let mut after = OsString::new();
    if let Some(ending) = path.extension() {
        after.push(".");
        after.push(ending);
    }
    (before, frame_digits(last, last).len(), after)
}

/// Filter from linear light to sRGB's gamma.
const TO_SCREEN: &str = "format=rgb48,lutrgb=r=gammaval(0.4545):g=gammaval(0.4545):b=gammaval(0.4545),setparams=color_trc=iec61966-2-1";

/// The ffmpeg command that joins the frames of a sequence into a video beside them. Samples are
/// linear light if `is_linear`. `None` if a name is not UTF-8 or has no ending.
pub fn video_command(
    path: &Path,
    [first, last]: [u32; 2],
    (width, height): (u32, u32),
    is_linear: bool,
) -> Option<String> {
    let ending = path.extension()?.to_str()?;
    let (before, digits, after) = name_parts(path, last);
    let [before, after] = [before.to_str()?, after.to_str()?];
    // ffmpeg takes a name with a colon for a protocol, and one with a hyphen for an option.
    let folder = Path::new(".").join(path.parent()?);
    let folder = folder.to_str()?.trim_end_matches('/');
    let parts = [folder, before, after].map(|text| text.replace('%', "%%"));
    let input = format!("{}/{}%0{digits}d{}", parts[0], parts[1], parts[2]);
    let rest = after.strip_suffix(ending).unwrap_or(after);
    let stem = before.trim_end_matches(['.', '-', '_', ' ']);
    let stem = format!("{stem}{}", rest.trim_end_matches('.'));
    let stem = if stem.is_empty() { "video" } else { &stem };
    let output = format!("{folder}/{stem}.mp4");
    // With yuv420p, colours have half the resolution, so both sides must be even.
    let is_odd = width % 2 + height % 2 > 0;
    let pad = is_odd.then_some("pad=ceil(iw/2)*2:ceil(ih/2)*2");
    let filters = [is_linear.then_some(TO_SCREEN), pad].into_iter().flatten();
    let filters = Vec::from_iter(filters).join(",");
    let input = shell_word(&input);
    let mut command = format!("ffmpeg -framerate {VIDEO_RATE} -start_number {first} -i {input}");
    if !filters.is_empty() {
        command.push_str(&format!(" -vf {}", shell_word(&filters)));
    }
    Some(format!(
        "{command} -pix_fmt yuv420p {}",
        shell_word(&output)
    ))
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
    fn a_video_has_the_names_of_the_frames() {
        let command = |path: &str, linear| {
            video_command(Path::new(path), [7, 119], (641, 480), linear).unwrap()
        };
        assert_eq!(
            command("a/b.png", false),
            "ffmpeg -framerate 24 -start_number 7 -i './a/b.%04d.png' \
             -vf 'pad=ceil(iw/2)*2:ceil(ih/2)*2' -pix_fmt yuv420p ./a/b.mp4"
        );
        for (path, input, output) in [
            ("b-##.exr", " -i './b-%02d.exr' ", " ./b.mp4"),
            (
                "-50% of it's.png",
                r" -i './-50%% of it'\''s.%04d.png' ",
                r" './-50% of it'\''s.mp4'",
            ),
            ("c:#.jpg", " -i './c:%01d.jpg' ", " ./c:.mp4"),
            ("###.png", " -i './%03d.png' ", " ./video.mp4"),
            (
                "-d%d/#.png",
                " -i './-d%%d/%01d.png' ",
                " './-d%d/video.mp4'",
            ),
            ("/#.png", " -i '/%01d.png' ", " /video.mp4"),
            ("a#b.png", " -i './a%01db.png' ", " ./ab.mp4"),
        ] {
            let command = command(path, true);
            assert!(
                command.contains(input) && command.ends_with(output),
                "{command}"
            );
            assert!(command.contains("gammaval"), "{command}");
        }
    }

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
