//! Sequences: frames, the camera's path, and file names.

use super::scene_args::{SceneArgs, WantedPicture};
use crate::cli::output::{self, CliError, bytes};
use clap::{Args, value_parser};
use glam::DVec3;
use phalanx::files::shown_path;
use phalanx::jobs::spec::headings::LONG_RENDERS;
use phalanx::jobs::{MAX_FRAME, PixelSpec, frame_name};
use phalanx::scene::{CameraKey, CameraPath, FileView, Scene, View};
use std::fs::File;
use std::io::Read;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
#[command(next_help_heading = LONG_RENDERS)]
pub struct FrameArgs {
    /// Frames A to B of a sequence, inclusive
    ///
    /// The scene is read and its BVH built only once. Each file name contains the frame number, in
    /// place of `#` characters or before the extension. [default: one full turn, or from the first
    /// to the last key frame]
    #[arg(long, value_name = "A..B", value_parser = parse_frames, requires = "path")]
    pub frames: Option<RangeInclusive<u32>>,
    /// Sequence of N frames, one turn around the target
    ///
    /// The camera circles its target once in N frames.
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=i64::from(MAX_FRAME)), group = "path")]
    pub turntable: Option<u32>,
    /// Move the camera through the views in this file
    ///
    /// Each line of the file holds a frame number, position X Y Z, target X Y Z, up vector X Y Z,
    /// and vertical field of view in degrees. Views in between are interpolated smoothly.
    #[arg(long, value_name = "FILE", hide_short_help = true, group = "path")]
    pub keyframes: Option<PathBuf>,
}

fn parse_frames(text: &str) -> Result<RangeInclusive<u32>, String> {
    let ends = text.split_once("..");
    let ends = ends.and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    match ends {
        Some((a, b)) if a <= b && b <= MAX_FRAME => Ok(a..=b),
        _ => Err(format!(
            "expected a range of frames A..B with A <= B <= {MAX_FRAME}, as in 0..119"
        )),
    }
}

/// A requested sequence.
pub struct Sequence {
    pub frames: RangeInclusive<u32>,
    /// The first frame of the path.
    pub first: u32,
    /// The camera's path.
    pub path: CameraPath,
}

impl FrameArgs {
    /// Returns true if these arguments describe a sequence.
    pub fn are_given(&self) -> bool {
        self.turntable.is_some() || self.keyframes.is_some()
    }

    /// Prints a note if --camera or --camera-name has no effect.
    pub fn note_camera(&self, scene: &SceneArgs) {
        let overrides = &scene.overrides;
        let given = [
            (overrides.camera.is_some(), "--camera"),
            (overrides.camera_name.is_some(), "--camera-name"),
        ];
        for (given, option) in given {
            if given && self.keyframes.is_some() {
                output::note(&format!("{option} has no effect with --keyframes"));
            }
        }
    }

    /// The picture that the scene is opened for.
    pub fn wanted(&self, pixels: &PixelSpec) -> WantedPicture {
        WantedPicture {
            size: pixels.size,
            turntable: self.turntable.is_some(),
        }
    }

    /// The origin of a result in messages; `None` if its name is a pattern for the names of frames.
    pub fn origin(&self, origin: &'static str) -> Option<&'static str> {
        (!self.are_given()).then_some(origin)
    }

    /// The requested sequence, if there is one. Positions of key frames are in the file's
    /// coordinates.
    pub fn sequence(&self, scene: &Scene) -> Result<Option<Sequence>, CliError> {
        let (path, all) = match (&self.keyframes, self.turntable) {
            (Some(file), _) => {
                let keys = read_keys(file, scene)?;
                // There is at least one key, and keys are in order.
                let all = keys[0].frame..=keys[keys.len() - 1].frame;
                (CameraPath::Keys(keys), all)
            }
            (None, Some(frames)) => (CameraPath::Turntable { frames }, 0..=frames - 1),
            (None, None) => return Ok(None),
        };
        Ok(Some(Sequence {
            first: *all.start(),
            frames: self.frames.clone().unwrap_or(all),
            path,
        }))
    }
}

impl Sequence {
    /// The view of a frame, for a scene whose own view is `scene`.
    pub fn view(&self, frame: u32, scene: &View) -> Result<View, CliError> {
        let view = self.path.view(frame, scene);
        match view.basis() {
            Ok(_) => Ok(view),
            Err(error) => Err(CliError::Usage(format!("frame {frame}: {error}"))),
        }
    }

    /// The file of a frame, of a sequence that goes to `path`.
    pub fn name(&self, path: &Path, frame: u32) -> PathBuf {
        frame_name(path, *self.frames.end(), frame)
    }
}

/// Maximum size of a key frame file; a view takes about a hundred bytes. A device never ends.
const MAX_KEYS: u64 = 16 << 20;

/// Key frames of a file, for this scene.
pub fn read_keys(path: &Path, scene: &Scene) -> Result<Vec<CameraKey>, CliError> {
    let name = shown_path(path);
    output::reads("the key frames", path)?;
    let mut text = String::new();
    let file = File::open(path);
    let read = file.and_then(|file| file.take(MAX_KEYS + 1).read_to_string(&mut text));
    read.map_err(|e| CliError::cannot_read(&name, e))?;
    if text.len() as u64 > MAX_KEYS {
        let most = bytes(MAX_KEYS);
        let message = format!("{name}: not a key frame file: larger than {most}");
        return Err(CliError::Usage(message));
    }
    parse_keys(&text, scene).map_err(|(line, what)| {
        CliError::Usage(format!(
            "{name}:{line}: {what}; each line holds a frame number, position X Y Z, target X Y Z, up vector X Y Z, and \
             field of view, as in 24 0 1 5 0 0 0 0 1 0 45"
        ))
    })
}

/// Parses lines of eleven numbers; a `#` begins a comment. An error has the line's number.
fn parse_keys(text: &str, scene: &Scene) -> Result<Vec<CameraKey>, (usize, String)> {
    let mut keys: Vec<CameraKey> = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.split('#').next().unwrap_or_default();
        let mut words = line.split_whitespace();
        let Some(first) = words.next() else {
            continue;
        };
        let wrong = |what: &str| (number, what.to_owned());
        let frame = first.parse();
        let frame = frame.map_err(|_| wrong(&format!("{first} is not a frame number")))?;
        let numbers: Result<Vec<f64>, _> = words.map(str::parse).collect();
        let numbers = numbers.map_err(|_| wrong("not a number"))?;
        let &[ex, ey, ez, cx, cy, cz, ux, uy, uz, fovy] = &numbers[..] else {
            let count = numbers.len();
            return Err(wrong(&format!(
                "expected 10 numbers after the frame, found {count}"
            )));
        };
        let view = scene.view_of(&FileView {
            eye: DVec3::new(ex, ey, ez),
            center: DVec3::new(cx, cy, cz),
            up: DVec3::new(ux, uy, uz).as_vec3(),
            fovy: fovy as f32,
            ortho: None,
        });
        view.basis().map_err(|e| wrong(&e.to_string()))?;
        if frame > MAX_FRAME {
            return Err(wrong(&format!(
                "frame {frame} is above the maximum, {MAX_FRAME}"
            )));
        }
        if keys.last().is_some_and(|last| last.frame >= frame) {
            return Err(wrong("frame numbers must increase"));
        }
        keys.push(CameraKey { frame, view });
    }
    if keys.is_empty() { Err((1, "no views".to_owned())) } else { Ok(keys) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_two_frames_in_order() {
        assert_eq!(parse_frames("3..7").unwrap(), 3..=7);
        assert_eq!(parse_frames("0..0").unwrap(), 0..=0);
        for bad in ["7..3", "3", "..", "3..", "-1..2", "a..b", "0..99999999999"] {
            assert!(parse_frames(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn keys_are_lines_of_eleven_numbers() {
        let keys = parse_keys(
            "# a way\n0 0 1 5 0 0 0 0 1 0 45\n\n24 1 1 5 0 0 0 0 1 0 30 # closer\n",
            &Scene {
                scale: 2.0,
                ..Scene::default()
            },
        )
        .unwrap();
        assert_eq!(keys.len(), 2);
        assert_eq!(
            (keys[1].frame, keys[1].view.eye.x, keys[1].view.fovy),
            (24, 2.0, 30.0)
        );
        let far = Scene {
            origin: [500_000.0, 0.0, 0.0],
            ..Scene::default()
        };
        let keys = parse_keys("0 500000.31 1 5 500000 0 0 0 1 0 45", &far).unwrap();
        assert_eq!((keys[0].view.eye.x, keys[0].view.center.x), (0.31, 0.0));
        for (bad, line, part) in [
            ("", 1, "no views"),
            ("0 1 2 3", 1, "found 3"),
            ("x 0 1 5 0 0 0 0 1 0 45", 1, "not a frame number"),
            (
                "0 0 1 5 0 0 0 0 1 0 45\n0 0 1 5 0 0 0 0 1 0 45",
                2,
                "increase",
            ),
            ("0 0 1 5 0 1 5 0 1 0 45", 1, "stands on the point"),
            ("0 0 1 5 0 0 0 0 1 0 nan", 1, "not finite"),
            ("0 0 1 5 0 0 0 0 1 0 x", 1, "not a number"),
        ] {
            let (error, what) = parse_keys(bad, &Scene::default()).unwrap_err();
            assert!(
                error == line && what.contains(part),
                "{bad}: {error}: {what}"
            );
        }
    }
}
