//! Settings that describe no picture are errors of the library, for both engines.

use phalanx::frame::{
    Accel, AccelRef, Control, Engine, FrameError, RayCost, RefinedFrame, Settings, Tile, render,
    render_heatmap,
};
use phalanx::scene::Scene;

fn scene() -> Scene {
    let mut scene = Scene::new();
    scene.add_spheres(&[[0.0; 3]], &[1.0]).expect("a sphere");
    scene
}

#[test]
fn pictures_without_pixels_are_refused() {
    let scene = scene();
    let control = Control::default();
    let all = Settings {
        width: 40,
        height: 30,
        ..Settings::of(&scene)
    };
    let part = |x, y, width, height| Settings {
        region: Some(Tile {
            x,
            y,
            width,
            height,
        }),
        ..all.clone()
    };
    let size = |width, height| Settings {
        width,
        height,
        ..all.clone()
    };
    let empty = [
        size(0, 30),
        size(40, 0),
        size(0, 0),
        part(40, 0, 8, 8),
        part(4000, 17, 8, 8),
        part(0, 30, 40, 1),
        part(3, 3, 0, 5),
        part(u32::MAX, u32::MAX, u32::MAX, u32::MAX),
    ];
    for engine in [Engine::Simd, Engine::Scalar] {
        let accel = Accel::build(&scene, engine);
        for settings in &empty {
            let refused = render(&scene, &accel, settings, &control).map(drop);
            assert_eq!(refused, Err(FrameError::NoPixels), "{settings:?}");
        }
        // One column of the region lies in the picture.
        let frame = render(&scene, &accel, &part(39, 29, 8, 8), &control).expect("a pixel");
        assert_eq!((frame.film.width, frame.film.height), (1, 1));
    }
    let accel = Accel::build(&scene, Engine::Simd);
    let AccelRef::Packets(bvh) = accel.accel() else {
        panic!("packets")
    };
    for settings in &empty {
        let refused = render_heatmap(&scene, bvh, settings, RayCost::Nodes, &control);
        assert_eq!(refused, Err(FrameError::NoPixels), "{settings:?}");
    }
    for settings in &empty[..3] {
        let mut refined = RefinedFrame::new(settings.clone());
        let refused = refined.refine(&scene, bvh, &control, 9).map(drop);
        assert_eq!(refused, Err(FrameError::NoPixels), "{settings:?}");
    }
}

#[test]
fn a_weight_that_is_not_a_number_is_refused() {
    let scene = scene();
    let control = Control::default();
    for engine in [Engine::Simd, Engine::Scalar] {
        let accel = Accel::build(&scene, engine);
        let with = |min_weight| Settings {
            width: 8,
            height: 8,
            min_weight: Some(min_weight),
            ..Settings::of(&scene)
        };
        let refused = render(&scene, &accel, &with(f32::NAN), &control).map(drop);
        assert_eq!(refused, Err(FrameError::MinWeight));
        for weight in [-1.0, 0.0, f32::INFINITY] {
            assert!(render(&scene, &accel, &with(weight), &control).is_ok());
        }
    }
}
