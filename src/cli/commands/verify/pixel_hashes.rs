//! `verify --record` and `--against`: hashes of a picture, small enough to keep.
//!
//! Each pixel has two hashes, of its primary hit and of its radiance: see [`pixel_hashes`].

use crate::cli::output::{self, CliError, PictureWindow, RenderSummary, interrupt};
use phalanx::files::shown_path;
use phalanx::frame::Settings;
use phalanx::image::pixel_hashes;
use phalanx::jobs::spec::OptionValue;
use phalanx::render::Film;
use phalanx::scene::OutputEncoding;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{self, BufRead, BufReader, BufWriter, Read};
use std::path::{Path, PathBuf};

/// Version of the record's layout and of the values that are hashed.
const SCHEMA_VERSION: u32 = 1;

/// Maximum size of a record read from a pipe or device: 32 digits for each of 30 million pixels.
const MAX_PIPED: u64 = 1 << 30;

/// A record file.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct PixelHashFile {
    schema_version: u32,
    scenes: Vec<PixelHashes>,
}

/// Hashes of one scene's picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PixelHashes {
    /// The scene's file name without folders, so that a record works on other machines.
    scene: String,
    #[serde(flatten)]
    window: PictureWindow,
    max_depth: u32,
    #[serde(flatten)]
    summary: RenderSummary,
    transfer: String,
    quantize: String,
    hits: Vec<String>,
    radiance: Vec<String>,
}

impl PixelHashFile {
    /// A record of these pictures.
    pub fn new(scenes: Vec<PixelHashes>) -> PixelHashFile {
        PixelHashFile {
            schema_version: SCHEMA_VERSION,
            scenes,
        }
    }

    /// Writes the record, whole or not at all.
    pub fn save(&self, path: &Path) -> Result<(), CliError> {
        interrupt::write_file(path, |writer| {
            serde_json::to_writer_pretty(BufWriter::new(writer), self).map_err(io::Error::other)
        })
    }

    /// Reads a record.
    pub fn load(path: &Path) -> Result<PixelHashFile, CliError> {
        let name = shown_path(path);
        output::reads("the record", path)?;
        let file = File::open(path).map_err(|e| CliError::cannot_read(&name, e))?;
        let most = if file.metadata().is_ok_and(|file| file.is_file()) {
            u64::MAX
        } else {
            MAX_PIPED
        };
        let mut reader = BufReader::with_capacity(1 << 16, file.take(most));
        let mut read = || -> io::Result<Vec<u8>> {
            // A device may never end, so what does not begin as a record is not read whole.
            let mut bytes = reader.fill_buf()?.to_vec();
            if bytes.trim_ascii_start().starts_with(b"{") {
                bytes.clear();
                reader.read_to_end(&mut bytes)?;
            }
            Ok(bytes)
        };
        let bytes = read().map_err(|e| CliError::cannot_read(&name, e))?;
        let record: PixelHashFile = serde_json::from_slice(&bytes)
            .map_err(|e| CliError::Runtime(format!("{name}: not a record of verify: {e}")))?;
        if record.schema_version != SCHEMA_VERSION {
            return Err(CliError::Usage(format!(
                "{name}: record version {} is not supported, only version {SCHEMA_VERSION}",
                record.schema_version
            )));
        }
        Ok(record)
    }

    /// Refuses scenes that a record could not distinguish by name.
    pub fn check_names(paths: &[PathBuf]) -> Result<(), CliError> {
        let mut names: Vec<_> = paths.iter().map(|path| name_of(path)).collect();
        names.sort();
        match names.windows(2).find(|pair| pair[0] == pair[1]) {
            Some(pair) => Err(CliError::Usage(format!(
                "two scenes are named {}: a record stores only file names, so record them separately",
                pair[0]
            ))),
            None => Ok(()),
        }
    }

    /// The hashes of a scene, which must have been rendered with the same settings.
    pub fn find(
        &self,
        path: &Path,
        settings: &Settings,
        encoding: OutputEncoding,
    ) -> Result<&PixelHashes, CliError> {
        let name = name_of(path);
        let recorded = self.scenes.iter().find(|recorded| recorded.scene == name);
        let recorded = recorded.ok_or_else(|| {
            CliError::Usage(format!("the record does not contain the scene {name}"))
        })?;
        let requested = PixelHashes::heading(path, settings, encoding);
        if recorded.describe() != requested.describe() {
            return Err(CliError::Usage(format!(
                "the record of {name} was made with {}, not with {}",
                recorded.describe(),
                requested.describe()
            )));
        }
        let rows = [&recorded.hits, &recorded.radiance];
        let is_complete = |row: &String| row.len() == recorded.window.width as usize * DIGITS;
        let sound = |r: &&Vec<String>| {
            r.len() == recorded.window.height as usize && r.iter().all(is_complete)
        };
        if !rows.iter().all(sound) {
            let message = format!("the record of {name} is damaged");
            return Err(CliError::Runtime(message));
        }
        Ok(recorded)
    }
}

fn name_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// Hexadecimal digits of a hash.
const DIGITS: usize = 16;

impl PixelHashes {
    /// A record without its pixels.
    fn heading(path: &Path, settings: &Settings, encoding: OutputEncoding) -> PixelHashes {
        PixelHashes {
            scene: name_of(path),
            window: PictureWindow::of(settings),
            max_depth: settings.max_depth,
            summary: RenderSummary::of(settings),
            transfer: encoding.transfer.text(),
            quantize: encoding.quantize.text(),
            hits: Vec::new(),
            radiance: Vec::new(),
        }
    }

    /// The hashes of a film.
    pub fn of(
        path: &Path,
        settings: &Settings,
        encoding: OutputEncoding,
        film: &Film,
    ) -> PixelHashes {
        let mut recorded = PixelHashes::heading(path, settings, encoding);
        [recorded.hits, recorded.radiance] = pixel_hashes(film);
        recorded
    }

    fn describe(&self) -> String {
        let PictureWindow { width, height, .. } = self.window;
        format!(
            "{width}x{height} pixels{}, max depth {}, {}, transfer {}, quantize {}",
            self.window.region_words(),
            self.max_depth,
            self.summary.words(),
            self.transfer,
            self.quantize
        )
    }

    /// Column and row of the first pixel whose hashes differ from those of a record that
    /// [`PixelHashFile::find`] returned.
    pub fn first_difference(&self, expected: &PixelHashes) -> Option<[u32; 2]> {
        let here = self.hits.iter().zip(&self.radiance);
        let there = expected.hits.iter().zip(&expected.radiance);
        here.zip(there).enumerate().find_map(|(y, (here, there))| {
            let x = first_in_row(here.0, there.0);
            let x = x.into_iter().chain(first_in_row(here.1, there.1)).min()?;
            Some([x as u32, y as u32])
        })
    }
}

fn first_in_row(a: &str, b: &str) -> Option<usize> {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    let digit = a.iter().zip(b).position(|(s, t)| s != t)?;
    Some(digit / DIGITS)
}

#[cfg(test)]
mod tests {
    use super::super::fixture::film;
    use super::*;
    use phalanx::frame::{Filter, Integrator, Lens, Sampling};
    use phalanx::scene::{Scene, Transfer};

    const PATH: &str = "folder/a.test";

    fn settings() -> Settings {
        Settings {
            width: 3,
            height: 2,
            ..Settings::of(&Scene::default())
        }
    }

    fn kept(film: &Film) -> PixelHashes {
        PixelHashes::of(
            Path::new(PATH),
            &settings(),
            Scene::default().encoding,
            film,
        )
    }

    #[test]
    fn a_record_survives_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("record.json");
        let record = PixelHashFile::new(vec![kept(&film())]);
        record.save(&path).unwrap();
        assert_eq!(PixelHashFile::load(&path).unwrap(), record);
    }

    #[test]
    fn a_changed_hit_or_radiance_is_found_at_its_pixel() {
        let before = kept(&film());
        assert_eq!(kept(&film()).first_difference(&before), None);
        let mut other = film();
        other.planes[2][5] = 0.75;
        assert_eq!(kept(&other).first_difference(&before), Some([2, 1]));
        other.hits.as_mut().unwrap().v[4] = 0.0;
        assert_eq!(kept(&other).first_difference(&before), Some([1, 1]));
        other.planes[0][2] = -0.0;
        other.hits.as_mut().unwrap().prim_id[1] = 8;
        assert_eq!(kept(&other).first_difference(&before), Some([1, 0]));
    }

    #[test]
    fn a_record_of_something_else_is_a_usage_error() {
        let record = PixelHashFile::new(vec![kept(&film())]);
        let encoding = Scene::default().encoding;
        assert!(
            record
                .find(Path::new("elsewhere/a.test"), &settings(), encoding)
                .is_ok()
        );
        let deeper = Settings {
            max_depth: 9,
            ..settings()
        };
        let wider = Settings {
            width: 4,
            ..settings()
        };
        let sampled = |spp, filter| Settings {
            sampling: Sampling {
                spp,
                filter,
                ..Sampling::CENTER
            },
            ..settings()
        };
        let blurred = Settings {
            lens: Some(Lens {
                aperture: 0.1,
                focus: 1.0,
            }),
            ..settings()
        };
        let open = Settings {
            integrator: Integrator::Occlusion { distance: 1.0 },
            ..settings()
        };
        let srgb = OutputEncoding {
            transfer: Transfer::Srgb,
            ..encoding
        };
        for (path, settings, encoding) in [
            ("b.test", settings(), encoding),
            (PATH, deeper, encoding),
            (PATH, wider, encoding),
            (PATH, sampled(4, Filter::Box), encoding),
            (PATH, blurred, encoding),
            (PATH, open, encoding),
            (PATH, settings(), srgb),
        ] {
            let refused = record
                .find(Path::new(path), &settings, encoding)
                .unwrap_err();
            assert_eq!(refused.code(), 2, "{refused:?}");
        }
    }

    #[test]
    fn a_record_that_does_not_say_is_of_the_defaults() {
        let mut json = serde_json::to_value(kept(&film())).unwrap();
        let object = json.as_object_mut().unwrap();
        for key in [
            "spp",
            "filter",
            "aperture",
            "focus",
            "integrator",
            "ao_distance",
        ] {
            assert!(object.remove(key).is_some(), "{key}");
        }
        let older: PixelHashes = serde_json::from_value(json).unwrap();
        assert_eq!(older, kept(&film()));
    }

    #[test]
    fn a_damaged_record_is_refused() {
        let mut record = PixelHashFile::new(vec![kept(&film())]);
        record.scenes[0].radiance[1].pop();
        let refused = record.find(Path::new(PATH), &settings(), Scene::default().encoding);
        assert_eq!(refused.unwrap_err().code(), 1);
    }

    #[test]
    fn scenes_of_one_name_cannot_share_a_record() {
        let paths = |names: &[&str]| names.iter().map(PathBuf::from).collect::<Vec<_>>();
        assert!(PixelHashFile::check_names(&paths(&["a/x.test", "a/y.test"])).is_ok());
        assert!(PixelHashFile::check_names(&paths(&["a/x.test", "y", "b/x.test"])).is_err());
    }
}
