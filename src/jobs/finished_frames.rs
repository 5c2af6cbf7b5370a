//! The list of a shard's finished frames: the pictures that it has written, with a checksum of
//! each, so that a file of the same name with other content is not mistaken for one of them.
//!
//! The list is a text file that only grows. Its first line identifies the sequence; every other
//! line is a frame. If a line is cut off or damaged, its frame is rendered again. A process that
//! renders a shard holds a lock on its list.

use super::kept_file::{KeptFileError, check_regular, open_exclusive};
use super::kept_header::{KeptHeader, KeptKind};
use super::render_key::RenderKey;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// The files' kind in messages.
const LIST: KeptKind = KeptKind {
    name: "a list of finished frames",
    foreign: "lists frames of another sequence",
    unnamed_version: None,
};

/// Longest line that is read: many times the length of a key.
const MAX_LINE: u64 = 1 << 20;

/// A frame's number, with a checksum of all that its file depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FrameIdentity {
    /// Number of the frame.
    pub frame: u32,
    /// Checksum of the picture's key, its encoding and its format.
    pub checksum: u32,
}

/// State of a frame's picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameState {
    /// The file is as the shard has written it.
    Finished,
    /// There is no file.
    Absent,
    /// There is a file that the shard has not written.
    Unlisted,
    /// There is a file that has changed since the shard wrote it.
    Changed,
}

/// Any other line: a frame, and the length and checksum of its file.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FinishedFrame {
    frame: u32,
    identity: u32,
    bytes: u64,
    crc32: u32,
}

/// Finished frames of a shard, by number.
#[derive(Debug)]
pub struct FinishedFrames {
    path: PathBuf,
    file: File,
    frames: HashMap<u32, FinishedFrame>,
}

impl FinishedFrames {
    /// Opens the list of a shard to add to it, or creates it if it does not exist. The shard
    /// belongs to this process until the list is dropped. `key` and `camera_path` are those of the
    /// sequence.
    ///
    /// # Errors
    /// [`KeptFileError`]: also where the list is another sequence's, and where another process
    /// renders the shard.
    pub fn open(
        path: &Path,
        key: &RenderKey,
        camera_path: &str,
    ) -> Result<FinishedFrames, KeptFileError> {
        let io = |source| KeptFileError::io(path, source);
        let file = open_exclusive(path)?;
        let (mut list, end) = FinishedFrames::scan(path, file, key, camera_path)?;
        // Bytes behind the last whole line are part of an unfinished one.
        list.file.set_len(end).map_err(io)?;
        list.file.seek(SeekFrom::Start(end)).map_err(io)?;
        if end == 0 {
            let header = header(key, camera_path);
            list.file.write_all(header.as_bytes()).map_err(io)?;
        }
        Ok(list)
    }

    /// Opens the list of a shard to read it.
    ///
    /// # Errors
    /// [`KeptFileError`].
    pub fn read(
        path: &Path,
        key: &RenderKey,
        camera_path: &str,
    ) -> Result<FinishedFrames, KeptFileError> {
        check_regular(path)?;
        let file = File::open(path).map_err(|source| KeptFileError::io(path, source))?;
        FinishedFrames::scan(path, file, key, camera_path).map(|(list, _)| list)
    }

    /// State of a frame whose file is `picture`. Reads the whole file.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn state(&self, frame: FrameIdentity, picture: &Path) -> io::Result<FrameState> {
        let metadata = match std::fs::metadata(picture) {
            Ok(metadata) => metadata,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                return Ok(FrameState::Absent);
            }
            Err(error) => return Err(error),
        };
        let listed = self.frames.get(&frame.frame);
        let Some(listed) = listed.filter(|listed| listed.identity == frame.checksum) else {
            return Ok(FrameState::Unlisted);
        };
        let same = metadata.is_file() && metadata.len() == listed.bytes;
        if same && checksum(picture)? == (listed.bytes, listed.crc32) {
            Ok(FrameState::Finished)
        } else {
            Ok(FrameState::Changed)
        }
    }

    /// Adds a frame whose file `picture` has been written.
    ///
    /// # Errors
    /// [`KeptFileError::Io`].
    pub fn add(&mut self, frame: FrameIdentity, picture: &Path) -> Result<(), KeptFileError> {
        let (bytes, crc32) =
            checksum(picture).map_err(|source| KeptFileError::io(picture, source))?;
        let finished = FinishedFrame {
            frame: frame.frame,
            identity: frame.checksum,
            bytes,
            crc32,
        };
        let mut line = serde_json::to_string(&finished).unwrap_or_default();
        line.push('\n');
        let written = self.file.write_all(line.as_bytes());
        let synced = written.and_then(|()| self.file.sync_data());
        synced.map_err(|source| KeptFileError::io(&self.path, source))?;
        self.frames.insert(finished.frame, finished);
        Ok(())
    }

    /// Reads every line. Returns the offset behind the last whole one, too.
    fn scan(
        path: &Path,
        file: File,
        key: &RenderKey,
        camera_path: &str,
    ) -> Result<(FinishedFrames, u64), KeptFileError> {
        let io = |source| KeptFileError::io(path, source);
        let mut reader = BufReader::new(&file);
        let mut line = Vec::new();
        let mut next = |line: &mut Vec<u8>| {
            line.clear();
            let read = reader.by_ref().take(MAX_LINE).read_until(b'\n', line);
            read.map_err(io)?;
            Ok(line.ends_with(b"\n"))
        };
        let mut frames = HashMap::new();
        let mut end = 0;
        if next(&mut line)? {
            KeptHeader::new(key, Some(camera_path)).check(&line, path, &LIST)?;
            end += line.len() as u64;
        } else if !header(key, camera_path).as_bytes().starts_with(&line) {
            return Err(KeptFileError::other(path, LIST.name));
        }
        while end > 0 && next(&mut line)? {
            end += line.len() as u64;
            if let Ok(frame) = serde_json::from_slice::<FinishedFrame>(&line) {
                frames.insert(frame.frame, frame);
            }
        }
        let path = path.into();
        Ok((FinishedFrames { path, file, frames }, end))
    }
}

/// The first line of a list.
fn header(key: &RenderKey, camera_path: &str) -> String {
    KeptHeader::new(key, Some(camera_path)).json() + "\n"
}

/// Length and checksum of a file.
fn checksum(path: &Path) -> io::Result<(u64, u32)> {
    let mut file = File::open(path)?;
    let mut hasher = crc32fast::Hasher::new();
    let mut bytes = vec![0; 1 << 20];
    let mut length = 0;
    loop {
        match file.read(&mut bytes)? {
            0 => return Ok((length, hasher.finalize())),
            read => {
                length += read as u64;
                hasher.update(&bytes[..read]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phalanx_render::frame::Settings;
    use phalanx_scene::Scene;
    use std::fs;

    fn key(width: u32) -> RenderKey {
        let scene = Scene::default();
        let settings = Settings {
            width,
            ..Settings::of(&scene)
        };
        RenderKey::of(&scene, &settings)
    }

    const FIRST: FrameIdentity = FrameIdentity {
        frame: 7,
        checksum: 1,
    };

    #[test]
    fn a_frame_is_finished_while_its_file_is_what_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let (path, picture) = (folder.path().join("a.frames"), folder.path().join("a.png"));
        let mut list = FinishedFrames::open(&path, &key(8), "0").unwrap();
        assert_eq!(list.state(FIRST, &picture).unwrap(), FrameState::Absent);
        fs::write(&picture, "pixels").unwrap();
        assert_eq!(list.state(FIRST, &picture).unwrap(), FrameState::Unlisted);
        list.add(FIRST, &picture).unwrap();
        drop(list);
        let state = |frame| {
            let list = FinishedFrames::read(&path, &key(8), "0").unwrap();
            list.state(frame, &picture).unwrap()
        };
        assert_eq!(state(FIRST), FrameState::Finished);
        let other = FrameIdentity {
            checksum: 2,
            ..FIRST
        };
        assert_eq!(state(other), FrameState::Unlisted);
        for changed in ["pixelS", "pixel", ""] {
            fs::write(&picture, changed).unwrap();
            assert_eq!(state(FIRST), FrameState::Changed, "{changed}");
        }
        fs::remove_file(&picture).unwrap();
        assert_eq!(state(FIRST), FrameState::Absent);
    }

    /// Opens a list. A process started by another test holds its files until it begins its program,
    /// locks included, so a list in use is tried again.
    fn open(path: &Path) -> FinishedFrames {
        for _ in 0..200 {
            match FinishedFrames::open(path, &key(8), "0") {
                Err(KeptFileError::InUse { .. }) => {
                    std::thread::sleep(std::time::Duration::from_millis(10));
                }
                opened => return opened.unwrap(),
            }
        }
        panic!("in use for two seconds");
    }

    #[test]
    fn a_list_that_is_cut_off_anywhere_keeps_its_whole_lines() {
        let folder = tempfile::tempdir().unwrap();
        let (path, picture) = (folder.path().join("a.frames"), folder.path().join("a.png"));
        fs::write(&picture, "pixels").unwrap();
        let second = FrameIdentity { frame: 8, ..FIRST };
        let mut list = open(&path);
        list.add(FIRST, &picture).unwrap();
        list.add(second, &picture).unwrap();
        drop(list);
        let bytes = fs::read(&path).unwrap();
        let ends: Vec<usize> = (1..=bytes.len())
            .filter(|&n| bytes[n - 1] == b'\n')
            .collect();
        for length in 0..=bytes.len() {
            fs::write(&path, &bytes[..length]).unwrap();
            let mut list = open(&path);
            let finished = |list: &FinishedFrames, frame| {
                list.state(frame, &picture).unwrap() == FrameState::Finished
            };
            assert_eq!(finished(&list, FIRST), length >= ends[1], "{length}");
            assert_eq!(finished(&list, second), length >= ends[2], "{length}");
            list.add(second, &picture).unwrap();
            drop(list);
            let list = FinishedFrames::read(&path, &key(8), "0").unwrap();
            assert!(finished(&list, second), "{length}");
        }
        // A damaged line costs only its own frame.
        let mut damaged = bytes.clone();
        damaged[ends[0] + 2] = b'!';
        fs::write(&path, damaged).unwrap();
        let list = FinishedFrames::read(&path, &key(8), "0").unwrap();
        assert_eq!(list.state(FIRST, &picture).unwrap(), FrameState::Unlisted);
        assert_eq!(list.state(second, &picture).unwrap(), FrameState::Finished);
    }

    #[test]
    fn lists_of_others_are_refused_and_left_as_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.frames");
        let ours = FinishedFrames::open(&path, &key(8), "0").unwrap();
        let refused = || FinishedFrames::open(&path, &key(8), "0").unwrap_err();
        assert!(matches!(refused(), KeptFileError::InUse { .. }));
        drop(ours);
        let other = FinishedFrames::open(&path, &key(9), "1").unwrap_err();
        let message = other.to_string();
        assert!(
            message.contains("--size is 8x480 there and 9x480 here"),
            "{message}"
        );
        assert!(message.contains("path is 0 there and 1 here"), "{message}");
        for text in [
            "my notes",
            "my notes\n",
            "{}\n",
            "{\"layout_version\": 5}\n",
        ] {
            fs::write(&path, text).unwrap();
            assert!(matches!(refused(), KeptFileError::Other { .. }), "{text}");
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
        }
        for old in [
            "{\"finished_frames\": 2, \"x\": 1}\n",
            "{\"layout_version\": 2}\n",
        ] {
            fs::write(&path, old).unwrap();
            assert!(matches!(refused(), KeptFileError::Layout { found: 2, .. }));
        }
        // A file without an end has no line either.
        File::create(&path).unwrap().set_len(1 << 40).unwrap();
        assert!(matches!(refused(), KeptFileError::Other { .. }));
    }
}
