//! Triangles over shared vertices.

use super::columns::{ColumnInfo, PrimColumns, RowScale, column_infos, column_list};
use super::row_check::{NO_INDEX, RowCheck};
use crate::bounds::Bounds;
use crate::column::{AnyColumn, Attribute, Column};
use crate::vectors::{Vec2s, Vec3s};
use glam::{DVec3, Vec2, Vec3};

/// Cosine of the angle between the mean of a triangle's vertex normals and its geometric normal
/// below which the winding counts as reversed. If the file's normals lie in the plane of the
/// triangle, the sign of the cosine is only rounding, and the winding counts.
pub const INWARD: f32 = -1e-3;

/// Triangles by the indices of their vertices.
///
/// Normals, texture coordinates and colours have index columns of their own, as in OBJ. A column
/// that no triangle uses is empty.
#[derive(Clone, Debug, Default)]
pub struct Triangles {
    /// Vertex positions, shared by the triangles around them.
    pub vertices: Vec3s,
    /// The three vertices of each triangle, counter-clockwise, as indices into `vertices`.
    pub corners: Column<[u32; 3]>,
    /// Indices of the vertices' normals in `vertex_normals`, or three times [`NO_INDEX`]; empty
    /// if no triangle has any.
    pub normals: Column<[u32; 3]>,
    /// Vertex normals, of any length but zero.
    pub vertex_normals: Vec3s,
    /// Indices of the vertices' texture coordinates in `vertex_uvs`, or three times [`NO_INDEX`];
    /// empty if no triangle has any. Coordinates of further layers follow those of the first: see
    /// [`TextureMap::uv_layer`](crate::TextureMap::uv_layer).
    pub uvs: Column<[u32; 3]>,
    /// Texture coordinates: (0, 0) is a texture's upper left corner, (1, 1) its lower right one.
    pub vertex_uvs: Vec2s,
    /// Indices of the vertices' tangents in `vertex_tangents`, or three times [`NO_INDEX`];
    /// empty if no triangle has any. Only normal maps need them.
    pub tangents: Column<[u32; 3]>,
    /// Directions in which u grows, of any length.
    pub vertex_tangents: Vec3s,
    /// Factor, 1 or −1, that turns normal × tangent toward the upper edge of the picture, one for
    /// each tangent (Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008).
    pub bitangent_signs: Column<f32>,
    /// Indices of the vertices' colours in `vertex_colors`, or three times [`NO_INDEX`]; empty if
    /// no triangle has any.
    pub colors: Column<[u32; 3]>,
    /// Vertex colours, linear, at least 0; they multiply Ka and Kd.
    pub vertex_colors: Vec3s,
    /// Opacity of the vertices, 0 to 1, one for each colour; multiplies the material's.
    pub vertex_opacity: Column<f32>,
    /// Indices of the materials.
    pub material: Column<u32>,
}

/// A mesh to be added as a whole. The columns are as in [`Triangles`], with indices into the mesh's
/// own vertices.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Vertex positions.
    pub vertices: Vec3s,
    /// Vertices of each triangle.
    pub corners: Column<[u32; 3]>,
    /// Indices of the normals: empty, or one row for each triangle.
    pub normals: Column<[u32; 3]>,
    /// Vertex normals.
    pub vertex_normals: Vec3s,
    /// Indices of the texture coordinates: empty, or one row for each triangle.
    pub uvs: Column<[u32; 3]>,
    /// Texture coordinates.
    pub vertex_uvs: Vec2s,
    /// Indices of the tangents: empty, or one row for each triangle.
    pub tangents: Column<[u32; 3]>,
    /// Tangents.
    pub vertex_tangents: Vec3s,
    /// Signs of the bitangents, one for each tangent.
    pub bitangent_signs: Column<f32>,
    /// Indices of the colours: empty, or one row for each triangle.
    pub colors: Column<[u32; 3]>,
    /// Vertex colours, linear, at least 0.
    pub vertex_colors: Vec3s,
    /// Opacity of the vertices, one for each colour, or empty if all are 1.
    pub vertex_opacity: Column<f32>,
    /// Materials: one for all triangles, or one row for each.
    pub material: MeshMaterial,
}

/// Materials of a [`Mesh`].
#[derive(Clone, Debug)]
pub enum MeshMaterial {
    /// One material for all triangles.
    One(u32),
    /// One row for each triangle.
    Each(Column<u32>),
}

impl Default for MeshMaterial {
    fn default() -> Self {
        MeshMaterial::One(0)
    }
}

impl Triangles {
    /// Number of triangles.
    #[inline]
    pub fn len(&self) -> usize {
        self.material.len()
    }

    /// Returns true if there are no triangles.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.material.is_empty()
    }

    pub(crate) fn push(&mut self, corners: [Vec3; 3], normals: Option<[Vec3; 3]>, material: u32) {
        let first = self.vertices.len() as u32;
        corners
            .into_iter()
            .for_each(|corner| self.vertices.push(corner));
        let first_normal = self.vertex_normals.len() as u32;
        normals
            .into_iter()
            .flatten()
            .for_each(|n| self.vertex_normals.push(n));
        let three = |first: u32| [first, first + 1, first + 2];
        let before = self.len();
        let rows = match normals {
            Some(_) => Column::from(vec![three(first_normal)]),
            None => Column::new(),
        };
        append_optional(&mut self.normals, rows, before, 1);
        append_optional(&mut self.uvs, Column::new(), before, 1);
        append_optional(&mut self.tangents, Column::new(), before, 1);
        append_optional(&mut self.colors, Column::new(), before, 1);
        self.corners.push(three(first));
        self.material.push(material);
    }

    /// Appends a mesh; if the columns are empty, the mesh's own are moved.
    pub(crate) fn append(&mut self, mesh: Mesh) {
        let (before, more) = (self.len(), mesh.corners.len());
        let shifted = |mut rows: Column<[u32; 3]>, offset: usize| {
            if offset > 0 {
                let given = rows.iter_mut().filter(|row| row[0] != NO_INDEX);
                given.for_each(|row| *row = row.map(|index| index + offset as u32));
            }
            rows
        };
        let corners = shifted(mesh.corners, self.vertices.len());
        let append_rows = |column: &mut _, rows, vertices: usize| {
            append_optional(column, shifted(rows, vertices), before, more);
        };
        append_rows(&mut self.normals, mesh.normals, self.vertex_normals.len());
        append_rows(&mut self.uvs, mesh.uvs, self.vertex_uvs.len());
        let tangents = self.vertex_tangents.len();
        append_rows(&mut self.tangents, mesh.tangents, tangents);
        append_rows(&mut self.colors, mesh.colors, self.vertex_colors.len());
        if mesh.vertex_opacity.is_empty() {
            let opaque = std::iter::repeat_n(1.0, mesh.vertex_colors.len());
            self.vertex_opacity.extend(opaque);
        } else {
            self.vertex_opacity.append(mesh.vertex_opacity)
        }
        self.vertex_colors.append(mesh.vertex_colors);
        self.corners.append(corners);
        self.vertices.append(mesh.vertices);
        self.vertex_normals.append(mesh.vertex_normals);
        self.vertex_uvs.append(mesh.vertex_uvs);
        self.vertex_tangents.append(mesh.vertex_tangents);
        self.bitangent_signs.append(mesh.bitangent_signs);
        match mesh.material {
            MeshMaterial::One(row) => self.material.extend(std::iter::repeat_n(row, more)),
            MeshMaterial::Each(rows) => self.material.append(rows),
        }
    }

    /// Replaces rows by bare triangles of material 0, and the vertices from `first_vertex` on by
    /// theirs.
    pub(crate) fn replace(
        &mut self,
        first: usize,
        first_vertex: u32,
        vertices: &[[f32; 3]],
        corners: &[[u32; 3]],
    ) {
        let rows = first..first + corners.len();
        for (row, corners) in self.corners[rows.clone()].iter_mut().zip(corners) {
            *row = corners.map(|corner| first_vertex + corner);
        }
        for column in [
            &mut self.normals,
            &mut self.uvs,
            &mut self.tangents,
            &mut self.colors,
        ] {
            if !column.is_empty() {
                column[rows.clone()].fill([NO_INDEX; 3]);
            }
        }
        self.material[rows].fill(0);
        self.set_vertices(first_vertex as usize, vertices);
    }

    /// Moves the vertices from this one on.
    pub(crate) fn set_vertices(&mut self, first: usize, vertices: &[[f32; 3]]) {
        let columns = self.vertices.parts_mut();
        for (axis, column) in columns.into_iter().enumerate() {
            let column = &mut column[first..first + vertices.len()];
            for (c, vertex) in column.iter_mut().zip(vertices) {
                *c = vertex[axis];
            }
        }
    }

    /// The three vertices of a triangle. Written out, because a closure in an array's map becomes a
    /// call, and most passes over a mesh use this.
    #[inline]
    pub fn corners(&self, i: usize) -> [Vec3; 3] {
        let [a, b, c] = self.corners[i];
        [
            self.vertices.get(a as usize),
            self.vertices.get(b as usize),
            self.vertices.get(c as usize),
        ]
    }

    /// A function of the index of a triangle to its bounds, for loops over many: a column is
    /// resolved once.
    pub(crate) fn boxes(&self) -> impl Fn(usize) -> Bounds {
        let [x, y, z] = self.vertices.parts().map(|part| &part[..]);
        let corners = &self.corners[..];
        move |i| {
            let vertex = |k: u32| Vec3::new(x[k as usize], y[k as usize], z[k as usize]);
            let [a, b, c] = corners[i].map(vertex);
            Bounds::new(a.min(b).min(c), a.max(b).max(c))
        }
    }

    /// Marks the vertices of marked triangles; nothing if no triangles are marked.
    pub(crate) fn marked_vertices(&self, marks: &[bool]) -> Vec<bool> {
        if marks.is_empty() {
            return Vec::new();
        }
        let mut vertices = vec![false; self.vertices.len()];
        let corners = self.corners.iter().zip(marks);
        for (corners, _) in corners.filter(|(_, marked)| **marked) {
            corners.iter().for_each(|&v| vertices[v as usize] = true);
        }
        vertices
    }

    /// Distance to the plane of a triangle, and its normal; `t` where the ray lies in the plane.
    pub fn refine_on_plane(
        [a, b, c]: [DVec3; 3],
        origin: DVec3,
        direction: DVec3,
        t: f64,
    ) -> (f64, DVec3) {
        let normal = (b - a).cross(c - a);
        let met = normal.dot(a - origin) / normal.dot(direction);
        (if met.is_finite() { met } else { t }, normal)
    }

    /// Rows of the triangle's normals, if it has any.
    #[inline]
    pub fn normal_rows(&self, i: usize) -> Option<[u32; 3]> {
        self.normals.get(i).copied().filter(|r| r[0] != NO_INDEX)
    }

    /// The three vertex normals, if the triangle has them.
    #[inline]
    pub fn corner_normals(&self, i: usize) -> Option<[Vec3; 3]> {
        let rows = self.normal_rows(i)?;
        Some(rows.map(|row| self.vertex_normals.get(row as usize)))
    }

    /// The texture coordinates of the vertices in a layer, if the triangle has them.
    #[inline]
    pub fn corner_uvs(&self, i: usize, layer: u32) -> Option<[Vec2; 3]> {
        let rows = self.uvs.get(i).filter(|r| r[0] != NO_INDEX)?;
        let rows = rows.map(|row| row as usize + layer as usize);
        let count = self.vertex_uvs.len();
        (rows.iter().all(|&row| row < count)).then(|| rows.map(|row| self.vertex_uvs.get(row)))
    }

    /// The tangents of the vertices and the sign of the first one's bitangent, if the triangle has
    /// them.
    #[inline]
    pub fn corner_tangents(&self, i: usize) -> Option<([Vec3; 3], f32)> {
        let rows = self.tangents.get(i).filter(|r| r[0] != NO_INDEX)?;
        let sign = self.bitangent_signs[rows[0] as usize];
        Some((rows.map(|row| self.vertex_tangents.get(row as usize)), sign))
    }

    /// Rows of the triangle's colours, if it has any.
    #[inline]
    pub fn color_rows(&self, i: usize) -> Option<[u32; 3]> {
        self.colors.get(i).copied().filter(|r| r[0] != NO_INDEX)
    }

    /// The three vertex colours, if the triangle has them.
    #[inline]
    pub fn corner_colors(&self, i: usize) -> Option<[Vec3; 3]> {
        let rows = self.color_rows(i)?;
        Some(rows.map(|row| self.vertex_colors.get(row as usize)))
    }
}

impl PrimColumns for Triangles {
    fn material(&self) -> &Column<u32> {
        &self.material
    }

    column_list! {
        fn columns(triangles, materials), columns_mut;
        "vertex", triangles.vertices.len() => {
            vertices: ["vertices", "place"], RowCheck::Finite;
        }
        "triangle", triangles.len() => {
            corners: ["triangle corners", "corners"], RowCheck::Below(triangles.vertices.len());
            normals: ["triangle normals", "normals"],
                RowCheck::CornersOrNone(triangles.vertex_normals.len());
        }
        "vertex normal", triangles.vertex_normals.len() => {
            vertex_normals: ["vertex normals", "direction"], RowCheck::Finite;
        }
        "triangle", triangles.len() => {
            uvs: ["triangle texture places", "texture places"],
                RowCheck::CornersOrNone(triangles.vertex_uvs.len());
        }
        "vertex", triangles.vertex_uvs.len() => {
            vertex_uvs: ["texture places", "texture place"], RowCheck::Finite;
        }
        "triangle", triangles.len() => {
            tangents: ["triangle tangents", "tangents"],
                RowCheck::CornersOrNone(triangles.vertex_tangents.len());
        }
        "vertex tangent", triangles.vertex_tangents.len() => {
            vertex_tangents: ["vertex tangents", "direction"], RowCheck::Finite;
            bitangent_signs: ["vertex tangents", "sign"], RowCheck::Finite;
        }
        "triangle", triangles.len() => {
            colors: ["triangle colours", "colors"],
                RowCheck::CornersOrNone(triangles.vertex_colors.len());
        }
        "vertex", triangles.vertex_colors.len() => {
            vertex_colors: ["vertex colours", "color"], RowCheck::Color;
            vertex_opacity: ["vertex opacity", "opacity"], RowCheck::UnitInterval;
        }
        "triangle", triangles.len() => {
            material: ["triangle materials", "material"], RowCheck::Below(materials);
        }
    }

    #[inline]
    fn bounds(&self, i: usize) -> Bounds {
        let [a, b, c] = self.corners(i);
        Bounds::new(a.min(b).min(c), a.max(b).max(c))
    }

    fn largest_coordinate(&self, i: usize) -> f64 {
        let [a, b, c] = self.corners(i);
        f64::from(a.abs().max(b.abs()).max(c.abs()).max_element())
    }

    fn largest_of_all(&self) -> f64 {
        f64::from(self.vertices.largest_magnitude())
    }

    fn rescale(&mut self, scale: &RowScale) {
        let of_vertices = RowScale {
            factors: scale.factors,
            in_meshes: self.marked_vertices(&scale.in_meshes),
        };
        of_vertices.apply_to_vectors(&mut self.vertices);
    }

    fn enclosing_spheres(&self, i: usize, add: &mut dyn FnMut(Vec3, f32)) {
        let corners = self.corners(i).into_iter();
        corners.for_each(|corner| add(corner, 0.0));
    }

    fn shape_numbers(&self, i: usize, take: &mut dyn FnMut(&[f32])) {
        let corners = self.corners(i).into_iter();
        corners.for_each(|corner| take(&corner.to_array()));
    }

    fn refine(&self, i: usize, origin: DVec3, direction: DVec3, t: f64) -> (f64, DVec3) {
        let corners = self.corners(i).map(|corner| corner.as_dvec3());
        Triangles::refine_on_plane(corners, origin, direction, t)
    }
}

/// Appends `more` rows to an optional column, of which `before` rows exist. The column stays empty
/// as long as no rows were given; an empty `rows` stands for `more` empty entries.
fn append_optional(
    column: &mut Column<[u32; 3]>,
    rows: Column<[u32; 3]>,
    before: usize,
    more: usize,
) {
    if column.is_empty() && rows.is_empty() {
        return;
    }
    if column.is_empty() && before > 0 {
        *column = vec![[NO_INDEX; 3]; before].into();
    }
    if rows.is_empty() {
        column.extend(std::iter::repeat_n([NO_INDEX; 3], more));
    } else {
        column.append(rows);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

    fn mesh(with_normals: bool) -> Mesh {
        let mut mesh = Mesh::default();
        CORNERS
            .into_iter()
            .for_each(|corner| mesh.vertices.push(corner));
        mesh.corners = vec![[0, 1, 2], [2, 1, 0]].into();
        mesh.material = MeshMaterial::Each(vec![7, 8].into());
        if with_normals {
            mesh.vertex_normals.push(Vec3::Z);
            mesh.normals = vec![[0, 0, 0], [NO_INDEX; 3]].into();
        }
        mesh
    }

    #[test]
    fn columns_that_nobody_needs_stay_empty() {
        let mut t = Triangles::default();
        t.push(CORNERS, None, 0);
        t.append(mesh(false));
        assert_eq!((t.len(), t.normals.len(), t.uvs.len()), (3, 0, 0));
        assert_eq!(t.corners[1..], [[3, 4, 5], [5, 4, 3]]);
        assert_eq!(t.corner_normals(2), None);
    }

    #[test]
    fn normals_start_where_the_first_triangle_has_them() {
        let mut t = Triangles::default();
        t.push(CORNERS, None, 0);
        t.push(CORNERS, Some([Vec3::X; 3]), 0);
        t.append(mesh(true));
        t.append(mesh(false));
        let given: Vec<bool> = (0..t.len())
            .map(|i| t.corner_normals(i).is_some())
            .collect();
        assert_eq!(given, [false, true, true, false, false, false]);
        assert_eq!(t.corner_normals(2), Some([Vec3::Z; 3]));
        assert_eq!(t.corners(2), CORNERS);
        assert_eq!(*t.material, [0, 0, 7, 8, 7, 8]);
    }
}
