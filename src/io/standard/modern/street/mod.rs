//! street: a lane of old houses at nightfall, with a café whose window and door stand open.
//!
//! Houses consist of real parts: frames, sills, shutters, balusters, bricks. `detail` is their
//! fineness (quads to a metre); each kind of part appears from a detail of its own on. The rest of
//! the size is spent on the pavement.

mod cafe;
mod house;
mod lane;
mod opening;
mod stone;

use super::materials::{glass, glow, matte, polished, rgb};
use super::mesh_builder::{MeshBuilder, fit_detail};
use super::props::LocalFrame;
use super::{SIZES, hd, lamp, sun};
use crate::standard::builder::{DocumentMaterial, SceneBuilder};
use crate::standard::catalogue::{Family, SceneParams, StandardScene};
use glam::DVec3;
use house::House;

pub(in crate::standard) const ENTRY: StandardScene = StandardScene {
    name: "street",
    purpose: "a street of detailed houses and a furnished café: large and tiny triangles, seven lights",
    family: Family::Modern,
    default_size: 1_000_000,
    sizes: 6_000..=*SIZES.end(),
    size_means: "triangles",
    max_depth: 4,
    generate,
};

const SEED: u64 = 0x57ee_7000;
/// Mean light of the evening sky.
const AMBIENT: DVec3 = DVec3::new(0.105, 0.135, 0.225);
const SKY: DVec3 = DVec3::new(0.075, 0.135, 0.30);

// Rows of the palette.
const STUCCO: usize = 0;
const STUCCOS: usize = 5;
const BRICK: usize = STUCCO + STUCCOS;
const TRIM: usize = BRICK + 3;
const WOOD: usize = TRIM + 1;
const SHUTTER: usize = WOOD + 1;
const SHUTTERS: usize = 3;
const PANE: usize = SHUTTER + SHUTTERS;
const LIT: usize = PANE + 1;
const ROOF: usize = LIT + 3;
const IRON: usize = ROOF + 1;
const COBBLE: usize = IRON + 1;
const KERB: usize = COBBLE + 3;
const WARM_WALL: usize = KERB + 1;
const PLANK: usize = WARM_WALL + 1;
const TABLE: usize = PLANK + 1;
const BULB: usize = TABLE + 1;
const SHADE: usize = BULB + 1;
const BOTTLE: usize = SHADE + 1;
const CHINA: usize = BOTTLE + 3;
const LEAF: usize = CHINA + 1;
const PICTURE: usize = LEAF + 2;

fn palette() -> Vec<DocumentMaterial> {
    let dull = |r: f64, g: f64, b: f64| matte(rgb(r, g, b), AMBIENT);
    let wet = |material| polished(material, rgb(0.085, 0.085, 0.085), 120.0);
    // Light reflected by the walls inside the café is warm.
    let inside = |r: f64, g: f64, b: f64| matte(rgb(r, g, b), rgb(0.26, 0.17, 0.085));
    let tinted = |r: f64, g: f64, b: f64| DocumentMaterial {
        kt: rgb(r, g, b),
        ..glass(1.3)
    };
    let mut looks = vec![
        dull(0.62, 0.52, 0.37),
        dull(0.55, 0.34, 0.24),
        dull(0.58, 0.57, 0.52),
        dull(0.36, 0.43, 0.44),
        dull(0.60, 0.44, 0.22),
        dull(0.36, 0.13, 0.075),
        dull(0.30, 0.10, 0.06),
        dull(0.42, 0.18, 0.11),
        dull(0.62, 0.59, 0.53),
        dull(0.24, 0.13, 0.065),
        dull(0.075, 0.16, 0.12),
        dull(0.10, 0.15, 0.24),
        dull(0.27, 0.08, 0.06),
        polished(dull(0.02, 0.025, 0.035), rgb(0.42, 0.42, 0.42), 800.0),
        glow(rgb(1.0, 0.62, 0.24)),
        glow(rgb(0.74, 0.40, 0.135)),
        glow(rgb(0.40, 0.20, 0.07)),
        dull(0.30, 0.12, 0.07),
        dull(0.025, 0.027, 0.03),
    ];
    looks.extend([
        wet(dull(0.20, 0.19, 0.185)),
        wet(dull(0.155, 0.15, 0.15)),
        wet(dull(0.25, 0.235, 0.22)),
    ]);
    looks.extend([
        wet(dull(0.30, 0.29, 0.27)),
        inside(0.70, 0.46, 0.22),
        polished(inside(0.30, 0.16, 0.07), rgb(0.05, 0.05, 0.05), 80.0),
        inside(0.24, 0.11, 0.045),
        glow(rgb(1.0, 0.86, 0.56)),
        DocumentMaterial {
            ke: rgb(0.50, 0.24, 0.07),
            ..inside(0.6, 0.4, 0.2)
        },
        tinted(0.15, 0.55, 0.20),
        tinted(0.65, 0.30, 0.07),
        tinted(0.75, 0.75, 0.70),
        polished(inside(0.75, 0.72, 0.66), rgb(0.06, 0.06, 0.06), 200.0),
        dull(0.06, 0.16, 0.04),
        dull(0.10, 0.22, 0.05),
        inside(0.12, 0.25, 0.30),
    ]);
    looks
}

/// Half the width of the lane, from wall to wall.
const HALF: f64 = 3.6;
/// The z coordinate where the first houses begin, toward the eye.
const START: f64 = 7.0;

fn generate(params: &SceneParams, builder: &mut dyn SceneBuilder) {
    builder.view(&hd(
        DVec3::new(1.75, 1.72, 10.1),
        DVec3::new(-1.6, 2.15, 0.0),
        52.0,
    ));
    builder.background(SKY);
    let town = Town::of(params.size);
    builder.light(&sun(DVec3::new(0.35, 0.85, 0.55), rgb(0.13, 0.17, 0.29)));
    cafe::lights(&town.cafe()).for_each(|light| builder.light(&light));
    lane::LAMPS.iter().for_each(|post| {
        let light = lamp(post.light(), rgb(0.95, 0.62, 0.28), 2.1);
        builder.light(&light);
    });
    let palette = palette();
    let mut mesh = MeshBuilder::new(builder, &palette);
    let budget = u64::from(params.size);
    let detail = fit_detail(budget * 7 / 10, (0.01, 400.0), |mesh, detail| {
        town.build(mesh, detail)
    });
    town.build(&mut mesh, detail);
    let left = budget.saturating_sub(mesh.triangles());
    lane::pave(&mut mesh, town.length, left);
    mesh.finish();
}

/// The houses, left and right from the eye on, and one across the end.
struct Town {
    houses: Vec<House>,
    /// Length from the first houses to the last.
    length: f64,
}

impl Town {
    /// Builds more houses for larger sizes, so that small ones still have windows.
    fn of(size: u32) -> Town {
        let depth: u32 = match size {
            0..25_000 => 1,
            25_000..80_000 => 2,
            80_000..250_000 => 3,
            250_000..3_000_000 => 4,
            _ => 5,
        };
        let length = 7.2 * f64::from(depth);
        let mut houses = Vec::new();
        for k in 0..depth {
            let z = START - 7.2 * f64::from(k);
            // x runs to the right for an observer in front of the house.
            let left = LocalFrame {
                origin: DVec3::new(-HALF, 0.0, z),
                axes: [DVec3::NEG_Z, DVec3::Y, DVec3::X],
            };
            let right = LocalFrame {
                origin: DVec3::new(HALF, 0.0, z - 7.2),
                axes: [DVec3::Z, DVec3::Y, DVec3::NEG_X],
            };
            houses.push(House::new(left, u64::from(2 * k), 7.2, k == 0));
            houses.push(House::new(right, u64::from(2 * k + 1), 7.2, false));
        }
        let end = LocalFrame::at(DVec3::new(-HALF, 0.0, START - length - 0.01));
        houses.push(House::new(end, 99, 2.0 * HALF, false));
        Town { houses, length }
    }

    /// Frame of the café: the first house on the left.
    fn cafe(&self) -> LocalFrame {
        self.houses[0].frame
    }

    fn build(&self, mesh: &mut MeshBuilder, detail: f64) {
        for house in &self.houses {
            house.build(mesh, detail);
        }
        cafe::furnish(mesh, &self.cafe(), detail);
        lane::furnish(mesh, self.length, detail);
    }
}
