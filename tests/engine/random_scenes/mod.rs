//! A hunt for scenes in which a kernel and the oracle differ by a bit.
//!
//! `PHALANX_HUNT_SECONDS` sets the duration (by default, a few hundred scenes of one seed), and
//! `PHALANX_HUNT_SEED` the seed, which is printed. A scene that differs is written to the temporary
//! folder and named, for `phalanx verify`.

mod text;

use crate::common::frames::{difference, frame_of};
use crate::common::rng::Rng;
use crate::environments::random_environment;
use phalanx::formats::read_test;
use phalanx::frame::{Accel, Engine, Filter, Integrator, Kernel, Lens, Sampling, Settings};
use phalanx::scene::Scene;
use std::time::{Duration, Instant};
use text::random_scene;

/// Number of scenes in an ordinary test run.
const SCENES: usize = 300;

/// Seed of an ordinary test run.
const SEED: u64 = 29;

/// Additional settings for one scene in three.
fn random_settings(scene: &Scene, rng: &mut Rng) -> Settings {
    let mut settings = Settings::of(scene);
    match rng.below(9) {
        0 => {
            settings.integrator = Integrator::Occlusion {
                distance: f32::INFINITY,
            }
        }
        1 => {
            settings.sampling = Sampling {
                spp: 4,
                filter: Filter::ALL[0].1,
                adaptive: None,
            }
        }
        2 => {
            let focus = (scene.view.center - scene.view.eye).length() / scene.scale;
            let aperture = focus * 0.01;
            settings.lens = Some(Lens { aperture, focus });
        }
        _ => {}
    }
    settings
}

/// The first kernel that differs from the oracle, and where.
fn differs(scene: &Scene, settings_of_all: &Settings) -> Option<String> {
    let settings = Settings {
        record_hits: true,
        ..settings_of_all.clone()
    };
    let oracle = Accel::build(scene, Engine::Scalar);
    let packets = Accel::build(scene, Engine::Simd);
    let scalar = Settings {
        engine: Engine::Scalar,
        ..settings.clone()
    };
    settings.camera(scene).ok()?;
    let want = frame_of(scene, &oracle, scalar);
    Kernel::ALL.iter().find_map(|&(name, kernel)| {
        let settings = Settings {
            kernel,
            ..settings.clone()
        };
        let frame = frame_of(scene, &packets, settings);
        difference(&want, &frame).map(|what| format!("{name}: {what}"))
    })
}

/// The end of a hunt: after a time, or after a number of scenes.
enum HuntEnd {
    Scenes(usize),
    At(Instant),
}

#[test]
fn every_kernel_renders_what_the_oracle_renders() {
    let from_environment = |name: &str| std::env::var(name).ok()?.parse::<u64>().ok();
    let end = match from_environment("PHALANX_HUNT_SECONDS") {
        Some(seconds) => HuntEnd::At(Instant::now() + Duration::from_secs(seconds)),
        None => HuntEnd::Scenes(SCENES),
    };
    let seed = from_environment("PHALANX_HUNT_SEED").unwrap_or(SEED);
    println!("seed {seed}");
    let (mut rendered, mut refused, mut large, mut failures) = (0, 0, 0, Vec::new());
    for number in 0.. {
        match end {
            HuntEnd::Scenes(count) if number == count => break,
            HuntEnd::At(moment) if Instant::now() >= moment => break,
            _ => {}
        }
        let mut rng = Rng::new(seed.wrapping_mul(0x1_0000_0001) ^ number as u64);
        let (text, ratio) = random_scene(&mut rng);
        let Ok(mut scene) = read_test(&text) else {
            refused += 1;
            continue;
        };
        let settings = random_settings(&scene.scene, &mut rng);
        scene.scene.environment = rng.once_in(2).then(|| random_environment(&mut rng));
        rendered += 1;
        large += usize::from(ratio >= 6.0);
        if let Some(what) = differs(&scene.scene, &settings) {
            let file = std::env::temp_dir().join(format!("phalanx-{seed}-{number}.test"));
            std::fs::write(&file, &text).expect("a temporary file");
            failures.push(format!(
                "{}: ratio 10^{ratio:.1}, {settings:?}: {what}",
                file.display()
            ));
        }
    }
    println!("{rendered} scenes rendered, {large} of ratio 10^6 and more, {refused} refused");
    assert!(
        failures.is_empty(),
        "{} of {rendered} differ:\n{}",
        failures.len(),
        failures.join("\n")
    );
    assert!(
        2 * refused < rendered,
        "{refused} of {rendered} refused by the reader"
    );
}
