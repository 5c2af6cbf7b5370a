//! Tests of options that pixels depend on.

use super::*;
use phalanx_render::frame::Sampling;

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
fn json_gives_every_option_back_to_the_bit_and_options_their_settings() {
    let endless = Settings {
        integrator: Integrator::Occlusion {
            distance: f32::INFINITY,
        },
        ..odd()
    };
    let plain = Settings {
        min_weight: Some(0.0),
        ..Settings::of(&Scene::default())
    };
    for settings in [odd(), endless, plain] {
        let spec = PixelSpec::of(&settings);
        let text = serde_json::to_string(&spec).unwrap();
        assert!(text.contains("\"spp\":"), "{text}");
        let again: PixelSpec = serde_json::from_str(&text).unwrap();
        assert_eq!(again, spec, "{text}");
        assert_eq!(spec.settings(&Scene::default()), settings);
        spec.check().unwrap();
    }
}

#[test]
fn an_option_that_nobody_knows_is_refused() {
    let mut json = serde_json::to_value(PixelSpec::of(&odd())).unwrap();
    json["weather"] = "fine".into();
    let refused = serde_json::from_value::<PixelSpec>(json).unwrap_err();
    assert!(refused.to_string().contains("weather"), "{refused}");
}

#[test]
fn settings_that_differ_have_options_that_differ() {
    let texts = |settings: &Settings| {
        let rows = PixelSpec::of(settings).rows().into_iter();
        rows.map(|row| (row.text(), row.field))
    };
    let plain = texts(&Settings::of(&Scene::default()));
    let others = texts(&odd()).zip(plain).skip(3);
    for ((other, name), (plain, _)) in others {
        assert_ne!(plain, other, "{name}");
    }
}

/// A setting that is missing here has no option yet, or no place among those that change no pixel.
#[test]
fn every_setting_has_an_option_or_changes_no_pixel() {
    let Settings {
        width,
        height,
        region,
        aovs,
        max_depth,
        min_weight,
        sampling: Sampling {
            spp,
            filter,
            adaptive,
        },
        lens,
        integrator,
        threads: _,
        pin: _,
        tile: _,
        engine: _,
        kernel: _,
        record_hits: _,
    } = odd();
    let again = PixelSpec::of(&odd()).settings(&Scene::default());
    assert_eq!(
        (again.width, again.height, again.region),
        (width, height, region)
    );
    assert_eq!(
        (again.aovs, again.max_depth, again.min_weight),
        (aovs, max_depth, min_weight)
    );
    let sampling = Sampling {
        spp,
        filter,
        adaptive,
    };
    assert_eq!(again.sampling, sampling);
    assert_eq!((again.lens, again.integrator), (lens, integrator));
}
