//! Vertex normals for triangles whose file gives none.
//!
//! The corners of such triangles at one position of one object are a fan. The normal of a corner is
//! the sum of its fan's facet normals that are within an angle of its own facet's. Each has the
//! weight sin α / (|a| |b|), for edges a and b that enclose α (Max, "Weights for computing vertex
//! normals from facet normals", 1999): cross(a, b) / (|a|² |b|²). So edges beyond the angle stay.
//!
//! Each thread has a share of the vertices, and passes through the triangles for those around them.
//! Each sum is in the order of the triangles, so no bit depends on the number of threads.

use super::faces::NONE;
use super::fan::{Facet, Fan};
use super::first_equal::{FIRST_EQUAL_BYTES, first_equal};
use crate::memory::{MemoryLedger, OverLimit};
use crate::text::workers;
use glam::{DVec3, Vec3};
use phalanx_scene::huge_pages::zeroed;
use phalanx_scene::{SMOOTH_SLOPE, Triangles, Vec3s};
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Number of triangles that a thread takes at a time.
const BLOCK: usize = 1 << 14;
/// Most shares of vertices.
const SHARES: usize = 64;
/// Number of facets that a thread keeps for the vertices that follow, which mostly share them.
const KEPT: usize = 1 << 12;

/// Bytes of a triangle's references to normals.
const ROW_BYTES: u64 = 12;
/// Bytes of a normal.
const NORMAL_BYTES: u64 = 12;
/// Bytes of a triangle while normals are made: its corners in fans.
const FAN_BYTES: u64 = 12;
/// Bytes of a vertex while normals are made: its fan, and the fan's beginning.
const VERTEX_BYTES: u64 = FIRST_EQUAL_BYTES + 4;

/// Degrees that are added to the angle, so that in a prism of as many sides as its angle allows
/// the rounding of coordinates decides nothing.
const ROUNDING: f64 = 0.05;

/// Addend to the cosine of half the angle, so that no rounding decides whether facets so
/// near to a normal are within the angle of each other.
const MARGIN: f64 = 1e-6;

/// Gives vertex normals to the triangles that have none, smooth up to an angle in degrees. Objects,
/// given by their first vertices, ascending, are apart from each other. Returns false, and changes
/// nothing, if there are no such triangles, if nothing of them is smooth, so that flat faces stay
/// flat, or if there are more corners than numbers.
pub(crate) fn add_smooth_normals(
    triangles: &mut Triangles,
    objects: &[u32],
    angle: f32,
    threads: usize,
    memory: &MemoryLedger,
) -> Result<bool, OverLimit> {
    let what = "for smooth normals";
    let [count, vertices] = [triangles.len(), triangles.vertices.len()];
    if u32::try_from(3 * count).is_err() {
        return Ok(false);
    }
    let most = ROW_BYTES + FAN_BYTES + 3 * NORMAL_BYTES;
    memory.lend(count as u64 * most + vertices as u64 * VERTEX_BYTES, what)?;
    let angle = (f64::from(angle) + ROUNDING).min(180.0).to_radians();
    let mesh = BareMesh::of(triangles, objects, threads);
    let share = vertices.div_ceil(threads.clamp(1, SHARES)).max(1);
    let ranges = (0..vertices).step_by(share);
    let ranges = ranges.map(|first| first..vertices.min(first + share));
    let fans = workers::map(threads, ranges.collect(), |range| Fans::of(&mesh, range));
    // From here on, numbers of normals take the places of fans.
    let fans = workers::map(threads, fans, |fans| fans.smoothed(&mesh, angle));
    if !fans.iter().any(|fans| fans.is_smooth) {
        return Ok(false);
    }
    let normals: usize = fans.iter().map(|fans| fans.normals.len()).sum();
    let bytes = count as u64 * ROW_BYTES + normals as u64 * NORMAL_BYTES;
    memory.take(bytes, what)?;
    let mut next = triangles.vertex_normals.len();
    let fans = fans.into_iter().map(|fans| {
        next += fans.normals.len();
        ((next - fans.normals.len()) as u32, fans)
    });
    let normals = workers::map(threads, fans.collect(), |(first, fans)| {
        let corners = if first > 0 { &fans.corners[..] } else { &[] };
        for corner in corners.iter().map(|&corner| mesh.row(corner)) {
            corner.store(corner.load(Relaxed) + first, Relaxed);
        }
        fans.normals
    });
    let rows = mesh.rows.into_iter();
    let rows = rows.map(|[a, b, c]| [a.into_inner(), b.into_inner(), c.into_inner()]);
    let mut rows: Vec<[u32; 3]> = rows.collect();
    for normals in normals {
        triangles.vertex_normals.append(normals);
    }
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
    /// The fan of each corner, which is the number of its first vertex, and then its normal; three
    /// times [`NONE`] for triangles with normals.
    rows: Vec<[AtomicU32; 3]>,
    /// The first and the last fan of each block of triangles.
    bounds: Vec<[u32; 2]>,
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
        let mut rows: Vec<[u32; 3]> = zeroed(triangles.len());
        let blocks = (0..).step_by(BLOCK).zip(rows.chunks_mut(BLOCK)).collect();
        let bounds = workers::map(threads, blocks, |(first, block): (usize, &mut [_])| {
            let mut bounds = [NONE, 0];
            for (k, row) in (first..).zip(block) {
                *row = [NONE; 3];
                if triangles.normal_rows(k).is_none() {
                    let fan = |vertex: u32| fans[vertex as usize];
                    let [a, b, c] = triangles.corners[k];
                    let [a, b, c] = [fan(a), fan(b), fan(c)];
                    *row = [a, b, c];
                    bounds = [
                        bounds[0].min(a).min(b).min(c),
                        bounds[1].max(a).max(b).max(c),
                    ];
                }
            }
            bounds
        });
        let rows = rows
            .into_iter()
            .map(|[a, b, c]| [a.into(), b.into(), c.into()]);
        BareMesh {
            vertices,
            corners: &triangles.corners,
            rows: rows.collect(),
            bounds,
        }
    }

    /// Number of a corner's fan, and then of its normal.
    #[inline]
    fn row(&self, corner: u32) -> &AtomicU32 {
        &self.rows.as_flattened()[corner as usize]
    }

    /// Calls `take` with the number of a fan in a range, and each of its corners, in their order.
    #[inline]
    fn each_corner(&self, range: &Range<usize>, mut take: impl FnMut(usize, u32)) {
        let blocks = (0..).step_by(3 * BLOCK).zip(self.rows.chunks(BLOCK));
        for ((first, block), &[lo, hi]) in blocks.zip(&self.bounds) {
            if (lo as usize) < range.end && hi as usize >= range.start {
                for (corner, fan) in (first..).zip(block.as_flattened()) {
                    let k = (fan.load(Relaxed) as usize).wrapping_sub(range.start);
                    if k < range.len() {
                        take(k, corner);
                    }
                }
            }
        }
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
    /// The first corner of each, and their end.
    starts: Vec<u32>,
    /// Corners around each vertex, in the order of their triangles.
    corners: Vec<u32>,
    normals: Vec3s,
    /// True if any of the normals is not that of a facet.
    is_smooth: bool,
}

impl Fans {
    fn of(mesh: &BareMesh, range: Range<usize>) -> Fans {
        // Where each fan ends, two places behind its own: then where it is filled next.
        let mut starts = vec![0; range.len() + 2];
        mesh.each_corner(&range, |k, _| starts[k + 2] += 1);
        for k in 2..starts.len() {
            starts[k] += starts[k - 1];
        }
        let mut corners = zeroed(starts[range.len() + 1] as usize);
        mesh.each_corner(&range, |k, corner| {
            corners[starts[k + 1] as usize] = corner;
            starts[k + 1] += 1;
        });
        Fans {
            starts,
            corners,
            normals: Vec3s::default(),
            is_smooth: false,
        }
    }

    /// Makes the normals of all fans.
    fn smoothed(mut self, mesh: &BareMesh, angle: f64) -> Fans {
        let least = libm::cos(angle);
        let half = libm::cos(0.5 * angle) + MARGIN;
        let mut fan = Fan::default();
        let mut facets = vec![(NONE, Facet::default()); KEPT];
        let ends = &self.starts[..self.starts.len() - 1];
        for range in ends.windows(2).filter(|range| range[0] < range[1]) {
            let corners = &self.corners[range[0] as usize..range[1] as usize];
            fan.clear();
            for &corner in corners {
                let triangle = corner / 3;
                let facets = &mut facets[triangle as usize % KEPT];
                if facets.0 != triangle {
                    *facets = (triangle, Facet::of(mesh.points(triangle as usize)));
                }
                fan.push(&facets.1, corner as usize % 3);
            }
            let before = self.normals.len();
            if let Some(normal) = fan.whole(half) {
                self.is_smooth = self.is_smooth || fan.is_bent(normal, FLAT);
                self.normals.push(normal.as_vec3());
                for &corner in corners {
                    mesh.row(corner).store(before as u32, Relaxed);
                }
                continue;
            }
            fan.corner_normals(least, |number, along, normal| {
                let has_area = normal != DVec3::ZERO;
                self.is_smooth |= has_area && along < FLAT;
                let normal = if has_area { normal.as_vec3() } else { Vec3::Z };
                let last = self.normals.len();
                let mut like = before.max(last.saturating_sub(LIKE))..last;
                let known = like.find(|&row| self.normals.get(row) == normal);
                if known.is_none() {
                    self.normals.push(normal);
                }
                let row = mesh.row(corners[number as usize]);
                row.store(known.unwrap_or(last) as u32, Relaxed);
            });
        }
        self
    }
}

/// Cosine of the smallest angle between a facet and a vertex normal that counts as smooth.
const FLAT: f64 = 1.0 - 0.5 * (SMOOTH_SLOPE * SMOOTH_SLOPE) as f64;

/// Number of normals of a fan to which the next one is compared.
const LIKE: usize = 8;

#[cfg(test)]
#[path = "smooth_tests.rs"]
mod tests;
