//! Geometry numbers: the primitives that were added together.

use crate::bounds::Bounds;
use crate::column::Column;
use crate::prim_places::{FreePlace, PrimPlace};
use std::collections::BTreeSet;
use std::fmt;

/// Number of a geometry, from 0 in the order in which geometries were added. The number of one that
/// was removed is given to a later one: see `Scene::remove`.
///
/// A geometry is what one call of `Scene::add_mesh`, `Scene::add_spheres` or `Scene::add_instance`
/// added.
pub type GeomId = u32;

/// Geometry of a miss, and of primitives that were added one by one: 2³² − 1.
pub const NO_GEOM: GeomId = GeomId::MAX;

/// Primitives that were added together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Geometry {
    /// A run of stored primitives.
    Prims {
        /// The first.
        first: u32,
        /// How many.
        count: u32,
    },
    /// An instance.
    Instance(u32),
}

/// A row of the table: a geometry, or what one that was removed has left.
#[derive(Clone, Copy, Debug)]
pub(crate) enum GeometryRow {
    There(Geometry),
    /// Primitives, the first of which was this one.
    RemovedPrims(u32),
    RemovedInstance(u32),
}

impl GeometryRow {
    fn of(first: u32, count: u32) -> GeometryRow {
        match count {
            INSTANCE => GeometryRow::There(Geometry::Instance(first)),
            REMOVED_INSTANCE => GeometryRow::RemovedInstance(first),
            REMOVED_PRIMS => GeometryRow::RemovedPrims(first),
            count => GeometryRow::There(Geometry::Prims { first, count }),
        }
    }

    /// The first primitive, or the number of the instance; and the count.
    fn numbers(self) -> (u32, u32) {
        match self {
            GeometryRow::There(Geometry::Prims { first, count }) => (first, count),
            GeometryRow::There(Geometry::Instance(number)) => (number, INSTANCE),
            GeometryRow::RemovedPrims(first) => (first, REMOVED_PRIMS),
            GeometryRow::RemovedInstance(number) => (number, REMOVED_INSTANCE),
        }
    }

    fn present(self) -> Option<Geometry> {
        match self {
            GeometryRow::There(geometry) => Some(geometry),
            GeometryRow::RemovedPrims(_) | GeometryRow::RemovedInstance(_) => None,
        }
    }
}

/// Counts of rows that are no primitives.
const INSTANCE: u32 = u32::MAX;
const REMOVED_INSTANCE: u32 = u32::MAX - 1;
const REMOVED_PRIMS: u32 = u32::MAX - 2;

/// One row per geometry, in the order of [`GeomId`].
#[derive(Clone, Debug, Default)]
pub struct Geometries {
    /// First primitive, or number of the instance.
    pub first: Column<u32>,
    /// Number of primitives; 2³² − 1 for an instance, − 2 for a removed one, − 3 for removed
    /// primitives.
    pub count: Column<u32>,
    /// Bits that a ray's mask must share: see [`Scene::set_mask`](crate::Scene::set_mask).
    pub mask: Column<u32>,
    /// Places of what was added as slices, prototypes among them, ascending: the first primitive,
    /// how many fit, the first vertex, how many fit, and how many are in use.
    pub places: Column<[u32; 5]>,
    pub(crate) past: PastGeometries,
}

/// Geometries as they were.
#[derive(Clone, Default)]
pub(crate) struct PastGeometries {
    /// Boxes of all positions before the present ones, by geometry.
    pub(crate) bounds: Vec<Bounds>,
    /// Places of what was removed; `None` until they are looked up.
    pub(crate) free: Option<BTreeSet<FreePlace>>,
}

/// The past is no part of what a scene is.
impl fmt::Debug for PastGeometries {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("PastGeometries")
    }
}

impl Geometries {
    /// Number of geometries.
    #[inline]
    pub fn len(&self) -> usize {
        self.first.len()
    }

    /// Returns true if nothing was added as a geometry.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.first.is_empty()
    }

    /// All rows, those of removed geometries among them.
    pub(crate) fn rows(&self) -> impl Iterator<Item = (GeomId, GeometryRow)> {
        let rows = self.first.iter().zip(self.count.iter());
        (0..).zip(rows.map(|(&first, &count)| GeometryRow::of(first, count)))
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = (GeomId, Geometry)> {
        self.rows()
            .filter_map(|(id, row)| Some((id, row.present()?)))
    }

    /// Row of the place that begins with this primitive.
    fn place_row(&self, first_prim: u32) -> Option<usize> {
        let row = self.places.binary_search_by_key(&first_prim, |row| row[0]);
        row.ok()
    }

    /// The place that begins with this primitive.
    pub fn prim_place(&self, first_prim: u32) -> Option<PrimPlace> {
        let row = self.place_row(first_prim)?;
        Some(PrimPlace::of_row(self.places[row]))
    }

    /// How many vertices of the place that begins with this primitive are in use.
    pub(crate) fn used_vertices(&self, first_prim: u32) -> u32 {
        self.place_row(first_prim)
            .map_or(0, |row| self.places[row][4])
    }

    /// The box of all positions that a geometry has had, without the present ones.
    pub fn former_bounds(&self, id: GeomId) -> Bounds {
        self.past
            .bounds
            .get(id as usize)
            .copied()
            .unwrap_or_default()
    }

    /// Adds to the positions that a geometry has had.
    pub(crate) fn leave_bounds(&mut self, id: GeomId, bounds: Bounds) {
        let row = id as usize;
        if self.past.bounds.len() <= row {
            self.past.bounds.resize(row + 1, Bounds::EMPTY);
        }
        self.past.bounds[row] = self.past.bounds[row].union(bounds);
    }

    /// Sets how many vertices of a place are in use.
    pub(crate) fn use_vertices(&mut self, first_prim: u32, count: u32) {
        if let Some(row) = self.place_row(first_prim) {
            self.places[row][4] = count;
        }
    }

    /// Runs and instances that no ray hits: hidden geometries, removed ones, and what is free in
    /// the places of others.
    pub(crate) fn unseen(&self) -> impl Iterator<Item = Geometry> {
        let rows = self.rows().zip(self.mask.iter());
        rows.filter_map(|((_, row), &mask)| match row {
            GeometryRow::There(Geometry::Prims { count: 0, .. }) => None,
            GeometryRow::There(Geometry::Prims { first, count }) => {
                let fit = self.prim_place(first).map_or(count, |place| place.prims);
                let seen = if mask == 0 { 0 } else { count };
                (seen < fit).then_some(Geometry::Prims {
                    first: first + seen,
                    count: fit - seen,
                })
            }
            GeometryRow::RemovedPrims(first) => {
                self.prim_place(first).map(|place| Geometry::Prims {
                    first,
                    count: place.prims,
                })
            }
            GeometryRow::There(instance) => (mask == 0).then_some(instance),
            GeometryRow::RemovedInstance(k) => Some(Geometry::Instance(k)),
        })
    }

    /// The geometry of this number; `None` for one that was removed.
    pub(crate) fn get(&self, id: GeomId) -> Option<Geometry> {
        let row = self.first.get(id as usize).zip(self.count.get(id as usize));
        row.and_then(|(&first, &count)| GeometryRow::of(first, count).present())
    }

    /// The geometry of this number, if rays hit it.
    pub fn visible(&self, id: GeomId) -> Option<Geometry> {
        let mask = self.mask.get(id as usize).copied();
        self.get(id).filter(|_| mask != Some(0))
    }

    /// Number of stored primitives of a geometry; none of an instance.
    pub fn prims_of(&self, id: GeomId) -> usize {
        match self.get(id) {
            Some(Geometry::Prims { count, .. }) => count as usize,
            _ => 0,
        }
    }

    /// Replaces a row by another one; all rays hit a geometry in it.
    pub(crate) fn replace(&mut self, id: GeomId, by: GeometryRow) {
        let row = id as usize;
        (self.first[row], self.count[row]) = by.numbers();
        self.mask[row] = u32::MAX;
    }

    /// The first geometry that is neither a run of `prims` primitives after those before it, nor
    /// one of `instances` instances after those before it.
    pub(crate) fn first_wrong(&self, prims: usize, instances: usize) -> Option<GeomId> {
        let (mut end, mut next_instance) = (0, 0);
        let is_wrong = |&(_, row): &(GeomId, GeometryRow)| match row {
            GeometryRow::There(Geometry::Prims { count: 0, .. }) => false,
            GeometryRow::There(Geometry::Prims { first, count }) => {
                let place = self.prim_place(first);
                let fits = place.is_some_and(|place| count <= place.prims);
                let overlaps = u64::from(first) < end;
                end = u64::from(first) + u64::from(count);
                overlaps || !fits || end > prims as u64
            }
            GeometryRow::RemovedPrims(first) => {
                let place = self.prim_place(first);
                let overlaps = place.is_some() && u64::from(first) < end;
                end = place.map_or(end, |place| place.all_prims().end.into());
                overlaps || end > prims as u64
            }
            GeometryRow::There(Geometry::Instance(k)) | GeometryRow::RemovedInstance(k) => {
                let overlaps = k < next_instance;
                next_instance = k.saturating_add(1);
                overlaps || k as usize >= instances
            }
        };
        self.rows().find(is_wrong).map(|(id, _)| id)
    }

    /// The first place that is not within these many primitives and vertices, and behind the one
    /// before.
    pub(crate) fn first_wrong_place(&self, prims: usize, vertices: usize) -> Option<usize> {
        let (mut end, mut end_vertex) = (0, 0);
        self.places.iter().position(|&row| {
            let place = PrimPlace::of_row(row);
            let [first, first_vertex] = [place.first_prim, place.first_vertex].map(u64::from);
            let overlaps = first < end || place.vertices > 0 && first_vertex < end_vertex;
            end = first + u64::from(place.prims);
            end_vertex = end_vertex.max(first_vertex + u64::from(place.vertices));
            let is_beyond = end > prims as u64 || end_vertex > vertices as u64;
            overlaps || is_beyond || place.prims == 0 || row[4] > place.vertices
        })
    }

    pub(crate) fn push(&mut self, geometry: Geometry) -> GeomId {
        let id = self.len() as GeomId;
        let (first, count) = GeometryRow::There(geometry).numbers();
        self.first.push(first);
        self.count.push(count);
        self.mask.push(u32::MAX);
        id
    }
}
