//! A section of a scene: what one thread draws at a time.

use glam::DVec3;

/// Triangles of one material in a section.
#[derive(Debug, Default)]
pub(super) struct Strip {
    pub(super) vertices: Vec<DVec3>,
    /// Number of vertices at the start that repeat the last ones of the section before, because a
    /// shape is continued.
    pub(super) shared: usize,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Rows of triangles that stay together: a mesh may end after each step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub(super) material: u32,
    /// Numbers of vertices and triangles in the material's strip at the end of the step.
    pub(super) vertices: u32,
    pub(super) triangles: u32,
    /// Number of vertices at the end from which the next step starts.
    pub(super) shared: u32,
}

/// Consecutive steps of a scene, and their triangles by material.
#[derive(Debug, Default)]
pub(super) struct SceneSection {
    pub(super) strips: Vec<Strip>,
    pub(super) steps: Vec<Step>,
}

impl SceneSection {
    /// The strip of a material.
    pub(super) fn strip(&mut self, material: usize) -> &mut Strip {
        if self.strips.len() <= material {
            self.strips.resize_with(material + 1, Strip::default);
        }
        &mut self.strips[material]
    }

    /// Ends a step of a material.
    pub(super) fn end_step(&mut self, material: usize, shared: usize) {
        let strip = &self.strips[material];
        self.steps.push(Step {
            material: material as u32,
            vertices: strip.vertices.len() as u32,
            triangles: strip.triangles.len() as u32,
            shared: shared as u32,
        });
    }
}
