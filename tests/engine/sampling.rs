//! Pixels with several samples against closed forms, in both engines.

use crate::common::tolerances::{ALL_SAMPLES, SAMPLED_EDGE, SAMPLED_LOBES};
use phalanx::formats::read_test;
use phalanx::frame::{Accel, Adaptive, Control, Engine, Filter, Sampling, Settings, render};
use phalanx::render::{Film, RayCounts};
use phalanx::sampling::FIRST_SAMPLES;
use phalanx::scene::Scene;
use phalanx::standard;

const SPP: u32 = 1024;

/// Twelve pixels across the edge of an emissive wall that ends `right` pixels from the middle, seen
/// at a right angle.
fn edge(right: f64) -> Scene {
    // 2 tan(45°)/1 is a pixel's width at distance 1.
    let column = 2.0 * right;
    let text = format!(
        "size 12 1\ncamera 0 0 1 0 0 0 0 1 0 90\nambient 0 0 0\nemission 1 .5 2\n\
         vertex -60 -30 0\nvertex {column} -30 0\nvertex {column} 30 0\nvertex -60 30 0\ntri 0 1 2\ntri 0 2 3\n"
    );
    match read_test(&text) {
        Ok(loaded) => loaded.scene,
        Err(errors) => panic!("{text}\n{errors:#?}"),
    }
}

fn uniform(spp: u32, filter: Filter) -> Sampling {
    Sampling {
        spp,
        filter,
        adaptive: None,
    }
}

/// The picture of both engines, after asserting that it has the same bits.
fn film(scene: &Scene, sampling: Sampling) -> Film {
    traced(scene, sampling).0
}

fn traced(scene: &Scene, sampling: Sampling) -> (Film, RayCounts) {
    let [simd, scalar] = [Engine::Simd, Engine::Scalar].map(|engine| {
        let settings = Settings {
            engine,
            sampling,
            record_hits: true,
            ..Settings::of(scene)
        };
        let prepared = Accel::build(scene, engine);
        let frame = render(scene, &prepared, &settings, &Control::default()).expect("a frame");
        if sampling.adaptive.is_none() {
            assert_eq!(frame.stats.rays.primary, settings.camera_rays());
        }
        (frame.film, frame.stats.rays)
    });
    assert_eq!(simd, scalar);
    simd
}

/// Share of a filter to the left of `x`, in closed form.
fn left_of(filter: Filter, x: f64) -> f64 {
    match filter {
        Filter::Box => (x + 0.5).clamp(0.0, 1.0),
        Filter::Tent => match x.clamp(-1.0, 1.0) {
            x if x < 0.0 => 0.5 * (x + 1.0) * (x + 1.0),
            x => 1.0 - 0.5 * (1.0 - x) * (1.0 - x),
        },
        Filter::Mitchell => {
            let size = x.abs().min(2.0);
            let near = |x: f64| (7.0 / 4.0 * x.powi(4) - 4.0 * x.powi(3) + 16.0 / 3.0 * x) / 6.0;
            let far = |x: f64| {
                (-7.0 / 12.0 * x.powi(4) + 4.0 * x.powi(3) - 10.0 * x * x + 32.0 / 3.0 * x) / 6.0
            };
            let half = if size < 1.0 { near(size) } else { near(1.0) + far(size) - far(1.0) };
            0.5 + half * x.signum()
        }
    }
}

#[test]
fn an_edge_is_as_soft_as_its_filter() {
    for (name, filter) in Filter::ALL {
        let most = match filter {
            Filter::Mitchell => SAMPLED_LOBES,
            _ => SAMPLED_EDGE,
        };
        for right in [0.0, 0.3, -0.45] {
            let film = film(&edge(right), uniform(SPP, filter));
            for x in 0..12 {
                let centre = f64::from(x) + 0.5 - 6.0;
                let want = left_of(filter, right - centre);
                let got = film.pixel(x, 0).map(f64::from);
                for (got, shine) in got.into_iter().zip([1.0, 0.5, 2.0]) {
                    assert!(
                        (got - want * shine).abs() <= most * shine,
                        "{name}, edge at {right}, pixel {x}: {got}, not {want} times {shine}"
                    );
                }
            }
        }
    }
}

/// A picture without edges is the same for any filter and number of samples.
#[test]
fn a_plain_wall_stays_plain() {
    let scene = edge(20.0);
    for (name, filter) in Filter::ALL {
        for spp in [1, 2, 3, 5, 16] {
            let film = film(&scene, uniform(spp, filter));
            for x in 0..12 {
                assert_eq!(film.pixel(x, 0), [1.0, 0.5, 2.0], "{name}, {spp} samples");
            }
        }
    }
}

/// One sample gives the same picture for any filter.
#[test]
fn one_sample_has_no_filter() {
    let scene = edge(0.3);
    let plain = film(&scene, Sampling::CENTER);
    for (_, filter) in Filter::ALL {
        assert_eq!(film(&scene, uniform(1, filter)), plain);
    }
    assert_ne!(
        film(
            &scene,
            Sampling {
                spp: 2,
                ..Sampling::CENTER
            }
        ),
        plain
    );
}

/// Only cells crossed by an edge, and their neighbours, are halved; the result is as good as with
/// all samples.
#[test]
fn adaptive_samples_go_where_the_edge_is() {
    for right in [0.3, -0.45] {
        let scene = edge(right);
        let sampling = Sampling {
            spp: SPP,
            filter: Filter::Box,
            adaptive: Some(Adaptive { threshold: 1e-4 }),
        };
        let (film, rays) = traced(&scene, sampling);
        // The edge crosses 32 of the smallest cells. Of each size, those on both sides are halved:
        // twice (32 + 16 + 16 + 8 + 8 + …).
        let beyond = rays.primary - 12 * u64::from(FIRST_SAMPLES);
        assert!((32..=6 * 32).contains(&beyond), "{beyond}");
        for x in 0..12 {
            let want = left_of(Filter::Box, right - (f64::from(x) + 0.5 - 6.0));
            let got = f64::from(film.pixel(x, 0)[0]);
            assert!(
                (got - want).abs() <= SAMPLED_EDGE,
                "{right}, {x}: {got}, not {want}"
            );
        }
    }
    // With a threshold that nothing reaches, or no more samples than the first, all pixels have as
    // many.
    for (spp, threshold) in [(SPP, 1e3), (FIRST_SAMPLES, 1e-9)] {
        let sampling = |adaptive| Sampling {
            spp,
            filter: Filter::Tent,
            adaptive,
        };
        let (film, rays) = traced(&edge(0.3), sampling(Some(Adaptive { threshold })));
        assert_eq!(rays.primary, 12 * u64::from(FIRST_SAMPLES));
        let first = uniform(FIRST_SAMPLES, Filter::Tent);
        assert_eq!(film.planes, traced(&edge(0.3), first).0.planes);
    }
}

/// Benefit of adaptive sampling: the error of 64 uniform samples with a third of their rays, in a
/// scene of mirror spheres with shadows.
#[test]
fn adaptive_samples_are_worth_three_uniform_ones() {
    let mut scene = standard::scene(standard::parse_spec("standard:balls:2").expect("a name"), 0)
        .expect("a scene");
    (scene.width, scene.height) = (96, 96);
    let prepared = Accel::build(&scene, Engine::Simd);
    let rendered = |spp, threshold: Option<f32>| {
        let sampling = Sampling {
            adaptive: threshold.map(|threshold| Adaptive { threshold }),
            ..uniform(spp, Filter::Box)
        };
        let settings = Settings {
            sampling,
            ..Settings::of(&scene)
        };
        render(&scene, &prepared, &settings, &Control::default()).expect("a frame")
    };
    let apart = |one: &Film, other: &Film| {
        let pairs = one
            .planes
            .iter()
            .flatten()
            .zip(other.planes.iter().flatten());
        let squares: f64 = pairs
            .map(|(a, b)| f64::from(a - b) * f64::from(a - b))
            .sum();
        (squares / (3.0 * 96.0 * 96.0)).sqrt()
    };
    let reference = rendered(1024, None).film;
    let (uniform, adaptive) = (rendered(64, None), rendered(256, Some(0.001)));
    let errors = [&uniform, &adaptive].map(|frame| apart(&frame.film, &reference));
    let rays = [&uniform, &adaptive].map(|frame| frame.stats.rays.total());
    println!("{errors:?} {rays:?}");
    assert!(errors[1] < errors[0], "{errors:?}");
    assert!(3 * rays[1] < rays[0], "{rays:?}");
    // If the threshold requires all samples, no result is reused, and they are the uniform ones.
    let all = rendered(64, Some(1e-9));
    let apart = apart(&all.film, &uniform.film);
    assert!(apart < ALL_SAMPLES, "{apart}");
}
