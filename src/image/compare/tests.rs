//! Figures of pictures with known differences, compared with scikit-image 0.26, numpy, and
//! flip-evaluator 1.7.

use super::super::bands::save_bands;
use super::super::description::{Depth, PictureFile};
use super::super::encoder::{Exposure, Picture, ToneCurve};
use super::super::error::CompareError;
use super::super::format::ImageFormat;
use super::super::png::save_png;
use super::super::read::{PictureReader, load};
use super::*;
use phalanx_scene::OutputEncoding;
use phalanx_scene::film::{Aov, Aovs, Film};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

const SIDES: (u32, u32) = (32, 24);

/// A sample of a picture with edges, and of one that differs from its tenth column on.
fn sample(x: u32, y: u32, c: u32, changed: bool) -> u8 {
    let first = (x * 7 + y * 13 + c * 31 + (x * y) % 11 * 5) % 256;
    let more = if changed && x >= 10 { (x * 3 + y * 5 + c) % 7 } else { 0 };
    (first + more).min(255) as u8
}

fn for_screen(changed: bool) -> Picture {
    let (width, height) = SIDES;
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let rgb = pixels.flat_map(|(x, y)| [0, 1, 2].map(|c| sample(x, y, c, changed)));
    Picture {
        width,
        height,
        rgb: rgb.collect(),
    }
}

/// The same samples as radiance of 0 to 4, with a depth that is infinite in the first column.
fn linear(changed: bool, aovs: Aovs) -> Film {
    let mut film = Film::new(SIDES.0, SIDES.1, false).with_aovs(aovs);
    for (k, (x, y)) in (0..SIDES.1)
        .flat_map(|y| (0..SIDES.0).map(move |x| (x, y)))
        .enumerate()
    {
        for c in 0..3 {
            film.planes[c as usize][k] = f32::from(sample(x, y, c, changed)) / 64.0;
        }
        for plane in &mut film.aov_planes {
            plane[k] = if x == 0 { f32::INFINITY } else { (x + y) as f32 };
        }
    }
    film
}

fn save(folder: &TempDir, name: &str, film: Film) -> PathBuf {
    let path = folder.path().join(name);
    let format = ImageFormat::of(&path).unwrap();
    let file = PictureFile {
        width: film.width,
        height: film.height,
        crop: None,
        format,
        aovs: film.aovs,
        origin: [0.0; 3],
        exposure: Exposure {
            stops: 0.0,
            curve: ToneCurve::Linear,
            encoding: OutputEncoding::LINEAR,
        },
        depth: match format {
            ImageFormat::Exr => Depth::Standard,
            _ => Depth::Sixteen,
        },
        header: Default::default(),
    };
    save_bands(&path, &file, [Ok(film)]).unwrap();
    path
}

fn open(path: &Path) -> PictureReader {
    PictureReader::open(path).unwrap()
}

fn compared(a: &Path, b: &Path, tolerance: Option<f64>) -> PictureComparison {
    compare_pictures(&mut open(a), &mut open(b), tolerance).unwrap()
}

fn close(got: f64, want: f64) {
    assert!(
        (got - want).abs() < 1e-9 * want.abs().max(1.0),
        "{got} {want}"
    );
}

#[test]
fn figures_of_a_screen_are_those_of_scikit_image() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = ["a.png", "b.png"].map(|name| folder.path().join(name));
    save_png(&a, &for_screen(false)).unwrap();
    save_png(&b, &for_screen(true)).unwrap();
    let comparison = compared(&a, &b, None);
    assert!(comparison.display && !comparison.identical());
    assert_eq!((comparison.differing, comparison.layers.len()), (528, 1));
    let layer = &comparison.layers[0];
    assert_eq!((&layer.name[..], layer.differing), ("color", 528));
    let largest = layer.largest.as_ref().unwrap();
    assert_eq!((largest.value, largest.x, largest.y), (6.0, 11, 0));
    assert_eq!(largest.channel, "G");
    close(layer.rmse, 2.967_196_230_825_022_6);
    close(layer.psnr.unwrap(), 38.683_878_235_787_4);
    close(layer.ssim.unwrap(), 0.998_223_152_282_098);
    // The evaluator of its authors computes in single precision.
    let flip = layer.flip.unwrap();
    assert!((flip - 0.059_993).abs() < 2e-5, "{flip}");
    assert_eq!(compared(&a, &b, Some(3.0)).differing, 377);
    assert_eq!(compared(&a, &b, Some(6.0)).differing, 0);
    let same = compared(&a, &a, None);
    assert!(same.identical() && same.layers[0].largest.is_none());
    assert_eq!(
        (same.layers[0].psnr, same.layers[0].ssim),
        (None, Some(1.0))
    );
}

#[test]
fn figures_of_radiance_are_those_of_numpy_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    for (first, second) in [
        ("exr", "exr"),
        ("pfm", "pfm"),
        ("exr", "pfm"),
        ("hdr", "exr"),
    ] {
        let a = save(&folder, &format!("a.{first}"), linear(false, Aovs::NONE));
        let b = save(&folder, &format!("b.{second}"), linear(true, Aovs::NONE));
        let comparison = compared(&a, &b, None);
        let layer = &comparison.layers[0];
        assert!(!comparison.display);
        // RGBE has eight bits for the largest component, so that these samples lose some.
        if first != "hdr" {
            assert_eq!(layer.largest.as_ref().unwrap().value, 0.093_75);
            close(layer.rmse, 0.046_362_441_106_640_98);
            close(layer.psnr.unwrap(), 38.683_878_235_787_4);
            close(layer.ssim.unwrap(), 0.992_222_868_115_071_5);
            let flip = layer.flip.unwrap();
            assert!((flip - 0.058_126).abs() < 2e-5, "{flip}");
            assert_eq!(comparison.differing, 528);
        }
        assert!((layer.rmse - 0.046).abs() < 0.01, "{}", layer.rmse);
        assert!(compared(&a, &a, None).identical());
    }
}

#[test]
fn layers_are_compared_one_by_one_and_missing_ones_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let [both, more] = [
        Aovs::NONE.with(Aov::Depth),
        Aovs::NONE
            .with(Aov::Depth)
            .with(Aov::Material)
            .with(Aov::Ns),
    ];
    let a = save(&folder, "a.exr", linear(false, both));
    let mut film = linear(false, more);
    film.aov_planes[0][5] += 0.5;
    film.aov_planes[0][0] = 1.0;
    let b = save(&folder, "b.exr", film);
    let comparison = compared(&a, &b, Some(0.25));
    let names: Vec<&str> = comparison
        .layers
        .iter()
        .map(|layer| &layer.name[..])
        .collect();
    assert_eq!(names, ["color", "Z"]);
    assert!(comparison.layers[0].identical);
    let depth = &comparison.layers[1];
    assert_eq!(depth.largest.as_ref().unwrap().value, 0.5);
    assert_eq!((depth.differing, comparison.differing), (2, 2));
    assert_eq!(depth.not_finite.infinite, [24, 23]);
    assert_eq!(depth.not_finite.different, 1);
    assert_eq!(depth.ssim, None);
    assert_eq!(
        comparison.only_in,
        [vec![], vec!["N".to_owned(), "material".to_owned()]]
    );
    assert!(!comparison.identical());
    // A format with only colours cannot have them.
    let c = save(&folder, "c.pfm", linear(false, Aovs::NONE));
    let comparison = compared(&b, &c, None);
    assert!(comparison.identical());
    assert_eq!(comparison.left_out, ["N", "Z", "material"]);
}

#[test]
fn what_is_no_number_equals_its_like_alone() {
    let folder = tempfile::tempdir().unwrap();
    let mut film = linear(false, Aovs::NONE);
    film.planes[0][0] = f32::NAN;
    film.planes[1][1] = f32::INFINITY;
    film.planes[2][2] = f32::NEG_INFINITY;
    film.planes[2][4] = 0.0;
    let a = save(&folder, "a.pfm", film.clone());
    let mut other = film.clone();
    other.planes[0][0] = f32::from_bits(f32::NAN.to_bits() | 1);
    other.planes[2][4] = -0.0;
    let b = save(&folder, "b.pfm", other);
    assert!(compared(&a, &a, None).identical());
    // Other bits of the same numbers: every bit counts only without a tolerance.
    let bits = compared(&a, &b, None);
    assert_eq!((bits.identical(), bits.differing), (false, 2));
    assert_eq!(compared(&a, &b, Some(0.0)).differing, 0);
    for (place, value) in [
        (0, 1.0),
        (1, f32::NEG_INFINITY),
        (1, f32::NAN),
        (3, f32::NAN),
    ] {
        let mut other = film.clone();
        other.planes[place.min(1)][place] = value;
        let c = save(&folder, "c.pfm", other);
        let comparison = compared(&a, &c, Some(1e30));
        assert_eq!(comparison.differing, 1, "{place} {value}");
        assert_eq!(comparison.layers[0].not_finite.different, 1);
        assert!(comparison.layers[0].rmse.is_finite());
    }
}

#[test]
fn pictures_of_other_meaning_or_size_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let exr = save(&folder, "a.exr", linear(false, Aovs::NONE));
    let png = save(&folder, "a.png", linear(false, Aovs::NONE));
    let pfm = save(&folder, "small.pfm", Film::new(3, 2, false));
    let refusal = |a: &Path, b: &Path| {
        let refused = compare_pictures(&mut open(a), &mut open(b), None);
        refused.unwrap_err()
    };
    for (a, b) in [(&exr, &png), (&png, &exr)] {
        let CompareError::Meaning { linear, display } = refusal(a, b) else {
            panic!("compared");
        };
        assert_eq!((linear, display), (exr.clone(), png.clone()));
    }
    let sizes = refusal(&exr, &pfm).to_string();
    assert_eq!(sizes, "the pictures differ in size: 32x24 and 3x2");
}

/// Straight alpha weights colours where they are shown; the samples themselves are compared as they
/// are.
#[test]
fn colours_that_alpha_hides_are_not_seen() {
    let folder = tempfile::tempdir().unwrap();
    let alpha = Aovs::NONE.with(Aov::Alpha);
    let saved = |name: &str, changed: bool, shade: &dyn Fn(usize) -> f32| {
        let mut film = linear(changed, alpha);
        for k in 0..film.aov_planes[0].len() {
            let a = shade(k);
            film.aov_planes[0][k] = a;
            // Radiance of a film is already weighted.
            film.planes.iter_mut().for_each(|plane| plane[k] *= a / 4.0);
        }
        save(&folder, name, film)
    };
    // Other colours, but as good as invisible from the tenth column on.
    let faint = |k: usize| if k % 32 < 10 { 1.0 } else { 1e-5 };
    let [a, b] = [("a.png", false), ("b.png", true)].map(|(n, changed)| saved(n, changed, &faint));
    let comparison = compared(&a, &b, None);
    let layer = &comparison.layers[0];
    assert_eq!(layer.channels, ["R", "G", "B", "A"]);
    assert!(layer.rmse > 1.0 && comparison.differing == 528, "{layer:?}");
    assert!(layer.ssim.unwrap() > 0.999_999, "{:?}", layer.ssim);
    assert!(layer.flip.unwrap() < 1e-3, "{:?}", layer.flip);
    // The same colours, but half of them half as visible.
    let half = |k: usize| if k % 32 < 10 { 1.0_f32 } else { 0.5 };
    let [c, d] = [
        ("c.png", &half as &dyn Fn(usize) -> f32),
        ("d.png", &|_| 1.0),
    ]
    .map(|(name, shade)| saved(name, false, shade));
    let comparison = compared(&c, &d, None);
    let layer = &comparison.layers[0];
    assert!(layer.rmse < 1e-2 && layer.flip.unwrap() > 0.05, "{layer:?}");
    assert_eq!(layer.largest.as_ref().unwrap().channel, "A");
    assert!(compared(&c, &c, None).identical());
    let side_by_side = folder.path().join("beside.png");
    save_side_by_side(&side_by_side, &mut open(&c), &mut open(&d), &comparison).unwrap();
    let side_by_side = load(&side_by_side).unwrap();
    for x in 0..32 {
        let [left, right] = [x, x + 40].map(|x| i32::from(side_by_side.pixels[x][1] / 257));
        let shown = if x < 10 { right } else { right / 2 };
        assert!((left - shown).abs() <= 1, "{x}: {left} of {right}");
    }
}

#[test]
fn sixteen_bits_and_jpeg_are_in_steps_of_eight_bits() {
    let folder = tempfile::tempdir().unwrap();
    let mut film = linear(false, Aovs::NONE);
    film.planes.iter_mut().flatten().for_each(|s| *s /= 8.0);
    let a = save(&folder, "a.png", film.clone());
    film.planes[1][3] += 1.5 / 65_535.0;
    let b = save(&folder, "b.png", film.clone());
    let comparison = compared(&a, &b, None);
    let largest = comparison.layers[0].largest.as_ref().unwrap();
    assert!(
        largest.value > 0.0 && largest.value <= 2.0 / 257.0,
        "{largest:?}"
    );
    assert_eq!((largest.x, largest.y, comparison.differing), (3, 0, 1));
    let jpeg = save(&folder, "a.jpg", film);
    let comparison = compared(&a, &jpeg, Some(255.0));
    assert!(!comparison.identical() && comparison.differing == 0);
    assert!(comparison.layers[0].rmse > 0.0 && comparison.layers[0].rmse < 40.0);
}

#[test]
fn pictures_of_differences_show_them() {
    let folder = tempfile::tempdir().unwrap();
    let depth = Aovs::NONE.with(Aov::Depth);
    let a = save(&folder, "a.exr", linear(false, depth));
    let mut film = linear(true, depth);
    film.planes[0][0] = f32::NAN;
    let b = save(&folder, "b.exr", film);
    let comparison = compared(&a, &b, None);
    let [heat, side_by_side] = ["heat.png", "beside.png"].map(|name| folder.path().join(name));
    save_heat(&heat, &mut open(&a), &mut open(&b), &comparison).unwrap();
    save_side_by_side(&side_by_side, &mut open(&a), &mut open(&b), &comparison).unwrap();
    let (heat, side_by_side) = (load(&heat).unwrap(), load(&side_by_side).unwrap());
    assert_eq!((heat.width, heat.height), SIDES);
    assert_eq!(heat.pixels[0], [0, 65_535, 65_535, 65_535]);
    let lit = heat.pixels.iter().filter(|p| p[0] > 0).count();
    assert_eq!(lit as u64, comparison.differing - 1);
    assert_eq!((side_by_side.width, side_by_side.height), (3 * 32 + 16, 24));
    let row = |y: usize| &side_by_side.pixels[y * 112..(y + 1) * 112];
    for y in 0..24 {
        assert_eq!(row(y)[80..], heat.pixels[y * 32..(y + 1) * 32]);
        assert_eq!(row(y)[1..10], row(y)[41..50]);
        assert_eq!(row(y)[32..40], [[64 * 257, 64 * 257, 64 * 257, 65_535]; 8]);
    }
    // 25/64 is 0.6593 in sRGB.
    let index = (0..24 * 32).position(|k: u32| sample(k % 32, k / 32, 0, false) == 25);
    let index = index.unwrap();
    assert_eq!(row(index / 32)[index % 32][0], 168 * 257);
}
