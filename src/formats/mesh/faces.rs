//! Faces of a chunk of a file, before they are triangulated.
//!
//! A polygon is kept as a fan of the largest number of triangles that it can become, from which its
//! corners can be recovered. It is triangulated properly once all vertices are known.

use super::polygon::triangulate;
use crate::diagnostics::{ParseError, Span};
use glam::Vec3;
use phalanx_scene::{NO_INDEX, Vec3s};

/// Stands for "none" in a row of an optional column, as in the scene.
pub(crate) const NONE: u32 = NO_INDEX;

/// Maximum number of corners of a face. More are treated as a mistake: triangulating the face could
/// take forever.
pub(crate) const MAX_CORNERS: usize = 1 << 16;

/// Refuses a face of too many corners, before its triangles are made.
pub(crate) fn check_corners(count: usize, span: Span) -> Result<(), ParseError> {
    if count > MAX_CORNERS {
        let message = format!("a face of {count} corners: at most {MAX_CORNERS}");
        Err(ParseError::new(span, message))
    } else {
        Ok(())
    }
}

/// Bytes of a triangle of a polygon, while the chunks of a file are joined: its corners, marks, and
/// room to grow.
const TRIANGLE_BYTES: u64 = 20;
/// Additional bytes of a triangle for each attribute.
const ATTRIBUTE_BYTES: u64 = 12;

/// Bytes that a face of `corners` corners takes beyond `paid`, the bytes that its text accounts
/// for. In a polygon with short numbers, two bytes of file make a triangle.
#[inline]
pub(crate) fn extra_bytes(corners: usize, attributes: u64, paid: u64) -> u64 {
    let triangles = corners.saturating_sub(2) as u64;
    (triangles * (TRIANGLE_BYTES + attributes * ATTRIBUTE_BYTES)).saturating_sub(paid)
}

/// Purpose of the bytes of triangles, for a message.
pub(crate) const PURPOSE: &str = "for the triangles of the file's faces";

/// Bytes for each corner of a polygon while it is cut (`perf/notes/memory.md`).
const CUT_BYTES: u64 = 300;

/// Bytes that are used while the polygons of all chunks are triangulated on `threads` threads.
pub(crate) fn cutting_bytes<'a>(chunks: impl Iterator<Item = &'a Faces>, threads: usize) -> u64 {
    let polygons = chunks.flat_map(|faces| &faces.polygons);
    let (count, largest) = polygons.fold((0, 0), |(count, largest), polygon| {
        (count + 1, polygon.corners.max(largest))
    });
    u64::from(largest) * CUT_BYTES * threads.min(count) as u64
}

/// Attributes of a corner, as indices of the columns.
pub(crate) const VERTEX: usize = 0;
pub(crate) const UV: usize = 1;
pub(crate) const NORMAL: usize = 2;

/// A relative number that stands for the first row of the chunk. It is far from [`NONE`] in either
/// direction.
pub(crate) const RELATIVE_ZERO: u32 = 1 << 31;

/// One corner of a face: the numbers of its vertex, UV and normal, from 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FaceCorner {
    pub(crate) numbers: [u32; 3],
    /// Bit k is set if number k counts from the first row of the chunk, which is [`RELATIVE_ZERO`].
    pub(crate) relative: u8,
}

/// Triangles as columns of the corners' numbers.
#[derive(Debug, Default)]
pub(crate) struct Faces {
    /// One column per attribute. Those of UVs and normals are empty, or have a row for each
    /// triangle.
    pub(crate) columns: [Vec<[u32; 3]>; 3],
    /// Empty, or a mask for each triangle of the numbers that are relative: three bits for each
    /// corner.
    relative: Vec<u16>,
    polygons: Vec<Polygon>,
}

/// A face of more than three corners.
#[derive(Clone, Copy, Debug)]
struct Polygon {
    /// First triangle of its fan.
    first: u32,
    corners: u32,
}

impl Faces {
    /// Number of triangles.
    pub(crate) fn len(&self) -> usize {
        self.columns[VERTEX].len()
    }

    /// Adds a triangle with vertices only.
    #[inline]
    pub(crate) fn add_plain(&mut self, corners: [u32; 3]) {
        self.columns[VERTEX].push(corners);
    }

    /// Adds a polygon of at least three corners, with vertices only.
    pub(crate) fn add_plain_polygon(&mut self, corners: &[i64]) {
        self.note_polygon(corners.len());
        for k in 2..corners.len() {
            self.add_plain([0, k - 1, k].map(|k| corners[k] as u32));
        }
    }

    /// Adds a face of at least three corners.
    #[inline]
    pub(crate) fn add(&mut self, corners: &[FaceCorner]) {
        self.note_polygon(corners.len());
        for k in 2..corners.len() {
            self.add_triangle([corners[0], corners[k - 1], corners[k]]);
        }
    }

    #[inline]
    fn note_polygon(&mut self, corners: usize) {
        if corners > 3 {
            self.polygons.push(Polygon {
                first: self.len() as u32,
                corners: corners as u32,
            });
        }
    }

    #[inline]
    fn add_triangle(&mut self, corners: [FaceCorner; 3]) {
        let row = self.len();
        let relative = corners.iter().any(|c| c.relative != 0);
        if relative || !self.relative.is_empty() {
            let bits = (0..3).fold(0, |bits, k| {
                bits | u16::from(corners[k].relative) << (3 * k)
            });
            self.relative.resize(row, 0);
            self.relative.push(bits);
        }
        self.columns[VERTEX].push(corners.map(|c| c.numbers[VERTEX]));
        for attribute in [UV, NORMAL] {
            let numbers = corners.map(|c| c.numbers[attribute]);
            let column = &mut self.columns[attribute];
            if numbers[0] != NONE || !column.is_empty() {
                column.resize(row, [NONE; 3]);
                column.push(numbers);
            }
        }
    }

    /// Makes relative numbers absolute. `before` is the number of rows of each attribute before the
    /// chunk.
    pub(crate) fn resolve(&mut self, before: [u32; 3]) {
        for (row, &bits) in self.relative.iter().enumerate().filter(|(_, b)| **b != 0) {
            for bit in (0..9).filter(|bit| bits >> bit & 1 == 1) {
                let number = &mut self.columns[bit % 3][row][bit / 3];
                let from_first = number.wrapping_sub(RELATIVE_ZERO);
                *number = from_first.wrapping_add(before[bit % 3]);
            }
        }
        self.relative = Vec::new();
    }

    /// Collapses faces with a vertex that `is_lost` to a point: one of their other vertices, or
    /// `home`. Returns the number of their triangles.
    pub(crate) fn leave_out(&mut self, home: u32, mut is_lost: impl FnMut(u32) -> bool) -> usize {
        let mut left_out = 0;
        let rows = &mut self.columns[VERTEX];
        let mut check = |rows: &mut [[u32; 3]]| {
            let (mut point, mut any) = (home, false);
            for &number in rows.as_flattened() {
                if is_lost(number) { any = true } else { point = number }
            }
            if any {
                rows.fill([point; 3]);
                left_out += rows.len();
            }
        };
        // The faces of a polygon first, whose corners are still those of its fan.
        for polygon in &self.polygons {
            let first = polygon.first as usize;
            check(&mut rows[first..first + polygon.corners as usize - 2]);
        }
        rows.chunks_mut(1).for_each(check);
        left_out
    }

    /// Triangulates the polygons. A polygon with collinear corners may give fewer triangles than
    /// its fan has. The rest become points, so that a face of n corners is always n - 2 triangles.
    pub(crate) fn triangulate(&mut self, vertices: &Vec3s) {
        for polygon in std::mem::take(&mut self.polygons) {
            self.cut_polygon(polygon, vertices);
        }
    }

    fn cut_polygon(&mut self, polygon: Polygon, vertices: &Vec3s) {
        let (first, corners) = (polygon.first as usize, polygon.corners as usize);
        let fan = first..first + corners - 2;
        let outline = |column: &[[u32; 3]]| -> Vec<u32> {
            let start = [column[first][0], column[first][1]];
            let rest = column[fan.clone()].iter().map(|row| row[2]);
            start.into_iter().chain(rest).collect()
        };
        let points: Vec<Vec3> = outline(&self.columns[VERTEX])
            .into_iter()
            .map(|number| vertices.get(number as usize))
            .collect();
        let triangles = triangulate(&points);
        let fanned = |(k, t): (usize, &[u32; 3])| *t == [0, k as u32 + 1, k as u32 + 2];
        if triangles.len() == fan.len() && triangles.iter().enumerate().all(fanned) {
            return;
        }
        for column in self.columns.iter_mut().filter(|c| !c.is_empty()) {
            let numbers = outline(column);
            let cut = triangles.iter().chain(std::iter::repeat(&[0; 3]));
            for (row, triangle) in column[fan.clone()].iter_mut().zip(cut) {
                *row = triangle.map(|corner| numbers[corner as usize]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(v: u32, n: u32, relative: u8) -> FaceCorner {
        FaceCorner {
            numbers: [v, NONE, n],
            relative,
        }
    }

    #[test]
    fn optional_columns_begin_where_they_are_needed() {
        let mut faces = Faces::default();
        let face = |n, relative| [0, 1, 2].map(|v| corner(v, n, relative));
        faces.add(&face(NONE, 0));
        faces.add(&face(RELATIVE_ZERO.wrapping_add(7), 4));
        faces.add(&face(NONE, 0));
        assert_eq!(faces.columns[NORMAL].len(), 3);
        assert_eq!(faces.columns[NORMAL][0], [NONE; 3]);
        assert!(faces.columns[UV].is_empty());
        faces.resolve([100, 200, 300]);
        assert_eq!(faces.columns[NORMAL][1], [307; 3]);
        assert_eq!(faces.columns[VERTEX], [[0, 1, 2]; 3]);
    }

    #[test]
    fn a_polygon_is_cut_when_its_vertices_are_known() {
        let mut vertices = Vec3s::default();
        // An arrow head whose fan from the first corner would overlap itself, and a spike without
        // area.
        for (x, y) in [
            (4.0, 0.0),
            (1.0, 1.0),
            (0.0, 4.0),
            (0.0, 0.0),
            (2.0, 2.0),
            (9.0, 9.0),
        ] {
            vertices.push(Vec3::new(x, y, 0.0));
        }
        let mut faces = Faces::default();
        faces.add(&[0, 1, 2, 3].map(|v| corner(v, v + 10, 0)));
        faces.add_triangle([3, 4, 5].map(|v| corner(v, v, 0)));
        faces.triangulate(&vertices);
        let cut: Vec<[u32; 3]> = faces.columns[VERTEX].clone();
        assert!(
            cut[..2].iter().all(|t| t.contains(&1) && t.contains(&3)),
            "{cut:?}"
        );
        assert_eq!(cut[2], [3, 4, 5]);
        let normals: Vec<_> = cut[..2].iter().map(|t| t.map(|v| v + 10)).collect();
        assert_eq!(faces.columns[NORMAL][..2], normals);
    }

    #[test]
    fn a_face_of_n_corners_is_n_minus_two_triangles() {
        let mut vertices = Vec3s::default();
        for x in [0.0, 1.0, 1.0, 0.5] {
            vertices.push(Vec3::new(x, x * x, 0.0));
        }
        let mut faces = Faces::default();
        faces.add_plain_polygon(&[0, 1, 2, 3]);
        faces.triangulate(&vertices);
        let is_point = |t: &[u32; 3]| *t == [0; 3];
        assert_eq!(faces.len(), 2);
        assert!(faces.columns[VERTEX].iter().filter(|t| is_point(t)).count() <= 1);
    }
}
