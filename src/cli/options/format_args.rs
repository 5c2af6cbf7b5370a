//! `--format`: overrides the format implied by a file name.

use crate::cli::output::CliError;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use phalanx::formats::endings;
use phalanx::image::ImageFormat;
use std::path::Path;

/// A format name. No scene format shares its name with a picture format, so one option takes both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FormatName {
    /// A scene format, named for its file extension.
    Scene(&'static str),
    /// A picture format.
    Picture(ImageFormat),
}

/// The scene format of a file name's extension.
pub fn ending_of(name: &Path) -> Option<&'static str> {
    let ending = name.extension()?;
    endings().find(|known| ending.eq_ignore_ascii_case(known))
}

/// A parser for the names of all formats.
pub fn format_parser() -> impl TypedValueParser<Value = FormatName> {
    let pictures = ImageFormat::ENDINGS.map(|(name, _)| name);
    PossibleValuesParser::new(endings().chain(pictures))
        .try_map(|name| FormatName::named(&name).ok_or("an unknown name"))
}

impl FormatName {
    /// The format of this name, if there is one.
    pub fn named(name: &str) -> Option<FormatName> {
        let mut pictures = ImageFormat::ENDINGS.iter();
        let picture = pictures.find(|(ending, _)| *ending == name);
        let scene = || endings().find(|ending| *ending == name);
        match picture {
            Some((_, format)) => Some(FormatName::Picture(*format)),
            None => scene().map(FormatName::Scene),
        }
    }
}

/// The format that `pick` finds among names; at most one is allowed.
pub fn only<T>(
    names: &[FormatName],
    what: &str,
    pick: impl Fn(&FormatName) -> Option<T>,
) -> Result<Option<T>, CliError> {
    let mut picked = names.iter().filter_map(pick);
    let first = picked.next();
    match picked.next() {
        None => Ok(first),
        Some(_) => Err(CliError::Usage(format!(
            "--format names two formats for {what}: give only one"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::super::scene_args::SceneArgs;
    use super::*;

    /// Checks that the names differ, because one option takes both.
    #[test]
    fn no_scene_format_is_called_as_a_picture_format_is() {
        for (picture, _) in ImageFormat::ENDINGS {
            assert!(endings().all(|scene| scene != picture), "{picture}");
        }
    }

    #[test]
    fn each_kind_of_format_is_found_among_the_names() {
        let names = [
            FormatName::Scene("obj"),
            FormatName::Picture(ImageFormat::Exr),
            FormatName::Scene("ply"),
        ];
        let args_of = |names: &[FormatName]| SceneArgs {
            format: names.to_vec(),
            ..SceneArgs::default()
        };
        assert_eq!(args_of(&names[..2]).scene_format().unwrap(), Some("obj"));
        let picture = args_of(&names).picture_format().unwrap();
        assert_eq!(picture, Some(ImageFormat::Exr));
        assert_eq!(args_of(&names[2..]).picture_format().unwrap(), None);
        assert!(args_of(&names).scene_format().is_err());
    }
}
