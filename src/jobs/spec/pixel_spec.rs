//! Options other than the scene that change pixels. Shared by `render` and `verify`, because
//! `verify` covers all of them.

#[cfg(feature = "clap")]
use super::headings;
use super::numbers::{
    parse_aperture, parse_distance, parse_number, parse_size, parse_threshold, parse_weight,
};
use super::options::{fields, option_text};
use crate::field_error::FieldError;
#[cfg(feature = "clap")]
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use phalanx_files::shown_text;
use phalanx_render::frame::{
    Adaptive, Aov, Aovs, Filter, Integrator, Lens, MAX_SPP, Sampling, Settings, Tile,
};
use phalanx_scene::{MAX_DEPTH_LIMIT, MAX_SIDE, Scene};
use serde::{Deserialize, Serialize};

/// Default of `--spp` with `--aa adaptive`.
const ADAPTIVE_SPP: u32 = 256;

/// Default of `--threshold`.
const THRESHOLD: f32 = 0.002;

/// Names of `--aa`, and their help.
const ANTI_ALIASING: [(&str, &str); 2] = [
    ("uniform", "The same number for every pixel"),
    ("adaptive", "More at edges, highlights and reflections"),
];

/// Names of `--integrator`, and their help.
const INTEGRATORS: [(&str, &str); 2] = [
    ("whitted", "Shading, shadows, mirror and refracted rays"),
    ("ao", "Ambient occlusion"),
];

/// Options that change pixels. Options not given have a default, or are taken from the scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "clap", derive(clap::Args), command(next_help_heading = headings::QUALITY))]
pub struct PixelSpec {
    /// Samples per pixel [default: 1; 4 for bare meshes]
    ///
    /// Camera rays per pixel, 1 to 65536; the maximum with --aa adaptive, best a power of two. A
    /// single sample goes through the pixel's centre, several are spread over the filter. [default:
    /// 1; 4 for a mesh without a camera in its file, and without lights; 256 with --aa adaptive]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SPP))))]
    pub spp: Option<u32>,
    /// Anti-aliasing: uniform (default) or adaptive
    ///
    /// Distribution of samples: the same number for every pixel (uniform), or more where they help
    /// most (adaptive): at edges, highlights and reflections.
    #[cfg_attr(feature = "clap", arg(long, value_name = "MODE", hide_possible_values = true, value_parser = described(&ANTI_ALIASING)))]
    pub aa: Option<String>,
    /// Noise at which --aa adaptive stops [default: 0.002]
    ///
    /// Smallest worthwhile improvement by another sample, in radiance. Lower values are better and
    /// slower; 0.001 is about as good as 64 uniform samples per pixel.
    #[cfg_attr(feature = "clap", arg(long, value_name = "T", hide_short_help = true, requires = "aa", value_parser = parse_threshold))]
    pub threshold: Option<f32>,
    /// Pixel filter: box (default), tent or mitchell
    ///
    /// Weighting of a pixel's samples: box covers the pixel's square, tent reaches into its
    /// neighbours, and mitchell (Mitchell's cubic) is sharper.
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME", hide_possible_values = true, value_parser = PossibleValuesParser::new(Filter::ALL.map(|(name, _)| name))))]
    pub filter: Option<String>,
    /// Maximum number of bounces [default: the scene's]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=i64::from(MAX_DEPTH_LIMIT))))]
    pub max_depth: Option<u32>,
    /// Minimum weight of mirror and refracted rays
    ///
    /// Mirror and refracted rays below this weight are not traced; 0 traces all. The weight is the
    /// product of Ks and Kt along the path, each divided by Ks + Kt where that exceeds 1, in its
    /// largest component. [default: 0 for a maximum depth of up to 10, else 1/4096; always 1/4096
    /// for scenes with opacity below 1]
    #[cfg_attr(feature = "clap", arg(long, value_name = "W", hide_short_help = true, value_parser = parse_weight))]
    pub min_weight: Option<f32>,
    /// Lens diameter, for depth of field
    ///
    /// In the scene's units. Anything out of focus is blurred; a higher --spp reduces the noise.
    /// [default: pinhole]
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIAMETER", help_heading = headings::CAMERA, requires = "focus", value_parser = parse_aperture))]
    pub aperture: Option<f32>,
    /// Focus distance, for depth of field
    ///
    /// Distance of the plane in focus along the viewing direction, in the scene's units.
    #[cfg_attr(feature = "clap", arg(long, value_name = "DISTANCE", help_heading = headings::CAMERA, requires = "aperture", value_parser = parse_distance))]
    pub focus: Option<f32>,
    /// whitted (default), or ao (ambient occlusion)
    ///
    /// whitted: direct light with shadows, mirror and refracted rays. ao: ambient occlusion, the
    /// fraction of open sky above each point; best with --spp 64 or more. [default: whitted]
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME", hide_possible_values = true, value_parser = described(&INTEGRATORS)))]
    pub integrator: Option<String>,
    /// Maximum distance of occluders for --integrator ao
    ///
    /// In the scene's units. [default: unlimited]
    #[cfg_attr(feature = "clap", arg(long, value_name = "DISTANCE", hide_short_help = true, value_parser = parse_distance))]
    pub ao_distance: Option<f32>,
    /// Picture size in pixels [default: the scene's]
    #[cfg_attr(feature = "clap", arg(long, value_name = "WxH", help_heading = headings::OUTPUT, value_parser = parse_size))]
    pub size: Option<(u32, u32)>,
    /// Render only this part of the picture
    ///
    /// Column and row of the region's top left pixel, then its width and height, all in pixels.
    #[cfg_attr(feature = "clap", arg(long, num_args = 4, value_names = ["X", "Y", "W", "H"], help_heading = headings::OUTPUT, hide_short_help = true))]
    pub region: Option<Vec<u32>>,
    /// EXR layers: Z, N, albedo, …, or all; PNG: alpha
    ///
    /// AOVs (arbitrary output variables) to write as layers of an OpenEXR file, separated by
    /// commas: depth (Z), position (P), ng (Ng), ns (N: shading normals), albedo, material,
    /// primitive, direct, reflection, refraction, samples, crypto_object, crypto_material
    /// (Cryptomatte), or all of these. Not included in all: alpha (A), which makes the background
    /// black and transparent, and cost (BVH nodes visited by the first camera ray; depends on the
    /// build). PNG output takes alpha alone, and gets straight (unassociated) alpha.
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAMES", help_heading = headings::OUTPUT, value_delimiter = ',', hide_possible_values = true, value_parser = aov_parser()))]
    pub aov: Vec<String>,
}

impl PixelSpec {
    /// The options that give these settings, written out in full: settings that make the same
    /// pixels have the same options.
    pub fn of(settings: &Settings) -> PixelSpec {
        let Settings {
            width,
            height,
            region: _,
            aovs,
            max_depth,
            // The same weight gives the same picture, whether it was given or is the default.
            min_weight: _,
            sampling:
                Sampling {
                    spp,
                    filter,
                    adaptive,
                },
            lens,
            integrator,
            // These change no bit of a pixel.
            threads: _,
            pin: _,
            tile: _,
            engine: _,
            kernel: _,
            record_hits: _,
        } = *settings;
        let [uniform, adaptively] = ANTI_ALIASING.map(|(name, _)| name);
        let [whitted, occlusion] = INTEGRATORS.map(|(name, _)| name);
        let (integrator, distance) = match integrator {
            Integrator::Whitted => (whitted, None),
            Integrator::Occlusion { distance } => (occlusion, Some(distance)),
        };
        let aa = adaptive.map_or(uniform, |_| adaptively);
        let window = settings.window();
        let region = [window.x, window.y, window.width, window.height];
        let layers = Aov::ALL.iter().filter(|(_, aov)| aovs.has(*aov));
        PixelSpec {
            spp: Some(spp),
            aa: Some(aa.to_owned()),
            threshold: adaptive.map(|adaptive| adaptive.threshold),
            filter: Some(filter.name().to_owned()),
            max_depth: Some(max_depth),
            min_weight: Some(settings.min_path_weight()),
            aperture: lens.map(|lens| lens.aperture),
            focus: lens.map(|lens| lens.focus),
            integrator: Some(integrator.to_owned()),
            ao_distance: distance.filter(|distance| distance.is_finite()),
            size: Some((width, height)),
            region: (window != Tile::whole(width, height)).then(|| region.to_vec()),
            aov: layers.map(|(name, _)| (*name).to_owned()).collect(),
        }
    }

    /// These options applied to the scene's settings, for the packet engine on one thread.
    pub fn settings(&self, scene: &Scene) -> Settings {
        let (width, height) = self.size.unwrap_or((scene.width, scene.height));
        let adaptive = self.aa.as_deref() == Some(ANTI_ALIASING[1].0);
        let mut filters = Filter::ALL.iter();
        let filter = filters.find(|(name, _)| self.filter.as_deref() == Some(*name));
        let lens = self.aperture.zip(self.focus);
        let default = Settings::of(scene);
        Settings {
            width,
            height,
            region: self.part(),
            max_depth: self.max_depth.unwrap_or(scene.max_depth),
            min_weight: self.min_weight.or(default.min_weight),
            sampling: Sampling {
                spp: self
                    .spp
                    .unwrap_or(if adaptive { ADAPTIVE_SPP } else { default.sampling.spp }),
                filter: filter.map_or(Filter::Box, |(_, filter)| *filter),
                adaptive: adaptive.then(|| Adaptive {
                    threshold: self.threshold.unwrap_or(THRESHOLD),
                }),
            },
            lens: lens.map(|(aperture, focus)| Lens { aperture, focus }),
            integrator: if self.is_occlusion() {
                Integrator::Occlusion {
                    distance: self.ao_distance.unwrap_or(f32::INFINITY),
                }
            } else {
                Integrator::Whitted
            },
            aovs: self.aovs(),
            ..default
        }
    }

    fn is_occlusion(&self) -> bool {
        self.integrator.as_deref() == Some(INTEGRATORS[1].0)
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
        let named = self.aov.iter().map(|name| match Aov::named(name) {
            Some(aov) => Aovs::default().with(aov),
            // Alpha changes radiance, so it must be requested by name.
            None if name == ALL_AOVS => Aovs::all().without(Aov::Alpha),
            None => Aovs::default(),
        });
        named.fold(Aovs::default(), Aovs::and)
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
            Some(asked) if asked.pixels() == 0 || settings.window() != asked => Err(format!(
                "--region {} {} {} {} is outside the picture of {}x{} pixels (columns and rows start at 0)",
                asked.x, asked.y, asked.width, asked.height, settings.width, settings.height
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
        let wrong = |option: &str, text: &str, expected: String| {
            FieldError::new(format!("pixels.{option}"), shown_text(text), expected)
        };
        let (given, settings) = (fields(self), self.settings(&Scene::default()));
        for (option, value) in given.iter().filter(|(_, value)| !value.is_null()) {
            let text = option_text(option, value);
            let checked = match option.as_str() {
                "region" => self.check_region(&settings).map_err(|_| {
                    let Settings { width, height, .. } = settings;
                    format!("column, row, width and height of a part of {width}x{height} pixels")
                }),
                _ => check_number(option, &text),
            };
            checked.map_err(|reason| {
                let expected = reason.strip_prefix("expected ");
                wrong(option, &text, expected.unwrap_or(&reason).to_owned())
            })?;
        }
        // All names are known, and no option is missing.
        let resolved = fields(&PixelSpec::of(&settings));
        match given.iter().zip(&resolved).find(|(a, b)| a != b) {
            Some(((option, value), (_, good))) => {
                let [text, good] = [value, good].map(|value| option_text(option, value));
                Err(wrong(option, &text, format!("a value such as {good}")))
            }
            None => Ok(()),
        }
    }
}

/// Checks the number of an option. Names are checked by what they resolve to.
fn check_number(option: &str, text: &str) -> Result<(), String> {
    match option {
        "size" => match parse_size(text) {
            Ok(_) => Ok(()),
            Err(_) => Err(format!("sides of 1 to {MAX_SIDE} pixels")),
        },
        "spp" => {
            let good = |spp: &u32| (1..=MAX_SPP).contains(spp);
            parse_number(text, good, format!("1 to {MAX_SPP}")).map(drop)
        }
        "max_depth" => {
            let good = |depth: &u32| *depth <= MAX_DEPTH_LIMIT;
            parse_number(text, good, format!("0 to {MAX_DEPTH_LIMIT}")).map(drop)
        }
        "min_weight" => parse_weight(text).map(drop),
        "threshold" => parse_threshold(text).map(drop),
        "aperture" => parse_aperture(text).map(drop),
        "focus" | "ao_distance" => parse_distance(text).map(drop),
        "aa" | "filter" | "integrator" | "aov" => Ok(()),
        // Refuses every plan until a new number has its limits above.
        _ => Err("an option with limits".to_owned()),
    }
}

/// Value of `--aov` for all layers except alpha and cost.
const ALL_AOVS: &str = "all";

#[cfg(feature = "clap")]
fn aov_parser() -> impl TypedValueParser<Value = String> {
    let named = |first: &'static (&str, Aov)| {
        let others = Aov::OTHER_NAMES.iter().filter(|(_, aov)| *aov == first.1);
        std::iter::once(first).chain(others).map(|(name, _)| *name)
    };
    PossibleValuesParser::new(Aov::ALL.iter().flat_map(named).chain([ALL_AOVS]))
}

/// A parser for a fixed set of names with help texts.
#[cfg(feature = "clap")]
pub(super) fn described(names: &[(&'static str, &'static str)]) -> PossibleValuesParser {
    let names = names.iter();
    PossibleValuesParser::new(names.map(|(name, help)| PossibleValue::new(*name).help(*help)))
}

#[cfg(test)]
mod tests;
