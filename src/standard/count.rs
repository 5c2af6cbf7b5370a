//! Counts the shapes of a scene.

use super::builder::{MaterialDesc, SceneBuilder, StandardLight, StandardView};
use super::mesh_slice::{Prepare, PreparedMesh};
use glam::DVec3;

/// Numbers of the shapes and lights of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShapeCounts {
    /// Spheres.
    pub spheres: u64,
    /// Cones and cylinders.
    pub cones: u64,
    /// Polygons and patches of any number of corners, as the databases count them. Triangles of
    /// meshes are not included.
    pub polygons: u64,
    /// Triangles, including those of polygons and patches.
    pub triangles: u64,
    /// Lights.
    pub lights: u64,
}

/// A builder that counts.
#[derive(Clone, Debug, Default)]
pub struct ShapeCounter {
    counts: ShapeCounts,
}

impl ShapeCounter {
    /// The counts so far.
    pub fn counts(&self) -> ShapeCounts {
        self.counts
    }

    fn polygon_of(&mut self, corners: usize) {
        self.counts.polygons += 1;
        self.counts.triangles += corners.saturating_sub(2) as u64;
    }
}

impl SceneBuilder for ShapeCounter {
    fn view(&mut self, _: &StandardView) {}

    fn background(&mut self, _: DVec3) {}

    fn light(&mut self, _: &StandardLight) {
        self.counts.lights += 1;
    }

    fn material(&mut self, _: &MaterialDesc) {}

    fn sphere(&mut self, _: DVec3, _: f64) {
        self.counts.spheres += 1;
    }

    fn cone(&mut self, _: DVec3, _: f64, _: DVec3, _: f64) {
        self.counts.cones += 1;
    }

    fn polygon(&mut self, points: &[DVec3]) {
        self.polygon_of(points.len());
    }

    fn patch(&mut self, points: &[(DVec3, DVec3)]) {
        self.polygon_of(points.len());
    }

    fn takes_count(&mut self, triangles: u64) -> bool {
        self.counts.triangles += triangles;
        true
    }

    fn preparation(&self) -> Box<Prepare> {
        Box::new(|parts, _| PreparedMesh::sized(parts))
    }

    fn prepared(&mut self, mesh: PreparedMesh) {
        self.counts.triangles += mesh.triangles as u64;
    }
}
