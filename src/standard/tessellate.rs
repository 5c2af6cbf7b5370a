//! Spheres and cones as polygons, for files and tracers that only support those.

use super::builder::{MaterialDesc, SceneBuilder, StandardLight, StandardView};
use super::mesh_slice::{Prepare, PreparedMesh};
use glam::{DVec3, dvec3};
use std::f64::consts::{FRAC_PI_4, PI};

/// Largest fineness: a sphere of 12 million triangles.
const FINEST: u32 = 1000;

/// Passes everything on to another builder, with spheres and cones as patches with the normals of
/// the curved surface.
///
/// With fineness n a sphere is an inflated cube of six n × n grids at equal angles: 12 n²
/// triangles. A cone is 4n quadrilaterals. At n = 4 that gives the databases' published numbers of
/// polygons.
pub struct Tessellate<'a> {
    inner: &'a mut dyn SceneBuilder,
    /// Triangles on the unit sphere about the origin: each corner is its own normal.
    sphere: Vec<[DVec3; 3]>,
    sides: u32,
}

impl<'a> Tessellate<'a> {
    /// Tessellates with `fineness`, clamped to 1 to 1000, into `inner`.
    pub fn new(fineness: u32, inner: &'a mut dyn SceneBuilder) -> Self {
        let fineness = fineness.clamp(1, FINEST);
        Tessellate {
            inner,
            sphere: unit_sphere(fineness),
            sides: 4 * fineness,
        }
    }
}

/// The triangles of the unit sphere, counter-clockwise from outside.
fn unit_sphere(fineness: u32) -> Vec<[DVec3; 3]> {
    // A grid line is at the tangent of its angle. The outermost ones are exactly on the cube's
    // edges, and those left and right of the middle exactly opposite, so that neighbouring faces
    // agree on their common edge.
    let line = |k: u32| {
        let from_middle = f64::from(2 * k) - f64::from(fineness);
        match k {
            0 => -1.0,
            _ if k == fineness => 1.0,
            _ => libm::tan(FRAC_PI_4 * from_middle / f64::from(fineness)),
        }
    };
    let mut triangles = Vec::new();
    for face in 0..6 {
        for u in 0..fineness {
            for v in 0..fineness {
                let corners = [[u, v], [u + 1, v], [u + 1, v + 1], [u, v + 1]];
                let [a, b, c, d] =
                    corners.map(|[u, v]| on_cube(face, line(u), line(v)).normalize());
                triangles.extend([[a, b, c], [c, d, a]]);
            }
        }
    }
    triangles
}

/// A point of a face of the cube \[−1, 1\]³; (u, v) run counter-clockwise from outside.
fn on_cube(face: u32, u: f64, v: f64) -> DVec3 {
    match face {
        0 => dvec3(1.0, u, v),
        1 => dvec3(-1.0, v, u),
        2 => dvec3(v, 1.0, u),
        3 => dvec3(u, -1.0, v),
        4 => dvec3(u, v, 1.0),
        _ => dvec3(v, u, -1.0),
    }
}

/// Two unit vectors perpendicular to the unit vector `axis` and to each other. The first turns into
/// the second counter-clockwise about `axis`.
fn across(axis: DVec3) -> [DVec3; 2] {
    let other = if axis.x.abs() < 0.5 { DVec3::X } else { DVec3::Y };
    let first = axis.cross(other).normalize();
    [first, axis.cross(first)]
}

impl SceneBuilder for Tessellate<'_> {
    fn view(&mut self, view: &StandardView) {
        self.inner.view(view);
    }

    fn background(&mut self, rgb: DVec3) {
        self.inner.background(rgb);
    }

    fn light(&mut self, light: &StandardLight) {
        self.inner.light(light);
    }

    fn material(&mut self, material: &MaterialDesc) {
        self.inner.material(material);
    }

    fn sphere(&mut self, center: DVec3, radius: f64) {
        for triangle in &self.sphere {
            let corners = triangle.map(|normal| (center + normal * radius, normal));
            self.inner.patch(&corners);
        }
    }

    fn cone(&mut self, base: DVec3, base_radius: f64, apex: DVec3, apex_radius: f64) {
        let height = (apex - base).length();
        let axis = (apex - base) / height;
        let [first, second] = across(axis);
        // A corner at the base, one at the apex, and their common normal.
        let ruling = |side: u32| {
            let angle = 2.0 * PI * f64::from(side % self.sides) / f64::from(self.sides);
            let (sin, cos) = libm::sincos(angle);
            let out = first * cos + second * sin;
            let normal = (out * height + axis * (base_radius - apex_radius)).normalize();
            let low = (base + out * base_radius, normal);
            (low, (apex + out * apex_radius, normal))
        };
        for side in 0..self.sides {
            let ((a, d), (b, c)) = (ruling(side), ruling(side + 1));
            if apex_radius == 0.0 {
                self.inner.patch(&[a, b, d]);
            } else if base_radius == 0.0 {
                self.inner.patch(&[a, c, d]);
            } else {
                self.inner.patch(&[a, b, c, d]);
            }
        }
    }

    fn polygon(&mut self, points: &[DVec3]) {
        self.inner.polygon(points);
    }

    fn patch(&mut self, points: &[(DVec3, DVec3)]) {
        self.inner.patch(points);
    }

    fn takes_count(&mut self, triangles: u64) -> bool {
        self.inner.takes_count(triangles)
    }

    fn threads(&self) -> usize {
        self.inner.threads()
    }

    fn preparation(&self) -> Box<Prepare> {
        self.inner.preparation()
    }

    fn prepared(&mut self, mesh: PreparedMesh) {
        self.inner.prepared(mesh);
    }
}
