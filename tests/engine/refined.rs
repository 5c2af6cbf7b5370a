//! Pictures that get sample after sample are those that are rendered at once.

use crate::common::frames::frame_of;
use crate::common::rng::Rng;
use crate::common::scenes;
use phalanx::frame::{
    Accel, AccelRef, Control, Engine, Filter, FrameError, Integrator, RefinedFrame, Sampling,
    Settings,
};
use phalanx::scene::Scene;
use phalanx::standard;
use std::sync::atomic::Ordering::Relaxed;
use std::time::Duration;

/// Refines a picture of 67 by 45 pixels in slices of random size, some of which are interrupted,
/// and compares it with that of both engines for each number of samples.
fn check(scene: &Scene, settings: Settings, rng: &mut Rng) {
    let settings = Settings {
        width: 67,
        height: 45,
        tile: 16,
        threads: 2,
        ..settings
    };
    let accel = Accel::build(scene, Engine::Simd);
    let oracle = Accel::build(scene, Engine::Scalar);
    let AccelRef::Packets(bvh) = accel.accel() else {
        panic!("packets")
    };
    let mut refined = RefinedFrame::new(settings.clone());
    let control = Control::default();
    let mut last = None;
    for spp in 1..=5 {
        while refined.samples() < spp {
            control.stop.store(false, Relaxed);
            let (most, pause) = (1 + rng.below(9), rng.below(400) as u64);
            let traced = std::thread::scope(|scope| {
                if rng.once_in(2) {
                    scope.spawn(|| {
                        std::thread::sleep(Duration::from_micros(pause));
                        control.stop.store(true, Relaxed);
                    });
                }
                refined.refine(scene, bvh, &control, most)
            });
            match traced {
                Ok(traced) => assert!(traced.tile_seconds.len() <= most),
                Err(error) => assert!(matches!(error, FrameError::Interrupted(_)), "{error}"),
            }
            // An interruption never leaves a picture that looks finished and is not.
            if refined.is_even() && refined.samples() < spp {
                assert!(last.as_ref().is_none_or(|last| last == refined.film()));
            }
        }
        assert!(refined.is_even());
        last = Some(refined.film().clone());
        let sampling = Sampling {
            spp,
            ..settings.sampling
        };
        for (engine, accel) in [(Engine::Simd, &accel), (Engine::Scalar, &oracle)] {
            let full = Settings {
                engine,
                sampling,
                ..settings.clone()
            };
            let frame = frame_of(scene, accel, full);
            assert_eq!(*refined.film(), frame.film, "{spp} samples, {engine:?}");
        }
    }
}

#[test]
fn a_refined_picture_is_the_picture_of_as_many_samples() {
    let mut rng = Rng::new(53);
    let glossy = standard::scene(standard::parse_spec("standard:room:4k").unwrap(), 0).unwrap();
    for (_, filter) in Filter::ALL {
        check(&glossy, Settings::of(&glossy), &mut rng);
        let scene = scenes::random(&mut rng, 60, 1.0);
        let mut settings = Settings::of(&scene);
        settings.sampling.filter = filter;
        check(&scene, settings.clone(), &mut rng);
        settings.integrator = Integrator::Occlusion { distance: 2.0 };
        check(&scene, settings, &mut rng);
    }
}
