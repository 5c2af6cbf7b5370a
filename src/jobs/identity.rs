//! What the pixels of a picture depend on: two renders of one identity may share their tiles.

use crate::cache::fingerprint;
use crate::frame::{Aov, Aovs, Engine, Kernel, Pin, Settings, Tile};
use crate::scene::Scene;
use serde::{Deserialize, Serialize};

/// Everything that a pixel's radiance depends on, as names and values for people, and nothing else: not threads, tile size, kernel or
/// engine, which give the same bits.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// Version of the program, which may have changed a bit somewhere.
    pub version: String,
    /// [`fingerprint`] of the scene, hexadecimal.
    pub scene: String,
    /// Width of the whole picture in pixels.
    pub width: u32,
    /// Height of the whole picture in pixels.
    pub height: u32,
    /// The part of it that is rendered: column, row, width and height.
    pub region: [u32; 4],
    /// Names of the layers that are kept beside radiance.
    pub layers: Vec<String>,
    /// All other settings, in words.
    pub settings: String,
}

impl Identity {
    /// Of a scene rendered with these settings.
    pub fn of(scene: &Scene, settings: &Settings) -> Identity {
        let Tile {
            x,
            y,
            width,
            height,
        } = settings.window();
        // What is the same for all renders says nothing; what is left is what pixels depend on, whatever settings there will be.
        let others = Settings {
            width: 0,
            height: 0,
            region: None,
            threads: 0,
            pin: Pin::None,
            tile: 0,
            engine: Engine::Simd,
            kernel: Kernel::Auto,
            aovs: Aovs::default(),
            record_hits: false,
            ..settings.clone()
        };
        let layers = Aov::ALL.iter().filter(|(_, aov)| settings.aovs.has(*aov));
        Identity {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scene: format!("{:016x}", fingerprint(scene)),
            width: settings.width,
            height: settings.height,
            region: [x, y, width, height],
            layers: layers.map(|(name, _)| (*name).to_owned()).collect(),
            settings: format!("{others:?}"),
        }
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

    /// Of all of it, to be kept beside every tile.
    pub fn checksum(&self) -> u32 {
        crc32fast::hash(
            self.words()
                .map(|(_, value)| value + "\n")
                .concat()
                .as_bytes(),
        )
    }

    /// What first differs from another: its name, and both values.
    pub fn difference(&self, other: &Identity) -> Option<(&'static str, String, String)> {
        let pairs = self.words().into_iter().zip(other.words());
        let mut different = pairs.filter(|((_, here), (_, there))| here != there);
        let ((name, here), (_, there)) = different.next()?;
        Some((name, here, there))
    }

    fn words(&self) -> [(&'static str, String); 6] {
        [
            ("version of phalanx", self.version.clone()),
            ("scene", self.scene.clone()),
            ("size", format!("{}x{}", self.width, self.height)),
            ("region", format!("{:?}", self.region)),
            ("layers", self.layers.join(" ")),
            ("settings", self.settings.clone()),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Sampling;
    use glam::Vec3;

    #[test]
    fn what_changes_pixels_changes_the_identity_and_nothing_else_does() {
        let scene = Scene::default();
        let settings = Settings::of(&scene);
        let plain = Identity::of(&scene, &settings);
        let same = Settings {
            threads: 3,
            tile: 64,
            engine: Engine::Scalar,
            kernel: Kernel::Packet8,
            record_hits: true,
            ..settings.clone()
        };
        assert_eq!(Identity::of(&scene, &same), plain);
        assert_eq!(plain.difference(&plain), None);
        let region = Tile {
            x: 1,
            ..settings.window()
        };
        let sampling = Sampling {
            spp: 4,
            ..Sampling::CENTER
        };
        let others = [
            (
                "size",
                Settings {
                    width: 7,
                    ..settings.clone()
                },
            ),
            (
                "region",
                Settings {
                    region: Some(region),
                    ..settings.clone()
                },
            ),
            (
                "settings",
                Settings {
                    max_depth: 1,
                    ..settings.clone()
                },
            ),
            (
                "settings",
                Settings {
                    sampling,
                    ..settings.clone()
                },
            ),
        ];
        for (name, other) in others {
            let other = Identity::of(&scene, &other);
            assert_eq!(plain.difference(&other).map(|d| d.0), Some(name));
            assert_ne!(plain.checksum(), other.checksum(), "{name}");
        }
        let lit = Scene {
            background: Vec3::new(0.0, 0.0, 0.25),
            ..Scene::default()
        };
        let other = Identity::of(&lit, &settings);
        assert_eq!(plain.difference(&other).map(|d| d.0), Some("scene"));
        let mut ball = Scene::default();
        ball.add_sphere(Vec3::ZERO, 1.0, 0);
        assert_ne!(Identity::of(&ball, &settings).scene, plain.scene);
    }
}
