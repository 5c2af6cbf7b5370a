//! A picture's settings other than size and depth, as shown in reports and records.

use phalanx::frame::{Filter, Settings};
use phalanx::jobs::PixelSpec;
use phalanx::jobs::spec::{AsText, IntegratorName};
use phalanx::report::counted;
use phalanx::scene::Scene;
use serde::{Deserialize, Serialize};

/// Size of a picture, and its position if it is a region of a larger one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PictureWindow {
    pub width: u32,
    pub height: u32,
    /// Position of a region: column and row of its upper left pixel, and the size of the whole
    /// picture. Older records have no regions.
    #[serde(default)]
    region: Option<[u32; 4]>,
}

impl PictureWindow {
    /// The window given by these settings.
    pub fn of(settings: &Settings) -> PictureWindow {
        let Settings { width, height, .. } = *settings;
        PictureWindow {
            width: settings.window().width,
            height: settings.window().height,
            region: settings.region.map(|r| [r.x, r.y, width, height]),
        }
    }

    /// The position in words; empty if there is none.
    pub fn region_words(&self) -> String {
        self.region.map_or(String::new(), |[x, y, width, height]| {
            format!(" from ({x}, {y}) of {width}x{height}")
        })
    }
}

/// The settings that change the picture. A record without one predates the setting, and used what
/// is now its default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RenderSummary {
    /// Minimum weight of a traced ray; 0 if all were traced.
    min_weight: f32,
    spp: u32,
    filter: AsText<Filter>,
    /// Threshold at which a pixel has enough samples; `None` if all pixels have the same number.
    aa_threshold: Option<f32>,
    /// Diameter of the lens; 0 for a pinhole, which has no focus distance.
    aperture: f32,
    focus: Option<f32>,
    integrator: IntegratorName,
    /// Range of ambient occlusion; `None` if it is unlimited.
    ao_distance: Option<f32>,
}

impl Default for RenderSummary {
    fn default() -> RenderSummary {
        RenderSummary::of(&Settings::of(&Scene::default()))
    }
}

impl RenderSummary {
    /// The summary of these settings.
    pub fn of(settings: &Settings) -> RenderSummary {
        // A lens of diameter 0 is a pinhole.
        let lens = settings.lens.filter(|lens| lens.aperture > 0.0);
        let options = PixelSpec::of(settings);
        let reach = options.ao_distance.map(|reach| reach.0);
        RenderSummary {
            min_weight: settings.min_path_weight(),
            spp: settings.sampling.spp,
            filter: AsText(settings.sampling.filter),
            aa_threshold: settings.sampling.adaptively().map(|aa| aa.threshold),
            aperture: lens.map_or(0.0, |lens| lens.aperture),
            focus: lens.map(|lens| lens.focus),
            integrator: options.integrator.unwrap_or_default(),
            ao_distance: reach.filter(|reach| reach.is_finite()),
        }
    }

    /// The samples per pixel in words; with adaptive sampling, the maximum.
    pub fn samples_words(&self) -> String {
        let most = self.aa_threshold.map_or("", |_| "up to ");
        format!("{most}{} per pixel", counted(self.spp as usize, "sample"))
    }

    /// The settings in words, without the filter of a single sample and a minimum weight of 0.
    pub fn words(&self) -> String {
        let mut words = self.samples_words();
        if self.spp > 1 {
            words.push_str(&format!(" ({})", self.filter.0.name()));
        }
        if let Some(threshold) = self.aa_threshold {
            words.push_str(&format!(", adaptive to {threshold}"));
        }
        if let Some(focus) = self.focus {
            words.push_str(&format!(", aperture {} focused at {focus}", self.aperture));
        }
        if self.integrator != IntegratorName::Whitted {
            words.push_str(", ambient occlusion");
        }
        if let Some(distance) = self.ao_distance {
            words.push_str(&format!(" within {distance}"));
        }
        if self.min_weight > 0.0 {
            words.push_str(&format!(", rays of weight {} or more", self.min_weight));
        }
        words
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phalanx::frame::{Integrator, Lens, Sampling};

    #[test]
    fn what_is_not_said_is_the_default() {
        let default = Settings::of(&Scene::default());
        assert_eq!(
            serde_json::from_str::<RenderSummary>("{}").unwrap(),
            RenderSummary::of(&default)
        );
        let deep = Settings {
            max_depth: 11,
            ..default.clone()
        };
        let words = "1 sample per pixel, rays of weight 0.00024414063 or more";
        assert_eq!(RenderSummary::of(&deep).words(), words);
        assert_eq!(RenderSummary::of(&default).words(), "1 sample per pixel");
        let pinhole = Lens {
            aperture: 0.0,
            focus: 3.0,
        };
        let settings = Settings {
            lens: Some(pinhole),
            ..default
        };
        assert_eq!(RenderSummary::of(&settings).words(), "1 sample per pixel");
        let settings = Settings {
            sampling: Sampling {
                spp: 4,
                filter: Filter::Tent,
                adaptive: None,
            },
            lens: Some(Lens {
                aperture: 0.1,
                ..pinhole
            }),
            integrator: Integrator::Occlusion { distance: 2.5 },
            ..settings
        };
        let words =
            "4 samples per pixel (tent), aperture 0.1 focused at 3, ambient occlusion within 2.5";
        assert_eq!(RenderSummary::of(&settings).words(), words);
        let endless = Settings {
            integrator: Integrator::Occlusion {
                distance: f32::INFINITY,
            },
            ..settings.clone()
        };
        assert!(
            RenderSummary::of(&endless)
                .words()
                .ends_with(", ambient occlusion")
        );
        let json = serde_json::to_value(RenderSummary::of(&settings)).unwrap();
        let again: RenderSummary = serde_json::from_value(json).unwrap();
        assert_eq!(again, RenderSummary::of(&settings));
    }
}
