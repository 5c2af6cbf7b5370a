//! Building parts: boxes, turned work and rods, cut into quads of a given density.

use super::geodesic;
use super::mesh_builder::{Grid, MeshBuilder, count};
use glam::{DVec2, DVec3, dvec2, dvec3};
use libm::{cos, sin};
use phalanx_scene::map_on_pool;
use std::f64::consts::TAU;

/// An origin and its directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalFrame {
    pub(super) origin: DVec3,
    /// Unit vectors, right-handed.
    pub(super) axes: [DVec3; 3],
}

impl LocalFrame {
    /// The world's directions at this origin.
    pub(super) fn at(origin: DVec3) -> LocalFrame {
        LocalFrame::upright(origin, DVec3::X, DVec3::Z)
    }

    /// A frame with y up, from its other unit vectors.
    pub(super) fn upright(origin: DVec3, x: DVec3, z: DVec3) -> LocalFrame {
        LocalFrame {
            origin,
            axes: [x, DVec3::Y, z],
        }
    }

    /// The frame turned by this many degrees about y, which stays up.
    pub(super) fn turned(self, degrees: f64) -> LocalFrame {
        let (s, c) = (sin(degrees.to_radians()), cos(degrees.to_radians()));
        let [x, y, z] = self.axes;
        LocalFrame {
            axes: [x * c - z * s, y, x * s + z * c],
            ..self
        }
    }

    /// The same directions, at an origin given in this frame.
    pub(super) fn moved(self, x: f64, y: f64, z: f64) -> LocalFrame {
        LocalFrame {
            origin: self.point(dvec3(x, y, z)),
            ..self
        }
    }

    /// The position in the world of a point of this frame.
    pub(super) fn point(&self, p: DVec3) -> DVec3 {
        let [x, y, z] = self.axes;
        self.origin + x * p.x + y * p.y + z * p.z
    }
}

/// A point of a frame: x, y, z.
pub(super) type FramePoint = (f64, f64, f64);

/// Number of quads along this length: at least one, and about `density` per unit.
pub(super) fn cells(length: f64, density: f64) -> usize {
    (length * density).round().clamp(1.0, 1e6) as usize
}

/// Cosine and sine of the `i`-th of `count` equal parts of a turn.
pub(super) fn on_circle(i: usize, count: usize) -> DVec2 {
    let turn = TAU * i as f64 / count as f64;
    dvec2(cos(turn), sin(turn))
}

/// Axes of the columns and rows of a face across `axis`, so that it faces along the axis (`upper`)
/// or against it.
pub(super) fn face_axes(axis: usize, upper: bool) -> (usize, usize) {
    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
    if upper { (next, last) } else { (last, next) }
}

/// Sides of a box: left, right, bottom, top, back, front (x, y, z, lower before upper).
pub(super) type BoxSides = [bool; 6];

pub(super) const ALL: BoxSides = [true; 6];

/// All sides but the bottom, on which it stands.
pub(super) const STANDING: BoxSides = [true, true, false, true, true, true];

/// All sides but the back, where it meets a wall.
pub(super) const ON_WALL: BoxSides = [true, true, true, true, false, true];

/// The detail between `least` and `most` at which all of `parts` come closest to `target` triangles
/// from below, or nearly so. `draw` draws one of them, with more triangles for more detail; the
/// threads of a pool count several at a time.
pub(super) fn fitted_detail(
    target: u64,
    (mut least, mut most): (f64, f64),
    parts: usize,
    draw: impl Fn(&mut PartBuilder, usize) + Sync,
) -> f64 {
    let count_all = |detail: f64| -> u64 {
        let of_part = |part| count(|mesh| draw(&mut PartBuilder::new(mesh, detail), part));
        map_on_pool(0..parts, of_part).into_iter().sum()
    };
    for _ in 0..40 {
        let middle = (least + most) / 2.0;
        if count_all(middle) <= target {
            least = middle;
        } else {
            most = middle;
        }
    }
    least
}

/// Draws parts in a frame, cut into about `detail` quads per unit of length.
pub(super) struct PartBuilder<'m, 'b> {
    pub(super) mesh: &'m mut MeshBuilder<'b>,
    pub(super) frame: LocalFrame,
    pub(super) detail: f64,
}

impl<'m, 'b> PartBuilder<'m, 'b> {
    /// A builder in the world's frame.
    pub(super) fn new(mesh: &'m mut MeshBuilder<'b>, detail: f64) -> PartBuilder<'m, 'b> {
        PartBuilder {
            mesh,
            frame: LocalFrame::at(DVec3::ZERO),
            detail,
        }
    }

    /// The same mesh and detail, in another frame.
    pub(super) fn at(&mut self, frame: LocalFrame) -> PartBuilder<'_, 'b> {
        PartBuilder {
            mesh: self.mesh,
            frame,
            detail: self.detail,
        }
    }

    /// The same mesh and detail, at an origin given in this frame.
    pub(super) fn moved(&mut self, x: f64, y: f64, z: f64) -> PartBuilder<'_, 'b> {
        self.at(self.frame.moved(x, y, z))
    }

    /// The same mesh and frame, in another detail.
    pub(super) fn with_detail(&mut self, detail: f64) -> PartBuilder<'_, 'b> {
        PartBuilder {
            detail,
            ..self.at(self.frame)
        }
    }

    /// Chooses a material of the palette.
    pub(super) fn material(&mut self, material: usize) {
        self.mesh.material(material);
    }

    /// Number of quads along this length.
    pub(super) fn cells(&self, length: f64) -> usize {
        cells(length, self.detail)
    }

    /// Draws a quad of these corners in the frame, cut into `across` by `rows`.
    pub(super) fn quad(&mut self, corners: [FramePoint; 4], (across, rows): (usize, usize)) {
        let corners = corners.map(|corner| self.frame.point(corner.into()));
        self.mesh.quad(corners, across, rows);
    }

    /// Draws a quad of these corners in the frame, cut as its first and last side demand.
    pub(super) fn wall(&mut self, corners: [FramePoint; 4]) {
        let [a, b, _, d] = corners.map(|corner| self.frame.point(corner.into()));
        let (across, rows) = ((b - a).length(), (d - a).length());
        self.quad(corners, (self.cells(across), self.cells(rows)));
    }

    /// Draws a floor of `count` by `count` tiles in two alternating materials, from -`half` to
    /// `half` in x and z.
    pub(super) fn tiles(&mut self, materials: [usize; 2], half: f64, count: u32) {
        let step = 2.0 * half / f64::from(count);
        let n = self.cells(step);
        for row in 0..count {
            for column in 0..count {
                self.material(materials[((row + column) % 2) as usize]);
                let (x, z) = (
                    f64::from(column) * step - half,
                    half - f64::from(row) * step,
                );
                let tile = [(x, z), (x + step, z), (x + step, z - step), (x, z - step)];
                self.quad(tile.map(|(x, z)| (x, 0.0, z)), (n, n));
            }
        }
    }

    /// Draws all sides of a box between two opposite corners.
    pub(super) fn slab(&mut self, lo: FramePoint, hi: FramePoint) {
        self.cuboid(lo, hi, ALL);
    }

    /// Draws the chosen sides of a box between two opposite corners. Neighbouring sides share their
    /// edges' points.
    pub(super) fn cuboid(&mut self, lo: FramePoint, hi: FramePoint, sides: BoxSides) {
        let (lo, hi) = (DVec3::from(lo), DVec3::from(hi));
        let (frame, size) = (self.frame, hi - lo);
        let counts: [usize; 3] = std::array::from_fn(|k| self.cells(size[k]));
        let coordinate = |axis: usize, i: usize| {
            if i == counts[axis] {
                hi[axis]
            } else {
                lo[axis] + size[axis] * (i as f64 / counts[axis] as f64)
            }
        };
        for (number, _) in sides.iter().enumerate().filter(|(_, drawn)| **drawn) {
            let (axis, upper) = (number / 2, number % 2 == 1);
            let (u, v) = face_axes(axis, upper);
            self.mesh.grid(Grid::open(counts[u], counts[v]), |i, j| {
                let mut p = if upper { hi } else { lo };
                p[u] = coordinate(u, i);
                p[v] = coordinate(v, j);
                frame.point(p)
            });
        }
    }

    /// Draws a surface of revolution about the frame's y axis, from a profile of (radius, height)
    /// from the bottom to the top. A radius of 0 closes an end with a fan; it may occur only at an
    /// end.
    pub(super) fn lathe(&mut self, profile: &[(f64, f64)], around: usize) {
        let frame = self.frame;
        let ring = |radius: f64, height: f64, i: usize| {
            let on = on_circle(i, around) * radius;
            frame.point(dvec3(on.x, height, -on.y))
        };
        let closed = |p: DVec2| p.x <= 0.0;
        for pair in profile.windows(2) {
            let (a, b) = (DVec2::from(pair[0]), DVec2::from(pair[1]));
            let hub = |height: f64| frame.point(dvec3(0.0, height, 0.0));
            match (closed(a), closed(b)) {
                (true, _) => self
                    .mesh
                    .fan(hub(a.y), around, |i| ring(b.x, b.y, (around - i) % around)),
                (_, true) => self.mesh.fan(hub(b.y), around, |i| ring(a.x, a.y, i)),
                _ => {
                    let rows = self.cells((b - a).length());
                    self.mesh.grid(Grid::tube(around, rows), |i, j| {
                        let p = if j == rows { b } else { a + (b - a) * (j as f64 / rows as f64) };
                        ring(p.x, p.y, i)
                    });
                }
            }
        }
    }

    /// Draws a profile of (out, up) swept along the frame's x axis from `from` to `to`. Seen from
    /// the end of the axis, the front is on the right of the profile's direction.
    pub(super) fn moulding(&mut self, (from, to): (f64, f64), profile: &[(f64, f64)]) {
        let (frame, columns) = (self.frame, self.cells(to - from));
        self.mesh
            .grid(Grid::open(columns, profile.len() - 1), |i, j| {
                let x = from + (to - from) * (i as f64 / columns as f64);
                let (out, up) = profile[j];
                frame.point(dvec3(x, up, out))
            });
    }

    /// Draws a rod with this many sides and rows of quads between two points; its ends are open.
    pub(super) fn rod(
        &mut self,
        ends: [FramePoint; 2],
        radius: f64,
        (around, rows): (usize, usize),
    ) {
        let [from, to] = ends.map(|end| self.frame.point(end.into()));
        let along = (to - from) / (to - from).length();
        let other = if along.x.abs() < 0.6 { DVec3::X } else { DVec3::Y };
        let side = along.cross(other);
        let side = side / side.length();
        let up = along.cross(side);
        self.mesh.grid(Grid::tube(around, rows), |i, j| {
            let on = on_circle(i, around);
            let t = j as f64 / rows as f64;
            from + (to - from) * t + (side * on.x + up * on.y) * radius
        });
    }

    /// Draws a sphere about a point of the frame, its icosahedron's edges cut into `frequency`.
    pub(super) fn sphere(&mut self, center: FramePoint, radius: f64, frequency: usize) {
        let center = self.frame.point(center.into());
        geodesic::sphere(self.mesh, frequency, |p| center + p * radius);
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::modern::assembly;
    use crate::{DocumentMaterial, MemoryBuilder};

    /// Volume inside closed surfaces that face outward, by the divergence theorem.
    pub(in crate::modern) fn volume(detail: f64, draw: impl Fn(&mut PartBuilder) + Sync) -> f64 {
        let mut builder = MemoryBuilder::default();
        let frame = LocalFrame::at(dvec3(3.0, -2.0, 5.0)).turned(33.0);
        assembly::draw(&mut builder, [DocumentMaterial::default()], &|mesh| {
            draw(&mut PartBuilder::new(mesh, detail).at(frame));
        });
        let triangles = builder.finish().triangles;
        let parts = (0..triangles.len()).map(|i| {
            let [a, b, c] = triangles.corners(i).map(|p| p.as_dvec3());
            a.dot(b.cross(c)) / 6.0
        });
        parts.sum()
    }

    #[test]
    fn detail_is_found_from_below() {
        let draw = |parts: &mut PartBuilder, k: usize| {
            let cells = (parts.detail + k as f64 / 100.0) as usize;
            let grid = Grid::open(cells, cells);
            parts.mesh.grid(grid, |_, _| unreachable!());
        };
        let detail = fitted_detail(1_000_000, (1.0, 1000.0), 100, draw);
        let triangles = count(|mesh| {
            let mut parts = PartBuilder::new(mesh, detail);
            (0..100).for_each(|k| draw(&mut parts, k));
        });
        assert!((980_000..=1_000_000).contains(&triangles));
    }

    #[test]
    fn solids_face_outward_and_are_closed() {
        let brick = volume(2.3, |parts| parts.slab((-1.0, 0.0, 0.5), (1.0, 3.0, 1.0)));
        assert!((brick - 3.0).abs() < 1e-5, "{brick}");
        // A double cone over a square, as a lathe of four sides.
        let cones = [(0.0, -1.0), (1.0, 0.0), (0.0, 1.0)];
        let top = volume(1.0, |parts| parts.lathe(&cones, 4));
        assert!((top - 4.0 / 3.0).abs() < 1e-5, "{top}");
        let prism = [(0.0, 0.0), (1.0, 0.0), (1.0, 2.0), (0.0, 2.0)];
        let drum = volume(3.0, |parts| parts.lathe(&prism, 4));
        assert!((drum - 4.0).abs() < 1e-5, "{drum}");
        let ball = volume(1.0, |parts| parts.sphere((0.0, 0.0, 0.0), 2.0, 30));
        assert!((ball - TAU * 16.0 / 3.0).abs() < 0.1, "{ball}");
    }
}
