//! Who renders which tiles of a picture, written down once for all machines.

use super::identity::Identity;
use crate::frame::{Aov, Aovs, Tile};
use crate::render::tiles;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Version of the layout of plans.
const SCHEMA_VERSION: u32 = 1;

/// Most shards of a plan: as many tasks as schedulers take in one array, and more.
pub const MAX_SHARDS: u32 = 100_000;

/// Side of the tiles that are dealt out, in pixels, where the picture is large enough.
const SIDE: u32 = 64;

/// As many tiles a shard make up for some of them being hard.
const TILES_A_SHARD: u64 = 16;

/// A plan: what is rendered, into how many shards it is cut, and where the picture goes.
///
/// The tiles of the window, cells of a grid of [`Plan::tile`] pixels, are dealt out like cards, in the order of [`tiles`]: the k-th
/// tile is of shard k modulo [`Plan::shards`]. So every shard has some of the easy ones and some of the hard ones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    schema_version: u32,
    /// The scene, as its file was named, or a standard scene; a file's name is absolute.
    pub scene: String,
    /// What `phalanx plan` was asked for.
    pub arguments: Vec<String>,
    /// The picture to be.
    pub output: PathBuf,
    /// What becomes of radiance in it.
    pub developing: Developing,
    /// What its pixels depend on.
    pub picture: Identity,
    /// How many shards there are.
    pub shards: u32,
    /// Side in pixels of the tiles that are dealt out.
    pub tile: u32,
}

/// How samples are made of radiance, where the picture's format has samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Developing {
    /// In stops.
    pub exposure: f32,
    /// Whether samples are on the sRGB curve, and not linear.
    pub srgb: bool,
    /// Whether they are rounded to the nearest, and not down.
    pub round: bool,
    /// Bits of a PNG's samples: 8 or 16.
    pub bits: u8,
}

/// Why a plan cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// The file could not be read.
    #[error("cannot read {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// It is none.
    #[error("{}: not a plan: {reason}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// There is no such shard.
    #[error("there is no shard {shard}: the plan has {shards}, from 0 to {}", shards - 1)]
    NoShard {
        /// The number that was asked for.
        shard: u32,
        /// How many there are.
        shards: u32,
    },
}

impl Plan {
    /// A plan of so many shards.
    pub fn new(
        scene: String,
        arguments: Vec<String>,
        output: PathBuf,
        developing: Developing,
        picture: Identity,
        shards: u32,
    ) -> Plan {
        let enough = |side: u32| {
            let Tile { width, height, .. } = picture.window();
            let cells = u64::from(width.div_ceil(side)) * u64::from(height.div_ceil(side));
            cells >= TILES_A_SHARD * u64::from(shards)
        };
        let sides = [SIDE, SIDE / 2, SIDE / 4];
        let tile = sides.into_iter().find(|&side| enough(side)).unwrap_or(8);
        Plan {
            schema_version: SCHEMA_VERSION,
            scene,
            arguments,
            output,
            developing,
            picture,
            shards,
            tile,
        }
    }

    /// Reads one.
    ///
    /// # Errors
    /// [`PlanError`]: a plan of another version of this layout is refused.
    pub fn read(path: &Path) -> Result<Plan, PlanError> {
        let bytes = std::fs::read(path).map_err(|source| PlanError::Io {
            path: path.into(),
            source,
        })?;
        let malformed = |reason: String| PlanError::Malformed {
            path: path.into(),
            reason,
        };
        let plan: Plan = serde_json::from_slice(&bytes).map_err(|e| malformed(e.to_string()))?;
        let sides = [8, 16, 32, 64];
        match () {
            () if plan.schema_version != SCHEMA_VERSION => Err(malformed(format!(
                "it is of version {}, and this program reads version {SCHEMA_VERSION}",
                plan.schema_version
            ))),
            () if !(1..=MAX_SHARDS).contains(&plan.shards) => {
                Err(malformed(format!("it has {} shards", plan.shards)))
            }
            () if !sides.contains(&plan.tile) => {
                Err(malformed(format!("its tiles have sides of {}", plan.tile)))
            }
            () => Ok(plan),
        }
    }

    /// The layers of the picture.
    pub fn aovs(&self) -> Aovs {
        let named = Aov::ALL.iter();
        let named = named.filter(|(name, _)| self.picture.layers.iter().any(|n| n == name));
        named.fold(Aovs::default(), |set, (_, aov)| set.with(*aov))
    }

    /// The tiles of a shard.
    ///
    /// # Errors
    /// [`PlanError::NoShard`].
    pub fn share(&self, shard: u32) -> Result<Vec<Tile>, PlanError> {
        if shard >= self.shards {
            return Err(PlanError::NoShard {
                shard,
                shards: self.shards,
            });
        }
        let all = tiles(self.picture.window(), self.tile).into_iter();
        Ok(all
            .skip(shard as usize)
            .step_by(self.shards as usize)
            .collect())
    }

    /// The file of a shard's tiles, beside the plan.
    pub fn shard_file(&self, plan: &Path, shard: u32) -> PathBuf {
        let digits = (self.shards - 1).to_string().len();
        let mut name = plan.file_stem().unwrap_or(plan.as_os_str()).to_os_string();
        name.push(format!(".shard-{shard:0digits$}.tiles"));
        plan.with_file_name(name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Settings;
    use crate::scene::Scene;

    fn plan(width: u32, height: u32, shards: u32) -> Plan {
        let scene = Scene::default();
        let settings = Settings {
            width,
            height,
            ..Settings::of(&scene)
        };
        let identity = Identity::of(&scene, &settings);
        let developing = Developing {
            exposure: 0.5,
            srgb: true,
            round: false,
            bits: 8,
        };
        let (scene, output) = ("a.test".into(), "a.png".into());
        Plan::new(scene, Vec::new(), output, developing, identity, shards)
    }

    #[test]
    fn every_pixel_is_of_one_shard_and_shares_are_alike() {
        for (width, height, shards, side) in [
            (640, 480, 1, 64),
            (640, 480, 7, 32),
            (641, 479, 64, 16),
            (40, 24, 64, 8),
        ] {
            let plan = plan(width, height, shards);
            assert_eq!(plan.tile, side, "{width}x{height} in {shards}");
            let mut seen = vec![0u8; (width * height) as usize];
            let mut counts = Vec::new();
            for shard in 0..shards {
                let share = plan.share(shard).unwrap();
                counts.push(share.len());
                for tile in share {
                    for y in tile.y..tile.y + tile.height {
                        for x in tile.x..tile.x + tile.width {
                            seen[(y * width + x) as usize] += 1;
                        }
                    }
                }
            }
            assert!(seen.iter().all(|&n| n == 1));
            let (least, most) = (counts.iter().min().unwrap(), counts.iter().max().unwrap());
            assert!(most - least <= 1, "{counts:?}");
            assert!(plan.share(shards).is_err());
        }
    }

    #[test]
    fn shard_files_stand_beside_the_plan_in_order() {
        let plan = plan(640, 480, 64);
        let file = |shard| plan.shard_file(Path::new("jobs/a.json"), shard);
        assert_eq!(file(3), Path::new("jobs/a.shard-03.tiles"));
        assert_eq!(file(63), Path::new("jobs/a.shard-63.tiles"));
    }

    #[test]
    fn what_is_no_plan_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plan.json");
        let good = serde_json::to_value(plan(640, 480, 4)).unwrap();
        std::fs::write(&path, good.to_string()).unwrap();
        assert_eq!(Plan::read(&path).unwrap(), plan(640, 480, 4));
        for (key, value) in [
            ("schema_version", 2),
            ("shards", 0),
            ("tile", 7),
            ("tile", 0),
        ] {
            let mut bad = good.clone();
            bad[key] = value.into();
            std::fs::write(&path, bad.to_string()).unwrap();
            assert!(Plan::read(&path).is_err(), "{key}");
        }
        std::fs::write(&path, "{}").unwrap();
        assert!(Plan::read(&path).is_err());
        assert!(Plan::read(folder.path()).is_err());
    }
}
