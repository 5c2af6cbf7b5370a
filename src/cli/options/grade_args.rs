//! The options that say how samples for a screen are made of radiance.

use super::headings::OUTPUT;
use super::parsers::parse_number;
use super::picture_args::PictureArgs;
use crate::cli::output::{CliError, OutputFile};
use clap::Args;
use phalanx::files::shown_path;
use phalanx::frame::Settings;
use phalanx::image::{Depth, Exposure, ImageFormat, MAX_EXPOSURE};
use phalanx::scene::Scene;
use std::path::PathBuf;

/// How samples for a screen are made of radiance.
#[derive(Debug, Args)]
#[command(next_help_heading = OUTPUT)]
pub struct GradeArgs {
    /// Stops by which PNG and JPEG are lighter
    ///
    /// Stops by which PNG and JPEG pictures are lighter (or darker, as in --exposure=-1.5).
    #[arg(long, value_name = "STOPS", hide_short_help = true, value_parser = parse_exposure)]
    pub exposure: Option<f32>,
    /// Bits of a PNG's samples: 8 or 16 [default: 8]
    #[arg(long, value_name = "N", hide_short_help = true, value_parser = parse_depth)]
    pub bits: Option<Depth>,
}

fn parse_exposure(text: &str) -> Result<f32, String> {
    let expected = format!("stops from -{MAX_EXPOSURE} to {MAX_EXPOSURE}, as in 0.5");
    parse_number(text, |stops: &f32| stops.abs() <= MAX_EXPOSURE, expected)
}

fn parse_depth(text: &str) -> Result<Depth, String> {
    match text {
        "8" => Ok(Depth::Eight),
        "16" => Ok(Depth::Sixteen),
        _ => Err("expected 8 or 16".to_owned()),
    }
}

impl GradeArgs {
    /// The file that a picture is written to. Refuses options that the format does not use, so
    /// that none is silently ignored.
    pub fn output_file(
        &self,
        path: PathBuf,
        format: ImageFormat,
        picture: &PictureArgs,
        scene: &Scene,
        settings: &Settings,
    ) -> Result<OutputFile, CliError> {
        let name = shown_path(&path);
        let asked = [
            ("--exposure", self.exposure.is_some()),
            ("--transfer", picture.transfer.is_some()),
            ("--quantize", picture.quantize.is_some()),
        ];
        if let (true, Some((option, _))) = (format.is_linear(), asked.iter().find(|(_, on)| *on)) {
            return Err(CliError::Usage(format!(
                "{option} is for PNG and JPEG: {name} holds radiance as it is"
            )));
        }
        if self.bits.is_some() && format != ImageFormat::Png {
            return Err(CliError::Usage(format!(
                "--bits is for PNG, and {name} is none: leave it out"
            )));
        }
        let exposure = Exposure {
            stops: self.exposure.unwrap_or(0.0),
            encoding: picture.tone(scene),
        };
        OutputFile::for_picture(
            path,
            format,
            exposure,
            self.bits.unwrap_or_default(),
            (settings.window(), (settings.width, settings.height)),
            (settings.aovs, scene.origin),
        )
    }
}
