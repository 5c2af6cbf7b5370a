//! The file that a picture is written to: its format by its name, and what may be asked of that.

use super::failure::Failure;
use super::picture_args::PictureArgs;
use clap::Args;
use phalanx::frame::{Aovs, Settings, Tile};
use phalanx::image::{Depth, Format, Grade, PictureFile, save_bands};
use phalanx::jobs::BandsError;
use phalanx::render::Film;
use phalanx::scene::Scene;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::mpsc::sync_channel;

/// How samples for a screen are made of radiance.
#[derive(Debug, Args)]
pub struct GradeArgs {
    /// Stops by which PNG and JPEG pictures are lighter (or darker, as in --exposure=-1.5)
    #[arg(long, value_name = "STOPS", value_parser = parse_exposure)]
    pub exposure: Option<f32>,
    /// Bits of a PNG's samples: 8 or 16 [default: 8]
    #[arg(long, value_name = "N", value_parser = parse_depth)]
    pub bits: Option<Depth>,
}

fn parse_exposure(text: &str) -> Result<f32, String> {
    let stops: Option<f32> = text.parse().ok();
    stops
        .filter(|stops| stops.abs() <= 100.0)
        .ok_or_else(|| "expected stops from -100 to 100, as in 0.5".to_owned())
}

fn parse_depth(text: &str) -> Result<Depth, String> {
    match text {
        "8" => Ok(Depth::Eight),
        "16" => Ok(Depth::Sixteen),
        _ => Err("expected 8 or 16".to_owned()),
    }
}

/// Longest side of a JPEG.
const JPEG_SIDE: u32 = 65_535;

/// What a picture's name says of it; refuses one whose ending no format has, for the given reason of asking.
pub fn format_of(path: &Path, origin: &str) -> Result<Format, Failure> {
    Format::of(path).ok_or_else(|| {
        let endings = Format::ENDINGS.map(|(ending, _)| format!(".{ending}"));
        Failure::Usage(format!(
            "{origin} {}: the name must end in one of {}, which says what is written",
            path.display(),
            endings.join(", ")
        ))
    })
}

/// A picture file to be.
#[derive(Clone, Debug)]
pub struct Target {
    pub path: PathBuf,
    pub file: PictureFile,
}

impl Target {
    /// Refuses what the format has no use for: nobody should wonder why it did nothing.
    pub fn new(
        path: PathBuf,
        format: Format,
        args: &GradeArgs,
        picture: &PictureArgs,
        scene: &Scene,
        settings: &Settings,
    ) -> Result<Target, Failure> {
        let name = path.display();
        let asked = [
            ("--exposure", args.exposure.is_some()),
            ("--transfer", picture.transfer.is_some()),
            ("--quantize", picture.quantize.is_some()),
        ];
        if let (true, Some((option, _))) = (format.is_linear(), asked.iter().find(|(_, on)| *on)) {
            return Err(Failure::Usage(format!(
                "{option} is for PNG and JPEG: {name} holds radiance as it is"
            )));
        }
        if args.bits.is_some() && format != Format::Png {
            return Err(Failure::Usage(format!(
                "--bits is for PNG, and {name} is none: leave it out"
            )));
        }
        let grade = Grade {
            exposure: args.exposure.unwrap_or(0.0),
            tone: picture.tone(scene),
        };
        Target::fitting(
            path,
            format,
            grade,
            args.bits.unwrap_or_default(),
            settings.window(),
            settings.aovs,
        )
    }

    /// A file of a window, which the format must be able to hold.
    pub fn fitting(
        path: PathBuf,
        format: Format,
        grade: Grade,
        depth: Depth,
        window: Tile,
        aovs: Aovs,
    ) -> Result<Target, Failure> {
        if !aovs.is_empty() && format != Format::Exr {
            return Err(Failure::Usage(format!(
                "--aov is for OpenEXR, and {} is none: name it .exr",
                path.display()
            )));
        }
        let Tile { width, height, .. } = window;
        let longest = width.max(height);
        if format == Format::Jpeg && longest > JPEG_SIDE {
            return Err(Failure::Usage(format!(
                "{}: the sides of a JPEG are {JPEG_SIDE} pixels at most, not {longest}: write a PNG",
                path.display()
            )));
        }
        let file = PictureFile {
            width,
            height,
            format,
            aovs,
            grade,
            depth,
        };
        Ok(Target { path, file })
    }

    /// Writes bands as they are made, on a thread of its own; `make` is given what takes them.
    pub fn write_while<T>(
        &self,
        make: impl FnOnce(&mut dyn FnMut(Film) -> bool) -> Result<T, BandsError>,
    ) -> Result<T, Failure> {
        // No band waits: one is being made, one is being written.
        let (send, receive) = sync_channel::<io::Result<Film>>(0);
        std::thread::scope(|scope| {
            let write = || save_bands(&self.path, &self.file, receive);
            let writer = std::thread::Builder::new()
                .spawn_scoped(scope, write)
                .map_err(|e| Failure::Runtime(format!("cannot start a thread: {e}")))?;
            let made = make(&mut |film| send.send(Ok(film)).is_ok());
            drop(send);
            let written = writer
                .join()
                .unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            match (made, written) {
                // Nobody took the bands, and that is why.
                (Err(BandsError::Unwanted), Err(error)) => Err(error.into()),
                (Err(error), _) => Err(error.into()),
                (Ok(_), Err(error)) => Err(error.into()),
                (Ok(done), Ok(())) => Ok(done),
            }
        })
    }
}
