//! menger: the sponge of Karl Menger (1926), its inner walls coloured by the size of their hole.
//!
//! Only faces between stone and air are drawn: 2·20ⁿ + 4·8ⁿ quads at level n. The level is the
//! deepest that fits the size. The rest of the size is spent inside the quads. Each is cut into k ×
//! k cells, and cells get points on their diagonals, two more triangles for each. Neither adds a
//! point on an edge that is missing in the neighbour, so that the sponge stays one closed surface.

use super::assembly;
use super::materials::{matte, polished, rgb};
use super::mesh_builder::{Grid, MeshBuilder};
use super::props::face_axes;
use super::setup::{hd, lamp, sun};
use crate::builder::{DocumentMaterial, SceneBuilder};
use glam::{DVec3, dvec3};
use std::ops::Range;

/// Deepest level, at any size.
const LEVELS: u32 = 5;
const FLOOR: usize = LEVELS as usize + 1;
const AMBIENT: DVec3 = dvec3(0.10, 0.12, 0.18);

/// Materials of the walls by the level at which their hole was cut (0: the outside), then of the
/// floor.
fn palette() -> Vec<DocumentMaterial> {
    let colors = [
        rgb(0.70, 0.66, 0.58),
        rgb(0.78, 0.36, 0.12),
        rgb(0.12, 0.42, 0.46),
        rgb(0.66, 0.50, 0.16),
        rgb(0.42, 0.20, 0.34),
        rgb(0.26, 0.40, 0.24),
    ];
    let mut materials: Vec<_> = colors.iter().map(|c| matte(*c, AMBIENT)).collect();
    let floor = matte(rgb(0.05, 0.055, 0.07), AMBIENT);
    materials.push(polished(floor, rgb(0.30, 0.31, 0.34), 400.0));
    materials
}

/// Number of quads of the surface at a level.
fn quads(level: u32) -> u64 {
    2 * 20u64.pow(level) + 4 * 8u64.pow(level)
}

/// Subdivision of the quads.
#[derive(Clone, Copy, Debug)]
struct SpongeDetail {
    level: u32,
    /// Cells along the side of a quad.
    cells: usize,
    /// Number of points on the diagonals of every 2¹⁶ cells.
    extra: u64,
}

impl SpongeDetail {
    fn of(size: u32) -> SpongeDetail {
        let target = f64::from(size);
        let fits = |level: &u32| 2 * quads(*level) <= u64::from(size);
        let level = (1..=LEVELS).rev().find(fits).unwrap_or(1);
        let pairs = target / (2.0 * quads(level) as f64);
        let cells = pairs.sqrt().floor().max(1.0);
        let extra = (pairs / (cells * cells) - 1.0).max(0.0) * 65536.0;
        SpongeDetail {
            level,
            cells: cells as usize,
            extra: extra as u64,
        }
    }

    /// Number of triangles of the whole sponge.
    fn triangles(self) -> u64 {
        let cells = quads(self.level) * (self.cells * self.cells) as u64;
        2 * (cells + self.points(0..cells))
    }

    /// Number of points on the diagonals of the cells of this range.
    fn points(self, cells: Range<u64>) -> u64 {
        ((cells.end * self.extra) >> 16) - ((cells.start * self.extra) >> 16)
    }
}

pub(crate) fn generate(size: u32, builder: &mut dyn SceneBuilder) {
    builder.view(&hd(dvec3(1.50, 1.28, 2.30), dvec3(0.02, 0.43, 0.0), 33.5));
    builder.background(rgb(0.045, 0.065, 0.115));
    builder.light(&sun(dvec3(0.42, 0.72, 0.95), rgb(0.86, 0.78, 0.66)));
    builder.light(&sun(dvec3(0.95, 0.38, 0.05), rgb(0.13, 0.19, 0.36)));
    builder.light(&lamp(dvec3(0.0, 0.5, 0.0), rgb(1.1, 0.62, 0.24), 0.5));
    let cut = SpongeDetail::of(size);
    assembly::draw(builder, palette(), &|mesh| {
        floor(mesh);
        if !mesh.counted(cut.triangles()) {
            Sponge::new(cut).draw(mesh);
        }
    });
}

fn floor(mesh: &mut MeshBuilder) {
    mesh.material(FLOOR);
    mesh.grid(Grid::open(1, 1), |i, j| {
        let side = |k: usize| 40.0 * k as f64 - 20.0;
        dvec3(side(i), -0.002, -side(j))
    });
}

/// Cells along the side of the blocks in which the sponge is drawn: those of two levels.
const BLOCK: usize = 9;

/// For each coordinate the base-3 digits that are 1, as bits, finest first.
fn middles(level: u32) -> Vec<u32> {
    let bit = |c: u32, digit: u32| u32::from(c / 3u32.pow(digit) % 3 == 1) << digit;
    let mask = |c: u32| (0..level).map(|digit| bit(c, digit)).sum();
    (0..3u32.pow(level)).map(mask).collect()
}

/// The digits at which at least two of three coordinates are in the middle, so that the cell is cut
/// out.
fn holes([x, y, z]: [u32; 3]) -> u32 {
    (x & y) | (y & z) | (z & x)
}

struct Sponge {
    cut: SpongeDetail,
    /// [`middles`] of its level.
    middles: Vec<u32>,
    /// Number of cells of quads drawn so far.
    number: u64,
    /// Number of faces of a block, by its sides that meet air, as bits.
    faces: [Option<u64>; 64],
    /// Lowest corner of the block being drawn, in cells, and its drawn part.
    origin: [usize; 3],
    vertices: Vec<DVec3>,
    facets: Vec<(usize, [u32; 3])>,
    /// The vertex at each point of the block's lattice, `u32::MAX` if there is none yet.
    lattice: Vec<u32>,
}

impl Sponge {
    fn new(cut: SpongeDetail) -> Sponge {
        Sponge {
            cut,
            middles: middles(cut.level),
            number: 0,
            faces: [None; 64],
            origin: [0; 3],
            vertices: Vec::new(),
            facets: Vec::new(),
            lattice: vec![u32::MAX; (BLOCK * cut.cells + 1).pow(3)],
        }
    }

    fn draw(&mut self, mesh: &mut MeshBuilder) {
        for origin in blocks(self.middles.len()) {
            // A block that is cut out as a whole has no stone; its walls belong to its neighbours.
            if holes(origin.map(|c| self.middles[c] >> 2)) != 0 {
                continue;
            }
            self.origin = origin;
            let end = self.number + self.faces() * (self.cut.cells * self.cut.cells) as u64;
            let points = self.cut.points(self.number..end);
            if mesh.counted_facets(2 * (end - self.number + points)) {
                self.number = end;
                continue;
            }
            for cell in cells() {
                for (corner, axes, material) in self.faces_of(cell).into_iter().flatten() {
                    self.face(corner, axes, material);
                }
            }
            mesh.facets(&self.vertices, &self.facets);
            self.vertices.clear();
            self.facets.clear();
            self.lattice.fill(u32::MAX);
        }
    }

    /// Number of faces of the block that meet air. Blocks are alike, but for the sides where the
    /// next block is stone.
    fn faces(&mut self) -> u64 {
        let sides = (0..6).map(|side| {
            let (axis, upper) = (side / 2, side % 2 == 1);
            let here = self.origin.map(|c| self.middles[c]);
            let is_stone = |cell: [u32; 3]| holes(cell.map(|middles| middles >> 2)) == 0;
            let next = self.beyond(self.origin[axis] + if upper { BLOCK - 1 } else { 0 }, upper);
            let is_open = next.is_none_or(|next| !is_stone(replaced(here, axis, next)));
            usize::from(is_open) << side
        });
        let sides = sides.sum::<usize>();
        let count = || {
            let faces = cells().flat_map(|cell| self.faces_of(cell));
            faces.flatten().count() as u64
        };
        let faces = self.faces[sides].unwrap_or_else(count);
        self.faces[sides] = Some(faces);
        faces
    }

    /// [`middles`] of the coordinate after or before this one; `None` outside the sponge.
    fn beyond(&self, position: usize, upper: bool) -> Option<u32> {
        let next = if upper { position + 1 } else { position.wrapping_sub(1) };
        self.middles.get(next).copied()
    }

    /// The faces of a cell of the block that meet air: lowest corner, in cells within the block,
    /// axes of its columns and rows, and material.
    fn faces_of(&self, cell: [usize; 3]) -> [Option<CellFace>; 6] {
        let position: [usize; 3] = std::array::from_fn(|k| self.origin[k] + cell[k]);
        let here = position.map(|c| self.middles[c]);
        let is_stone = holes(here) == 0;
        std::array::from_fn(|side| {
            if !is_stone {
                return None;
            }
            let (axis, upper) = (side / 2, side % 2 == 1);
            let material = match self.beyond(position[axis], upper) {
                None => 0,
                Some(middle) => match holes(replaced(here, axis, middle)) {
                    0 => return None,
                    cut => (self.cut.level - cut.ilog2()) as usize,
                },
            };
            let corner = replaced(cell, axis, cell[axis] + usize::from(upper));
            Some((corner, face_axes(axis, upper), material))
        })
    }

    /// Draws a face from its lowest corner, in cells within the block; its columns and rows run
    /// along the axes `u` and `v`.
    fn face(&mut self, corner: [usize; 3], (u, v): (usize, usize), material: usize) {
        let cells = self.cut.cells;
        for row in 0..cells {
            for column in 0..cells {
                let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| {
                    let mut point = corner.map(|c| c * cells);
                    point[u] += column + i;
                    point[v] += row + j;
                    self.vertex(point)
                });
                self.quad(corners, material);
            }
        }
    }

    /// The vertex at a point of the block's lattice.
    fn vertex(&mut self, point: [usize; 3]) -> u32 {
        let cells = self.cut.cells;
        let points = BLOCK * cells + 1;
        let slot = &mut self.lattice[(point[2] * points + point[1]) * points + point[0]];
        if *slot == u32::MAX {
            *slot = self.vertices.len() as u32;
            let side = (cells * self.middles.len()) as f64;
            let [x, y, z] =
                std::array::from_fn(|k| (self.origin[k] * cells + point[k]) as f64 / side);
            self.vertices.push(dvec3(x - 0.5, y, z - 0.5));
        }
        *slot
    }

    /// Draws the next quad, with points on its diagonal.
    fn quad(&mut self, [a, b, c, d]: [u32; 4], material: usize) {
        let points = self.cut.points(self.number..self.number + 1);
        self.number += 1;
        let (from, to) = (self.vertices[a as usize], self.vertices[c as usize]);
        let mut last = a;
        for k in 1..=points {
            let t = k as f64 / (points + 1) as f64;
            let next = self.vertices.len() as u32;
            self.vertices.push(from + (to - from) * t);
            self.facets
                .extend([(material, [last, b, next]), (material, [last, next, d])]);
            last = next;
        }
        self.facets
            .extend([(material, [last, b, c]), (material, [last, c, d])]);
    }
}

/// A face of a cell: its lowest corner, the axes of its columns and rows, and its material.
type CellFace = ([usize; 3], (usize, usize), usize);

/// The coordinates with one of them replaced.
fn replaced<T>(mut all: [T; 3], axis: usize, value: T) -> [T; 3] {
    all[axis] = value;
    all
}

/// The lowest corners of all blocks of a sponge of this side, in cells.
fn blocks(side: usize) -> impl Iterator<Item = [usize; 3]> {
    let along = move || (0..side).step_by(BLOCK);
    along().flat_map(move |z| along().flat_map(move |y| along().map(move |x| [x, y, z])))
}

/// All cells of a block.
fn cells() -> impl Iterator<Item = [usize; 3]> {
    (0..BLOCK * BLOCK * BLOCK).map(|i| [i % BLOCK, i / BLOCK % BLOCK, i / (BLOCK * BLOCK)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ShapeCounter, ShapeCounts};

    fn count(size: u32) -> ShapeCounts {
        let mut builder = ShapeCounter::default();
        generate(size, &mut builder);
        builder.counts()
    }

    #[test]
    fn faces_of_a_level_are_as_many_as_its_formula_says() {
        for (level, quads_there) in [(1, 72), (2, 1056), (3, 18_048)] {
            assert_eq!(quads(level), quads_there);
        }
        let floor = 2;
        for level in 2..=4 {
            let size = 2 * quads(level);
            assert_eq!(count(size as u32).triangles, size + floor);
        }
    }

    #[test]
    fn any_size_between_two_levels_can_be_met() {
        for size in [4_000, 7_000, 30_000, 36_000, 60_000, 650_000, 1_234_567] {
            let triangles = count(size).triangles as f64 / f64::from(size);
            assert!((0.95..1.01).contains(&triangles), "{size}: {triangles}");
        }
    }
}
