//! The file that a picture is written to: its format by its name, and what may be asked of that.

use super::failure::Failure;
use super::interrupt;
use super::picture_args::PictureArgs;
use clap::Args;
use phalanx::frame::Settings;
use phalanx::image::{Depth, Format, Grade, save};
use phalanx::render::Film;
use phalanx::scene::Scene;
use std::path::{Path, PathBuf};

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
#[derive(Debug)]
pub struct PictureFile {
    pub path: PathBuf,
    format: Format,
    grade: Grade,
    depth: Depth,
}

impl PictureFile {
    /// Refuses what the format has no use for: nobody should wonder why it did nothing.
    pub fn new(
        path: PathBuf,
        format: Format,
        args: &GradeArgs,
        picture: &PictureArgs,
        scene: &Scene,
        settings: &Settings,
    ) -> Result<PictureFile, Failure> {
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
        let longest = settings.width.max(settings.height);
        if format == Format::Jpeg && longest > JPEG_SIDE {
            return Err(Failure::Usage(format!(
                "{name}: the sides of a JPEG are {JPEG_SIDE} pixels at most, not {longest}: write a PNG"
            )));
        }
        Ok(PictureFile {
            format,
            grade: Grade {
                exposure: args.exposure.unwrap_or(0.0),
                tone: picture.tone(scene),
            },
            depth: args.bits.unwrap_or_default(),
            path,
        })
    }

    /// Writes a finished film.
    pub fn write(&self, film: &Film) -> Result<(), Failure> {
        let PictureFile {
            path,
            format,
            grade,
            depth,
        } = self;
        Ok(interrupt::undisturbed(|| {
            save(path, film, *format, *grade, *depth)
        })??)
    }
}
