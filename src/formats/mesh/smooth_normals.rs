//! Vertex normals for triangles whose file gives none.
//!
//! The corners of such triangles at one position of one object are a fan. The normal of a corner is
//! the sum of its fan's facet normals that are within an angle of its own facet's. Each has the
//! weight sin α / (|a| |b|), for edges a and b that enclose α (Max, "Weights for computing vertex
//! normals from facet normals", 1999): cross(a, b) / (|a|² |b|²). So edges beyond the angle stay.
//!
//! Each thread has a share of the vertices, and passes through all triangles for those around
//! them. Each sum is in the order of the triangles, so no bit depends on the number of threads.

use super::faces::NONE;
use super::fan::Fan;
use super::first_equal::{FIRST_EQUAL_BYTES, first_equal};
use crate::memory::{MemoryLedger, OverLimit};
use crate::text::workers;
use glam::{DVec3, Vec3};
use phalanx_scene::huge_pages::{room, zeroed};
use phalanx_scene::{SMOOTH_SLOPE, Triangles, Vec3s};
use std::ops::Range;

/// Number of triangles that a thread takes at a time.
const BLOCK: usize = 1 << 14;
/// Most shares of vertices.
const SHARES: usize = 64;

/// Bytes of a triangle's references to normals.
const ROW_BYTES: u64 = 12;
/// Bytes of a normal.
const NORMAL_BYTES: u64 = 12;
/// Bytes of a triangle while normals are made: its corners in fans, each with its normal's number.
const FAN_BYTES: u64 = 24;
/// Bytes of a vertex while normals are made: its fan, and the fan's beginning, twice.
const VERTEX_BYTES: u64 = FIRST_EQUAL_BYTES + 8;

/// Degrees that are added to the angle, so that in a prism of as many sides as its angle allows
/// the rounding of coordinates decides nothing.
const ROUNDING: f64 = 0.05;

/// Smallest dot product of the normals of facets between which corners are smooth up to an angle
/// in degrees.
fn least_dot(angle: f32) -> f64 {
    libm::cos((f64::from(angle) + ROUNDING).min(180.0).to_radians())
}

/// Gives vertex normals to the triangles that have none, smooth up to an angle in degrees. Objects,
/// given by their first vertices, ascending, are apart from each other. Returns false, and changes
/// nothing, if there are no such triangles, or if nothing of them is smooth: flat faces stay flat.
pub(crate) fn add_smooth_normals(
    triangles: &mut Triangles,
    objects: &[u32],
    angle: f32,
    threads: usize,
    memory: &MemoryLedger,
) -> Result<bool, OverLimit> {
    let what = "for smooth normals";
    let [count, vertices] = [triangles.len(), triangles.vertices.len()];
    let most = ROW_BYTES + FAN_BYTES + 3 * NORMAL_BYTES;
    memory.lend(count as u64 * most + vertices as u64 * VERTEX_BYTES, what)?;
    let mesh = BareMesh::of(triangles, objects, threads);
    let share = vertices.div_ceil(threads.clamp(1, SHARES)).max(1);
    let ranges = (0..vertices).step_by(share);
    let ranges = ranges.map(|first| first..vertices.min(first + share));
    let least = least_dot(angle);
    let fans = workers::map(threads, ranges.collect(), |range| {
        Fans::of(&mesh, range, least)
    });
    if !fans.iter().any(|fans| fans.is_smooth) {
        return Ok(false);
    }
    let normals: usize = fans.iter().map(|fans| fans.normals.len()).sum();
    let bytes = count as u64 * ROW_BYTES + normals as u64 * NORMAL_BYTES;
    memory.take(bytes, what)?;
    let mut rows = mesh.rows;
    let mut next = triangles.vertex_normals.len();
    let firsts = fans.iter().map(|fans| {
        next += fans.normals.len();
        (next - fans.normals.len()) as u32
    });
    let firsts: Vec<u32> = firsts.collect();
    let number = |row: u32, fan: u32| {
        let k = fan as usize / share;
        firsts[k] + fans[k].number(fan, row)
    };
    let blocks = (0..).step_by(BLOCK).zip(rows.chunks_mut(BLOCK)).collect();
    workers::map(threads, blocks, |(first, block): (u32, &mut [[u32; 3]])| {
        let bare = (first..).zip(block).filter(|(_, row)| row[0] != NONE);
        for (k, row) in bare {
            let [a, b, c] = *row;
            *row = [number(k, a), number(k, b), number(k, c)];
        }
    });
    let mut columns = workers::map(threads, vec![0, 1, 2], |axis: usize| {
        let mut column = room(normals);
        column.extend(fans.iter().flat_map(|fans| &fans.normals).map(|n| n[axis]));
        column.into()
    });
    let [z, y, x] = [(); 3].map(|()| columns.pop().unwrap_or_default());
    triangles.vertex_normals.append(Vec3s { x, y, z });
    if !triangles.normals.is_empty() {
        let own = rows.iter_mut().zip(triangles.normals.iter());
        own.filter(|(row, _)| row[0] == NONE)
            .for_each(|(row, own)| *row = *own);
    }
    triangles.normals = rows.into();
    Ok(true)
}

/// Triangles without normals, over vertices.
struct BareMesh<'a> {
    vertices: [&'a [f32]; 3],
    corners: &'a [[u32; 3]],
    /// The fan of each corner, which is the number of its first vertex; three times [`NONE`] for
    /// triangles with normals.
    rows: Vec<[u32; 3]>,
}

impl<'a> BareMesh<'a> {
    fn of(triangles: &'a Triangles, objects: &[u32], threads: usize) -> BareMesh<'a> {
        let vertices = triangles.vertices.parts().map(|column| &column[..]);
        // Zeros of either sign are one position.
        let fans = first_equal(vertices[0].len(), threads, |row| {
            let object = objects.partition_point(|&first| first as usize <= row);
            let [x, y, z] = vertices;
            let bits = |column: &[f32]| (column[row] + 0.0).to_bits();
            [bits(x), bits(y), bits(z), object as u32]
        });
        let mut mesh = BareMesh {
            vertices,
            corners: &triangles.corners,
            rows: Vec::new(),
        };
        let mut rows: Vec<[u32; 3]> = zeroed(triangles.len());
        let blocks = (0..).step_by(BLOCK).zip(rows.chunks_mut(BLOCK)).collect();
        workers::map(threads, blocks, |(first, block): (usize, &mut [_])| {
            for (k, row) in (first..).zip(block) {
                let is_bare = triangles.normal_rows(k).is_none();
                let [a, b, c] = mesh.corners[k];
                let fan = |vertex: u32| fans[vertex as usize];
                *row = if is_bare { [fan(a), fan(b), fan(c)] } else { [NONE; 3] };
            }
        });
        mesh.rows = rows;
        mesh
    }

    /// Positions of a triangle's corners.
    #[inline]
    fn points(&self, k: usize) -> [DVec3; 3] {
        let [x, y, z] = self.vertices;
        let point = |v: u32| {
            let v = v as usize;
            DVec3::new(x[v].into(), y[v].into(), z[v].into())
        };
        // Written out: a closure in an array's map becomes a call.
        let [a, b, c] = self.corners[k];
        [point(a), point(b), point(c)]
    }
}

/// Fans of a range of vertices.
struct Fans {
    /// Number of the first.
    first: u32,
    /// The first corner of each, and their end.
    starts: Vec<u32>,
    /// Triangles around each vertex, in their order, and which corner is there; then the number of
    /// its normal.
    corners: Vec<[u32; 2]>,
    normals: Vec<Vec3>,
    /// True if any of the normals is not that of a facet.
    is_smooth: bool,
}

impl Fans {
    fn of(mesh: &BareMesh, range: Range<usize>, least: f64) -> Fans {
        let first = range.start as u32;
        let mut fans = Fans {
            first,
            starts: vec![0; range.len() + 1],
            corners: Vec::new(),
            normals: Vec::new(),
            is_smooth: false,
        };
        let within = |fan: u32| Some(fan.wrapping_sub(first) as usize).filter(|&k| k < range.len());
        let all = || mesh.rows.as_flattened().iter();
        all()
            .filter_map(|&fan| within(fan))
            .for_each(|k| fans.starts[k + 1] += 1);
        for k in 1..fans.starts.len() {
            fans.starts[k] += fans.starts[k - 1];
        }
        fans.corners = zeroed(fans.starts[range.len()] as usize);
        let mut ends = fans.starts.clone();
        for (triangle, row) in mesh.rows.iter().enumerate() {
            for (corner, &fan) in (0..).zip(row) {
                if let Some(k) = within(fan) {
                    fans.corners[ends[k] as usize] = [triangle as u32, corner];
                    ends[k] += 1;
                }
            }
        }
        let mut fan = Fan::default();
        for k in 0..range.len() {
            fans.smooth(mesh, k, &mut fan, least);
        }
        fans
    }

    /// Makes the normals of a fan.
    fn smooth(&mut self, mesh: &BareMesh, k: usize, fan: &mut Fan, least: f64) {
        let corners = &mut self.corners[self.starts[k] as usize..self.starts[k + 1] as usize];
        if corners.is_empty() {
            return;
        }
        fan.clear();
        for &[triangle, corner] in &*corners {
            fan.push(mesh.points(triangle as usize), corner as usize);
        }
        let before = self.normals.len();
        fan.corner_normals(least, |number, along, normal| {
            let has_area = normal != DVec3::ZERO;
            self.is_smooth |= has_area && along < FLAT;
            let normal = if has_area { normal.as_vec3() } else { Vec3::Z };
            let last = self.normals.len();
            let mut like = before.max(last.saturating_sub(LIKE))..last;
            let known = like.find(|&row| self.normals[row] == normal);
            if known.is_none() {
                self.normals.push(normal);
            }
            corners[number as usize][1] = known.unwrap_or(last) as u32;
        });
    }

    /// Number of the normal of a triangle's corner in a fan.
    #[inline]
    fn number(&self, fan: u32, triangle: u32) -> u32 {
        let k = (fan - self.first) as usize;
        let corners = &self.corners[self.starts[k] as usize..self.starts[k + 1] as usize];
        let row = corners.binary_search_by_key(&triangle, |corner| corner[0]);
        corners[row.unwrap_or(0)][1]
    }
}

/// Cosine of the smallest angle between a facet and a vertex normal that counts as smooth.
const FLAT: f64 = 1.0 - 0.5 * (SMOOTH_SLOPE * SMOOTH_SLOPE) as f64;

/// Number of normals of a fan to which the next one is compared.
const LIKE: usize = 8;

#[cfg(test)]
#[path = "smooth_tests.rs"]
mod tests;
