//! Names of a sequence's files.

use phalanx_files::shell_word;
use std::ffi::{OsStr, OsString};
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
    if let Some(FrameNumber {
        before,
        digits,
        after,
    }) = FrameNumber::of(path)
    {
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

/// A name that says where the number goes: its parts, and the digits between them.
struct FrameNumber {
    before: String,
    digits: usize,
    after: String,
}

impl FrameNumber {
    fn of(path: &Path) -> Option<FrameNumber> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let (place, digits) = number_place(&name)?;
        Some(FrameNumber {
            before: name[..place.start].to_owned(),
            digits,
            after: name[place.end..].to_owned(),
        })
    }
}

/// The command that joins the frames of a sequence into a video beside them, in these names and of
/// this size. Samples are linear light if `is_linear`. `None` if no command can have the names.
pub fn video_command(
    path: &Path,
    [first, last]: [u32; 2],
    (width, height): (u32, u32),
    is_linear: bool,
) -> Option<String> {
    let ending = path.extension().and_then(OsStr::to_str)?;
    let FrameNumber {
        before,
        digits,
        after,
    } = match FrameNumber::of(path) {
        Some(number) => number,
        None => FrameNumber {
            before: format!("{}.", path.file_stem()?.to_str()?),
            digits: frame_digits(last, last).len(),
            after: format!(".{ending}"),
        },
    };
    // What comes before a colon would be a protocol, and a hyphen begins an option.
    let folder = Path::new(".").join(path.parent()?);
    let folder = folder.to_str()?.trim_end_matches('/');
    let literal = |text: &str| text.replace('%', "%%");
    let name = format!("{}%0{digits}d{}", literal(&before), literal(&after));
    let input = format!("{}/{name}", literal(folder));
    let rest = after.strip_suffix(ending).unwrap_or(&after);
    let rest = rest.trim_end_matches('.');
    let stem = format!("{}{rest}", before.trim_end_matches(['.', '-', '_', ' ']));
    let stem = if stem.is_empty() { "video" } else { &stem };
    let output = format!("{folder}/{stem}.mp4");
    let [rate, first] = [VIDEO_RATE, first].map(|number| number.to_string());
    let mut words = vec![
        "ffmpeg",
        "-framerate",
        &rate,
        "-start_number",
        &first,
        "-i",
        &input,
    ];
    let mut filters = Vec::new();
    if is_linear {
        let curve = ["r", "g", "b"].map(|c| format!("{c}=gammaval(0.4545)"));
        let curve = curve.join(":");
        filters.push(format!(
            "format=rgb48,lutrgb={curve},setparams=color_trc=iec61966-2-1"
        ));
    }
    // Colours have half the resolution.
    if width % 2 + height % 2 > 0 {
        filters.push("pad=ceil(iw/2)*2:ceil(ih/2)*2".to_owned());
    }
    let filters = filters.join(",");
    if !filters.is_empty() {
        words.extend(["-vf", &filters]);
    }
    words.extend(["-pix_fmt", "yuv420p", &output]);
    Some(Vec::from_iter(words.iter().map(shell_word)).join(" "))
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
