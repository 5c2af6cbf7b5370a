//! cornell: a box in the manner of Goral, Torrance, Greenberg and Battaile, "Modeling the
//! Interaction of Light Between Diffuse Surfaces" (SIGGRAPH 1984), with a sphere of glass and one
//! of mirror, all of triangles.
//!
//! The lamp in the ceiling is nine points. Two weak coloured lights beside the walls stand in for
//! the light that the walls' colours would cast on their neighbours.

use super::geodesic;
use super::materials::{glass, glow, matte, polished, rgb};
use super::mesh_builder::MeshBuilder;
use super::setup::{SIZES, hd, lamp};
use crate::standard::builder::{DocumentMaterial, SceneBuilder, StandardLight, StandardView};
use crate::standard::catalogue::{Family, SceneParams, StandardScene};
use glam::{DVec2, DVec3};

pub(in crate::standard) const ENTRY: StandardScene = StandardScene {
    name: "cornell",
    purpose: "a Cornell box with glass and mirror spheres: secondary rays, many lights, all hits near",
    family: Family::Modern,
    default_size: 1_000_000,
    sizes: SIZES,
    size_means: "triangles",
    max_depth: 8,
    generate,
};

const WHITE: usize = 0;
const RED: usize = 1;
const GREEN: usize = 2;
const GLASS: usize = 3;
const MIRROR: usize = 4;
const LAMP: usize = 5;
const BLOCK: usize = 6;
const TILES: [usize; 2] = [7, 8];

const AMBIENT: DVec3 = DVec3::new(0.12, 0.105, 0.09);

fn palette() -> [DocumentMaterial; 9] {
    let mirror = DocumentMaterial {
        ks: rgb(0.86, 0.87, 0.88),
        shininess: 2000.0,
        ..DocumentMaterial::default()
    };
    let polish = rgb(0.07, 0.07, 0.07);
    [
        matte(rgb(0.73, 0.71, 0.67), AMBIENT),
        matte(rgb(0.62, 0.06, 0.05), AMBIENT),
        matte(rgb(0.11, 0.43, 0.10), AMBIENT),
        glass(1.5),
        mirror,
        glow(rgb(1.0, 0.96, 0.86)),
        matte(rgb(0.60, 0.56, 0.48), AMBIENT),
        polished(matte(rgb(0.70, 0.67, 0.60), AMBIENT), polish, 300.0),
        polished(matte(rgb(0.34, 0.30, 0.26), AMBIENT), polish, 300.0),
    ]
}

fn generate(params: &SceneParams, builder: &mut dyn SceneBuilder) {
    builder.view(&StandardView {
        width: 1024,
        height: 1024,
        ..hd(DVec3::new(0.0, 1.0, 5.2), DVec3::new(0.0, 1.0, 0.0), 26.6)
    });
    // Visible in the spheres only: the dim room in front of the open box.
    builder.background(rgb(0.075, 0.065, 0.055));
    lights().for_each(|light| builder.light(&light));
    let palette = palette();
    let mut mesh = MeshBuilder::new(builder, &palette);
    // The spheres get their share first. The rest goes to the flat parts, where more triangles make
    // no visible difference.
    let budget = f64::from(params.size);
    let frequency = geodesic::frequency(budget * 0.4);
    spheres(&mut mesh, frequency);
    let flat = (budget - mesh.triangles() as f64).max(1.0);
    // 14 unit squares of wall and floor and about 3 of blocks, 2 triangles to a quad.
    let cells = (flat / 2.0 / 24.6).max(1.0).sqrt();
    room(&mut mesh, cells);
    blocks(&mut mesh, cells);
    mesh.finish();
}

fn lights() -> impl Iterator<Item = StandardLight> {
    let lamps = (0..9).map(|k| {
        let (i, j) = (f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0);
        // Skewed, because shadows would line up in a straight grid.
        let (x, z) = (0.22 * i + 0.06 * j, 0.18 * j - 0.05 * i);
        lamp(DVec3::new(x, 1.93, z), rgb(1.0, 0.91, 0.76) * 0.1, 1.55)
    });
    let bounce = |x: f64, color| StandardLight {
        attenuation: DVec3::new(1.0, 0.0, 2.0),
        ..StandardLight::colored(DVec3::new(x, 0.7, 0.1), color)
    };
    let bounces = [
        bounce(-0.86, rgb(0.17, 0.02, 0.015)),
        bounce(0.86, rgb(0.02, 0.11, 0.02)),
    ];
    lamps.chain(bounces)
}

fn spheres(mesh: &mut MeshBuilder, frequency: usize) {
    mesh.material(MIRROR);
    geodesic::sphere(mesh, frequency, |p| {
        DVec3::new(-0.40, 1.12 + 0.36, -0.38) + p * 0.36
    });
    mesh.material(GLASS);
    geodesic::sphere(mesh, frequency, |p| DVec3::new(0.20, 0.38, 0.46) + p * 0.38);
}

/// Number of quads along a length.
fn along(length: f64, cells: f64) -> usize {
    (length * cells).round().max(1.0) as usize
}

/// Floor, ceiling with its lamp, back and side walls of the box from -1 to 1, 0 to 2, -1 to 1.
fn room(mesh: &mut MeshBuilder, cells: f64) {
    let at = DVec3::new;
    let wall = |mesh: &mut MeshBuilder, material: usize, corners: [DVec3; 4]| {
        mesh.material(material);
        let [a, b, _, d] = corners;
        mesh.quad(
            corners,
            along((b - a).length(), cells),
            along((d - a).length(), cells),
        );
    };
    let (l, h, f, k) = (1.0, 2.0, 1.0, -1.0);
    wall(
        mesh,
        WHITE,
        [at(-l, 0.0, k), at(l, 0.0, k), at(l, h, k), at(-l, h, k)],
    );
    wall(
        mesh,
        RED,
        [at(-l, 0.0, f), at(-l, 0.0, k), at(-l, h, k), at(-l, h, f)],
    );
    wall(
        mesh,
        GREEN,
        [at(l, 0.0, k), at(l, 0.0, f), at(l, h, f), at(l, h, k)],
    );
    wall(
        mesh,
        WHITE,
        [at(-l, h, k), at(l, h, k), at(l, h, f), at(-l, h, f)],
    );
    wall(
        mesh,
        LAMP,
        [
            at(-0.34, 1.985, -0.28),
            at(0.34, 1.985, -0.28),
            at(0.34, 1.985, 0.28),
            at(-0.34, 1.985, 0.28),
        ],
    );
    let side = 8;
    let step = 2.0 / f64::from(side);
    for row in 0..side {
        for column in 0..side {
            let (x, z) = (-1.0 + f64::from(column) * step, 1.0 - f64::from(row) * step);
            let material = TILES[((row + column) % 2) as usize];
            wall(
                mesh,
                material,
                [
                    at(x, 0.0, z),
                    at(x + step, 0.0, z),
                    at(x + step, 0.0, z - step),
                    at(x, 0.0, z - step),
                ],
            );
        }
    }
}

/// The tall block under the mirror sphere and the low one beside it.
fn blocks(mesh: &mut MeshBuilder, cells: f64) {
    mesh.material(BLOCK);
    block(
        mesh,
        DVec2::new(-0.40, -0.38),
        DVec3::new(0.29, 1.12, 0.29),
        DVec2::new(0.96, 0.28),
        cells,
    );
    block(
        mesh,
        DVec2::new(0.55, -0.36),
        DVec3::new(0.27, 0.62, 0.27),
        DVec2::new(0.958, -0.287),
        cells,
    );
}

/// A block on the floor of these half widths (and whole height), turned so that its x axis points
/// to `turn`.
fn block(mesh: &mut MeshBuilder, center: DVec2, size: DVec3, turn: DVec2, cells: f64) {
    let turn = turn / turn.length();
    let at = |x: f64, y: f64, z: f64| {
        let (x, z) = (x * size.x, z * size.z);
        let position = center + turn * x + DVec2::new(-turn.y, turn.x) * z;
        DVec3::new(position.x, y * size.y, position.y)
    };
    let up = along(size.y, cells);
    let across = along(2.0 * size.x, cells);
    for [(ax, az), (bx, bz)] in [
        [(-1.0, 1.0), (1.0, 1.0)],
        [(1.0, 1.0), (1.0, -1.0)],
        [(1.0, -1.0), (-1.0, -1.0)],
        [(-1.0, -1.0), (-1.0, 1.0)],
    ] {
        let side = [
            at(ax, 0.0, az),
            at(bx, 0.0, bz),
            at(bx, 1.0, bz),
            at(ax, 1.0, az),
        ];
        mesh.quad(side, across, up);
    }
    let top = [
        at(-1.0, 1.0, 1.0),
        at(1.0, 1.0, 1.0),
        at(1.0, 1.0, -1.0),
        at(-1.0, 1.0, -1.0),
    ];
    mesh.quad(top, across, across);
}
