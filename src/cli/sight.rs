//! The picture so far, for people who wait: in the terminal, or in a file that is written anew now and then.

use super::failure::Failure;
use super::output;
use super::picture_file::Target;
use super::preview::Preview;
use clap::Args;
use phalanx::frame::Tile;
use phalanx::image::{Grade, encode, save_png};
use phalanx::jobs::Overview;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

#[derive(Debug, Args)]
pub struct SightArgs {
    /// Draw the picture so far in the terminal
    #[arg(long)]
    pub preview: bool,
    /// Write the picture so far to this file, every ten seconds and at the end, 2048 pixels wide or high at most
    #[arg(long, value_name = "FILE.png")]
    pub snapshot: Option<PathBuf>,
}

/// How often a snapshot is written.
const EVERY: Duration = Duration::from_secs(10);

/// Longest side of a snapshot.
const SIDE: u32 = 2048;

/// What is to be seen of a picture while it is made.
pub struct Sight<'a> {
    pub overview: Overview,
    grade: Grade,
    preview: bool,
    snapshot: Option<&'a Path>,
}

impl<'a> Sight<'a> {
    /// What was asked for, if anything was.
    pub fn of(
        args: &'a SightArgs,
        target: &Target,
        window: Tile,
    ) -> Result<Option<Sight<'a>>, Failure> {
        if args.preview {
            Preview::check()?;
        }
        if let Some(path) = &args.snapshot {
            output::check_png_name(path, "--snapshot")?;
            output::check_place(path)?;
        }
        if !args.preview && args.snapshot.is_none() {
            return Ok(None);
        }
        let side = match args.snapshot {
            Some(_) => SIDE,
            None => Preview::side(),
        };
        Ok(Some(Sight {
            overview: Overview::new(window, side),
            grade: target.file.grade,
            preview: args.preview,
            snapshot: args.snapshot.as_deref(),
        }))
    }
}

/// Shows a sight.
pub struct Viewer<'a> {
    sight: &'a Sight<'a>,
    preview: Option<Preview>,
    written: Instant,
}

impl<'a> Viewer<'a> {
    pub fn of(sight: &'a Sight<'a>) -> Viewer<'a> {
        Viewer {
            sight,
            preview: sight.preview.then(Preview::default),
            written: Instant::now(),
        }
    }

    /// Whether it draws on stderr.
    pub fn draws(&self) -> bool {
        self.preview.is_some()
    }

    /// Shows the picture so far, with these words; a file is written when it is time to, or at the end.
    pub fn show(&mut self, words: &str, end: bool) {
        let due = end || self.written.elapsed() >= EVERY;
        if self.preview.is_none() && !due {
            return;
        }
        let picture = encode(&self.sight.overview.film(), self.sight.grade);
        if let Some(preview) = &mut self.preview {
            preview.draw(&picture, words);
        }
        if let Some(path) = self.sight.snapshot.filter(|_| due) {
            self.written = Instant::now();
            // A disk that is full for a moment is no reason to give up a picture that takes hours.
            if let Err(error) = save_png(path, &picture) {
                output::note(&format!("warning: {error}"));
            }
        }
    }
}
