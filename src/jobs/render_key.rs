//! Key of a picture. Its pixels depend on this and nothing else: two renders with the same key may
//! share their tiles.

use crate::field_error::FieldError;
use crate::frame_view::check_view;
use crate::spec::PixelSpec;
use glam::Vec3;
use phalanx_files::quoted_text;
use phalanx_io::cache::fingerprint;
use phalanx_render::frame::Settings;
use phalanx_scene::{Scene, View};
use serde::{Deserialize, Serialize};
use std::fmt;

/// A scene as one version of the program reads it: what pixels depend on beside their options.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneStamp {
    /// Version of the program, which may have changed a bit somewhere.
    pub version: String,
    /// [`fingerprint`] of the scene, hexadecimal.
    pub scene: String,
    /// The scene's origin, in its file's coordinates.
    pub origin: [f64; 3],
}

/// Everything that a pixel's radiance depends on, as names and values for people. Threads, tile
/// size, kernel and engine are not in it, because they give the same bits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RenderKey {
    /// The scene, and the version that reads it.
    pub stamp: SceneStamp,
    /// The options, all of which are given.
    pub pixels: PixelSpec,
    /// The view of a frame of a plan's sequence; `None` for the scene's own, which its fingerprint
    /// covers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub view: Option<View>,
}

/// A difference between the picture of a file and the requested one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyDifference {
    /// The option, or another name for people.
    pub what: String,
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

impl SceneStamp {
    /// The stamp of a scene in this version.
    pub fn of(scene: &Scene) -> SceneStamp {
        SceneStamp {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scene: format!("{:016x}", fingerprint(scene)),
            origin: scene.origin,
        }
    }

    /// Checks that [`SceneStamp::of`] could have made this, in some version.
    fn check(&self) -> Result<(), FieldError> {
        let wrong = |field: &str, value: &str, expected: &str| {
            Err(FieldError::new(field, quoted_text(value), expected))
        };
        let SceneStamp { version, scene, .. } = self;
        let number = |c: char| c.is_ascii_alphanumeric() || ".-+".contains(c);
        if version.is_empty() || version.len() > 64 || !version.chars().all(number) {
            return wrong("stamp.version", version, "the number of a version");
        }
        let digit = |c: char| matches!(c, '0'..='9' | 'a'..='f');
        if scene.len() != 16 || !scene.chars().all(digit) {
            return wrong("stamp.scene", scene, "16 hexadecimal digits");
        }
        Ok(())
    }
}

impl RenderKey {
    /// The key of a scene rendered with these settings.
    pub fn of(scene: &Scene, settings: &Settings) -> RenderKey {
        RenderKey {
            stamp: SceneStamp::of(scene),
            pixels: PixelSpec::of(settings),
            view: None,
        }
    }

    /// The key of the same picture from another view.
    pub fn with_view(&self, view: View) -> RenderKey {
        RenderKey {
            view: Some(view),
            ..self.clone()
        }
    }

    /// Checks that [`RenderKey::of`] could have made this key. The file that it was read from may
    /// come from anybody.
    ///
    /// # Errors
    /// The first field that holds a value that it may not have.
    pub fn check(&self) -> Result<(), FieldError> {
        self.stamp.check()?;
        self.pixels.check()?;
        self.view.map_or(Ok(()), |view| check_view(&view, "view"))
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

    fn describe(&self) -> Vec<(String, String)> {
        let origin = self.stamp.origin.map(|x| x.to_string()).join(",");
        let view = self.view.map_or("not given".to_owned(), describe_view);
        let facts = [
            ("the version of phalanx", self.stamp.version.clone()),
            ("the scene's local origin", origin),
            ("the scene's fingerprint", self.stamp.scene.clone()),
            ("the frame's view", view),
        ];
        let options = self.pixels.rows().into_iter();
        let options = options.map(|row| (row.option(), row.text()));
        let facts = facts.map(|(what, value)| (what.to_owned(), value));
        facts.into_iter().chain(options).collect()
    }
}

/// A view in the words of `--camera`, in the scene's coordinates. Different views have different
/// words.
fn describe_view(view: View) -> String {
    let triple = |v: Vec3| v.to_array().map(|x| format!("{x:?}")).join(",");
    let [eye, center, up] = [view.eye, view.center, view.up].map(triple);
    let fovy = view.fovy;
    let ortho = view
        .ortho
        .map_or(String::new(), |height| format!(" --ortho={height:?}"));
    format!("{eye} {center} {up} {fovy:?}{ortho}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::AsText;
    use phalanx_render::frame::{Adaptive, Aovs, Engine, Integrator, Kernel, Lens, Sampling, Tile};

    fn differing(here: &RenderKey, there: &RenderKey) -> Vec<String> {
        let differences = there.differences(here);
        differences.into_iter().map(|d| d.what).collect()
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
        assert_ne!(RenderKey::of(&ball, &settings).stamp, plain.stamp);
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
        let message = list_differences(&frame.differences(&plain.with_view(view(1.5))));
        assert!(
            message.starts_with("the frame's view is 1.0,0.0,5.0 "),
            "{message}"
        );
        assert!(message.contains(" there and 1.5,0.0,5.0 "), "{message}");
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
        let message = list_differences(&with(64).differences(&with(4)));
        assert_eq!(message, "--spp is 64 there and 4 here");
    }

    #[test]
    fn fields_that_no_picture_has_are_named() {
        let scene = Scene::default();
        let good = RenderKey::of(&scene, &Settings::of(&scene));
        good.check().unwrap();
        let (width, height) = good.pixels.size.unwrap();
        let refused = |field: &str, change: &dyn Fn(&mut RenderKey)| {
            let mut bad = good.clone();
            change(&mut bad);
            let refused = bad.check().unwrap_err();
            assert_eq!(refused.field, field);
            let message = refused.to_string();
            assert!(!message.contains(char::is_control), "{message:?}");
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
            refused("pixels.region", &|i| {
                i.pixels.region = Some(region.to_vec())
            });
        }
        for side in [0, 65_537, u32::MAX] {
            refused("pixels.size", &|i| i.pixels.size = Some((side, height)));
            refused("pixels.size", &|i| i.pixels.size = Some((width, side)));
        }
        for layers in [["depth", "depth"], ["ng", "depth"]] {
            let layers: Vec<_> = layers.iter().map(|l| AsText::parse(l).unwrap()).collect();
            refused("pixels.aov", &|i| i.pixels.aov = layers.clone());
        }
        let nowhere = View {
            eye: scene.view.center,
            ..scene.view
        };
        refused("view", &|i| i.view = Some(nowhere));
        for text in ["", "1.0\n", "\x1b[2J", &"1".repeat(65)] {
            refused("stamp.version", &|i| i.stamp.version = text.to_owned());
            refused("stamp.scene", &|i| i.stamp.scene = text.to_owned());
        }
    }
}
