//! Alpha and Cryptomatte layers, compared with known facts of a scene, in both engines.

use phalanx::formats::read_test;
use phalanx::frame::{
    Accel, Adaptive, Aov, Aovs, Control, Engine, Filter, Integrator, Sampling, Settings, render,
};
use phalanx::render::Film;
use phalanx::scene::{Scene, matte_id};
use std::collections::BTreeMap;

/// Three panes one behind the other, each shifted right by a pixel, and a ball next to them. A
/// picture of parallel rays, one scene unit per pixel.
const SCENE: &str = "size 16 8\ncamera 0 0 9 0 0 0 0 1 0 45\northo 8\npoint 3 4 6 1 1 1\nambient .1 .1 .1\n\
    diffuse .6 .3 .2\n\
    vertex -6 -4 2\nvertex -2 -4 2\nvertex -2 4 2\nvertex -6 4 2\ntri 0 1 2\ntri 0 2 3\n\
    diffuse .2 .3 .6\n\
    vertex -5 -4 1\nvertex -1 -4 1\nvertex -1 4 1\nvertex -5 4 1\ntri 4 5 6\ntri 4 6 7\n\
    diffuse .2 .6 .2\n\
    vertex -4 -4 0\nvertex 0 -4 0\nvertex 0 4 0\nvertex -4 4 0\ntri 8 9 10\ntri 8 10 11\n\
    diffuse .9 .9 .2\nsphere 4 0 0 3\n";

/// The scene with these opacities of the panes.
fn scene(opacity: [f32; 3]) -> Scene {
    let mut scene = read_test(SCENE).expect("a scene").scene;
    for (pane, opacity) in opacity.into_iter().enumerate() {
        let material = scene.prim_material(2 * pane as u32) as usize;
        scene.materials.opacity[material] = opacity;
    }
    scene
}

/// Values of a pixel: alpha, and the coverage of each object and of each material.
struct Mattes {
    alpha: f32,
    objects: BTreeMap<u32, f32>,
    materials: BTreeMap<u32, f32>,
}

/// The pixels of the scene, after asserting that both engines make the same film, bit for bit.
fn pixels(scene: &Scene, shared: &Settings) -> Vec<Mattes> {
    let aovs = [Aov::Alpha, Aov::CryptoObject, Aov::CryptoMaterial];
    let aovs = aovs.into_iter().fold(Aovs::NONE, Aovs::with);
    let [simd, scalar] = [Engine::Simd, Engine::Scalar].map(|engine| {
        let settings = Settings {
            engine,
            aovs,
            ..shared.clone()
        };
        let prepared = Accel::build(scene, engine);
        render(scene, &prepared, &settings, &Control::default())
            .expect("a frame")
            .film
    });
    let bits = |film: &Film| -> Vec<Vec<u32>> {
        let planes = film.all_planes().into_iter();
        planes
            .map(|plane| plane.iter().map(|value| value.to_bits()).collect())
            .collect()
    };
    assert!(bits(&simd) == bits(&scalar), "{shared:?}");
    let planes = &simd.aov_planes;
    let mattes = |offset: usize| {
        let ranks = |planes: &[Vec<f32>]| {
            let pairs = planes.as_chunks::<2>().0.iter();
            let pairs: Vec<_> = pairs.map(|[id, part]| (id[offset], part[offset])).collect();
            assert!(pairs.is_sorted_by(|a, b| a.1 >= b.1), "{pairs:?}");
            let there = pairs.into_iter().take_while(|(_, part)| *part > 0.0);
            there.map(|(id, part)| (id.to_bits(), part)).collect()
        };
        Mattes {
            alpha: planes[0][offset],
            objects: ranks(&planes[1..13]),
            materials: ranks(&planes[13..25]),
        }
    };
    (0..simd.planes[0].len()).map(mattes).collect()
}

fn ids(names: &[(&str, f32)]) -> BTreeMap<u32, f32> {
    let pairs = names.iter().map(|(name, part)| (matte_id(name), *part));
    pairs.collect()
}

/// One ray per pixel: each pane covers its share of what the panes in front leave.
#[test]
fn panes_take_their_parts_of_a_ray() {
    let scene = scene([0.5, 0.25, 1.0]);
    let pixels = pixels(&scene, &Settings::of(&scene));
    let row = |x: usize| &pixels[4 * 16 + x];
    // Columns of the first pane alone, of the first and second, of all, of the last, of none.
    let [a, b, c] = ["triangles0", "triangles2", "triangles4"];
    for (x, parts) in [
        (2, &[(a, 0.5)][..]),
        (3, &[(a, 0.5), (b, 0.125)]),
        (5, &[(a, 0.5), (b, 0.125), (c, 0.375)]),
        (6, &[(b, 0.25), (c, 0.75)]),
        (7, &[(c, 1.0)]),
        (8, &[]),
        (12, &[("sphere6", 1.0)]),
    ] {
        assert_eq!(row(x).objects, ids(parts), "column {x}");
        assert_eq!(row(x).materials.len(), parts.len(), "column {x}");
        let sum: f32 = parts.iter().map(|(_, part)| part).sum();
        assert_eq!(row(x).alpha, sum, "column {x}");
    }
    // A fully transparent pane covers nothing, and ambient occlusion treats the others as opaque.
    let scene = self::scene([0.0, 0.25, 1.0]);
    let pixels = self::pixels(
        &scene,
        &Settings {
            integrator: Integrator::Occlusion { distance: 1.0 },
            ..Settings::of(&scene)
        },
    );
    assert_eq!(pixels[4 * 16 + 2].objects, ids(&[]));
    assert_eq!(pixels[4 * 16 + 5].objects, ids(&[(b, 1.0)]));
}

/// With many rays, coverage is the area of the objects in a pixel, and adds up to alpha for any
/// sampling.
#[test]
fn parts_are_areas_and_add_up_to_alpha() {
    let scene = scene([0.5, 1.0, 1.0]);
    let many = Sampling {
        spp: 256,
        ..Sampling::CENTER
    };
    let adaptive = Some(Adaptive { threshold: 0.002 });
    let mut glossy = scene.clone();
    glossy.materials.gloss[1] = 9.0;
    for (scene, sampling) in [
        (&scene, many),
        (&scene, Sampling { adaptive, ..many }),
        (&glossy, Sampling { adaptive, ..many }),
    ] {
        let settings = Settings {
            sampling,
            ..Settings::of(scene)
        };
        let pixels = pixels(scene, &settings);
        for (offset, pixel) in pixels.iter().enumerate() {
            for parts in [&pixel.objects, &pixel.materials] {
                let sum: f32 = parts.values().sum();
                assert!((sum - pixel.alpha).abs() < 1e-6, "{offset}: {sum}");
            }
            assert!((0.0..=1.0).contains(&pixel.alpha), "{offset}");
        }
        let ball = matte_id("sphere6");
        let part = |pixel: &Mattes| pixel.objects.get(&ball).copied().unwrap_or(0.0);
        let area: f32 = pixels.iter().map(part).sum();
        let circle = 9.0 * std::f32::consts::PI;
        assert!((area - circle).abs() < 0.2, "{area} {circle}");
        // The sphere's edge crosses this pixel from side to side.
        let edge = &pixels[16 + 13];
        assert!((0.4..0.7).contains(&edge.alpha), "{}", edge.alpha);
    }
    // A filter with negative weights must not give negative coverage.
    let filter = Filter::Mitchell;
    let settings = Settings {
        sampling: Sampling { filter, ..many },
        ..Settings::of(&scene)
    };
    let pixels = pixels(&scene, &settings);
    let parts = pixels.iter().flat_map(|pixel| pixel.objects.values());
    assert!(parts.into_iter().all(|part| (0.0..=1.0).contains(part)));
}

/// With alpha, radiance is that of the surfaces alone: over the background, it gives the picture
/// without alpha.
#[test]
fn the_background_is_what_alpha_leaves() {
    let background = glam::Vec3::new(0.2, 0.5, 0.75);
    let scene = Scene {
        background,
        ..scene([0.5, 0.25, 1.0])
    };
    let sampling = Sampling {
        spp: 16,
        filter: Filter::Tent,
        ..Sampling::CENTER
    };
    for integrator in [Integrator::Whitted, Integrator::Occlusion { distance: 1.0 }] {
        let film = |aovs| {
            let settings = Settings {
                aovs,
                sampling,
                integrator,
                ..Settings::of(&scene)
            };
            let prepared = Accel::build(&scene, Engine::Simd);
            render(&scene, &prepared, &settings, &Control::default())
                .expect("a frame")
                .film
        };
        let alone = film(Aovs::NONE.with(Aov::Alpha));
        let full = film(Aovs::NONE);
        let mut clear = 0;
        for offset in 0..full.planes[0].len() {
            let alpha = alone.aov_planes[0][offset];
            for ((alone, full), behind) in
                (alone.planes.iter().zip(&full.planes)).zip(background.to_array())
            {
                let over = alone[offset] + (1.0 - alpha) * behind;
                assert!((over - full[offset]).abs() < 1e-5, "{offset}: {over}");
                assert!(alpha > 0.0 || alone[offset] == 0.0, "{offset}");
            }
            clear += usize::from(alpha == 0.0);
        }
        assert!(clear > 20, "{clear} pixels of background");
    }
}
