//! Building parts: boxes, turned work and rods, cut into quads of a given density.

use super::mesh_builder::{Grid, MeshBuilder};
use glam::{DVec2, DVec3};
use libm::{cos, sin};
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
        LocalFrame {
            origin,
            axes: [DVec3::X, DVec3::Y, DVec3::Z],
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
            origin: self.point(DVec3::new(x, y, z)),
            ..self
        }
    }

    /// The position in the world of a point of this frame.
    pub(super) fn point(&self, p: DVec3) -> DVec3 {
        let [x, y, z] = self.axes;
        self.origin + x * p.x + y * p.y + z * p.z
    }
}

/// Number of quads along this length: at least one, and about `density` to a unit.
pub(super) fn cells(length: f64, density: f64) -> usize {
    (length * density).round().clamp(1.0, 1e6) as usize
}

/// Sides of a box: left, right, bottom, top, back, front (x, y, z, lower before upper).
pub(super) const ALL: [bool; 6] = [true; 6];

/// All sides but the lower one, on which it stands.
pub(super) const STANDING: [bool; 6] = [true, true, false, true, true, true];

/// Draws the chosen sides of a box between two opposite corners. Neighbouring sides share their
/// edges' points.
pub(super) fn cuboid(
    mesh: &mut MeshBuilder,
    frame: &LocalFrame,
    (lo, hi): (DVec3, DVec3),
    density: f64,
    sides: [bool; 6],
) {
    let size = hi - lo;
    let counts: [usize; 3] = std::array::from_fn(|k| cells(size[k], density));
    let place = |axis: usize, i: usize| match i == counts[axis] {
        true => hi[axis],
        false => lo[axis] + size[axis] * (i as f64 / counts[axis] as f64),
    };
    for (number, _) in sides.iter().enumerate().filter(|(_, drawn)| **drawn) {
        let (axis, upper) = (number / 2, number % 2 == 1);
        let (mut u, mut v) = ((axis + 1) % 3, (axis + 2) % 3);
        if !upper {
            (u, v) = (v, u);
        }
        mesh.grid(Grid::open(counts[u], counts[v]), |i, j| {
            let mut p = if upper { hi } else { lo };
            p[u] = place(u, i);
            p[v] = place(v, j);
            frame.point(p)
        });
    }
}

/// Draws a surface of revolution about the frame's y axis, from a profile of (radius, height) from
/// the bottom to the top. A radius of 0 closes an end with a fan; it may occur only at an end.
pub(super) fn lathe(
    mesh: &mut MeshBuilder,
    frame: &LocalFrame,
    profile: &[DVec2],
    around: usize,
    density: f64,
) {
    let ring = |radius: f64, height: f64, i: usize| {
        let turn = TAU * i as f64 / around as f64;
        frame.point(DVec3::new(radius * cos(turn), height, -radius * sin(turn)))
    };
    let closed = |p: &DVec2| p.x <= 0.0;
    for pair in profile.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let hub = |height: f64| frame.point(DVec3::new(0.0, height, 0.0));
        match (closed(&a), closed(&b)) {
            (true, _) => mesh.fan(hub(a.y), around, |i| ring(b.x, b.y, (around - i) % around)),
            (_, true) => mesh.fan(hub(b.y), around, |i| ring(a.x, a.y, i)),
            _ => {
                let rows = cells((b - a).length(), density);
                mesh.grid(Grid::tube(around, rows), |i, j| {
                    let p = if j == rows {
                        b
                    } else {
                        a + (b - a) * (j as f64 / rows as f64)
                    };
                    ring(p.x, p.y, i)
                });
            }
        }
    }
}

/// Draws a rod with this many sides between two points; its ends are open.
pub(super) fn rod(
    mesh: &mut MeshBuilder,
    (from, to): (DVec3, DVec3),
    radius: f64,
    around: usize,
    rows: usize,
) {
    let along = (to - from) / (to - from).length();
    let other = if along.x.abs() < 0.6 {
        DVec3::X
    } else {
        DVec3::Y
    };
    let side = along.cross(other);
    let side = side / side.length();
    let up = along.cross(side);
    mesh.grid(Grid::tube(around, rows), |i, j| {
        let turn = TAU * i as f64 / around as f64;
        let t = j as f64 / rows as f64;
        from + (to - from) * t + (side * cos(turn) + up * sin(turn)) * radius
    });
}

/// Draws a profile of (out, up) swept along the frame's x axis from `from` to `to`. Seen from the
/// end of the axis, the front is on the right of the profile's direction.
pub(super) fn moulding(
    mesh: &mut MeshBuilder,
    frame: &LocalFrame,
    (from, to): (f64, f64),
    profile: &[DVec2],
    density: f64,
) {
    let columns = cells(to - from, density);
    mesh.grid(Grid::open(columns, profile.len() - 1), |i, j| {
        let x = from + (to - from) * (i as f64 / columns as f64);
        frame.point(DVec3::new(x, profile[j].y, profile[j].x))
    });
}

#[cfg(test)]
mod tests {
    use super::super::super::builder::DocumentMaterial;
    use super::super::super::{MemoryBuilder, SceneBuilder};
    use super::super::geodesic;
    use super::*;

    /// Volume inside closed surfaces that face outward, by the divergence theorem.
    fn volume(draw: impl Fn(&mut MeshBuilder)) -> f64 {
        let mut builder = MemoryBuilder::default();
        let palette = [DocumentMaterial::default()];
        let mut mesh = MeshBuilder::new(&mut builder as &mut dyn SceneBuilder, &palette);
        draw(&mut mesh);
        mesh.finish();
        let triangles = builder.finish().triangles;
        let parts = (0..triangles.len()).map(|i| {
            let [a, b, c] = triangles.corners(i).map(|p| p.as_dvec3());
            a.dot(b.cross(c)) / 6.0
        });
        parts.sum()
    }

    #[test]
    fn solids_face_outward_and_are_closed() {
        let frame = LocalFrame::at(DVec3::new(3.0, -2.0, 5.0)).turned(33.0);
        let brick = volume(|mesh| {
            let corners = (DVec3::new(-1.0, 0.0, 0.5), DVec3::new(1.0, 3.0, 1.0));
            cuboid(mesh, &frame, corners, 2.3, ALL);
        });
        assert!((brick - 3.0).abs() < 1e-5, "{brick}");
        // A double cone of a square, which is what a lathe of four sides makes.
        let top = volume(|mesh| {
            let profile = [(0.0, -1.0), (1.0, 0.0), (0.0, 1.0)].map(DVec2::from);
            lathe(mesh, &frame, &profile, 4, 1.0);
        });
        assert!((top - 4.0 / 3.0).abs() < 1e-5, "{top}");
        let drum = volume(|mesh| {
            let profile = [(0.0, 0.0), (1.0, 0.0), (1.0, 2.0), (0.0, 2.0)].map(DVec2::from);
            lathe(mesh, &frame, &profile, 4, 3.0);
        });
        assert!((drum - 4.0).abs() < 1e-5, "{drum}");
        let ball = volume(|mesh| geodesic::sphere(mesh, 30, |p| frame.point(p * 2.0)));
        assert!((ball - TAU * 16.0 / 3.0).abs() < 0.1, "{ball}");
    }
}
