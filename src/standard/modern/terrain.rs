//! terrain: mountains around a lake, a height field.
//!
//! The heights are octaves of value noise that fade where the slope accumulated so far is steep.
//! That leaves ridges sharp and valleys smooth, as if worn by water (Quilez, "Value noise
//! derivatives", 2008). Vegetation follows from height and slope. Air is part of the materials:
//! with distance from the eye they approach the colour of the sky.

use super::assembly;
use super::materials::{hazy, matte, polished, rgb};
use super::mesh_builder::MeshBuilder;
use super::noise::{Dice, Points, fractal2_of, noise2, smoothstep, turned};
use super::setup::{hd, sun};
use crate::builder::{DocumentMaterial, SceneBuilder};
use glam::{DVec2, DVec3, dvec2, dvec3};

const SEED: u64 = 0x7e44_a1c5;
const EYE: DVec3 = dvec3(0.6, 0.55, 10.4);
const SKY: DVec3 = dvec3(0.23, 0.42, 0.72);
const AIR: DVec3 = dvec3(0.36, 0.49, 0.68);
/// Mean light from the sky.
const AMBIENT: DVec3 = dvec3(0.11, 0.15, 0.23);
/// Half the width and half the depth of the land.
const HALF: DVec2 = dvec2(15.0, 13.0);
/// Number of steps of haze, from the eye to the far end.
const HAZES: usize = 16;

/// Kinds of ground, as rows of the palette; each comes in every step of haze.
#[derive(Clone, Copy)]
enum Ground {
    Sand,
    Meadow,
    Heath,
    Forest,
    Rock,
    DarkRock,
    Scree,
    Snow,
}

const GROUNDS: usize = 8;
const WATER: usize = GROUNDS * HAZES;

fn palette() -> Vec<DocumentMaterial> {
    let colors = [
        rgb(0.34, 0.28, 0.19),
        rgb(0.13, 0.20, 0.045),
        rgb(0.21, 0.20, 0.07),
        rgb(0.045, 0.085, 0.03),
        rgb(0.25, 0.225, 0.20),
        rgb(0.14, 0.13, 0.125),
        rgb(0.31, 0.275, 0.23),
        rgb(0.86, 0.89, 0.95),
    ];
    let mut materials = Vec::new();
    for color in colors {
        for step in 0..HAZES {
            let haze = 0.5 * step as f64 / (HAZES - 1) as f64;
            materials.push(hazy(matte(color, AMBIENT), AIR, haze));
        }
    }
    let deep = matte(rgb(0.012, 0.045, 0.055), AMBIENT);
    materials.push(polished(deep, rgb(0.52, 0.56, 0.58), 900.0));
    materials
}

/// Number of points whose heights are computed at once.
const LANES: usize = 8;

/// Heights of the land; the lake's surface is at 0.
fn heights(points: &Points<LANES>) -> [f64; LANES] {
    let broad = points.map(|p| p * 0.17);
    let x = fractal2_of(SEED, broad, 2);
    let y = fractal2_of(SEED + 8, broad, 2);
    let mut drifted = *points;
    for k in 0..LANES {
        let p = dvec2(points.x[k], points.y[k]);
        let p = (p + dvec2(x[k], y[k]) * 1.6) * 0.21;
        (drifted.x[k], drifted.y[k]) = (p.x, p.y);
    }
    let ridges = eroded(drifted);
    let hills = fractal2_of(SEED + 16, points.map(|p| p * 1.1), 5);
    std::array::from_fn(|k| height(dvec2(points.x[k], points.y[k]), ridges[k], 0.16 * hills[k]))
}

/// Height of the land from its ridges and hills.
fn height(p: DVec2, ridges: f64, hills: f64) -> f64 {
    // The lake lies in front of the mountains, and the near shore stays low so that nothing hides
    // it.
    let from_lake = ((p - dvec2(-0.6, 4.6)) / dvec2(5.2, 3.6)).length();
    let shore = smoothstep(0.55, 1.5, from_lake);
    let near = smoothstep(2.0, 9.5, p.y);
    let mountains = smoothstep(0.9, 3.1, from_lake) * (1.0 - 0.86 * near);
    -0.28 + 0.42 * shore + mountains * (2.1 + 3.6 * ridges) + hills * (0.45 + 0.55 * shore)
}

/// Octaves of noise that fade with the slope accumulated so far.
fn eroded(mut points: Points<LANES>) -> [f64; LANES] {
    let (mut sums, mut part) = ([0.0; LANES], 1.0);
    let mut slopes = Points {
        x: [0.0; LANES],
        y: [0.0; LANES],
    };
    for octave in 0..11 {
        for (k, sum) in sums.iter_mut().enumerate() {
            let p = dvec2(points.x[k], points.y[k]);
            let (value, gradient) = noise2(SEED + 32 + octave, p);
            let slope = dvec2(slopes.x[k], slopes.y[k]) + gradient * 0.75;
            *sum += part * value / (1.0 + slope.dot(slope));
            (slopes.x[k], slopes.y[k]) = (slope.x, slope.y);
        }
        part *= 0.5;
        points = points.map(|p| turned(p) * 2.0);
    }
    sums
}

/// The ground of a face at this center with this (unnormalised, upward) normal. `patch` in [-1, 1]
/// separates woods from meadows.
fn ground(center: DVec3, normal: DVec3, patch: f64, dice: &mut Dice) -> Ground {
    let steep = normal.y / normal.length();
    let grain = dice.range(-1.0, 1.0);
    let height = center.y + 0.25 * patch + 0.05 * grain;
    let steep = steep + 0.10 * patch + 0.035 * grain;
    if height > 2.1 && steep > 0.66 - 0.05 * (height - 2.1) {
        Ground::Snow
    } else if steep < 0.62 && patch + 0.4 * grain < -0.1 {
        Ground::DarkRock
    } else if steep < 0.70 {
        Ground::Rock
    } else if center.y < 0.035 + 0.02 * grain {
        Ground::Sand
    } else if height > 1.6 || steep < 0.76 {
        Ground::Scree
    } else if patch + 0.3 * grain > 0.12 {
        Ground::Forest
    } else if patch + 0.3 * grain < -0.12 {
        Ground::Heath
    } else {
        Ground::Meadow
    }
}

/// Numbers of columns and rows of quads for about `size` triangles.
fn net(size: u32) -> (usize, usize) {
    let quads = f64::from(size) / 2.0 - 1.0;
    let across = (quads.sqrt() * 1.05).round().max(1.0);
    let rows = (quads / across).round().max(1.0);
    (across as usize, rows as usize)
}

/// Position of column or row `i` of `cells`, in [-1, 1]: denser toward 0.
fn spread(i: usize, cells: usize) -> f64 {
    let t = 2.0 * i as f64 / cells as f64 - 1.0;
    t * (0.2 + 0.8 * t * t)
}

/// Position of row `j` of `rows`, in [-1, 1]: denser toward 1, near the eye.
fn depth(j: usize, rows: usize) -> f64 {
    let t = j as f64 / rows as f64;
    1.0 - 2.0 * t * (0.12 + 0.88 * t)
}

/// Quads along the side of the square blocks in which the land is generated.
const BLOCK: usize = 64;

pub(crate) fn generate(size: u32, builder: &mut dyn SceneBuilder) {
    builder.view(&hd(EYE, dvec3(-0.75, 1.5, 0.0), 40.0));
    builder.background(SKY);
    builder.light(&sun(dvec3(-0.80, 0.42, 0.06), rgb(1.9, 1.55, 1.12)));
    // The sky's light from the other side, weak and blue.
    builder.light(&sun(dvec3(0.5, 0.7, 0.5), rgb(0.14, 0.18, 0.27)));
    let (across, rows) = net(size);
    assembly::draw(builder, palette(), &|mesh| {
        lake(mesh);
        if mesh.counted(2 * (across * rows) as u64) {
            return;
        }
        for j in (0..rows).step_by(BLOCK) {
            let high = BLOCK.min(rows - j);
            for i in (0..across).step_by(BLOCK) {
                let wide = BLOCK.min(across - i);
                if !mesh.counted_facets(2 * (wide * high) as u64) {
                    block(mesh, (across, rows), (i, j), (wide, high));
                }
            }
        }
    });
}

fn lake(mesh: &mut MeshBuilder) {
    let on_ground = |x: f64, z: f64| dvec3(x, 0.0, z);
    let (x, z) = (HALF.x, HALF.y);
    mesh.material(WATER);
    mesh.quad(
        [
            on_ground(-x, z),
            on_ground(x, z),
            on_ground(x, -z),
            on_ground(-x, -z),
        ],
        1,
        1,
    );
}

/// Draws the quads of a block of this size from its first column and row on.
fn block(
    mesh: &mut MeshBuilder,
    (across, rows): (usize, usize),
    (left, first): (usize, usize),
    (wide, high): (usize, usize),
) {
    let columns: Vec<f64> = (left..=left + wide).map(|i| spread(i, across)).collect();
    let mut points = Vec::with_capacity((wide + 1) * (high + 1));
    for j in first..=first + high {
        let z = depth(j, rows);
        points.extend(columns.iter().map(|&x| HALF * dvec2(x, z)));
    }
    let woods = |points: &Points<LANES>| fractal2_of(SEED + 64, points.map(|p| p * 1.7), 3);
    let (heights, patches) = (at_all(&points, heights), at_all(&points, woods));
    let vertices = points.iter().zip(heights);
    let vertices: Vec<_> = vertices
        .map(|(p, height)| dvec3(p.x, height, p.y))
        .collect();
    let mut facets = Vec::with_capacity(2 * wide * high);
    let mut dice = Dice::of(SEED + first as u64, left as u64);
    for j in 0..high {
        for i in 0..wide {
            let a = (j * (wide + 1) + i) as u32;
            let above = a + wide as u32 + 1;
            // The diagonals alternate, so that no direction stands out.
            let split = match (i + j) % 2 {
                0 => [[a, a + 1, above + 1], [a, above + 1, above]],
                _ => [[a, a + 1, above], [a + 1, above + 1, above]],
            };
            let patch = patches[a as usize];
            for corners in split {
                let material = material_of(&vertices, corners, patch, &mut dice);
                facets.push((material, corners));
            }
        }
    }
    mesh.facets(&vertices, &facets);
}

/// The values at all points.
fn at_all(points: &[DVec2], values: impl Fn(&Points<LANES>) -> [f64; LANES]) -> Vec<f64> {
    let mut all = Vec::with_capacity(points.len() + LANES);
    for block in points.chunks(LANES) {
        let mut lanes = Points {
            x: [0.0; LANES],
            y: [0.0; LANES],
        };
        for (k, p) in block.iter().enumerate() {
            (lanes.x[k], lanes.y[k]) = (p.x, p.y);
        }
        all.extend(values(&lanes));
    }
    all
}

/// The row of the palette for a face.
fn material_of(vertices: &[DVec3], corners: [u32; 3], patch: f64, dice: &mut Dice) -> usize {
    let corner = |k: usize| vertices[corners[k] as usize];
    let (a, b, c) = (corner(0), corner(1), corner(2));
    let center = (a + b + c) / 3.0;
    let distance = (center - EYE).length() / 26.0 * (HAZES - 1) as f64;
    // Chosen at random between two steps, so that no step shows as a line.
    let step = (distance + dice.unit()) as usize;
    let ground = ground(center, (b - a).cross(c - a), patch, dice);
    ground as usize * HAZES + step.min(HAZES - 1)
}
