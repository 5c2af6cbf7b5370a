//! Settings that pixels depend on, as plans and tile files store them: a JSON object of named
//! fields.
//!
//! A new field of [`Settings`] stops this file from compiling until it is stored here, too, or
//! listed as one that changes no pixel. Floats come back from JSON to the bit (serde_json's
//! `float_roundtrip`). Values that may be infinite are `None` there, because JSON has no infinity.

use phalanx_render::frame::{Integrator, Sampling, Settings};
use serde::{Deserialize, Serialize};

/// Settings that pixels depend on, beside the picture's size, region and layers. Fields are named
/// for their options.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PictureSettings {
    /// Bounces after the primary ray.
    pub max_depth: u32,
    /// Least weight of a bounce that is traced.
    pub min_weight: f32,
    /// Camera rays of a pixel; the maximum where `threshold` is set.
    pub spp: u32,
    /// Name of the reconstruction filter.
    pub filter: String,
    /// Threshold at which a pixel has enough samples; `None` where every pixel has `spp` of them.
    pub threshold: Option<f32>,
    /// Diameter of the lens; `None` for a pinhole.
    pub aperture: Option<f32>,
    /// Distance of the plane in focus; `None` for a pinhole.
    pub focus: Option<f32>,
    /// Name of the integrator.
    pub integrator: String,
    /// Reach of ambient occlusion; `None` where it is infinite, and for other integrators.
    pub ao_distance: Option<f32>,
}

impl PictureSettings {
    /// The settings of a render that pixels depend on.
    pub fn of(settings: &Settings) -> PictureSettings {
        let Settings {
            // Stored in the identity.
            width: _,
            height: _,
            region: _,
            aovs: _,
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
        } = settings;
        let (integrator, distance) = match integrator {
            Integrator::Whitted => ("whitted", None),
            Integrator::Occlusion { distance } => ("ao", Some(*distance)),
        };
        PictureSettings {
            max_depth: *max_depth,
            min_weight: settings.min_path_weight(),
            spp: *spp,
            filter: filter.name().to_owned(),
            threshold: adaptive.map(|adaptive| adaptive.threshold),
            aperture: lens.map(|lens| lens.aperture),
            focus: lens.map(|lens| lens.focus),
            integrator: integrator.to_owned(),
            ao_distance: distance.filter(|distance| distance.is_finite()),
        }
    }

    /// Each setting that is given, or has a default of its own, as its option and its value.
    pub fn given_options(&self) -> Vec<(&'static str, String)> {
        let mut options = self.options();
        options.retain(|(_, value)| value != NOT_GIVEN);
        options
    }

    /// Each setting as its option and its value. Different settings have different values.
    pub(super) fn options(&self) -> Vec<(&'static str, String)> {
        let PictureSettings {
            max_depth,
            min_weight,
            spp,
            filter,
            threshold,
            aperture,
            focus,
            integrator,
            ao_distance,
        } = self;
        let aa = match threshold {
            Some(_) => "adaptive",
            None => "uniform",
        };
        vec![
            ("--max-depth", max_depth.to_string()),
            ("--min-weight", given(Some(*min_weight))),
            ("--spp", spp.to_string()),
            ("--filter", filter.clone()),
            ("--aa", aa.to_owned()),
            ("--threshold", given(*threshold)),
            ("--aperture", given(*aperture)),
            ("--focus", given(*focus)),
            ("--integrator", integrator.clone()),
            ("--ao-distance", given(*ao_distance)),
        ]
    }
}

/// Value of an option that is not given.
const NOT_GIVEN: &str = "not given";

fn given(value: Option<f32>) -> String {
    // For very small and very large numbers `Debug` prints fewer digits than `Display`, and loses
    // no bits.
    value.map_or_else(|| NOT_GIVEN.to_owned(), |value| format!("{value:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use phalanx_render::frame::{Adaptive, Filter, Lens};
    use phalanx_scene::Scene;

    fn odd() -> Settings {
        Settings {
            max_depth: 3,
            min_weight: Some(0.01),
            sampling: Sampling {
                spp: 7,
                filter: Filter::Mitchell,
                adaptive: Some(Adaptive { threshold: 0.1 }),
            },
            // If it were read as a double first, this one would become another float.
            lens: Some(Lens {
                aperture: 7.038_531e-26,
                focus: f32::from_bits(1),
            }),
            integrator: Integrator::Occlusion { distance: f32::MAX },
            ..Settings::of(&Scene::default())
        }
    }

    #[test]
    fn json_gives_every_setting_back_to_the_bit() {
        let endless = Settings {
            integrator: Integrator::Occlusion {
                distance: f32::INFINITY,
            },
            ..odd()
        };
        for settings in [odd(), endless, Settings::of(&Scene::default())] {
            let kept = PictureSettings::of(&settings);
            let text = serde_json::to_string(&kept).unwrap();
            assert!(text.contains("\"spp\":"), "{text}");
            let again: PictureSettings = serde_json::from_str(&text).unwrap();
            assert_eq!(again, kept, "{text}");
        }
    }

    #[test]
    fn a_setting_that_nobody_knows_is_refused() {
        let mut json = serde_json::to_value(PictureSettings::of(&odd())).unwrap();
        json["weather"] = "fine".into();
        let refused = serde_json::from_value::<PictureSettings>(json).unwrap_err();
        assert!(refused.to_string().contains("weather"), "{refused}");
    }

    #[test]
    fn settings_that_differ_have_options_that_differ() {
        let plain = PictureSettings::of(&Settings::of(&Scene::default()));
        let other = PictureSettings::of(&odd());
        let pairs = plain.options().into_iter().zip(other.options());
        for ((name, plain), (_, other)) in pairs {
            assert_ne!(plain, other, "{name}");
        }
    }
}
