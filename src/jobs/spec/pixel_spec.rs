//! Options that pixels depend on, beside the scene. `render` has them and `verify`, because all of
//! them are verified.

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

/// Most camera rays a pixel with `--aa adaptive`, by default.
const ADAPTIVE_SPP: u32 = 256;

/// Default of `--threshold`.
const THRESHOLD: f32 = 0.002;

/// Names of `--aa`, and their help.
const ANTI_ALIASING: [(&str, &str); 2] = [
    ("uniform", "All pixels alike"),
    (
        "adaptive",
        "Where more help most: edges, highlights, reflections",
    ),
];

/// Names of `--integrator`, and their help.
const INTEGRATORS: [(&str, &str); 2] = [
    ("whitted", "Shading, shadows, mirror and refracted rays"),
    ("ao", "Ambient occlusion"),
];

/// Options that change pixels. What is not given is the scene's, or has a default.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "clap", derive(clap::Args), command(next_help_heading = headings::QUALITY))]
pub struct PixelSpec {
    /// Samples per pixel (anti-aliasing) [default: 1]
    ///
    /// Camera rays a pixel, 1 to 65536, or the most of them with --aa adaptive (best a power of
    /// two): one goes through the pixel's centre, more are spread over the filter.
    /// [default: 1; with --aa adaptive 256]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SPP))))]
    pub spp: Option<u32>,
    /// Anti-aliasing: uniform (default), or adaptive
    ///
    /// Which pixels get the samples: all alike (uniform), or those where more help most (adaptive),
    /// at edges, highlights and reflections.
    #[cfg_attr(feature = "clap", arg(long, value_name = "MODE", hide_possible_values = true, value_parser = described(&ANTI_ALIASING)))]
    pub aa: Option<String>,
    /// Noise at which --aa adaptive stops [default: 0.002]
    ///
    /// With --aa adaptive, how much a sample must still help: less is better and takes longer,
    /// 0.001 is about as good as 64 uniform samples per pixel. [default: 0.002]
    #[cfg_attr(feature = "clap", arg(long, value_name = "T", hide_short_help = true, requires = "aa", value_parser = parse_threshold))]
    pub threshold: Option<f32>,
    /// Pixel filter: box (default), tent or mitchell
    ///
    /// The weight of a pixel's samples: its square (box, the default), a tent over its neighbours,
    /// or Mitchell's cubic, which is sharper.
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME", hide_possible_values = true, value_parser = PossibleValuesParser::new(Filter::ALL.map(|(name, _)| name))))]
    pub filter: Option<String>,
    /// Most bounces of a ray [default: the scene's]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=i64::from(MAX_DEPTH_LIMIT))))]
    pub max_depth: Option<u32>,
    /// Least weight of mirror and refracted rays
    ///
    /// Mirror and refracted rays of less weight than this are not traced: the product of Ks and Kt
    /// along the path, each divided by Ks + Kt where that is more than 1, in its largest component.
    /// 0 has all traced. [default: 0 for up to 10 bounces, 1/4096 for more, and where surfaces are
    /// only partly there]
    #[cfg_attr(feature = "clap", arg(long, value_name = "W", hide_short_help = true, value_parser = parse_weight))]
    pub min_weight: Option<f32>,
    /// Depth of field: diameter of the lens
    ///
    /// Diameter of the lens that camera rays come through, in the scene's units: what is not in
    /// focus is blurred, with less noise the more --spp. [default: a pinhole]
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIAMETER", help_heading = headings::CAMERA, requires = "focus", value_parser = parse_aperture))]
    pub aperture: Option<f32>,
    /// Depth of field: distance that is in focus
    ///
    /// Distance of the plane that is in focus, along the direction of view.
    #[cfg_attr(feature = "clap", arg(long, value_name = "DISTANCE", help_heading = headings::CAMERA, requires = "aperture", value_parser = parse_distance))]
    pub focus: Option<f32>,
    /// whitted (default), or ao: ambient occlusion
    ///
    /// Radiance of what camera rays hit: whitted (the default), the light that falls on it, with
    /// shadows, mirror and refracted rays; ao (ambient occlusion), how much of the sky is open
    /// above it, for which --spp 64 and more is meant.
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME", hide_possible_values = true, value_parser = described(&INTEGRATORS)))]
    pub integrator: Option<String>,
    /// Reach of --integrator ao
    ///
    /// Reach of --integrator ao in the scene's units: hits beyond do not count.
    /// [default: everything counts]
    #[cfg_attr(feature = "clap", arg(long, value_name = "DISTANCE", hide_short_help = true, value_parser = parse_distance))]
    pub ao_distance: Option<f32>,
    /// Picture size in pixels [default: the scene's]
    #[cfg_attr(feature = "clap", arg(long, value_name = "WxH", help_heading = headings::OUTPUT, value_parser = parse_size))]
    pub size: Option<(u32, u32)>,
    /// Only this part of the picture
    ///
    /// Column and row of its upper left pixel, width and height.
    #[cfg_attr(feature = "clap", arg(long, num_args = 4, value_names = ["X", "Y", "W", "H"], help_heading = headings::OUTPUT, hide_short_help = true))]
    pub region: Option<Vec<u32>>,
    /// AOVs in an EXR: Z, N, albedo, alpha, …, all
    ///
    /// AOVs (arbitrary output variables) of each pixel, in an OpenEXR file, names separated by
    /// commas: depth (or Z), position (P), ng (Ng), ns (N: normals), albedo, material, primitive,
    /// direct, reflection, refraction, samples, crypto_object, crypto_material (Cryptomatte); or
    /// all of these; or alpha (A), which makes the background black and transparent; or cost (nodes
    /// that the first camera ray visits, by the build).
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAMES", help_heading = headings::OUTPUT, value_delimiter = ',', hide_possible_values = true, value_parser = aov_parser()))]
    pub aov: Vec<String>,
}

impl PixelSpec {
    /// The options that give these settings, all of which are given but where there is nothing to
    /// give: settings that make the same pixels have the same options.
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

    /// The scene's settings with these changes, one thread, and the packet engine.
    pub fn settings(&self, scene: &Scene) -> Settings {
        let (width, height) = self.size.unwrap_or((scene.width, scene.height));
        let adaptive = self.aa.as_deref() == Some(ANTI_ALIASING[1].0);
        let mut filters = Filter::ALL.iter();
        let filter = filters.find(|(name, _)| self.filter.as_deref() == Some(*name));
        let lens = self.aperture.zip(self.focus);
        Settings {
            width,
            height,
            region: self.part(),
            max_depth: self.max_depth.unwrap_or(scene.max_depth),
            min_weight: self.min_weight.or(Settings::of(scene).min_weight),
            sampling: Sampling {
                spp: self.spp.unwrap_or(if adaptive { ADAPTIVE_SPP } else { 1 }),
                filter: filter.map_or(Filter::Box, |(_, filter)| *filter),
                adaptive: adaptive.then(|| Adaptive {
                    threshold: self.threshold.unwrap_or(THRESHOLD),
                }),
            },
            lens: lens.map(|(aperture, focus)| Lens { aperture, focus }),
            integrator: match self.is_occlusion() {
                true => Integrator::Occlusion {
                    distance: self.ao_distance.unwrap_or(f32::INFINITY),
                },
                false => Integrator::Whitted,
            },
            aovs: self.aovs(),
            ..Settings::of(scene)
        }
    }

    fn is_occlusion(&self) -> bool {
        self.integrator.as_deref() == Some(INTEGRATORS[1].0)
    }

    /// The requested part of the picture, wherever it lies; `None` for all of it.
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

    /// The part of the picture that is rendered, of options that name the size.
    pub fn window(&self) -> Tile {
        let (width, height) = self.size.unwrap_or_default();
        self.part().unwrap_or(Tile::whole(width, height))
    }

    /// The requested layers.
    pub fn aovs(&self) -> Aovs {
        let named = self.aov.iter().map(|name| match Aov::named(name) {
            Some(aov) => Aovs::default().with(aov),
            // Alpha changes radiance, so that it is there only if it is asked for by name.
            None if name == ALL_AOVS => Aovs::all().without(Aov::Alpha),
            None => Aovs::default(),
        });
        named.fold(Aovs::default(), Aovs::and)
    }

    /// Refuses options that would have no effect.
    ///
    /// # Errors
    /// The option, and the one that it needs.
    pub fn check_use(&self) -> Result<(), String> {
        match self.ao_distance {
            Some(_) if !self.is_occlusion() => {
                Err("--ao-distance needs --integrator ao".to_owned())
            }
            _ => Ok(()),
        }
    }

    /// Refuses a region that does not lie in the picture of these settings.
    ///
    /// # Errors
    /// The region and the size of the picture.
    pub fn check_region(&self, settings: &Settings) -> Result<(), String> {
        match self.part() {
            Some(asked) if asked.pixels() == 0 || settings.window() != asked => Err(format!(
                "--region {} {} {} {} does not lie in the picture, which is {}x{} pixels: columns and rows count from 0",
                asked.x, asked.y, asked.width, asked.height, settings.width, settings.height
            )),
            _ => Ok(()),
        }
    }

    /// Checks that [`PixelSpec::of`] could have made these options. The file that they were read
    /// from may come from anybody.
    ///
    /// # Errors
    /// The first option that has a value that it may not have.
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
        // Names are those that are known, and everything is given.
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

/// Checks the number of an option.
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
        _ => Ok(()),
    }
}

/// Name of `--aov` for all layers but those that change a picture.
const ALL_AOVS: &str = "all";

#[cfg(feature = "clap")]
fn aov_parser() -> impl TypedValueParser<Value = String> {
    let value = |(name, aov): &(&'static str, Aov)| {
        let mut others = Aov::OTHER_NAMES.iter();
        let other = others.find(|(_, of)| of == aov).map(|(other, _)| *other);
        PossibleValue::new(*name).aliases(other)
    };
    let names = Aov::ALL.iter().map(value);
    PossibleValuesParser::new(names.chain([PossibleValue::new(ALL_AOVS)]))
}

/// Takes one of some names, which have help.
#[cfg(feature = "clap")]
pub(super) fn described(names: &[(&'static str, &'static str)]) -> PossibleValuesParser {
    let names = names.iter();
    PossibleValuesParser::new(names.map(|(name, help)| PossibleValue::new(*name).help(*help)))
}

#[cfg(test)]
mod tests;
