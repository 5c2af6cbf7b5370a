//! Attributes of the vertices of a mesh under a map, block by block on several threads.

use super::skins::Influences;
use super::vertices::PrimitiveVertices;
use crate::mesh::is_in_reach;
use crate::text::workers;
use glam::{DAffine3, DMat3, DVec3, Vec2};
use phalanx_scene::huge_pages::zeroed;
use phalanx_scene::{Mesh, Vec2s, Vec3s};

/// Number of vertices that a thread takes at a time.
pub(super) const BLOCK: usize = 1 << 13;

/// A map of vertices and the one of their normals.
#[derive(Clone, Copy)]
pub(super) struct VertexMap {
    position: DAffine3,
    /// The inverse transpose, up to a positive factor.
    normal: DMat3,
    pub(super) mirrored: bool,
}

impl VertexMap {
    pub(super) fn of(position: DAffine3) -> VertexMap {
        let m = position.matrix3;
        let mirrored = m.determinant() < 0.0;
        let sign = if mirrored { -1.0 } else { 1.0 };
        let cofactors = DMat3::from_cols(
            m.y_axis.cross(m.z_axis),
            m.z_axis.cross(m.x_axis),
            m.x_axis.cross(m.y_axis),
        );
        VertexMap {
            position,
            normal: cofactors * sign,
            mirrored,
        }
    }
}

/// Vertices that cannot be used as the file has them, by their numbers, ascending.
#[derive(Default)]
pub(super) struct BadVertices {
    /// Vertices that are not finite, or out of reach.
    pub(super) lost: Vec<u32>,
    pub(super) normals: Vec<u32>,
    pub(super) uvs: Vec<u32>,
    pub(super) tangents: Vec<u32>,
    pub(super) colors: Vec<u32>,
    /// Number of normals that are unusable in the file already, as the map may spoil more of them.
    pub(super) normals_of_file: usize,
    /// Number of vertices that follow a joint which the skin does not have.
    pub(super) joints: usize,
}

impl BadVertices {
    fn append(&mut self, next: BadVertices) {
        self.lost.extend(next.lost);
        self.normals.extend(next.normals);
        self.uvs.extend(next.uvs);
        self.tangents.extend(next.tangents);
        self.colors.extend(next.colors);
        self.normals_of_file += next.normals_of_file;
        self.joints += next.joints;
    }
}

/// Vertices of a primitive, and what moves them.
pub(super) struct MovedVertices<'s> {
    pub(super) vertices: &'s PrimitiveVertices<'s>,
    pub(super) map: VertexMap,
    /// Joints that move each vertex instead of the map.
    pub(super) skin: Option<(&'s Influences<'s>, &'s [DAffine3])>,
}

/// Columns of each attribute.
struct AttributeColumns<T> {
    positions: [T; 3],
    normals: [T; 3],
    uvs: [T; 2],
    tangents: [T; 3],
    signs: T,
    colors: [T; 3],
    opacity: T,
}

const COLUMNS: usize = 16;

impl<T> From<[T; COLUMNS]> for AttributeColumns<T> {
    #[rustfmt::skip]
    fn from([x, y, z, nx, ny, nz, u, v, tx, ty, tz, signs, r, g, b, opacity]: [T; COLUMNS]) -> Self {
        AttributeColumns {
            positions: [x, y, z],
            normals: [nx, ny, nz],
            uvs: [u, v],
            tangents: [tx, ty, tz],
            signs,
            colors: [r, g, b],
            opacity,
        }
    }
}

impl MovedVertices<'_> {
    /// The vertices of these rows, as a mesh without triangles.
    pub(super) fn columns(&self, rows: &[u32], threads: usize) -> (Mesh, BadVertices) {
        let has = self.vertices.attributes();
        let [n, t, c, o] = [has.normals, has.tangents, has.colors, has.opacity].map(usize::from);
        let l = has.uvs;
        // Numbers of a vertex in each column.
        let widths: [usize; COLUMNS] = [1, 1, 1, n, n, n, l, l, t, t, t, t, c, c, c, o];
        let mut columns = widths.map(|width| zeroed(width * rows.len()));
        let mut number = 0..COLUMNS;
        let mut parts = columns.each_mut().map(|column| {
            let width = number.next().map_or(1, |k| widths[k].max(1));
            column.chunks_mut(width * BLOCK)
        });
        let blocks = (0..).step_by(BLOCK).zip(rows.chunks(BLOCK));
        let blocks = blocks.map(|(first, rows)| {
            let out = parts.each_mut().map(|p| p.next().unwrap_or_default());
            (first, rows, out)
        });
        let blocks = blocks.collect();
        let work =
            |(first, rows, out): (u32, &[u32], [_; COLUMNS])| self.block(first, rows, out.into());
        let mut bad = BadVertices::default();
        for next in workers::map(threads, blocks, work) {
            bad.append(next);
        }
        (mesh_of(columns.into()), bad)
    }

    /// Fills the columns of a block, whose first vertex has this number.
    fn block(&self, first: u32, rows: &[u32], out: AttributeColumns<&mut [f32]>) -> BadVertices {
        let mut bad = BadVertices::default();
        let maps = self.joint_maps(rows, &mut bad);
        let map = |k: usize| maps.get(k).unwrap_or(&self.map);
        let number = |k: usize| first + k as u32;
        let [x, y, z] = out.positions;
        self.vertices.each_position(rows, |k, position| {
            let placed = map(k).position.transform_point3(position).as_vec3();
            [x[k], y[k], z[k]] = placed.to_array();
            if !is_in_reach(placed.to_array()) {
                bad.lost.push(number(k));
            }
        });
        let [x, y, z] = out.normals;
        self.vertices.each_normal(rows, |k, normal| {
            let normal = unit(normal);
            bad.normals_of_file += usize::from(normal == DVec3::ZERO);
            let normal_in_world = unit(map(k).normal * normal);
            if normal_in_world == DVec3::ZERO {
                bad.normals.push(number(k));
            }
            [x[k], y[k], z[k]] = normal_in_world.as_vec3().to_array();
        });
        let [x, y, z] = out.tangents;
        self.vertices.each_tangent(rows, |k, tangent, side| {
            let tangent_in_world = unit(map(k).position.matrix3 * unit(tangent));
            if tangent_in_world == DVec3::ZERO || !side.is_finite() {
                bad.tangents.push(number(k));
            }
            [x[k], y[k], z[k]] = tangent_in_world.as_vec3().to_array();
            let upright = (side >= 0.0) != map(k).mirrored;
            out.signs[k] = if upright { 1.0 } else { -1.0 };
        });
        bad.uvs = self.uvs(first, rows, out.uvs);
        bad.colors = self.colors(first, rows, out.colors, out.opacity);
        bad
    }

    /// The maps of skinned vertices; none without a skin.
    fn joint_maps(&self, rows: &[u32], bad: &mut BadVertices) -> Vec<VertexMap> {
        let Some((influences, joints)) = self.skin else {
            return Vec::new();
        };
        let maps = rows.iter().map(|&row| {
            let (map, complete) = influences.map(row as usize, joints);
            bad.joints += usize::from(!complete);
            VertexMap::of(map)
        });
        maps.collect()
    }

    /// Fills texture coordinates, and returns the vertices that have bad ones.
    fn uvs(&self, first: u32, rows: &[u32], [u, v]: [&mut [f32]; 2]) -> Vec<u32> {
        let mut bad = Vec::new();
        let layers = self.vertices.attributes().uvs;
        for layer in 0..layers {
            self.vertices.each_uv(layer, rows, |k, mut uv| {
                if !uv.is_finite() {
                    bad.push(first + k as u32);
                    uv = Vec2::ZERO;
                }
                [u[k * layers + layer], v[k * layers + layer]] = uv.to_array();
            });
        }
        bad.sort_unstable();
        bad.dedup();
        bad
    }

    /// Fills colours, and returns the vertices that have bad ones.
    fn colors(
        &self,
        first: u32,
        rows: &[u32],
        [r, g, b]: [&mut [f32]; 3],
        opacity: &mut [f32],
    ) -> Vec<u32> {
        let mut bad = Vec::new();
        self.vertices.each_color(rows, |k, mut color| {
            if color.iter().any(|share| share.is_nan()) {
                bad.push(first + k as u32);
                color = [1.0; 4];
            }
            [r[k], g[k], b[k]] = [color[0], color[1], color[2]];
            if let Some(opacity) = opacity.get_mut(k) {
                *opacity = color[3];
            }
        });
        bad
    }
}

fn mesh_of(columns: AttributeColumns<Vec<f32>>) -> Mesh {
    let vectors = |columns: [Vec<f32>; 3]| {
        let [x, y, z] = columns.map(Into::into);
        Vec3s { x, y, z }
    };
    let [x, y] = columns.uvs.map(Into::into);
    Mesh {
        vertices: vectors(columns.positions),
        vertex_normals: vectors(columns.normals),
        vertex_uvs: Vec2s { x, y },
        vertex_tangents: vectors(columns.tangents),
        bitangent_signs: columns.signs.into(),
        vertex_colors: vectors(columns.colors),
        vertex_opacity: columns.opacity.into(),
        ..Mesh::default()
    }
}

/// v/|v|, or zero for a vector without a direction.
fn unit(v: DVec3) -> DVec3 {
    let length = v.length();
    if length > 0.0 && length.is_finite() {
        v * (1.0 / length)
    } else {
        DVec3::ZERO
    }
}
