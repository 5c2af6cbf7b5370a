//! cornell: a box in the manner of Goral, Torrance, Greenberg and Battaile, "Modeling the
//! Interaction of Light Between Diffuse Surfaces" (SIGGRAPH 1984), with a sphere of glass and one
//! of mirror, all of triangles.
//!
//! The lamp in the ceiling is nine points. Two weak coloured lights next to the walls replace the
//! light that the coloured walls would reflect onto their neighbours.

use super::materials::{glass, glow, matte, polished, rgb};
use super::mesh_builder::MeshBuilder;
use super::props::{FramePoint, LocalFrame, PartBuilder};
use super::setup::{hd, lamp};
use super::{assembly, geodesic};
use crate::builder::{DocumentMaterial, SceneBuilder, StandardLight, StandardView};
use glam::{DVec2, DVec3, dvec2, dvec3};

const WHITE: usize = 0;
const RED: usize = 1;
const GREEN: usize = 2;
const GLASS: usize = 3;
const MIRROR: usize = 4;
const LAMP: usize = 5;
const BLOCK: usize = 6;
const TILES: [usize; 2] = [7, 8];

const AMBIENT: DVec3 = dvec3(0.12, 0.105, 0.09);

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

pub(crate) fn generate(size: u32, builder: &mut dyn SceneBuilder) {
    builder.view(&StandardView {
        width: 1024,
        height: 1024,
        ..hd(dvec3(0.0, 1.0, 5.2), dvec3(0.0, 1.0, 0.0), 26.6)
    });
    // Visible only in the spheres: the dim room in front of the open box.
    builder.background(rgb(0.075, 0.065, 0.055));
    lights().for_each(|light| builder.light(&light));
    // The spheres get their share first. The rest goes to flat parts, where more triangles make no
    // visible difference.
    let budget = f64::from(size);
    let frequency = geodesic::frequency(budget * 0.4);
    assembly::draw(builder, palette(), &|mesh| {
        spheres(mesh, frequency);
        let flat = (budget - mesh.triangles() as f64).max(1.0);
        // 14 unit squares of wall and floor and about 3 of blocks, 2 triangles per quad.
        let cells = (flat / 2.0 / 24.6).max(1.0).sqrt();
        let mut parts = PartBuilder::new(mesh, cells);
        room(&mut parts);
        blocks(&mut parts);
    });
}

fn lights() -> impl Iterator<Item = StandardLight> {
    let lamps = (0..9).map(|k| {
        let (i, j) = (f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0);
        // Skewed, because shadows would line up in a straight grid.
        let (x, z) = (0.22 * i + 0.06 * j, 0.18 * j - 0.05 * i);
        lamp(dvec3(x, 1.93, z), rgb(1.0, 0.91, 0.76) * 0.1, 1.55)
    });
    let bounce = |x: f64, color| StandardLight {
        attenuation: dvec3(1.0, 0.0, 2.0),
        ..StandardLight::colored(dvec3(x, 0.7, 0.1), color)
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
        dvec3(-0.40, 1.12 + 0.36, -0.38) + p * 0.36
    });
    mesh.material(GLASS);
    geodesic::sphere(mesh, frequency, |p| dvec3(0.20, 0.38, 0.46) + p * 0.38);
}

/// Floor, ceiling with its lamp, back and side walls of the box from -1 to 1, 0 to 2, -1 to 1.
fn room(parts: &mut PartBuilder) {
    let mut wall = |material: usize, corners: [FramePoint; 4]| {
        parts.material(material);
        parts.wall(corners);
    };
    let (l, h, f, k) = (1.0, 2.0, 1.0, -1.0);
    wall(WHITE, [(-l, 0.0, k), (l, 0.0, k), (l, h, k), (-l, h, k)]);
    wall(RED, [(-l, 0.0, f), (-l, 0.0, k), (-l, h, k), (-l, h, f)]);
    wall(GREEN, [(l, 0.0, k), (l, 0.0, f), (l, h, f), (l, h, k)]);
    wall(WHITE, [(-l, h, k), (l, h, k), (l, h, f), (-l, h, f)]);
    let lamp = [(-0.34, -0.28), (0.34, -0.28), (0.34, 0.28), (-0.34, 0.28)];
    wall(LAMP, lamp.map(|(x, z)| (x, 1.985, z)));
    parts.tiles(TILES, 1.0, 8);
}

/// The tall block under the mirror sphere, and the low one next to it.
fn blocks(parts: &mut PartBuilder) {
    parts.material(BLOCK);
    block(parts, (-0.40, -0.38), (0.29, 1.12), dvec2(0.96, 0.28));
    block(parts, (0.55, -0.36), (0.27, 0.62), dvec2(0.958, -0.287));
}

/// A block on the floor at (x, z), of this half width and height, turned so that its x axis points
/// to `turn`.
fn block(parts: &mut PartBuilder, (x, z): (f64, f64), (half, height): (f64, f64), turn: DVec2) {
    let turn = turn / turn.length();
    let right = dvec3(turn.x, 0.0, turn.y);
    let front = dvec3(-turn.y, 0.0, turn.x);
    let mut block = parts.at(LocalFrame::upright(dvec3(x, 0.0, z), right, front));
    let (across, up) = (block.cells(2.0 * half), block.cells(height));
    let ring = [(-half, half), (half, half), (half, -half), (-half, -half)];
    for k in 0..4 {
        let ((ax, az), (bx, bz)) = (ring[k], ring[(k + 1) % 4]);
        let side = [
            (ax, 0.0, az),
            (bx, 0.0, bz),
            (bx, height, bz),
            (ax, height, az),
        ];
        block.quad(side, (across, up));
    }
    block.quad(ring.map(|(x, z)| (x, height, z)), (across, across));
}
