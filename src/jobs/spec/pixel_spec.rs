//! Options other than the scene that change pixels. Shared by `render` and `verify`, because
//! `verify` covers all of them.
//!
//! An option is one row of the table below, and rows have the order of help and of JSON, on which
//! the checksums of keys depend:
//!
//! ```text
//! /// Help
//! #[words for clap]
//! name: type, place in commands and messages, form in commands, value in settings,
//!     sets what it sets, limited to what a parser reads;
//! ```

use super::as_text::AsText;
#[cfg(feature = "clap")]
use super::as_text::{ALL_AOVS, names};
#[cfg(feature = "clap")]
use super::headings;
use super::numbers::{
    parse_aperture, parse_distance, parse_in, parse_size, parse_threshold, parse_weight,
};
use super::option_row::OptionForm::{List, Words};
use super::option_row::OptionRow;
use crate::field_error::FieldError;
use phalanx_files::shown_text;
use phalanx_render::frame::{
    Adaptive, Aov, Aovs, Filter, Integrator, Lens, MAX_SPP, Settings, Tile,
};
use phalanx_scene::{MAX_DEPTH_LIMIT, MAX_SIDE, Scene};
use serde::{Deserialize, Serialize};

/// Default of `--spp` with `--aa adaptive`.
const ADAPTIVE_SPP: u32 = 256;

/// Default of `--threshold`.
const THRESHOLD: f32 = 0.002;

/// Distribution of samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum AntiAliasing {
    /// The same number for every pixel
    #[default]
    Uniform,
    /// More at edges, highlights and reflections
    Adaptive,
}

/// Name of the quantity that is computed at a hit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum IntegratorName {
    /// Shading, shadows, mirror and refracted rays
    #[default]
    Whitted,
    /// Ambient occlusion
    Ao,
}

/// Makes a struct of the rows of its options, and the functions that go through them.
macro_rules! pixel_options {
    ($($(#[$attribute:meta])* $name:ident: $Type:ty, $place:literal, $form:expr, $get:expr
        $(, sets $set:expr)? $(, limited to $parse:expr)?;)*) => {
        /// Options that change pixels. Options not given have a default, or are taken from the
        /// scene.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        #[serde(deny_unknown_fields)]
        #[cfg_attr(feature = "clap", derive(clap::Args), command(next_help_heading = headings::QUALITY))]
        pub struct PixelSpec {
            $($(#[$attribute])* pub $name: $Type,)*
        }

        impl PixelSpec {
            /// The options that give these settings, written out in full: settings that make the
            /// same pixels have the same options.
            pub fn of(settings: &Settings) -> PixelSpec {
                $(let $name: fn(&Settings) -> $Type = $get;)*
                PixelSpec { $($name: $name(settings),)* }
            }

            /// These options applied to the scene's settings, for the packet engine on one thread.
            pub fn settings(&self, scene: &Scene) -> Settings {
                let mut settings = Settings::of(scene);
                $($(let set: fn(&PixelSpec, &mut Settings, &Scene) = $set; set(self, &mut settings, scene);)?)*
                settings
            }

            /// The options in the order of commands and messages.
            pub(crate) fn rows(&self) -> Vec<OptionRow> {
                let mut rows = [$(
                    ($place, OptionRow::new(stringify!($name), $form, &self.$name)),
                )*];
                rows.sort_by_key(|(place, _)| *place);
                rows.into_iter().map(|(_, row)| row).collect()
            }

            /// Parses the text of an option, and returns the expected values if it has none of
            /// them. Names are checked where they are read.
            fn check_limits(&self, row: &OptionRow) -> Result<(), String> {
                match row.field {
                    $($(stringify!($name) => $parse(&row.text()).map(drop),)?)*
                    _ => Ok(()),
                }
            }
        }
    };
}

pixel_options! {
    /// Samples per pixel [default: 4; .test, NFF: 1]
    ///
    /// Camera rays per pixel, 1 to 65536; the maximum with --aa adaptive, best a power of two. A
    /// single sample goes through the pixel's centre, several are spread over the filter. [default:
    /// 4; 1 for .test, NFF and standard scenes; 256 with --aa adaptive]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SPP))))]
    spp: Option<u32>, 60, Words,
        |s| Some(s.sampling.spp),
        sets |o, s, _| {
            let default = if o.is_adaptive() { ADAPTIVE_SPP } else { s.sampling.spp };
            s.sampling.spp = o.spp.unwrap_or(default);
        },
        limited to |text| parse_in(text, 1..=MAX_SPP);
    /// Anti-aliasing: uniform (default) or adaptive
    ///
    /// Distribution of samples: the same number for every pixel (uniform), or more where they help
    /// most (adaptive): at edges, highlights and reflections.
    #[cfg_attr(feature = "clap", arg(long, value_name = "MODE", hide_possible_values = true))]
    aa: Option<AntiAliasing>, 80, Words,
        |s| Some(s.sampling.adaptive.map_or(AntiAliasing::Uniform, |_| AntiAliasing::Adaptive)),
        sets |o, s, _| {
            let threshold = o.threshold.unwrap_or(THRESHOLD);
            s.sampling.adaptive = o.is_adaptive().then_some(Adaptive { threshold });
        };
    /// Noise at which --aa adaptive stops [default: 0.002]
    ///
    /// Smallest worthwhile improvement by another sample, in radiance. Lower values are better and
    /// slower; 0.001 is about as good as 64 uniform samples per pixel.
    #[cfg_attr(feature = "clap", arg(long, value_name = "T", hide_short_help = true, requires = "aa", value_parser = parse_threshold))]
    threshold: Option<f32>, 90, Words,
        |s| s.sampling.adaptive.map(|adaptive| adaptive.threshold),
        limited to parse_threshold;
    /// Pixel filter: box (default), tent or mitchell
    ///
    /// Weighting of a pixel's samples: box covers the pixel's square, tent reaches into its
    /// neighbours, and mitchell (Mitchell's cubic) is sharper.
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME", hide_short_help = true, hide_possible_values = true, value_parser = names::<Filter>(Filter::ALL.map(|(name, _)| name))))]
    filter: Option<AsText<Filter>>, 70, Words,
        |s| Some(AsText(s.sampling.filter)),
        sets |o, s, _| s.sampling.filter = o.filter.unwrap_or(AsText(Filter::Box)).0;
    /// Maximum number of bounces [default: the scene's]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=i64::from(MAX_DEPTH_LIMIT))))]
    max_depth: Option<u32>, 40, Words,
        |s| Some(s.max_depth),
        sets |o, s, _| s.max_depth = o.max_depth.unwrap_or(s.max_depth),
        limited to |text| parse_in(text, 0..=MAX_DEPTH_LIMIT);
    /// Minimum weight of mirror and refracted rays
    ///
    /// Mirror and refracted rays below this weight are not traced; 0 traces all. The weight is the
    /// product of Ks and Kt along the path, each divided by Ks + Kt where that exceeds 1, in its
    /// largest component. [default: 0 for a maximum depth of up to 10, else 1/4096; always 1/4096
    /// for scenes with opacity below 1]
    #[cfg_attr(feature = "clap", arg(long, value_name = "W", hide_short_help = true, value_parser = parse_weight))]
    min_weight: Option<f32>, 50, Words,
        // The same weight gives the same picture, whether it was given or is the default.
        |s| Some(s.min_path_weight()),
        sets |o, s, _| s.min_weight = o.min_weight.or(s.min_weight),
        limited to parse_weight;
    /// Lens diameter, for depth of field
    ///
    /// In the scene's units. Anything out of focus is blurred; a higher --spp reduces the noise.
    /// [default: pinhole]
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIAMETER", hide_short_help = true, help_heading = headings::CAMERA, requires = "focus", value_parser = parse_aperture))]
    aperture: Option<f32>, 100, Words,
        |s| s.lens.map(|lens| lens.aperture),
        sets |o, s, _| {
            let lens = o.aperture.zip(o.focus);
            s.lens = lens.map(|(aperture, focus)| Lens { aperture, focus });
        },
        limited to parse_aperture;
    /// Focus distance, for depth of field
    ///
    /// Distance of the plane in focus along the viewing direction, in the scene's units.
    #[cfg_attr(feature = "clap", arg(long, value_name = "DISTANCE", hide_short_help = true, help_heading = headings::CAMERA, requires = "aperture", value_parser = parse_distance))]
    focus: Option<f32>, 110, Words,
        |s| s.lens.map(|lens| lens.focus),
        limited to parse_distance;
    /// whitted (default), or ao (ambient occlusion)
    ///
    /// whitted: direct light with shadows, mirror and refracted rays. ao: ambient occlusion, the
    /// fraction of open sky above each point; best with --spp 64 or more. [default: whitted]
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME", hide_possible_values = true))]
    integrator: Option<IntegratorName>, 120, Words,
        |s| Some(match s.integrator {
            Integrator::Whitted => IntegratorName::Whitted,
            Integrator::Occlusion { .. } => IntegratorName::Ao,
        }),
        sets |o, s, scene| s.integrator = match o.ao_distance {
            _ if !o.is_occlusion() => Integrator::Whitted,
            Some(AsText(distance)) => Integrator::Occlusion { distance },
            None => Integrator::occlusion(scene),
        };
    /// Reach of ao [default: a tenth of the scene]
    ///
    /// Maximum distance of occluders, in the scene's units; inf for no limit, which leaves closed
    /// rooms black. [default: a tenth of the diagonal of the scene's bounds, to two digits]
    #[cfg_attr(feature = "clap", arg(long, value_name = "DISTANCE", value_parser = AsText::<f32>::parse))]
    ao_distance: Option<AsText<f32>>, 130, Words,
        |s| match s.integrator {
            Integrator::Occlusion { distance } => Some(AsText(distance)),
            Integrator::Whitted => None,
        };
    /// Picture size in pixels [default: the scene's]
    #[cfg_attr(feature = "clap", arg(long, value_name = "WxH", help_heading = headings::OUTPUT, value_parser = parse_size))]
    size: Option<(u32, u32)>, 10, List("x"),
        |s| Some((s.width, s.height)),
        sets |o, s, _| (s.width, s.height) = o.size.unwrap_or((s.width, s.height)),
        limited to planned_size;
    /// Render only this part of the picture
    ///
    /// Column and row of the region's top left pixel, then its width and height, all in pixels.
    #[cfg_attr(feature = "clap", arg(long, num_args = 4, value_names = ["X", "Y", "W", "H"], help_heading = headings::OUTPUT, hide_short_help = true))]
    region: Option<Vec<u32>>, 20, Words,
        |s| {
            let Tile { x, y, width, height } = s.window();
            let is_part = (width, height) != (s.width, s.height);
            is_part.then(|| vec![x, y, width, height])
        },
        sets |o, s, _| s.region = o.part();
    /// EXR layers: Z, N, albedo, …, or all; PNG: alpha
    ///
    /// AOVs (arbitrary output variables) to write as layers of an OpenEXR file, separated by
    /// commas: depth (Z), position (P), ng (Ng), ns (N: shading normals), albedo, material,
    /// primitive, direct, reflection, refraction, samples, crypto_object, crypto_material
    /// (Cryptomatte), or all of these. Not included in all: alpha (A), which makes the background
    /// black and transparent, and cost (BVH nodes visited by the first camera ray; depends on the
    /// build). PNG output takes alpha alone, and gets straight (unassociated) alpha.
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAMES", help_heading = headings::OUTPUT, value_delimiter = ',', hide_possible_values = true, value_parser = names::<Aovs>(aov_names())))]
    aov: Vec<AsText<Aovs>>, 30, List(","),
        |s| {
            let layers = Aov::ALL.iter().filter(|(_, aov)| s.aovs.has(*aov));
            layers.map(|(_, aov)| AsText(Aovs::default().with(*aov))).collect()
        },
        sets |o, s, _| s.aovs = o.aovs();
}

impl PixelSpec {
    fn is_adaptive(&self) -> bool {
        self.aa == Some(AntiAliasing::Adaptive)
    }

    fn is_occlusion(&self) -> bool {
        self.integrator == Some(IntegratorName::Ao)
    }

    /// The requested region, which may lie outside the picture; `None` for the whole picture.
    fn part(&self) -> Option<Tile> {
        match *self.region.as_deref()? {
            [x, y, width, height] => Some(Tile {
                x,
                y,
                width,
                height,
            }),
            _ => None,
        }
    }

    /// The part of the picture to render. The size must be given.
    pub fn window(&self) -> Tile {
        let (width, height) = self.size.unwrap_or_default();
        self.part().unwrap_or(Tile::whole(width, height))
    }

    /// The requested layers.
    pub fn aovs(&self) -> Aovs {
        self.aov
            .iter()
            .fold(Aovs::default(), |all, aovs| all.and(aovs.0))
    }

    /// Refuses options that would have no effect.
    ///
    /// # Errors
    /// The option, and the one it requires.
    pub fn check_use(&self) -> Result<(), String> {
        match self.ao_distance {
            Some(_) if !self.is_occlusion() => {
                Err("--ao-distance needs --integrator ao".to_owned())
            }
            _ => Ok(()),
        }
    }

    /// Refuses a region outside the picture of these settings.
    ///
    /// # Errors
    /// The region and the size of the picture.
    pub fn check_region(&self, settings: &Settings) -> Result<(), String> {
        match self.part() {
            Some(wanted) if wanted.pixels() == 0 || settings.window() != wanted => Err(format!(
                "--region {} {} {} {} is outside the picture of {}x{} pixels (columns and rows start at 0)",
                wanted.x, wanted.y, wanted.width, wanted.height, settings.width, settings.height
            )),
            _ => Ok(()),
        }
    }

    /// Checks that [`PixelSpec::of`] could have made these options. The file that they come from is
    /// not trusted.
    ///
    /// # Errors
    /// The first option with an invalid value.
    pub(crate) fn check(&self) -> Result<(), FieldError> {
        let wrong = |row: &OptionRow, expected: String| {
            let (field, text) = (format!("pixels.{}", row.field), row.text());
            Err(FieldError::new(field, shown_text(&text), expected))
        };
        let (rows, settings) = (self.rows(), self.settings(&Scene::default()));
        for row in rows.iter().filter(|row| row.is_given()) {
            if row.field == "region" && self.check_region(&settings).is_err() {
                let Settings { width, height, .. } = settings;
                let picture = format!("{width}x{height} pixels");
                return wrong(
                    row,
                    format!("column, row, width and height of a part of {picture}"),
                );
            }
            if let Err(reason) = self.check_limits(row) {
                return wrong(row, reason.trim_start_matches("expected ").to_owned());
            }
        }
        // No option is missing, and none is without effect.
        let resolved = PixelSpec::of(&settings).rows();
        match rows.iter().zip(&resolved).find(|(row, good)| row != good) {
            Some((row, good)) => wrong(row, format!("a value such as {}", good.text())),
            None => Ok(()),
        }
    }
}

/// Parses the size of a plan's picture.
fn planned_size(text: &str) -> Result<(u32, u32), String> {
    parse_size(text).map_err(|_| format!("sides of 1 to {MAX_SIDE} pixels"))
}

#[cfg(feature = "clap")]
fn aov_names() -> impl Iterator<Item = &'static str> {
    let named = |first: &'static (&str, Aov)| {
        let others = Aov::OTHER_NAMES.iter().filter(|(_, aov)| *aov == first.1);
        std::iter::once(first).chain(others).map(|(name, _)| *name)
    };
    Aov::ALL.iter().flat_map(named).chain([ALL_AOVS])
}

#[cfg(test)]
mod tests;
