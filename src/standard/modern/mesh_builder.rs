//! The mesh builder draws triangle scenes: the sections of them that its thread has taken. The rest
//! is counted without being drawn.

use super::section::{SceneSection, Strip};
use glam::DVec3;
use std::ops::Range;

/// Takes a finished section, and returns the numbers of the triangles to be drawn next, beyond it.
pub(super) type NextSection<'a> = dyn FnMut(SceneSection) -> Range<u64> + 'a;

/// Draws shapes with the materials of a palette.
pub(super) struct MeshBuilder<'a> {
    /// Number of triangles of all shapes so far, drawn or not.
    triangles: u64,
    /// The triangles to be drawn, by number; a row is drawn if its first one is.
    drawn: Range<u64>,
    next: &'a mut NextSection<'a>,
    section: SceneSection,
    material: usize,
    /// The row of corners at which a shape was divided.
    row: Vec<DVec3>,
    scatter: ScatterBuffers,
}

/// Buffers of [`MeshBuilder::facets`].
#[derive(Default)]
struct ScatterBuffers {
    /// Numbers of the triangles, by material.
    sorted: Vec<u32>,
    /// The vertex of a material's strip for each vertex; `u32::MAX` if there is none.
    slots: Vec<u32>,
}

/// Range of numbers that no triangle has.
pub(super) const NONE: Range<u64> = u64::MAX..u64::MAX;

/// Number of triangles that a function draws, without drawing them.
pub(super) fn count(draw: impl FnOnce(&mut MeshBuilder)) -> u64 {
    draw_sections(NONE, &mut |_| NONE, draw)
}

/// Draws the triangles in a range, and in those that `next` returns for finished sections. Returns
/// the number of all triangles.
pub(super) fn draw_sections(
    first: Range<u64>,
    next: &mut NextSection,
    draw: impl FnOnce(&mut MeshBuilder),
) -> u64 {
    let mut mesh = MeshBuilder {
        triangles: 0,
        drawn: first,
        next,
        section: SceneSection::default(),
        material: 0,
        row: Vec::new(),
        scatter: ScatterBuffers::default(),
    };
    draw(&mut mesh);
    // The sections in which no row begins are empty.
    while mesh.drawn != NONE {
        mesh.end_section();
    }
    mesh.triangles
}

/// A rectangular grid of quads, each of two triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    /// Quads along the rows.
    pub(super) across: usize,
    /// Rows of quads.
    pub(super) rows: usize,
    /// True if the last quad of a row meets the first.
    pub(super) closed_across: bool,
    /// True if the last row meets the first.
    pub(super) closed_rows: bool,
}

impl Grid {
    /// A grid with four borders.
    pub(super) fn open(across: usize, rows: usize) -> Grid {
        Grid {
            across,
            rows,
            closed_across: false,
            closed_rows: false,
        }
    }

    /// A tube, open at its ends.
    pub(super) fn tube(around: usize, along: usize) -> Grid {
        Grid {
            closed_across: true,
            ..Grid::open(around, along)
        }
    }

    /// A closed ring of tube.
    pub(super) fn torus(around: usize, along: usize) -> Grid {
        Grid {
            closed_rows: true,
            ..Grid::tube(around, along)
        }
    }

    /// Corners of a row.
    fn columns(&self) -> usize {
        self.across + usize::from(!self.closed_across)
    }
}

/// Rows of triangles between rows of corners.
enum Lattice {
    Grid(Grid),
    Triangle { side: usize },
}

/// Adds the corners of a row.
type DrawCorners<'a> = dyn FnMut(usize, &mut Vec<DVec3>) + 'a;

impl Lattice {
    fn rows(&self) -> usize {
        match *self {
            Lattice::Grid(grid) => grid.rows,
            Lattice::Triangle { side } => side,
        }
    }

    /// Number of triangles before a row.
    fn before(&self, row: usize) -> usize {
        match *self {
            Lattice::Grid(grid) => 2 * grid.across * row,
            Lattice::Triangle { side } => side * side - (side - row) * (side - row),
        }
    }

    /// Number of corners in a row.
    fn corners(&self, row: usize) -> usize {
        match *self {
            Lattice::Grid(grid) => grid.columns(),
            Lattice::Triangle { side } => side - row + 1,
        }
    }

    /// Adds the triangles of a row, from the first corners below and above it.
    fn connect(&self, row: usize, below: u32, above: u32, triangles: &mut Vec<[u32; 3]>) {
        match *self {
            Lattice::Grid(grid) => triangles.extend((0..grid.across).flat_map(|i| {
                let next = ((i + 1) % grid.columns()) as u32;
                let i = i as u32;
                let (a, b, c, d) = (below + i, below + next, above + next, above + i);
                [[a, b, c], [a, c, d]]
            })),
            Lattice::Triangle { side } => {
                let wide = (side - row - 1) as u32;
                let upright = (0..=wide).map(|i| [below + i, below + i + 1, above + i]);
                let inverted = (0..wide).map(|i| [below + i + 1, above + i + 1, above + i]);
                triangles.extend(upright.chain(inverted));
            }
        }
    }
}

impl MeshBuilder<'_> {
    /// Number of triangles so far.
    pub(super) fn triangles(&self) -> u64 {
        self.triangles
    }

    /// Counts triangles if none of them are drawn here, and returns true. If it returns false, they
    /// must be drawn. Nothing that follows may depend on which it was.
    pub(super) fn counted(&mut self, triangles: u64) -> bool {
        self.counted_before(self.triangles + triangles, triangles)
    }

    /// As [`MeshBuilder::counted`], for the triangles of one call of [`MeshBuilder::facets`].
    pub(super) fn counted_facets(&mut self, triangles: u64) -> bool {
        self.counted_before(self.triangles + 1, triangles)
    }

    fn counted_before(&mut self, end: u64, triangles: u64) -> bool {
        while self.drawn.end <= self.triangles {
            self.end_section();
        }
        let counted = end <= self.drawn.start;
        if counted {
            self.triangles += triangles;
        }
        counted
    }

    /// Chooses a material of the palette.
    pub(super) fn material(&mut self, material: usize) {
        self.material = material;
    }

    /// Draws the rows of a shape that belong to sections of this thread; `before` is the number of
    /// triangles before a row.
    fn rows(
        &mut self,
        rows: usize,
        before: impl Fn(usize) -> usize,
        mut draw: impl FnMut(&mut Self, Range<usize>),
    ) {
        let number = |row: usize| before(row) as u64;
        let start = self.triangles;
        let end = start + number(rows);
        while self.drawn.start < end {
            let first_at = |bound: u64| {
                let reached = (0..rows).find(|&row| start + number(row) >= bound);
                reached.unwrap_or(rows)
            };
            let from = first_at(self.drawn.start);
            let to = if end <= self.drawn.end { rows } else { first_at(self.drawn.end) };
            if from < to {
                draw(self, from..to);
            }
            if to == rows {
                break;
            }
            self.end_section();
        }
        self.triangles = end;
    }

    fn end_section(&mut self) {
        self.drawn = (self.next)(std::mem::take(&mut self.section));
    }

    /// Draws the rows of a shape by its corners. Not generic, so that it is compiled once for all
    /// shapes.
    fn lattice(&mut self, shape: &Lattice, draw_corners: &mut DrawCorners) {
        let mut known = None;
        let rows = shape.rows();
        self.rows(
            rows,
            |row| shape.before(row),
            |mesh, run| {
                let Strip {
                    vertices, shared, ..
                } = mesh.section.strip(mesh.material);
                let first = run.start;
                if first > 0 {
                    *shared = shape.corners(first);
                }
                if known == Some(first) {
                    vertices.extend_from_slice(&mesh.row)
                } else {
                    draw_corners(first, vertices)
                }
                for j in run.clone() {
                    let strip = mesh.section.strip(mesh.material);
                    let above = strip.vertices.len();
                    let below = above - shape.corners(j);
                    draw_corners(j + 1, &mut strip.vertices);
                    shape.connect(j, below as u32, above as u32, &mut strip.triangles);
                    mesh.section.end_step(mesh.material, shape.corners(j + 1));
                }
                if run.end < rows {
                    let vertices = &mesh.section.strip(mesh.material).vertices;
                    let last = &vertices[vertices.len() - shape.corners(run.end)..];
                    mesh.row.clear();
                    mesh.row.extend_from_slice(last);
                    known = Some(run.end);
                }
            },
        );
    }

    /// Draws a grid whose corner in column `i` of row `j` is `point(i, j)`. Seen from its front,
    /// columns run to the right and rows upward. A closed direction has no last corner: the first
    /// one is used again, so `point` must return the same each time.
    pub(super) fn grid(&mut self, grid: Grid, mut point: impl FnMut(usize, usize) -> DVec3) {
        let columns = grid.columns();
        self.lattice(&Lattice::Grid(grid), &mut |j, vertices| {
            let row = if grid.closed_rows { j % grid.rows } else { j };
            vertices.extend((0..columns).map(|i| point(i, row)));
        });
    }

    /// Draws a triangle of `side`² triangles. Its corner at `i` steps toward its second and `j`
    /// toward its third corner is `point(i, j)`.
    pub(super) fn triangle(&mut self, side: usize, mut point: impl FnMut(usize, usize) -> DVec3) {
        self.lattice(&Lattice::Triangle { side }, &mut |j, vertices| {
            vertices.extend((0..=side - j).map(|i| point(i, j)));
        });
    }

    /// Draws a flat four-cornered grid of `across` by `rows` quads. The corners are
    /// counter-clockwise from its front; columns run from the first to the second.
    pub(super) fn quad(&mut self, [a, b, c, d]: [DVec3; 4], across: usize, rows: usize) {
        self.grid(Grid::open(across, rows), |i, j| {
            let (u, v) = (i as f64 / across as f64, j as f64 / rows as f64);
            (a * (1.0 - u) + b * u) * (1.0 - v) + (d * (1.0 - u) + c * u) * v
        });
    }

    /// Draws a closed fan over a ring of corners that run counter-clockwise around `center`.
    pub(super) fn fan(&mut self, center: DVec3, ring: usize, point: impl Fn(usize) -> DVec3) {
        let before = |row: usize| row * ring;
        self.rows(1, before, |mesh, _| {
            let Strip {
                vertices,
                triangles,
                ..
            } = mesh.section.strip(mesh.material);
            let hub = vertices.len() as u32;
            vertices.push(center);
            vertices.extend((0..ring).map(&point));
            let corner = |i: usize| hub + 1 + (i % ring) as u32;
            triangles.extend((0..ring).map(|i| [hub, corner(i), corner(i + 1)]));
            mesh.section.end_step(mesh.material, 0);
        });
    }

    /// Draws triangles that each have a material of their own: `(material, corners)`, where corners
    /// index `vertices`.
    pub(super) fn facets(&mut self, vertices: &[DVec3], triangles: &[(usize, [u32; 3])]) {
        let before = |row: usize| row * triangles.len();
        self.rows(1, before, |mesh, _| mesh.scatter(vertices, triangles));
    }

    fn scatter(&mut self, vertices: &[DVec3], triangles: &[(usize, [u32; 3])]) {
        let ScatterBuffers { sorted, slots } = &mut self.scatter;
        sorted.clear();
        sorted.extend(0..triangles.len() as u32);
        sorted.sort_by_key(|&t| triangles[t as usize].0);
        for run in sorted.chunk_by(|&a, &b| triangles[a as usize].0 == triangles[b as usize].0) {
            let material = triangles[run[0] as usize].0;
            let strip = self.section.strip(material);
            slots.clear();
            slots.resize(vertices.len(), u32::MAX);
            for &t in run {
                let mut corners = triangles[t as usize].1;
                for v in &mut corners {
                    let slot = &mut slots[*v as usize];
                    if *slot == u32::MAX {
                        *slot = strip.vertices.len() as u32;
                        strip.vertices.push(vertices[*v as usize]);
                    }
                    *v = *slot;
                }
                strip.triangles.push(corners);
            }
            self.section.end_step(material, 0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modern::assembly;
    use crate::{DocumentMaterial, MemoryBuilder};
    use glam::dvec3;

    #[test]
    fn a_counting_builder_counts_what_a_drawing_one_draws() {
        let draw = |mesh: &mut MeshBuilder| {
            mesh.grid(Grid::torus(7, 5), |i, j| dvec3(i as f64, j as f64, 1.0));
            mesh.material(1);
            mesh.grid(Grid::tube(300, 100), |i, j| {
                assert!(i < 300 && j <= 100);
                dvec3(i as f64, j as f64, 0.0)
            });
            mesh.quad([DVec3::ZERO, DVec3::X, DVec3::ONE, DVec3::Y], 3, 4);
            mesh.triangle(200, |i, j| {
                assert!(i + j <= 200);
                DVec3::ZERO
            });
            mesh.fan(DVec3::ZERO, 6, |i| DVec3::splat(i as f64));
            mesh.facets(&[DVec3::ZERO; 3], &[(1, [0, 1, 2]), (0, [2, 1, 0])]);
        };
        let palette = [DocumentMaterial::default(); 2];
        let mut builder = MemoryBuilder::default();
        assembly::draw(&mut builder, palette, &draw);
        let drawn = builder.finish().triangles.len() as u64;
        assert_eq!(drawn, count(draw));
    }
}
