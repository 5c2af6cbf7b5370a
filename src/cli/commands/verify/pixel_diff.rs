//! The first difference between two films, and the values of both engines at that pixel.

use phalanx::files::quoted_text;
use phalanx::frame::Settings;
use phalanx::image::{HitBits, PixelBits, differing_pixels};
use phalanx::render::{Film, NO_HIT};
use phalanx::report::counted;
use phalanx::scene::Scene;
use serde::Serialize;
use std::fmt;

/// The first pixel at which two films differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FilmDifference {
    x: u32,
    y: u32,
    /// Number of pixels that differ.
    pixels: usize,
    /// The pixel's first camera ray; a rendered scene has one.
    ray: Option<CameraRay>,
    scalar: PixelRecord,
    simd: PixelRecord,
}

/// The values of a pixel, and the names of the object and the material that it shows.
#[derive(Clone, Debug, PartialEq)]
struct PixelRecord {
    bits: PixelBits,
    names: [Option<String>; 2],
}

impl PixelRecord {
    fn of(scene: &Scene, film: &Film, i: usize) -> PixelRecord {
        let bits = PixelBits::of(film, i);
        let prim = bits.hit.map_or(NO_HIT, |hit| hit.prim_id);
        let names = scene.prim_names(prim).map(|name| name.map(str::to_owned));
        PixelRecord { bits, names }
    }
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct CameraRay {
    org: [f64; 3],
    dir: [f32; 3],
}

/// Compares two films of one size, hits and radiance, bit by bit.
pub fn first_difference(
    scene: &Scene,
    settings: &Settings,
    scalar: &Film,
    simd: &Film,
) -> Option<FilmDifference> {
    let (first, pixels) = differing_pixels(scalar, simd)?;
    let width = scalar.width as usize;
    let window = settings.window();
    let [column, row] = [first % width, first / width].map(|index| index as u32);
    let (x, y) = (window.x + column, window.y + row);
    Some(FilmDifference {
        x,
        y,
        pixels,
        ray: camera_ray(scene, settings, x, y),
        scalar: PixelRecord::of(scene, scalar, first),
        simd: PixelRecord::of(scene, simd, first),
    })
}

/// The first camera ray of a pixel of the whole picture, in the file's coordinates.
fn camera_ray(scene: &Scene, settings: &Settings, x: u32, y: u32) -> Option<CameraRay> {
    let [org, dir] = settings.first_ray(scene, x, y).ok()?;
    let org = scene.short_position(org.into()).to_array();
    Some(CameraRay { org, dir })
}

impl fmt::Display for FilmDifference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let pixels = counted(self.pixels, "pixel");
        writeln!(f, "{pixels}, first at ({}, {})", self.x, self.y)?;
        if let Some(CameraRay { org, dir }) = &self.ray {
            let ([ox, oy, oz], [x, y, z]) = (org, dir);
            writeln!(f, "  ray    from ({ox}, {oy}, {oz}) toward ({x}, {y}, {z})")?;
        }
        writeln!(f, "  scalar {}", self.scalar)?;
        write!(f, "  simd   {}", self.simd)
    }
}

impl fmt::Display for PixelRecord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.bits.hit {
            None => write!(f, "hit not recorded")?,
            Some(HitBits {
                prim_id: NO_HIT, ..
            }) => write!(f, "hits nothing")?,
            Some(HitBits { prim_id, tuv }) => {
                write!(f, "hits prim {prim_id}")?;
                for (name, bits) in ["t", "u", "v"].iter().zip(tuv) {
                    write!(f, ", {name} {bits:08x} ({})", f32::from_bits(bits))?;
                }
            }
        }
        let [r, g, b] = self.bits.radiance;
        let [red, green, blue] = self.bits.radiance.map(f32::from_bits);
        write!(
            f,
            "; radiance {r:08x} {g:08x} {b:08x} ({red}, {green}, {blue})"
        )?;
        let names = ["object", "material"].iter().zip(&self.names);
        let mut known = names.filter_map(|(kind, name)| Some((kind, name.as_deref()?)));
        known.try_for_each(|(kind, name)| write!(f, "; {kind} {}", quoted_text(name)))
    }
}

impl Serialize for PixelRecord {
    /// Writes the bits as hexadecimal strings, with the numbers next to them for people.
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Shown<'a> {
            prim_id: Option<u32>,
            t_bits: Option<String>,
            u_bits: Option<String>,
            v_bits: Option<String>,
            t: Option<f32>,
            radiance_bits: [String; 3],
            radiance: [f32; 3],
            names: &'a [Option<String>; 2],
        }
        let PixelBits { hit, radiance, .. } = self.bits;
        let hex = |bits: u32| format!("{bits:08x}");
        let tuv = |i: usize| hit.map(|hit| hex(hit.tuv[i]));
        let met = hit.filter(|hit| hit.prim_id != NO_HIT);
        let shown = Shown {
            prim_id: met.map(|hit| hit.prim_id),
            t_bits: tuv(0),
            u_bits: tuv(1),
            v_bits: tuv(2),
            t: met.map(|hit| f32::from_bits(hit.tuv[0])),
            radiance_bits: radiance.map(hex),
            radiance: radiance.map(f32::from_bits),
            names: &self.names,
        };
        shown.serialize(serializer)
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture::film;
    use super::*;
    use phalanx::render::Hits;

    fn settings(width: u32, height: u32) -> Settings {
        Settings {
            width,
            height,
            ..Settings::of(&Scene::default())
        }
    }

    fn difference(other: &Film) -> Option<FilmDifference> {
        first_difference(&Scene::default(), &settings(3, 2), &film(), other)
    }

    fn hits(film: &mut Film) -> &mut Hits {
        film.hits.as_mut().unwrap()
    }

    #[test]
    fn equal_bits_are_equal_nan_included() {
        assert_eq!(difference(&film()), None);
    }

    #[test]
    fn a_difference_in_any_field_is_found_at_its_pixel() {
        let one_up = |v: &mut f32| *v = f32::from_bits(v.to_bits() + 1);
        let changes: [&dyn Fn(&mut Film); 8] = [
            &|f| f.planes[0][4] = -0.0,
            &|f| one_up(&mut f.planes[1][4]),
            &|f| f.planes[2][4] = 0.0,
            &|f| hits(f).prim_id[4] = 9,
            &|f| one_up(&mut hits(f).t[4]),
            &|f| one_up(&mut hits(f).u[4]),
            &|f| one_up(&mut hits(f).v[4]),
            &|f| f.planes[0][5] = 1.0,
        ];
        for (i, change) in changes.iter().enumerate() {
            let mut other = film();
            change(&mut other);
            let first = difference(&other).unwrap();
            let x = if i < 7 { 1 } else { 2 };
            assert_eq!((first.x, first.y, first.pixels), (x, 1, 1), "change {i}");
        }
    }

    #[test]
    fn the_first_of_several_is_named_with_what_both_engines_say() {
        let mut other = film();
        other.planes[0][5] = 1.0;
        hits(&mut other).prim_id[2] = 7;
        hits(&mut other).t[2] = 2.0;
        let report = difference(&other).unwrap();
        let text = report.to_string();
        for part in [
            "2 pixels, first at (2, 0)",
            "from (0, 0, 1) toward (",
            "scalar hits prim 2, t 3f800000 (1)",
            "simd   hits prim 7, t 40000000 (2)",
            "radiance 00000000 3f000000 7fc00000",
        ] {
            assert!(text.contains(part), "{part:?} in\n{text}");
        }
        let json = serde_json::to_value(&report).unwrap();
        assert_eq!((json["x"].as_u64(), json["y"].as_u64()), (Some(2), Some(0)));
        assert_eq!(json["simd"]["prim_id"], 7);
        assert_eq!(json["scalar"]["t_bits"], "3f800000");
    }

    #[test]
    fn what_a_pixel_shows_is_named() {
        let mut scene = Scene::default();
        let balls = scene.add_spheres(&[[0.0; 3]; 3], &[1.0; 3]).unwrap();
        scene.set_name(balls, "b\u{1b}").unwrap();
        let mut other = film();
        hits(&mut other).prim_id[2] = NO_HIT;
        let first = first_difference(&scene, &settings(3, 2), &film(), &other).unwrap();
        let text = first.to_string();
        assert!(
            text.contains("hits prim 2") && text.contains("; object `b\\u{1b}`\n"),
            "{text}"
        );
        let json = serde_json::to_value(&first).unwrap();
        assert_eq!(
            json["scalar"]["names"],
            serde_json::json!(["b\u{1b}", null])
        );
        assert_eq!(json["simd"]["names"], serde_json::json!([null, null]));
    }

    #[test]
    fn the_ray_goes_through_the_middle_of_the_pixel() {
        let ray = |x, y| camera_ray(&Scene::default(), &settings(3, 3), x, y).unwrap();
        let (middle, corner) = (ray(1, 1), ray(0, 0));
        assert!(middle.dir[0].abs() < 1e-6 && middle.dir[1].abs() < 1e-6 && middle.dir[2] < -0.999);
        assert!(corner.dir[0] < 0.0 && corner.dir[1] > 0.0);
    }

    /// Checks that pixels of a region have the numbers that they have in the whole picture.
    #[test]
    fn a_regions_pixels_are_those_of_the_picture() {
        let region = phalanx::frame::Tile {
            x: 10,
            y: 20,
            width: 3,
            height: 2,
        };
        let settings = Settings {
            region: Some(region),
            ..settings(40, 30)
        };
        let mut other = film();
        other.planes[0][4] = 7.0;
        let first = first_difference(&Scene::default(), &settings, &film(), &other).unwrap();
        assert_eq!((first.x, first.y), (11, 21));
        let ray = camera_ray(&Scene::default(), &settings, 11, 21).unwrap();
        assert_eq!(first.ray.map(|r| r.dir), Some(ray.dir));
    }
}
