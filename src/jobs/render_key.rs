//! Key of a picture. Its pixels depend on this and nothing else: two renders with the same key may
//! share their tiles.

use super::frame_view::FrameView;
use super::picture_settings::PictureSettings;
use phalanx_files::quoted_text;
use phalanx_io::cache::fingerprint;
use phalanx_render::frame::{Aov, Aovs, Settings, Tile};
use phalanx_scene::{MAX_SIDE, Scene, View, check_image_size};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Everything that a pixel's radiance depends on, as names and values for people. Threads, tile
/// size, kernel and engine are not in it, because they give the same bits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RenderKey {
    /// Version of the program, which may have changed a bit somewhere.
    pub version: String,
    /// [`fingerprint`] of the scene, hexadecimal.
    pub scene: String,
    /// The scene's origin, in its file's coordinates.
    pub origin: [f64; 3],
    /// Width of the whole picture in pixels.
    pub width: u32,
    /// Height of the whole picture in pixels.
    pub height: u32,
    /// The part of the picture that is rendered: column, row, width and height.
    pub region: [u32; 4],
    /// Names of the AOVs that are stored beside radiance.
    pub layers: Vec<String>,
    /// All other settings.
    pub settings: PictureSettings,
    /// The view of a frame of a plan's sequence; `None` for the scene's own, which its fingerprint
    /// covers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub view: Option<FrameView>,
}

/// A field of a plan or a key that holds a value that it may not have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field} is {value}: expected {expected}")]
pub struct FieldError {
    /// Name of the field, preceded by the fields that contain it.
    pub field: &'static str,
    /// Value of the field, without control characters.
    pub value: String,
    /// Values that it may have.
    pub expected: String,
}

/// A difference between the picture of a file and the requested one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyDifference {
    /// The option, or another name for people.
    pub what: &'static str,
    /// Value of the option in the file.
    pub there: String,
    /// Value of the option now.
    pub here: String,
}

impl fmt::Display for KeyDifference {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let KeyDifference { what, there, here } = self;
        write!(f, "{what} is {there} there and {here} here")
    }
}

/// All differences in one sentence.
pub(super) fn list_differences(differences: &[KeyDifference]) -> String {
    let all: Vec<String> = differences.iter().map(KeyDifference::to_string).collect();
    all.join(", ")
}

impl RenderKey {
    /// The key of a scene rendered with these settings.
    pub fn of(scene: &Scene, settings: &Settings) -> RenderKey {
        let Tile {
            x,
            y,
            width,
            height,
        } = settings.window();
        let layers = Aov::ALL.iter().filter(|(_, aov)| settings.aovs.has(*aov));
        RenderKey {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scene: format!("{:016x}", fingerprint(scene)),
            origin: scene.origin,
            width: settings.width,
            height: settings.height,
            region: [x, y, width, height],
            layers: layers.map(|(name, _)| (*name).to_owned()).collect(),
            settings: PictureSettings::of(settings),
            view: None,
        }
    }

    /// The key of the same picture from another view.
    pub fn with_view(&self, view: View) -> RenderKey {
        RenderKey {
            view: Some(view.into()),
            ..self.clone()
        }
    }

    /// Checks that [`RenderKey::of`] could have made this key. The file that it was read from may
    /// come from anybody.
    ///
    /// # Errors
    /// The first field that holds a value that it may not have.
    pub fn check(&self) -> Result<(), FieldError> {
        let wrong = |field, value: String, expected: &str| FieldError {
            field,
            value,
            expected: expected.to_owned(),
        };
        let number = |c: char| c.is_ascii_alphanumeric() || ".-+".contains(c);
        if self.version.is_empty() || self.version.len() > 64 || !self.version.chars().all(number) {
            let value = quoted_text(&self.version);
            return Err(wrong("picture.version", value, "the number of a version"));
        }
        let digit = |c: char| matches!(c, '0'..='9' | 'a'..='f');
        if self.scene.len() != 16 || !self.scene.chars().all(digit) {
            let value = quoted_text(&self.scene);
            return Err(wrong("picture.scene", value, "16 hexadecimal digits"));
        }
        for (field, side) in [
            ("picture.width", self.width),
            ("picture.height", self.height),
        ] {
            if check_image_size(side.into(), 1).is_err() {
                let sides = format!("1 to {MAX_SIDE} pixels");
                return Err(wrong(field, side.to_string(), &sides));
            }
        }
        let whole = Tile::whole(self.width, self.height);
        let window = self.window();
        if window.pixels() == 0 || window.within(whole) != window {
            let inside = format!(
                "column, row, width and height of a part of {}x{} pixels",
                self.width, self.height
            );
            let [x, y, columns, rows] = self.region;
            let value = format!("{x} {y} {columns} {rows}");
            return Err(wrong("picture.region", value, &inside));
        }
        let named = Aov::ALL.iter().map(|(name, _)| *name);
        let known = named.filter(|name| self.layers.iter().any(|layer| layer == name));
        if known.ne(self.layers.iter().map(String::as_str)) {
            let value = quoted_text(&self.layers.join(","));
            return Err(wrong(
                "picture.layers",
                value,
                "names of layers, each once and in their order",
            ));
        }
        if let Some(Err(error)) = self.view.map(|view| view.checked()) {
            let value = format!("none ({error})");
            return Err(wrong("picture.view", value, "a view that has axes"));
        }
        Ok(())
    }

    /// The part of the picture that is rendered.
    pub fn window(&self) -> Tile {
        let [x, y, width, height] = self.region;
        Tile {
            x,
            y,
            width,
            height,
        }
    }

    /// The layers of the picture.
    pub fn aovs(&self) -> Aovs {
        let named = Aov::ALL.iter();
        let named = named.filter(|(name, _)| self.layers.iter().any(|n| n == name));
        named.fold(Aovs::default(), |set, (_, aov)| set.with(*aov))
    }

    /// Checksum of the whole key, which is stored beside every tile.
    pub fn checksum(&self) -> u32 {
        crc32fast::hash(self.json().as_bytes())
    }

    /// The whole key as JSON. It holds nothing that JSON cannot express.
    pub(super) fn json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }

    /// The differences between this key, which comes from a file, and the requested one.
    pub fn differences(&self, here: &RenderKey) -> Vec<KeyDifference> {
        let pairs = self.describe().into_iter().zip(here.describe());
        let different = pairs.filter(|((_, there), (_, here))| there != here);
        let difference = |((what, there), (_, here))| KeyDifference { what, there, here };
        different.map(difference).collect()
    }

    fn describe(&self) -> Vec<(&'static str, String)> {
        let RenderKey {
            version,
            origin,
            scene,
            width,
            height,
            region,
            layers,
            settings,
            view,
        } = self;
        let [x, y, columns, rows] = region;
        let region = match self.window() == Tile::whole(*width, *height) {
            true => "not given".to_owned(),
            false => format!("{x} {y} {columns} {rows}"),
        };
        let layers = match layers.is_empty() {
            true => "not given".to_owned(),
            false => layers.join(","),
        };
        let mut words = vec![
            ("the version of phalanx", version.clone()),
            (
                "the scene's local origin",
                origin.map(|x| x.to_string()).join(","),
            ),
            ("the scene's fingerprint", scene.clone()),
            ("--size", format!("{width}x{height}")),
            ("--region", region),
            ("--aov", layers),
            (
                "the frame's view",
                view.map_or_else(|| "not given".to_owned(), describe_view),
            ),
        ];
        words.extend(settings.options());
        words
    }
}

/// A view in the words of `--camera`, in the scene's coordinates. Different views have different
/// words.
fn describe_view(view: FrameView) -> String {
    let FrameView {
        eye,
        center,
        up,
        fovy,
        ortho,
    } = view;
    let triple = |v: [f32; 3]| v.map(|x| format!("{x:?}")).join(",");
    let [eye, center, up] = [eye, center, up].map(triple);
    let ortho = ortho.map_or(String::new(), |height| format!(" --ortho={height:?}"));
    format!("{eye} {center} {up} {fovy:?}{ortho}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use phalanx_render::frame::{Adaptive, Engine, Integrator, Kernel, Lens, Sampling};

    fn differing(here: &RenderKey, there: &RenderKey) -> Vec<&'static str> {
        let differences = there.differences(here);
        differences.iter().map(|d| d.what).collect()
    }

    #[test]
    fn what_changes_pixels_changes_the_identity_and_nothing_else_does() {
        let scene = Scene::default();
        let settings = Settings::of(&scene);
        let plain = RenderKey::of(&scene, &settings);
        let same = Settings {
            threads: 3,
            tile: 64,
            engine: Engine::Scalar,
            kernel: Kernel::Packet8,
            record_hits: true,
            min_weight: Some(0.0),
            ..settings.clone()
        };
        assert_eq!(RenderKey::of(&scene, &same), plain);
        assert_eq!(plain.differences(&plain), []);
        let region = Tile {
            x: 1,
            ..settings.window()
        };
        let lens = Lens {
            aperture: 0.1,
            focus: 2.0,
        };
        let sampling = |spp, adaptive| Sampling {
            spp,
            adaptive,
            ..Sampling::CENTER
        };
        let adaptive = Some(Adaptive { threshold: 0.1 });
        let change = |change: &dyn Fn(&mut Settings)| {
            let mut settings = settings.clone();
            change(&mut settings);
            settings
        };
        let others: [(&[&str], Settings); 8] = [
            (&["--size"], change(&|s| s.width = 7)),
            (&["--region"], change(&|s| s.region = Some(region))),
            (&["--aov"], change(&|s| s.aovs = Aovs::all())),
            (&["--max-depth"], change(&|s| s.max_depth = 1)),
            (&["--spp"], change(&|s| s.sampling = sampling(4, None))),
            (
                &["--aa", "--threshold"],
                change(&|s| s.sampling = sampling(1, adaptive)),
            ),
            (
                &["--aperture", "--focus", "--integrator", "--ao-distance"],
                change(&|s| {
                    s.lens = Some(lens);
                    s.integrator = Integrator::Occlusion { distance: 3.0 };
                }),
            ),
            (&["--min-weight"], change(&|s| s.min_weight = Some(0.1))),
        ];
        for (names, other) in others {
            let other = RenderKey::of(&scene, &other);
            assert_eq!(differing(&plain, &other), names);
            assert_ne!(plain.checksum(), other.checksum(), "{names:?}");
            other.check().unwrap();
        }
        let lit = Scene {
            background: Vec3::new(0.0, 0.0, 0.25),
            ..Scene::default()
        };
        let other = RenderKey::of(&lit, &settings);
        assert_eq!(differing(&plain, &other), ["the scene's fingerprint"]);
        let moved = Scene {
            origin: [500_000.0, 0.0, 0.1],
            ..Scene::default()
        };
        let other = RenderKey::of(&moved, &settings);
        let names = differing(&plain, &other);
        assert_eq!(
            names,
            ["the scene's local origin", "the scene's fingerprint"]
        );
        assert_ne!(plain.checksum(), other.checksum());
        let json = serde_json::to_string(&other).unwrap();
        assert_eq!(serde_json::from_str::<RenderKey>(&json).unwrap(), other);
        let without = json.replace("origin", "other");
        serde_json::from_str::<RenderKey>(&without).unwrap_err();
        let mut ball = Scene::default();
        ball.add_sphere(Vec3::ZERO, 1.0, 0);
        assert_ne!(RenderKey::of(&ball, &settings).scene, plain.scene);
    }

    #[test]
    fn a_frame_has_a_key_of_its_own_and_a_picture_the_text_that_it_had() {
        let scene = Scene::default();
        let plain = RenderKey::of(&scene, &Settings::of(&scene));
        assert!(!plain.json().contains("view"), "{}", plain.json());
        let view = |x| View {
            eye: Vec3::new(x, 0.0, 5.0),
            ..scene.view
        };
        let frame = plain.with_view(view(1.0));
        frame.check().unwrap();
        assert_ne!(frame.checksum(), plain.checksum());
        let said = list_differences(&frame.differences(&plain.with_view(view(1.5))));
        assert!(
            said.starts_with("the frame's view is 1.0,0.0,5.0 "),
            "{said}"
        );
        assert!(said.contains(" there and 1.5,0.0,5.0 "), "{said}");
        let again: RenderKey = serde_json::from_str(&frame.json()).unwrap();
        assert_eq!(again, frame);
    }

    #[test]
    fn differences_are_told_with_their_options_and_both_values() {
        let scene = Scene::default();
        let with = |spp| {
            let mut settings = Settings::of(&scene);
            settings.sampling.spp = spp;
            RenderKey::of(&scene, &settings)
        };
        let said = list_differences(&with(64).differences(&with(4)));
        assert_eq!(said, "--spp is 64 there and 4 here");
    }

    #[test]
    fn fields_that_no_picture_has_are_named() {
        let scene = Scene::default();
        let good = RenderKey::of(&scene, &Settings::of(&scene));
        good.check().unwrap();
        let (width, height) = (good.width, good.height);
        let refused = |field: &str, change: &dyn Fn(&mut RenderKey)| {
            let mut bad = good.clone();
            change(&mut bad);
            let refused = bad.check().unwrap_err();
            assert_eq!(refused.field, field);
            let said = refused.to_string();
            assert!(!said.contains(char::is_control), "{said:?}");
        };
        for region in [
            [u32::MAX - 5, u32::MAX - 5, 400, 300],
            [0, 0, 0, 1],
            [0, 0, width, 0],
            [0, 0, width + 1, height],
            [1, 0, width, height],
            [0, height, 1, 1],
            [u32::MAX; 4],
        ] {
            refused("picture.region", &|i| i.region = region);
        }
        for side in [0, 65_537, u32::MAX] {
            refused("picture.width", &|i| i.width = side);
            refused("picture.height", &|i| i.height = side);
        }
        for layers in [&["colour"][..], &["depth", "depth"], &["ng", "depth"]] {
            let layers: Vec<String> = layers.iter().map(|l| (*l).to_owned()).collect();
            refused("picture.layers", &|i| i.layers = layers.clone());
        }
        let nowhere = View {
            eye: scene.view.center,
            ..scene.view
        };
        refused("picture.view", &|i| i.view = Some(nowhere.into()));
        for text in ["", "1.0\n", "\x1b[2J", &"1".repeat(65)] {
            refused("picture.version", &|i| i.version = text.to_owned());
            refused("picture.scene", &|i| i.scene = text.to_owned());
        }
    }
}
