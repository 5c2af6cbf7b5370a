//! All hits of each ray, list after list.

use super::Hit;
use std::ops::Range;

/// All hits of rays, in columns: the list of ray `i` is in rows `starts[i]` to `starts[i + 1]`.
///
/// Each list is ordered by (t, prim_id). A primitive appears in it at most once; an edge or a
/// vertex that a ray passes through, once for each triangle that it belongs to by the rules of
/// [`Bvh::intersect`](crate::bvh::Bvh::intersect); coincident surfaces, once each. A sphere appears
/// with the point where the ray enters it, or leaves it if the ray starts inside or a
/// [filter](crate::RayFilter) refuses where it enters. 20 bytes per hit. [`Hit`] documents the
/// columns.
///
/// Made by [`Bvh::all_hits_batch`](crate::bvh::Bvh::all_hits_batch), which has an example.
#[derive(Clone, Debug, PartialEq)]
pub struct HitLists {
    /// Row at which the list of each ray begins; the last entry is the number of hits.
    pub starts: Vec<usize>,
    /// Distances in units of the rays' directions.
    pub t: Vec<f32>,
    /// Barycentric weights of triangles' second vertices.
    pub u: Vec<f32>,
    /// Barycentric weights of triangles' third vertices.
    pub v: Vec<f32>,
    /// Primitives.
    pub prim_id: Vec<u32>,
    /// Geometries.
    pub geom_id: Vec<u32>,
}

impl HitLists {
    /// Rows of the hits of ray `i`.
    ///
    /// # Panics
    /// If there is no ray `i`.
    pub fn rows(&self, i: usize) -> Range<usize> {
        self.starts[i]..self.starts[i + 1]
    }

    /// Iterates over the hits of ray `i`, nearest first.
    ///
    /// # Panics
    /// If there is no ray `i`.
    pub fn of(&self, i: usize) -> impl ExactSizeIterator<Item = Hit> + '_ {
        self.rows(i).map(|row| Hit {
            t: self.t[row],
            u: self.u[row],
            v: self.v[row],
            prim_id: self.prim_id[row],
            geom_id: self.geom_id[row],
        })
    }

    /// Adds the list of the next ray.
    pub(super) fn push(&mut self, list: impl IntoIterator<Item = Hit>) {
        for hit in list {
            self.t.push(hit.t);
            self.u.push(hit.u);
            self.v.push(hit.v);
            self.prim_id.push(hit.prim_id);
            self.geom_id.push(hit.geom_id);
        }
        self.starts.push(self.t.len());
    }

    /// The lists of all chunks, one after the other.
    pub(super) fn joined(parts: &[HitLists]) -> HitLists {
        let mut all = HitLists::empty();
        let hits = parts.iter().map(|part| part.t.len()).sum();
        all.starts
            .reserve(parts.iter().map(|part| part.starts.len() - 1).sum());
        for column in [&mut all.t, &mut all.u, &mut all.v] {
            column.reserve(hits);
        }
        for column in [&mut all.prim_id, &mut all.geom_id] {
            column.reserve(hits);
        }
        parts.iter().for_each(|part| all.copy(part));
        all
    }

    /// Keeps the hits for which `keep` returns true, by the ray and the hit.
    pub(super) fn retain(&mut self, keep: impl Fn(usize, &Hit) -> bool) {
        let mut lists = HitLists::empty();
        for ray in 0..self.starts.len() - 1 {
            lists.push(self.of(ray).filter(|hit| keep(ray, hit)));
        }
        *self = lists;
    }

    /// No lists.
    pub fn empty() -> HitLists {
        HitLists {
            starts: vec![0],
            t: Vec::new(),
            u: Vec::new(),
            v: Vec::new(),
            prim_id: Vec::new(),
            geom_id: Vec::new(),
        }
    }

    /// Appends the lists of further rays.
    pub fn append(&mut self, more: HitLists) {
        if self.starts.len() == 1 {
            *self = more;
        } else {
            self.copy(&more);
        }
    }

    fn copy(&mut self, more: &HitLists) {
        let before = self.t.len();
        self.starts
            .extend(more.starts[1..].iter().map(|row| before + row));
        self.t.extend(&more.t);
        self.u.extend(&more.u);
        self.v.extend(&more.v);
        self.prim_id.extend(&more.prim_id);
        self.geom_id.extend(&more.geom_id);
    }
}
