//! Vertices and primitives.

use super::commands::Statement;
use super::reader::{NormalVertex, TestReader};
use super::transform::{inverse, rounded, similarity};
use crate::diagnostics::Span;
use glam::{Affine3A, DAffine3, DMat3, DVec3, Vec3};
use phalanx_scene::Prim;

impl TestReader<'_> {
    pub(super) fn vertex(&mut self, statement: &Statement<'_>) {
        // A faulty vertex still gets its number, so that indices of later vertices stay correct.
        let position = self.coordinates(statement).map(DVec3::from_array);
        if let Some(promised) = self.vertices.push(position.unwrap_or_default()) {
            self.too_many(statement.span(), "maxverts", promised);
        }
    }

    pub(super) fn vertexnormal(&mut self, statement: &Statement<'_>) {
        let mut vertex = NormalVertex::STAND_IN;
        if let Some([x, y, z, nx, ny, nz]) = self.coordinates(statement) {
            vertex.position = DVec3::new(x, y, z);
            match DVec3::new(nx, ny, nz).as_vec3() {
                Vec3::ZERO => self.refuse(statement, 3, "a normal must not be zero"),
                normal => vertex.normal = normal,
            }
        }
        if let Some(promised) = self.normal_vertices.push(vertex) {
            self.too_many(statement.span(), "maxvertnorms", promised);
        }
    }

    fn too_many(&mut self, span: Span, hint: &str, promised: u64) {
        self.report.error_with_help(
            span,
            format!("more vertices than `{hint} {promised}` announced"),
            format!("raise the count, or leave `{hint}` out: it is only a hint"),
        );
    }

    pub(super) fn tri(&mut self, statement: &Statement<'_>) {
        let Some(corners) = self.corners(statement, |reader| &reader.vertices.items) else {
            return;
        };
        if let Some(corners) = self.world_corners(statement, corners)
            && self.has_room(statement)
        {
            let material = self.material();
            self.scene.add_triangle(corners, None, material);
        }
    }

    pub(super) fn trinormal(&mut self, statement: &Statement<'_>) {
        let Some(corners) = self.corners(statement, |reader| &reader.normal_vertices.items) else {
            return;
        };
        let positions = corners.map(|corner| corner.position);
        let Some(positions) = self.world_corners(statement, positions) else {
            return;
        };
        let normals = corners.map(|corner| corner.normal.as_dvec3());
        let Some(normals) = world_normals(self.transforms.current().matrix3, normals) else {
            return self.flattened(statement, "triangle's normals");
        };
        if self.has_room(statement) {
            let material = self.material();
            self.scene.add_triangle(positions, Some(normals), material);
        }
    }

    /// The three vertices of `pile` that a statement names.
    fn corners<T: Copy>(
        &mut self,
        statement: &Statement<'_>,
        pile: for<'r> fn(&'r Self) -> &'r [T],
    ) -> Option<[T; 3]> {
        let indices: [u64; 3] = self.counts(statement)?;
        let vertices = pile(self);
        let count = vertices.len();
        let corner = |index: u64| vertices.get(usize::try_from(index).ok()?).copied();
        if let [Some(a), Some(b), Some(c)] = indices.map(corner) {
            return Some([a, b, c]);
        }
        for (k, &index) in indices.iter().enumerate() {
            if index >= count as u64 {
                self.no_such_vertex(statement.operand_place(k), index, count);
            }
        }
        None
    }

    fn no_such_vertex(&mut self, span: Span, index: u64, count: usize) {
        let so_far = match count {
            0 => String::from("none exists so far"),
            1 => String::from("only 1 exists so far"),
            _ => format!("only {count} exist so far"),
        };
        self.report.error_with_help(
            span,
            format!("there is no vertex {index}: {so_far}"),
            "`tri` counts `vertex` lines from 0, `trinormal` counts `vertexnormal` lines from 0",
        );
    }

    fn world_corners(
        &mut self,
        statement: &Statement<'_>,
        corners: [DVec3; 3],
    ) -> Option<[Vec3; 3]> {
        let corners = corners.map(|p| rounded(self.to_scene(p)));
        let [Some(a), Some(b), Some(c)] = corners else {
            self.out_of_range(statement);
            return None;
        };
        Some([a, b, c])
    }

    /// Position in the scene, not rounded yet, of a position under the current transform.
    pub(super) fn to_scene(&self, position: DVec3) -> DVec3 {
        self.transforms.current().transform_point3(position) - self.origin
    }

    pub(super) fn sphere(&mut self, statement: &Statement<'_>) {
        let Some([x, y, z, radius]) = self.coordinates(statement) else {
            return;
        };
        if radius <= 0.0 {
            return self.refuse(statement, 3, "the radius of a sphere must be positive");
        }
        let center = DVec3::new(x, y, z);
        let Some(world_center) = self.in_range(statement, self.to_scene(center)) else {
            return;
        };
        match similarity(self.transforms.current().matrix3) {
            Some(factor) => self.round_sphere(statement, world_center, radius * factor),
            None => self.ellipsoid(statement, center, radius),
        }
    }

    fn round_sphere(&mut self, statement: &Statement<'_>, center: Vec3, radius: f64) {
        let radius = radius as f32;
        if radius == 0.0 {
            return self.report.error(
                statement.span(),
                "the current transform shrinks this sphere to nothing",
            );
        }
        if !radius.is_finite() {
            return self.out_of_range(statement);
        }
        if self.has_room(statement) {
            let material = self.material();
            self.scene.add_sphere(center, radius, material);
        }
    }

    fn ellipsoid(&mut self, statement: &Statement<'_>, center: DVec3, radius: f64) {
        let current = self.transforms.current();
        let to_world = DAffine3 {
            matrix3: current.matrix3 * radius,
            translation: self.to_scene(center),
        };
        let Some(back) = inverse(to_world.matrix3) else {
            return self.flattened(statement, "sphere");
        };
        let to_object = DAffine3 {
            matrix3: back,
            translation: -(back * to_world.translation),
        };
        let (Some(to_world), Some(to_object)) = (affine(to_world), affine(to_object)) else {
            return self.out_of_range(statement);
        };
        if self.has_room(statement) {
            let material = self.material();
            self.scene.add_ellipsoid(to_world, to_object, material);
        }
    }

    fn flattened(&mut self, statement: &Statement<'_>, what: &str) {
        self.report.error_with_help(
            statement.span(),
            format!("the current transform flattens this {what} beyond single precision"),
            "its scales along different axes lie too far apart",
        );
    }

    /// Returns true if one more primitive can be numbered.
    fn has_room(&mut self, statement: &Statement<'_>) -> bool {
        let room = self.scene.prims.len() < Prim::MAX_INDEX as usize;
        if !room {
            self.report
                .error(statement.span(), "more primitives than can be numbered");
        }
        room
    }

    /// The material that a primitive captures here.
    fn material(&mut self) -> u32 {
        self.table.intern(&self.surface, &mut self.scene.materials)
    }
}

/// Normals under the inverse transpose of a matrix, as unit vectors. A file or a transform may give
/// them any length; as unit vectors they can be squared in f32 later. A zero normal was reported
/// where it was declared.
fn world_normals(m: DMat3, normals: [DVec3; 3]) -> Option<[Vec3; 3]> {
    let back = inverse(m)?.transpose();
    let [a, b, c] = normals.map(|n| Some((back * n).try_normalize()?.as_vec3()));
    Some([a?, b?, c?])
}

fn affine(map: DAffine3) -> Option<Affine3A> {
    let map = map.as_affine3a();
    map.is_finite().then_some(map)
}
