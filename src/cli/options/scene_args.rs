//! The scene of a command: its format, overrides and memory limit.

use super::format_args::{FormatName, format_parser, only};
use crate::cli::output::CliError;
use clap::Args;
use phalanx::formats::Options;
use phalanx::image::ImageFormat;
use phalanx::jobs::spec::headings::SCENE;
use phalanx::jobs::{EncodingSpec, PictureSpec, PixelSpec, RenderPlan, SceneOverrides};

/// Options of every command that opens a scene.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = SCENE)]
pub struct SceneArgs {
    #[command(flatten)]
    pub overrides: SceneOverrides,
    /// Format of the scene or the picture
    ///
    /// Overrides the extension: a scene format that of the scene (required for stdin, -), a picture
    /// format that of the picture. One of each may be given, as in --format obj --format exr
    #[arg(long, value_name = "NAME", hide_short_help = true, value_parser = format_parser())]
    pub format: Vec<FormatName>,
    /// Memory limit, as in 2G [default: none]
    ///
    /// Stop with an error before a step that is likely to need more memory than this, as in 500M,
    /// 2G (powers of 1000) or 2GiB (powers of 1024). Needs are estimated from the sizes of the
    /// input files, the scene and the picture.
    #[arg(long, value_name = "SIZE", value_parser = parse_memory)]
    pub max_memory: Option<u64>,
}

/// The properties of the picture that a default camera depends on.
#[derive(Clone, Copy, Debug, Default)]
pub struct WantedPicture {
    /// Its size; `None` for the scene's.
    pub size: Option<(u32, u32)>,
    /// True if the camera goes around the scene.
    pub turntable: bool,
}

impl SceneArgs {
    /// The requested format of the scene.
    pub fn scene_format(&self) -> Result<Option<&'static str>, CliError> {
        only(&self.format, "the scene", |name| match name {
            FormatName::Scene(ending) => Some(*ending),
            FormatName::Picture(_) => None,
        })
    }

    /// The requested format of the picture.
    pub fn picture_format(&self) -> Result<Option<ImageFormat>, CliError> {
        only(&self.format, "the picture", |name| match name {
            FormatName::Picture(format) => Some(*format),
            FormatName::Scene(_) => None,
        })
    }

    /// Refuses a picture format for a command that writes no picture.
    pub fn no_picture(&self) -> Result<(), CliError> {
        match self.picture_format()? {
            None => Ok(()),
            Some(_) => Err(CliError::Usage(
                "--format names a picture format, but this command writes no picture".to_owned(),
            )),
        }
    }

    /// The description of a picture of the scene of this name with these options.
    pub fn picture(
        &self,
        name: impl Into<String>,
        pixels: &PixelSpec,
        encoding: &EncodingSpec,
    ) -> Result<PictureSpec, CliError> {
        Ok(PictureSpec {
            scene: name.into(),
            format: self.scene_format()?.map(str::to_owned),
            overrides: self.overrides.clone(),
            pixels: pixels.clone(),
            encoding: encoding.clone(),
        })
    }

    /// The scene options of a planned picture.
    pub fn of_plan(plan: &RenderPlan) -> SceneArgs {
        let format = plan.spec.format.iter();
        SceneArgs {
            overrides: plan.spec.overrides.clone(),
            format: format.filter_map(|name| FormatName::named(name)).collect(),
            max_memory: plan.work.max_memory,
        }
    }

    /// Options for opening a scene for this picture.
    pub fn options(&self, picture: WantedPicture, threads: usize) -> Result<Options, CliError> {
        let mut options = self.overrides.options().map_err(CliError::Usage)?;
        options.look.size = picture.size;
        options.look.turntable = picture.turntable;
        options.read.threads = threads;
        Ok(options)
    }
}

fn parse_memory(text: &str) -> Result<u64, String> {
    let bytes = parse_size::parse_size(text).ok().filter(|&bytes| bytes > 0);
    bytes.ok_or_else(|| "expected a size in bytes, as in 500M, 2G or 2GiB".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_units() {
        assert_eq!(parse_memory("2G"), Ok(2_000_000_000));
        assert_eq!(parse_memory("2GiB"), Ok(2 << 30));
        assert_eq!(parse_memory("500 MB"), Ok(500_000_000));
        assert_eq!(parse_memory("1.5k"), Ok(1500));
        for bad in ["", "0", "-1", "much", "1X", "1e400"] {
            assert!(parse_memory(bad).is_err(), "{bad}");
        }
    }
}
