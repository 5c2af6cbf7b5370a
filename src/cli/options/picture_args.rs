//! The options that change the picture. `render` has them and `verify`, because all of them are
//! verified.

use super::headings::{CAMERA, MACHINE, OUTPUT, QUALITY};
use super::parsers::{described_name_parser, name_parser, parse_number};
use super::scene_args::WantedPicture;
use crate::cli::output::CliError;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum, value_parser};
use phalanx::frame::{
    Adaptive, Aov, Aovs, DEFAULT_TILE, Filter, Integrator, Lens, MAX_SPP, Sampling, Settings, Tile,
};
use phalanx::scene::{
    MAX_DEPTH_LIMIT, OutputEncoding, Quantize, Scene, Transfer, check_image_size,
};

/// Most camera rays a pixel with `--aa adaptive`, by default.
const ADAPTIVE_SPP: u32 = 256;

/// Default of `--threshold`.
const THRESHOLD: f32 = 0.002;

/// Options that change the picture, or the order in which it is made.
#[derive(Debug, Args)]
#[command(next_help_heading = QUALITY)]
pub struct PictureArgs {
    /// Samples per pixel (anti-aliasing) [default: 1]
    ///
    /// Camera rays a pixel, 1 to 65536, or the most of them with --aa adaptive (best a power of
    /// two): one goes through the pixel's centre, more are spread over the filter.
    /// [default: 1; with --aa adaptive 256]
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=i64::from(MAX_SPP)))]
    pub spp: Option<u32>,
    /// Anti-aliasing: uniform (default), or adaptive
    ///
    /// Which pixels get the samples: all alike (uniform), or those where more help most (adaptive),
    /// at edges, highlights and reflections.
    #[arg(long, value_name = "MODE", value_enum, default_value_t = AntiAliasing::Uniform, hide_possible_values = true, hide_default_value = true)]
    pub aa: AntiAliasing,
    /// Noise at which --aa adaptive stops [default: 0.002]
    ///
    /// With --aa adaptive, how much a sample must still help: less is better and takes longer,
    /// 0.001 is about as good as 64 uniform samples per pixel. [default: 0.002]
    #[arg(long, value_name = "T", hide_short_help = true, default_value_t = THRESHOLD, hide_default_value = true, requires = "aa", value_parser = parse_threshold)]
    pub threshold: f32,
    /// Pixel filter: box (default), tent or mitchell
    ///
    /// The weight of a pixel's samples: its square (box, the default), a tent over its neighbours,
    /// or Mitchell's cubic, which is sharper.
    #[arg(long, value_name = "NAME", default_value = "box", hide_possible_values = true, hide_default_value = true, value_parser = name_parser(&Filter::ALL))]
    pub filter: Filter,
    /// Most bounces of a ray [default: the scene's]
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(0..=i64::from(MAX_DEPTH_LIMIT)))]
    pub max_depth: Option<u32>,
    /// Least weight of mirror and refracted rays
    ///
    /// Mirror and refracted rays of less weight than this are not traced: the product of Ks and Kt
    /// along the path, each divided by Ks + Kt where that is more than 1, in its largest component.
    /// 0 has all traced. [default: 0 for up to 10 bounces, 1/4096 for more, and where surfaces are
    /// only partly there]
    #[arg(long, value_name = "W", hide_short_help = true, value_parser = parse_weight)]
    pub min_weight: Option<f32>,
    /// Depth of field: diameter of the lens
    ///
    /// Diameter of the lens that camera rays come through, in the scene's units: what is not in
    /// focus is blurred, with less noise the more --spp. [default: a pinhole]
    #[arg(long, value_name = "DIAMETER", help_heading = CAMERA, requires = "focus", value_parser = parse_aperture)]
    pub aperture: Option<f32>,
    /// Depth of field: distance that is in focus
    ///
    /// Distance of the plane that is in focus, along the direction of view.
    #[arg(long, value_name = "DISTANCE", help_heading = CAMERA, requires = "aperture", value_parser = parse_distance)]
    pub focus: Option<f32>,
    /// whitted (default), or ao: ambient occlusion
    ///
    /// Radiance of what camera rays hit: whitted (the default), the light that falls on it, with
    /// shadows, mirror and refracted rays; ao (ambient occlusion), how much of the sky is open
    /// above it, for which --spp 64 and more is meant.
    #[arg(long, value_name = "NAME", default_value = "whitted", hide_possible_values = true, hide_default_value = true, value_parser = described_name_parser(INTEGRATORS))]
    pub integrator: Integrator,
    /// Reach of --integrator ao
    ///
    /// Reach of --integrator ao in the scene's units: hits beyond do not count.
    /// [default: everything counts]
    #[arg(long, value_name = "DISTANCE", hide_short_help = true, value_parser = parse_distance)]
    pub ao_distance: Option<f32>,
    /// Picture size in pixels [default: the scene's]
    #[arg(long, value_name = "WxH", help_heading = OUTPUT, value_parser = parse_size)]
    pub size: Option<(u32, u32)>,
    /// Only this part of the picture
    ///
    /// Column and row of its upper left pixel, width and height.
    #[arg(long, num_args = 4, value_names = ["X", "Y", "W", "H"], help_heading = OUTPUT, hide_short_help = true)]
    pub region: Option<Vec<u32>>,
    /// AOVs in an EXR: Z, N, albedo, alpha, …, all
    ///
    /// AOVs (arbitrary output variables) of each pixel, in an OpenEXR file, names separated by
    /// commas: depth (or Z), position (P), ng (Ng), ns (N: normals), albedo, material, primitive,
    /// direct, reflection, refraction, samples, crypto_object, crypto_material (Cryptomatte); or
    /// all of these; or alpha (A), which makes the background black and transparent; or cost (nodes
    /// that the first camera ray visits, by the build).
    #[arg(long, value_name = "NAMES", help_heading = OUTPUT, value_delimiter = ',', hide_possible_values = true, value_parser = aov_parser())]
    pub aov: Vec<Aovs>,
    /// Transfer curve of the written samples [default: the scene format's]
    #[arg(long, help_heading = OUTPUT, hide_short_help = true, value_parser = described_name_parser(TRANSFERS))]
    pub transfer: Option<Transfer>,
    /// Quantisation of the written samples [default: the scene format's]
    #[arg(long, help_heading = OUTPUT, hide_short_help = true, value_parser = described_name_parser(QUANTIZERS))]
    pub quantize: Option<Quantize>,
    /// Tile size in pixels [default: 32]
    ///
    /// Side of a tile, the part of a picture that a thread renders at a time, in pixels: 8 to 1024,
    /// rounded up to a multiple of 8. No picture depends on it. [default: 32]
    #[arg(long, value_name = "N", help_heading = MACHINE, hide_short_help = true, default_value_t = DEFAULT_TILE, hide_default_value = true, value_parser = value_parser!(u32).range(8..=1024))]
    pub tile: u32,
}

impl PictureArgs {
    /// Refuses options that would have no effect.
    pub fn check(&self) -> Result<(), CliError> {
        match self.ao_distance {
            Some(_) if self.integrator == Integrator::Whitted => Err(CliError::Usage(
                "--ao-distance says how far --integrator ao looks: add that, or leave it out"
                    .to_owned(),
            )),
            _ => Ok(()),
        }
    }

    /// The scene's settings with the requested changes, one thread, and the packet engine.
    pub fn settings(&self, scene: &Scene) -> Settings {
        let (width, height) = self.size.unwrap_or((scene.width, scene.height));
        let adaptive = self.aa == AntiAliasing::Adaptive;
        Settings {
            width,
            height,
            region: self.region.as_deref().and_then(window_of),
            max_depth: self.max_depth.unwrap_or(scene.max_depth),
            min_weight: self.min_weight.or(Settings::of(scene).min_weight),
            sampling: Sampling {
                spp: self.spp.unwrap_or(if adaptive { ADAPTIVE_SPP } else { 1 }),
                filter: self.filter,
                adaptive: adaptive.then_some(Adaptive {
                    threshold: self.threshold,
                }),
            },
            lens: self
                .aperture
                .zip(self.focus)
                .map(|(aperture, focus)| Lens { aperture, focus }),
            integrator: match (self.integrator, self.ao_distance) {
                (Integrator::Occlusion { .. }, Some(distance)) => {
                    Integrator::Occlusion { distance }
                }
                (integrator, _) => integrator,
            },
            tile: self.tile,
            aovs: self
                .aov
                .iter()
                .fold(Aovs::default(), |set, asked| set.and(*asked)),
            ..Settings::of(scene)
        }
    }

    /// The picture that the scene is opened for.
    pub fn wanted(&self) -> WantedPicture {
        WantedPicture {
            size: self.size,
            turntable: false,
        }
    }

    /// Refuses a region that does not lie in the picture.
    pub fn check_region(&self, settings: &Settings) -> Result<(), CliError> {
        let Some(asked) = self.region.as_deref().and_then(window_of) else {
            return Ok(());
        };
        if asked.pixels() > 0 && settings.window() == asked {
            return Ok(());
        }
        Err(CliError::Usage(format!(
            "--region {} {} {} {} does not lie in the picture, which is {}x{} pixels: columns and rows count from 0",
            asked.x, asked.y, asked.width, asked.height, settings.width, settings.height
        )))
    }

    /// The scene's tone with the requested changes.
    pub fn tone(&self, scene: &Scene) -> OutputEncoding {
        OutputEncoding {
            transfer: self.transfer.unwrap_or(scene.encoding.transfer),
            quantize: self.quantize.unwrap_or(scene.encoding.quantize),
        }
    }
}

/// Names of `--integrator`.
const INTEGRATORS: &[(&str, &str, Integrator)] = &[
    (
        "whitted",
        "Shading, shadows, mirror and refracted rays",
        Integrator::Whitted,
    ),
    (
        "ao",
        "Ambient occlusion",
        Integrator::Occlusion {
            distance: f32::INFINITY,
        },
    ),
];

/// Names of `--transfer`.
const TRANSFERS: &[(&str, &str, Transfer)] = &[
    ("none", "Linear values as they are", Transfer::None),
    ("srgb", "The sRGB curve", Transfer::Srgb),
];

/// Names of `--quantize`.
const QUANTIZERS: &[(&str, &str, Quantize)] = &[
    ("floor", "floor(255 c)", Quantize::Floor),
    ("round", "Nearest", Quantize::Round),
];

/// Which pixels get many samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum AntiAliasing {
    /// All pixels alike
    Uniform,
    /// Where more help most: edges, highlights, reflections
    Adaptive,
}

fn aov_parser() -> impl TypedValueParser<Value = Aovs> {
    let value = |(name, aov): &(&'static str, Aov)| {
        let mut others = Aov::OTHER_NAMES.iter();
        let other = others.find(|(_, of)| of == aov).map(|(other, _)| *other);
        PossibleValue::new(*name).aliases(other)
    };
    let names = Aov::ALL.iter().map(value);
    let all = names.chain([PossibleValue::new("all")]);
    PossibleValuesParser::new(all).map(|name| match Aov::named(&name) {
        Some(aov) => Aovs::default().with(aov),
        // Alpha changes radiance, so that it is there only if it is asked for by name.
        None => Aovs::all().without(Aov::Alpha),
    })
}

fn parse_threshold(text: &str) -> Result<f32, String> {
    let good = |threshold: &f32| (1e-9..=1e3).contains(threshold);
    parse_number(text, good, "a number above 0, as in 0.002")
}

fn parse_weight(text: &str) -> Result<f32, String> {
    let good = |weight: &f32| (0.0..1.0).contains(weight);
    let weight = parse_number(text, good, "a number from 0 to less than 1, as in 0.001")?;
    // −0 becomes 0, so that it is shown as 0.
    Ok(weight + 0.0)
}

fn window_of(numbers: &[u32]) -> Option<Tile> {
    match *numbers {
        [x, y, width, height] => Some(Tile {
            x,
            y,
            width,
            height,
        }),
        _ => None,
    }
}

pub fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let sides = text.split_once(['x', 'X']);
    let sides = sides.and_then(|(w, h)| Some((side(w)?, side(h)?)));
    let (width, height) = sides.ok_or("expected WIDTHxHEIGHT in pixels, as in 640x480")?;
    check_image_size(width, height).map_err(|e| e.to_string())?;
    // Both are within the limits that were just checked.
    Ok((width as u32, height as u32))
}

/// A side of any number of digits; one beyond u64 becomes the largest u64, which is out of range,
/// too.
fn side(digits: &str) -> Option<u64> {
    let all_digits = !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit());
    all_digits.then(|| digits.parse().unwrap_or(u64::MAX))
}

fn parse_aperture(text: &str) -> Result<f32, String> {
    let good = |diameter: &f32| diameter.is_finite() && *diameter >= 0.0;
    parse_number(text, good, "a diameter of at least 0, as in 0.05")
}

fn parse_distance(text: &str) -> Result<f32, String> {
    let good = |distance: &f32| distance.is_finite() && *distance > 0.0;
    parse_number(text, good, "a distance greater than 0, as in 2.5")
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::FromArgMatches;

    #[test]
    fn sizes_are_two_numbers_in_range() {
        assert_eq!(parse_size("640x480"), Ok((640, 480)));
        assert_eq!(parse_size("1X65536"), Ok((1, 65_536)));
        for bad in [
            "", "x", "640", "640x", "x480", "-1x5", "+1x5", "1.5x2", "4x4x4", " 4x4", "4*4",
        ] {
            assert!(
                parse_size(bad).unwrap_err().contains("WIDTHxHEIGHT"),
                "{bad}"
            );
        }
        let huge = [
            "0x4",
            "4x0",
            "65537x1",
            "1000000x1000000",
            "99999999999999999999999x1",
        ];
        for bad in huge {
            assert!(
                parse_size(bad).unwrap_err().contains("out of range"),
                "{bad}"
            );
        }
    }

    #[test]
    fn weights_are_from_0_to_less_than_1() {
        let good = [("0", 0.0), ("-0", 0.0), ("1e-9", 1e-9), (".999", 0.999)];
        for (text, weight) in good {
            let parsed = parse_weight(text).map(f32::to_bits);
            assert_eq!(parsed, Ok(f32::to_bits(weight)), "{text}");
        }
        for bad in ["", "1", "-0.1", "nan", "inf", "1%", "0,5"] {
            assert!(parse_weight(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn picture_options_override_the_scene() {
        let scene = Scene::default();
        let parse = |line: &str| {
            let command = PictureArgs::augment_args(clap::Command::new("phalanx"));
            let found = command.try_get_matches_from(line.split(' ')).unwrap();
            PictureArgs::from_arg_matches(&found).unwrap()
        };
        let default = parse("phalanx");
        assert_eq!(
            default.settings(&scene),
            Settings {
                tile: DEFAULT_TILE,
                ..Settings::of(&scene)
            }
        );
        assert_eq!(default.tone(&scene), scene.encoding);
        let asked = parse(
            "phalanx --size 8x9 --max-depth 0 --min-weight 0.25 --spp 5 --filter tent --aperture .5 --focus 2 --integrator ao --ao-distance 7 --tile 64 --transfer srgb --quantize round",
        );
        let settings = asked.settings(&scene);
        assert_eq!((settings.width, settings.height), (8, 9));
        assert_eq!((settings.max_depth, settings.tile), (0, 64));
        assert_eq!(
            (default.settings(&scene).min_weight, settings.min_weight),
            (None, Some(0.25))
        );
        let sampling = Sampling {
            spp: 5,
            filter: Filter::Tent,
            adaptive: None,
        };
        assert_eq!(settings.sampling, sampling);
        let lens = Lens {
            aperture: 0.5,
            focus: 2.0,
        };
        assert_eq!(settings.lens, Some(lens));
        let occlusion = Integrator::Occlusion { distance: 7.0 };
        assert_eq!(settings.integrator, occlusion);
        let encoding = asked.tone(&scene);
        assert_eq!(
            (encoding.transfer, encoding.quantize),
            (Transfer::Srgb, Quantize::Round)
        );
    }
}
