//! hair: thin curved tubes, thousands to half a million of them: a windy meadow, and two creatures
//! in it.
//!
//! Bounding boxes fit tubes worse than any other shape. Each tube has three sides, seven steps and
//! a closed tip: 45 triangles. Their width shrinks as the square root of their number, so that the
//! picture stays the same and gets finer.

use super::materials::{matte, polished, rgb};
use super::mesh_builder::{Grid, MeshBuilder};
use super::noise::{Dice, blend, fractal2, noise2, smoothstep};
use super::setup::{hd, sun};
use super::{assembly, geodesic};
use crate::builder::{DocumentMaterial, SceneBuilder};
use glam::{DVec2, DVec3, dvec2, dvec3};
use libm::{cos, sin};
use std::f64::consts::TAU;

const SEED: u64 = 0x4a1e_0001;
const AMBIENT: DVec3 = dvec3(0.13, 0.16, 0.22);

/// Number of tones along a tube. Tubes are darker toward the root, where less light reaches them.
const TONES: usize = 3;
/// Number of colours of a kind of tube.
const HUES: usize = 4;
const GRASS: usize = 0;
const FUR: [usize; 2] = [HUES * TONES, 2 * HUES * TONES];
const SOIL: usize = 3 * HUES * TONES;
const WHITE: usize = SOIL + 1;
const BLACK: usize = SOIL + 2;

fn palette() -> Vec<DocumentMaterial> {
    let grass = [
        rgb(0.16, 0.27, 0.05),
        rgb(0.22, 0.31, 0.06),
        rgb(0.34, 0.33, 0.09),
        rgb(0.10, 0.22, 0.06),
    ];
    let ginger = [
        rgb(0.64, 0.25, 0.05),
        rgb(0.72, 0.33, 0.08),
        rgb(0.52, 0.17, 0.035),
        rgb(0.80, 0.46, 0.17),
    ];
    let blue = [
        rgb(0.10, 0.24, 0.52),
        rgb(0.15, 0.34, 0.62),
        rgb(0.07, 0.16, 0.42),
        rgb(0.30, 0.48, 0.70),
    ];
    let mut materials = Vec::new();
    for color in [grass, ginger, blue].as_flattened() {
        for light in [0.28, 0.7, 1.15] {
            materials.push(matte(*color * light, AMBIENT));
        }
    }
    materials.push(matte(rgb(0.075, 0.10, 0.025), AMBIENT));
    let white = matte(rgb(0.80, 0.79, 0.76), AMBIENT);
    materials.push(polished(white, rgb(0.06, 0.06, 0.06), 300.0));
    let black = matte(rgb(0.008, 0.008, 0.01), AMBIENT);
    materials.push(polished(black, rgb(0.07, 0.07, 0.07), 500.0));
    materials
}

/// Number of steps along a tube; `SIDES` is the number of its sides.
const STEPS: usize = 7;
const SIDES: usize = 3;
const TUBE: u64 = (2 * SIDES * STEPS + SIDES) as u64;

/// A creature of the meadow: a ball of fur with two eyes.
struct Creature {
    center: DVec3,
    radius: f64,
    fur: usize,
    /// Direction of its gaze.
    gaze: DVec3,
    /// Its share of all tubes.
    share: f64,
}

const DWELLERS: [Creature; 2] = [
    Creature {
        center: dvec3(-0.75, 1.02, 0.0),
        radius: 0.86,
        fur: FUR[0],
        gaze: dvec3(0.36, 0.10, 0.93),
        share: 0.24,
    },
    Creature {
        center: dvec3(1.12, 0.70, 0.75),
        radius: 0.52,
        fur: FUR[1],
        gaze: dvec3(-0.30, 0.22, 0.93),
        share: 0.12,
    },
];

pub(crate) fn generate(size: u32, builder: &mut dyn SceneBuilder) {
    builder.view(&hd(dvec3(0.15, 1.42, 5.6), dvec3(0.05, 0.93, 0.0), 33.0));
    builder.background(rgb(0.30, 0.50, 0.78));
    builder.light(&sun(dvec3(-0.75, 0.62, 0.42), rgb(1.75, 1.5, 1.15)));
    builder.light(&sun(dvec3(0.85, 0.5, -0.55), rgb(0.42, 0.44, 0.42)));
    assembly::draw(builder, palette(), &|mesh| grow(mesh, size));
}

fn grow(mesh: &mut MeshBuilder, size: u32) {
    let budget = f64::from(size);
    ground(mesh, (budget * 0.02 / 2.0).sqrt() as usize);
    let frequency = geodesic::frequency(budget * 0.03 / 10.0).clamp(3, 60);
    for dweller in &DWELLERS {
        dweller.skin(mesh, frequency);
    }
    let tubes = (size as u64).saturating_sub(mesh.triangles()) / TUBE;
    let width = 0.0115 / (tubes as f64 / 21_000.0).sqrt();
    let mut left = tubes;
    for dweller in &DWELLERS {
        let count = (tubes as f64 * dweller.share) as u64;
        dweller.coat(mesh, count, width);
        left -= count;
    }
    meadow(mesh, left, width);
}

/// z coordinate of the nearest grass; `FAR` is that of the farthest.
const NEAR: f64 = 4.6;
const FAR: f64 = -13.0;

fn half_width(z: f64) -> f64 {
    0.62 + (NEAR - z) * 0.47
}

fn height(p: DVec2) -> f64 {
    let far = smoothstep(0.0, -12.0, p.y);
    0.22 * fractal2(SEED, p * 0.42, 2) + far * (0.5 + 0.7 * noise2(SEED + 9, p * 0.23).0)
}

/// A position on the ground; `across` in [-1, 1], `away` in [0, 1] denser near the eye.
fn ground_point(across: f64, away: f64) -> DVec3 {
    let z = blend(NEAR, FAR, away * (0.24 + 0.76 * away));
    let p = dvec2(across * half_width(z), z);
    dvec3(p.x, height(p), p.y)
}

fn ground(mesh: &mut MeshBuilder, cells: usize) {
    let cells = cells.max(6);
    mesh.material(SOIL);
    mesh.grid(Grid::open(cells, cells), |i, j| {
        let across = 2.2 * i as f64 / cells as f64 - 1.1;
        ground_point(across, 1.15 * j as f64 / cells as f64 - 0.02)
    });
}

fn meadow(mesh: &mut MeshBuilder, count: u64, width: f64) {
    if mesh.counted(count * TUBE) {
        return;
    }
    // A jittered lattice, row by row from the eye: even, without a pattern.
    let rows = (count as f64).sqrt().ceil().max(1.0) as u64;
    for number in 0..count {
        if mesh.counted(TUBE) {
            continue;
        }
        let mut dice = Dice::of(SEED, number);
        let (row, column) = (number / rows, number % rows);
        let across = 2.0 * (column as f64 + dice.unit()) / rows as f64 - 1.0;
        let root = ground_point(across, (row as f64 + dice.unit()) / rows as f64);
        let holds_root = |d: &Creature| (root - d.center).length() < d.radius;
        if DWELLERS.iter().any(holds_root) {
            // Nothing grows inside a creature: the tube goes to its foot instead.
            skirt(mesh, number, width, &mut dice);
            continue;
        }
        blade(mesh, root, width, &mut dice);
    }
}

/// A blade of grass near a creature.
fn skirt(mesh: &mut MeshBuilder, number: u64, width: f64, dice: &mut Dice) {
    let dweller = &DWELLERS[(number % 2) as usize];
    let turn = dice.range(0.0, TAU);
    let reach = dweller.radius * dice.range(0.85, 1.25);
    let p = dvec2(dweller.center.x, dweller.center.z) + dvec2(cos(turn), sin(turn)) * reach;
    blade(mesh, dvec3(p.x, height(p), p.y), width, dice);
}

fn blade(mesh: &mut MeshBuilder, root: DVec3, width: f64, dice: &mut Dice) {
    let p = dvec2(root.x, root.z);
    // The wind comes in waves.
    let gust = 0.5 + 0.5 * noise2(SEED + 20, p * 0.9).0;
    let lean = dvec3(0.20 + 0.42 * gust, 0.0, 0.10 * gust);
    let tuft = fractal2(SEED + 30, p * 2.2, 2);
    let length = (0.30 + 0.25 * smoothstep(-2.0, -12.0, p.y))
        * (0.75 + 0.55 * tuft + dice.range(0.0, 0.45)).max(0.3);
    let scatter = dvec3(dice.range(-0.5, 0.5), 0.0, dice.range(-0.5, 0.5));
    let up = DVec3::Y + scatter * 0.55;
    let hue = match tuft + dice.range(-0.5, 0.5) {
        t if t > 0.42 => 2,
        t if t > 0.05 => 1,
        t if t > -0.3 => 0,
        _ => 3,
    };
    let tube = Tube {
        root: root - DVec3::Y * 0.01,
        along: up * length,
        bend: (lean + scatter * 0.4) * length * 1.1,
        width: width * 1.15,
        material: GRASS + hue * TONES,
    };
    tube.draw(mesh);
}

impl Creature {
    /// Positions of the eyes, relative to the middle, and their radius.
    fn eyes(&self) -> ([DVec3; 2], f64) {
        let gaze = self.gaze / self.gaze.length();
        let side = DVec3::Y.cross(gaze);
        let side = side / side.length();
        let up = gaze.cross(side);
        let eye = |sign: f64| (gaze * 0.86 + up * 0.30 + side * (0.34 * sign)) * self.radius;
        ([eye(-1.0), eye(1.0)], self.radius * 0.225)
    }

    fn skin(&self, mesh: &mut MeshBuilder, frequency: usize) {
        let (eyes, size) = self.eyes();
        let gaze = self.gaze / self.gaze.length();
        mesh.material(self.fur);
        geodesic::sphere(mesh, frequency.min(12), |p| {
            self.center + p * (self.radius * 0.97)
        });
        for eye in eyes {
            let center = self.center + eye * 1.06;
            mesh.material(WHITE);
            geodesic::sphere(mesh, frequency, |p| center + p * size);
            mesh.material(BLACK);
            let pupil = center + gaze * (size * 0.62);
            geodesic::sphere(mesh, frequency, |p| pupil + p * (size * 0.54));
        }
    }

    /// Fur from roots on a spiral of the golden angle, which spreads them evenly (Vogel, "A better
    /// way to construct the sunflower head", Mathematical Biosciences, 1979); combed downward and
    /// outward, away from the eyes.
    fn coat(&self, mesh: &mut MeshBuilder, count: u64, width: f64) {
        const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
        if mesh.counted(count * TUBE) {
            return;
        }
        let (eyes, size) = self.eyes();
        for number in 0..count {
            if mesh.counted(TUBE) {
                continue;
            }
            let mut dice = Dice::of(SEED + 77 + self.fur as u64, number);
            let y = 1.0 - 2.0 * (number as f64 + dice.unit()) / count as f64;
            let turn = GOLDEN_ANGLE * number as f64;
            let around = (1.0 - y * y).max(0.0).sqrt();
            let normal = dvec3(around * cos(turn), y, around * sin(turn));
            let mut lean = DVec3::NEG_Y * 0.55;
            let mut length = self.radius * dice.range(0.34, 0.52);
            for eye in eyes {
                let away = normal * self.radius - eye;
                let near = 1.0 - smoothstep(size * 0.9, size * 2.2, away.length());
                lean += away / (away.length() + 1e-9) * (1.3 * near);
                length *= 1.0 - 0.62 * near;
            }
            let whorl = 0.5 * fractal2(SEED + 55, dvec2(turn, y * 3.0), 2);
            let scatter = dice.vector(-0.5, 0.5);
            let p = dvec2(normal.x * 3.0 + normal.z, normal.y * 3.0);
            let tuft = fractal2(SEED + 60, p, 2);
            let hue = ((tuft * 1.6 + 0.5 + dice.range(-0.35, 0.35)).clamp(0.0, 0.99) * HUES as f64)
                as usize;
            let tube = Tube {
                root: self.center + normal * (self.radius * 0.96),
                along: (normal + scatter * 0.35) * (length * 0.8),
                bend: (lean + scatter * (0.35 + whorl)) * length,
                width,
                material: self.fur + hue * TONES,
            };
            tube.draw(mesh);
        }
    }
}

/// A curved tube that thins toward its tip.
struct Tube {
    root: DVec3,
    along: DVec3,
    /// Offset of the tip from the end of `along`.
    bend: DVec3,
    width: f64,
    material: usize,
}

impl Tube {
    fn draw(&self, mesh: &mut MeshBuilder) {
        let side = self.along.cross(self.bend + dvec3(1e-3, 0.0, 2e-3));
        let side = side / side.length();
        // End of each tone, in steps; the last is a step short of the tip.
        const ENDS: [usize; TONES + 1] = [0, 2, 4, STEPS];
        for tone in 0..TONES {
            mesh.material(self.material + tone);
            let (from, to) = (ENDS[tone], ENDS[tone + 1]);
            let mut rings = [[DVec3::ZERO; SIDES]; STEPS + 1];
            for (k, ring) in rings[from..=to].iter_mut().enumerate() {
                *ring = self.ring(side, from + k);
            }
            mesh.grid(Grid::tube(SIDES, to - from), |i, j| rings[from + j][i]);
            if tone + 1 == TONES {
                let tip = self.root + self.along + self.bend;
                mesh.fan(tip, SIDES, |i| rings[STEPS][i]);
            }
        }
    }

    /// The corners of the cross-section after `step` steps.
    fn ring(&self, side: DVec3, step: usize) -> [DVec3; SIDES] {
        let t = step as f64 / (STEPS + 1) as f64;
        let center = self.root + self.along * t + self.bend * (t * t);
        let along = self.along + self.bend * (2.0 * t);
        let up = side.cross(along);
        let up = up / up.length();
        let width = self.width * (1.0 - 0.85 * t * t);
        // The corners of a triangle: cosine and sine of 0, 120 and 240 degrees.
        const HALF_ROOT: f64 = 0.866_025_403_784_438_6;
        let (a, b) = (side * width, up * width);
        [
            center + a,
            center - a * 0.5 - b * HALF_ROOT,
            center - a * 0.5 + b * HALF_ROOT,
        ]
    }
}
