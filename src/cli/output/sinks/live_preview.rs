//! Live view of an unfinished picture: in the terminal, or in a file rewritten at intervals.

use super::destination::is_replaced;
use super::preview::Preview;
use super::stderr::warning;
use crate::cli::output::error::CliError;
use phalanx::frame::Tile;
use phalanx::image::{Exposure, Picture, Thumbnail, encode, save_png};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Interval between snapshots.
const SNAPSHOT_INTERVAL: Duration = Duration::from_secs(10);

/// Longest side of a snapshot.
const MAX_SNAPSHOT_SIDE: u32 = 2048;

/// Views of a picture during rendering.
pub struct LivePreview<'a> {
    pub thumbnail: Thumbnail,
    exposure: Exposure,
    preview: bool,
    snapshot: Option<&'a Path>,
}

impl<'a> LivePreview<'a> {
    /// The requested views, if any.
    pub fn of(
        preview: bool,
        snapshot: Option<&'a Path>,
        exposure: Exposure,
        window: Tile,
    ) -> Result<Option<LivePreview<'a>>, CliError> {
        if preview {
            Preview::check()?;
        }
        if !preview && snapshot.is_none() {
            return Ok(None);
        }
        let side = match snapshot {
            Some(_) => MAX_SNAPSHOT_SIDE,
            None => Preview::side(),
        };
        Ok(Some(LivePreview {
            thumbnail: Thumbnail::new(window, side),
            exposure,
            preview,
            snapshot,
        }))
    }
}

/// Shows a live preview.
pub struct PreviewWriter<'a> {
    source: &'a LivePreview<'a>,
    preview: Option<Preview>,
    written: Instant,
    /// Thread that writes the last snapshot to an output whose reader may block it.
    sent: Option<JoinHandle<()>>,
}

impl<'a> PreviewWriter<'a> {
    pub fn of(preview: &'a LivePreview<'a>) -> PreviewWriter<'a> {
        PreviewWriter {
            source: preview,
            preview: preview.preview.then(Preview::default),
            written: Instant::now(),
            sent: None,
        }
    }

    /// Returns true if it draws on stderr.
    pub fn draws(&self) -> bool {
        self.preview.is_some()
    }

    /// Shows the unfinished picture with a status line. A file is written at intervals and at the
    /// end. A pipe without a reader blocks nothing, except at the end until `stop` is set.
    pub fn show(&mut self, words: &str, end: bool, stop: &AtomicBool) {
        let is_due = end || self.written.elapsed() >= SNAPSHOT_INTERVAL;
        if self.preview.is_none() && !is_due {
            return;
        }
        let picture = encode(&self.source.thumbnail.film(), self.source.exposure);
        if let Some(preview) = &mut self.preview {
            preview.draw(&picture, words);
        }
        if let Some(path) = self.source.snapshot.filter(|_| is_due) {
            self.written = Instant::now();
            self.save(path, picture, end, stop);
        }
    }

    fn save(&mut self, path: &Path, picture: Picture, end: bool, stop: &AtomicBool) {
        if is_replaced(path) {
            save(path, &picture);
            return;
        }
        let waits = |sent: &Option<JoinHandle<()>>| sent.as_ref().is_some_and(|s| !s.is_finished());
        let wait = |sent: &Option<JoinHandle<()>>| {
            while end && waits(sent) && !stop.load(Ordering::SeqCst) {
                std::thread::sleep(Duration::from_millis(5));
            }
        };
        wait(&self.sent);
        if waits(&self.sent) {
            return;
        }
        let path = path.to_path_buf();
        self.sent = Some(std::thread::spawn(move || save(&path, &picture)));
        wait(&self.sent);
    }
}

/// Writes a snapshot. Errors are not fatal: a temporarily full disk must not end a render that
/// takes hours.
fn save(path: &Path, picture: &Picture) {
    if let Err(error) = save_png(path, picture) {
        warning(&error.to_string());
    }
}
