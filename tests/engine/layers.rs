//! Layers other than radiance, compared with known facts of a scene, in both engines.

use crate::common::tolerances::LAYER_SUM;
use exr::prelude::{ReadChannels, ReadLayers};
use phalanx::formats::read_test;
use phalanx::frame::{
    Accel, Adaptive, Aov, Aovs, Control, Engine, Sampling, Settings, Tile, render,
};
use phalanx::image::{Depth, Exposure, ImageFormat, PictureFile, PictureHeader, save_bands};
use phalanx::render::Film;
use phalanx::scene::Scene;

/// A mirror and a piece of glass in front of a wall of two materials, seen from a distance of 5,
/// with a gap between them.
const SCENE: &str = "size 64 48\nmaxdepth 3\ncamera 0 0 5 0 0 0 0 1 0 45\npoint 3 4 6 1 1 1\nambient .1 .1 .1\n\
    diffuse .6 .3 .2\nvertex -9 -9 -1\nvertex 0 -9 -1\nvertex 0 9 -1\nvertex -9 9 -1\ntri 0 1 2\ntri 0 2 3\n\
    diffuse .2 .3 .6\nspecular .5 .5 .5\nsphere -1 0 0 .5\nspecular 0 0 0\ntransmission .8 .8 .8\nior 1.3\nsphere 1 0 0 .5\n";

fn scene() -> Scene {
    read_test(SCENE).expect("a scene").scene
}

/// The film with all layers, after asserting that both engines agree, bit for bit.
fn film(shared: &Settings) -> Film {
    let scene = scene();
    let [simd, scalar] = [Engine::Simd, Engine::Scalar].map(|engine| {
        let settings = Settings {
            engine,
            aovs: Aovs::all(),
            ..shared.clone()
        };
        let prepared = Accel::build(&scene, engine);
        render(&scene, &prepared, &settings, &Control::default())
            .expect("a frame")
            .film
    });
    let channels = Aovs::all().channels().collect::<Vec<_>>();
    let names = ["R", "G", "B"]
        .into_iter()
        .chain(channels.into_iter().map(|(name, _)| name));
    for ((name, a), b) in names.zip(simd.all_planes()).zip(scalar.all_planes()) {
        let differ = |k: &usize| a[*k].to_bits() != b[*k].to_bits();
        let first = (0..a.len()).find(differ);
        assert_eq!(first, None, "{name}");
    }
    simd
}

/// The channels of a layer of a pixel.
fn layer(film: &Film, aov: Aov, x: u32, y: u32) -> Vec<f32> {
    let before = film.aovs.iter().take_while(|other| *other != aov);
    let before: usize = before.map(|other| other.channels().len()).sum();
    let position = (y * film.width + x) as usize;
    let channels = film.aov_planes[before..].iter().take(aov.channels().len());
    channels.map(|channel| channel[position]).collect()
}

fn id(film: &Film, aov: Aov, x: u32, y: u32) -> u32 {
    layer(film, aov, x, y)[0].to_bits()
}

#[test]
fn layers_tell_what_is_known_of_the_scene() {
    let settings = Settings::of(&scene());
    let film = film(&settings);
    // The middle of the picture, left of it: the wall, 6 away along the axis.
    let (x, y) = (31, 24);
    let position = layer(&film, Aov::Position, x, y);
    assert!((position[2] + 1.0).abs() < 1e-5, "{position:?}");
    let away = [position[0], position[1], position[2] - 5.0];
    let distance = away.iter().map(|c| c * c).sum::<f32>().sqrt();
    assert!((layer(&film, Aov::Depth, x, y)[0] - distance).abs() < 1e-5);
    assert_eq!(layer(&film, Aov::Ng, x, y), [0.0, 0.0, 1.0]);
    assert_eq!(layer(&film, Aov::Ns, x, y), [0.0, 0.0, 1.0]);
    assert_eq!(layer(&film, Aov::Albedo, x, y), [0.6, 0.3, 0.2]);
    assert!(id(&film, Aov::Primitive, x, y) < 2);
    // To the right of it is nothing at all.
    let (x, y) = (63, 0);
    assert_eq!(layer(&film, Aov::Depth, x, y), [f32::INFINITY]);
    assert_eq!(layer(&film, Aov::Ns, x, y), [0.0; 3]);
    assert_eq!(id(&film, Aov::Material, x, y), u32::MAX);
    assert_eq!(id(&film, Aov::Primitive, x, y), u32::MAX);
    // Mirror and glass, by their middles: normals toward the viewer, light by each way.
    let column = |x: f64| (32.0 + x / 5.0 * 24.0 / (22.5f64.to_radians()).tan()) as u32;
    for (x, prim, way, other) in [
        (-1.0, 2, Aov::Reflection, Aov::Refraction),
        (1.0, 3, Aov::Refraction, Aov::Reflection),
    ] {
        let x = column(x);
        assert_eq!(id(&film, Aov::Primitive, x, 24), prim);
        assert!(layer(&film, Aov::Ns, x, 24)[2] > 0.9);
        // It shows the wall somewhere, and by no other way anywhere.
        let places = (0..48).flat_map(|y| (0..64).map(move |x| (x, y)));
        let own = places.filter(|&(x, y)| id(&film, Aov::Primitive, x, y) == prim);
        let own: Vec<_> = own.collect();
        let shown = own
            .iter()
            .filter(|&&(x, y)| layer(&film, way, x, y)[0] > 0.0);
        assert!(shown.count() > 4, "{way:?}");
        assert!(
            own.iter()
                .all(|&(x, y)| layer(&film, other, x, y) == [0.0; 3])
        );
    }
    let materials = [31, column(-1.0), column(1.0)].map(|x| id(&film, Aov::Material, x, 24));
    assert!(
        materials[0] != materials[1] && materials[1] != materials[2],
        "{materials:?}"
    );
}

/// All light belongs to some path, regardless of the sampling; and the number of samples is
/// reported.
#[test]
fn light_adds_up_to_radiance() {
    let adaptive = Some(Adaptive { threshold: 0.01 });
    let many = Sampling {
        spp: 16,
        ..Sampling::CENTER
    };
    for sampling in [Sampling::CENTER, many, Sampling { adaptive, ..many }] {
        let region = Tile {
            x: 5,
            y: 3,
            width: 49,
            height: 41,
        };
        let settings = Settings {
            sampling,
            region: Some(region),
            ..Settings::of(&scene())
        };
        let film = film(&settings);
        let mut counts = Vec::new();
        for (x, y) in (0..41).flat_map(|y| (0..49).map(move |x| (x, y))) {
            let [direct, reflection, refraction] =
                [Aov::Direct, Aov::Reflection, Aov::Refraction].map(|aov| layer(&film, aov, x, y));
            for (c, radiance) in film.pixel(x, y).into_iter().enumerate() {
                let sum = (direct[c] + reflection[c]) + refraction[c];
                assert!(
                    (sum - radiance).abs() <= LAYER_SUM * radiance,
                    "{sum} {radiance}"
                );
            }
            counts.push(id(&film, Aov::Samples, x, y));
        }
        counts.sort_unstable();
        let (least, most) = (counts[0], counts[counts.len() - 1]);
        match (sampling.spp, sampling.adaptive) {
            (spp, None) => assert_eq!((least, most), (spp, spp)),
            (spp, Some(_)) => assert!(least < spp && most == spp, "{least} {most}"),
        }
    }
}

#[test]
fn the_file_has_them_by_name() {
    let settings = Settings::of(&scene());
    let film = film(&settings);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let file = PictureFile {
        width: 64,
        height: 48,
        crop: None,
        format: ImageFormat::Exr,
        aovs: Aovs::all(),
        origin: [0.0; 3],
        exposure: Exposure::from(scene().encoding),
        depth: Depth::Standard,
        header: PictureHeader::NONE,
    };
    save_bands(&path, &file, [Ok(film.clone())]).unwrap();
    let read = exr::image::read::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(&path)
        .unwrap();
    let list = read.layer_data.channel_data.list;
    let names: Vec<_> = Aovs::all().channels().collect();
    assert_eq!(list.len(), 3 + names.len());
    let planes = film.all_planes();
    for (k, (name, plane)) in names.into_iter().enumerate() {
        let channel = list.iter().find(|channel| channel.name.to_string() == name);
        let samples = &channel.unwrap_or_else(|| panic!("{name}")).sample_data;
        let bits: Vec<u32> = match samples {
            exr::image::FlatSamples::F32(values) if !plane => {
                values.iter().map(|v| v.to_bits()).collect()
            }
            exr::image::FlatSamples::U32(values) if plane => values.clone(),
            _ => panic!("{name} is of another type"),
        };
        let want: Vec<u32> = planes[3 + k].iter().map(|v| v.to_bits()).collect();
        assert!(bits == want, "{name}");
    }
}

/// Positions are in the file's units, relative to its origin, so that they keep their digits.
#[test]
fn positions_are_relative_to_the_origin() {
    let far = Scene {
        origin: [500_000.5, 0.0, -4_012_345.0],
        scale: 0.25,
        ..scene()
    };
    let near = scene();
    let films = [Engine::Simd, Engine::Scalar].map(|engine| {
        let film = |scene: &Scene| {
            let settings = Settings {
                engine,
                aovs: Aovs::NONE.with(Aov::Position),
                ..Settings::of(scene)
            };
            let prepared = Accel::build(scene, engine);
            render(scene, &prepared, &settings, &Control::default())
                .unwrap()
                .film
        };
        [film(&near), film(&far)]
    });
    assert_eq!(
        films[0][1].aov_planes, films[1][1].aov_planes,
        "both engines"
    );
    let [near, far] = &films[0];
    let mut hit = 0;
    for axis in 0..3 {
        for (near, far) in near.aov_planes[axis].iter().zip(&far.aov_planes[axis]) {
            let want = near / 0.25;
            let missed = *near == 0.0 && *far == 0.0;
            assert!(missed || *far == want, "{far}, not {want}");
            hit += usize::from(!missed);
        }
    }
    assert!(hit > 3000, "{hit} coordinates of hits");
}
