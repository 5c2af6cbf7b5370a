//! The mesh builder draws triangle scenes. It collects triangles by material and passes them to the
//! scene builder in chunks of bounded size. It can also count triangles without drawing them.

use crate::builder::{DocumentMaterial, MaterialDesc, SceneBuilder};
use glam::DVec3;

/// Approximate number of triangles in a chunk: a buffer is passed on as soon as it holds this many.
const CHUNK: usize = 8192;

/// Draws with the materials of a palette.
pub(super) struct MeshBuilder<'a> {
    builder: &'a mut dyn SceneBuilder,
    /// True if the scene builder needs only the number of triangles.
    counting: bool,
    /// One buffer for each material of the palette.
    buffers: Vec<MeshBuffer>,
    material: usize,
    triangles: u64,
    row: Vec<DVec3>,
    scatter: ScatterBuffers,
}

/// Buffers of [`MeshBuilder::facets`].
#[derive(Default)]
struct ScatterBuffers {
    /// Numbers of the triangles, by material.
    sorted: Vec<u32>,
    /// The vertex of a material's buffer for each vertex; `u32::MAX` if there is none.
    slots: Vec<u32>,
}

/// Triangles of one material that have not been passed on yet.
struct MeshBuffer {
    material: DocumentMaterial,
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
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

    fn triangles(self) -> usize {
        2 * self.across * self.rows
    }
}

impl<'a> MeshBuilder<'a> {
    /// A mesh builder that draws into a scene builder. If that only needs counts, no points are
    /// computed.
    pub(super) fn new(
        builder: &'a mut dyn SceneBuilder,
        palette: impl IntoIterator<Item = DocumentMaterial>,
    ) -> MeshBuilder<'a> {
        let buffer = |material| MeshBuffer {
            material,
            vertices: Vec::new(),
            triangles: Vec::new(),
        };
        MeshBuilder {
            counting: builder.takes_count(0),
            builder,
            buffers: palette.into_iter().map(buffer).collect(),
            material: 0,
            triangles: 0,
            row: Vec::new(),
            scatter: ScatterBuffers::default(),
        }
    }

    /// Number of triangles drawn, or counted.
    pub(super) fn triangles(&self) -> u64 {
        self.triangles
    }

    /// Returns true if it only counts triangles, after counting these.
    pub(super) fn counted(&mut self, triangles: u64) -> bool {
        if self.counting {
            self.triangles += triangles;
        }
        self.counting
    }

    /// Chooses a material of the palette.
    pub(super) fn material(&mut self, material: usize) {
        self.material = material;
    }

    /// Draws a grid whose corner in column `i` of row `j` is `point(i, j)`. Seen from its front,
    /// columns run to the right and rows upward. A closed direction has no last corner: the first
    /// one is used again, so `point` must return the same each time.
    pub(super) fn grid(&mut self, grid: Grid, mut point: impl FnMut(usize, usize) -> DVec3) {
        self.triangles += grid.triangles() as u64;
        if self.counting {
            return;
        }
        let columns = grid.across + usize::from(!grid.closed_across);
        for j in 0..=grid.rows {
            let row = if grid.closed_rows { j % grid.rows } else { j };
            self.row.clear();
            self.row.extend((0..columns).map(|i| point(i, row)));
            self.add_row(grid, j > 0);
        }
    }

    /// Adds a row of corners, and the quads between it and the previous one.
    fn add_row(&mut self, grid: Grid, quads: bool) {
        let buffer = &mut self.buffers[self.material];
        let above = buffer.vertices.len() as u32;
        buffer.vertices.extend_from_slice(&self.row);
        if !quads {
            return;
        }
        let columns = self.row.len();
        let below = above - columns as u32;
        for i in 0..grid.across {
            let next = (i + 1) % columns;
            let (i, next) = (i as u32, next as u32);
            let (a, b, c, d) = (below + i, below + next, above + next, above + i);
            buffer.triangles.extend([[a, b, c], [a, c, d]]);
        }
        self.end_row();
    }

    /// Passes on a full buffer, except the last row of corners, from which the next row starts.
    fn end_row(&mut self) {
        if self.buffers[self.material].triangles.len() >= CHUNK {
            self.flush(self.material);
            let kept = &mut self.buffers[self.material].vertices;
            kept.extend_from_slice(&self.row);
        }
    }

    /// Draws a triangle of `side`² triangles. Its corner at `i` steps toward its second and `j`
    /// toward its third corner is `point(i, j)`.
    pub(super) fn triangle(&mut self, side: usize, mut point: impl FnMut(usize, usize) -> DVec3) {
        self.triangles += (side * side) as u64;
        if self.counting {
            return;
        }
        self.row.clear();
        for j in 0..=side {
            let buffer = &mut self.buffers[self.material];
            let wide = side - j;
            let above = buffer.vertices.len() as u32;
            let below = above - self.row.len() as u32;
            self.row.clear();
            self.row.extend((0..=wide).map(|i| point(i, j)));
            buffer.vertices.extend_from_slice(&self.row);
            if j == 0 {
                continue;
            }
            let wide = wide as u32;
            let upright = (0..=wide).map(|i| [below + i, below + i + 1, above + i]);
            let inverted = (0..wide).map(|i| [below + i + 1, above + i + 1, above + i]);
            buffer.triangles.extend(upright.chain(inverted));
            self.end_row();
        }
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
        self.triangles += ring as u64;
        if self.counting {
            return;
        }
        let buffer = &mut self.buffers[self.material];
        let hub = buffer.vertices.len() as u32;
        buffer.vertices.push(center);
        buffer.vertices.extend((0..ring).map(point));
        let corner = |i: usize| hub + 1 + (i % ring) as u32;
        let fan = (0..ring).map(|i| [hub, corner(i), corner(i + 1)]);
        buffer.triangles.extend(fan);
        if buffer.triangles.len() >= CHUNK {
            self.flush(self.material);
        }
    }

    /// Draws triangles that each have a material of their own: `(material, corners)`, where corners
    /// index `vertices`.
    pub(super) fn facets(&mut self, vertices: &[DVec3], triangles: &[(usize, [u32; 3])]) {
        self.triangles += triangles.len() as u64;
        if self.counting {
            return;
        }
        let mut scatter = std::mem::take(&mut self.scatter);
        scatter.sorted.clear();
        scatter.sorted.extend(0..triangles.len() as u32);
        scatter.sorted.sort_by_key(|&t| triangles[t as usize].0);
        for run in scatter
            .sorted
            .chunk_by(|&a, &b| triangles[a as usize].0 == triangles[b as usize].0)
        {
            let material = triangles[run[0] as usize].0;
            let buffer = &mut self.buffers[material];
            scatter.slots.clear();
            scatter.slots.resize(vertices.len(), u32::MAX);
            for &t in run {
                let corners = triangles[t as usize].1.map(|v| {
                    let slot = &mut scatter.slots[v as usize];
                    if *slot == u32::MAX {
                        *slot = buffer.vertices.len() as u32;
                        buffer.vertices.push(vertices[v as usize]);
                    }
                    *slot
                });
                buffer.triangles.push(corners);
            }
            if buffer.triangles.len() >= CHUNK {
                self.flush(material);
            }
        }
        self.scatter = scatter;
    }

    fn flush(&mut self, material: usize) {
        let buffer = &mut self.buffers[material];
        if !buffer.triangles.is_empty() {
            self.builder
                .material(&MaterialDesc::Document(buffer.material));
            self.builder.mesh(&buffer.vertices, &buffer.triangles);
        }
        buffer.vertices.clear();
        buffer.triangles.clear();
    }

    /// Passes on the rest. Without this call, part of the scene is missing.
    pub(super) fn finish(mut self) {
        if self.counting {
            self.builder.takes_count(self.triangles);
        }
        for material in 0..self.buffers.len() {
            self.flush(material);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MemoryBuilder, ShapeCounter};
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
        let mut counter = ShapeCounter::default();
        let mut counting = MeshBuilder::new(&mut counter, []);
        draw(&mut counting);
        let palette = [DocumentMaterial::default(); 2];
        let mut builder = MemoryBuilder::default();
        let mut mesh = MeshBuilder::new(&mut builder, palette);
        draw(&mut mesh);
        assert_eq!(counting.triangles(), mesh.triangles());
        mesh.finish();
        let drawn = builder.finish().triangles.len() as u64;
        assert_eq!(drawn, counting.triangles());
    }
}
