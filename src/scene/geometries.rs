//! Geometry numbers: the primitives that were added together.

use crate::column::Column;
use std::ops::Range;

/// Number of a geometry, from 0 in the order in which geometries were added.
///
/// A geometry is what one call of `Scene::add_mesh`, `Scene::add_spheres` or `Scene::add_instance`
/// added.
pub type GeomId = u32;

/// Geometry of a miss, and of primitives that were added one by one: 2³² − 1.
pub const NO_GEOM: GeomId = GeomId::MAX;

/// Primitives that were added together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Geometry {
    /// A run of stored primitives.
    Prims { first: u32, count: u32 },
    /// An instance.
    Instance(u32),
}

impl Geometry {
    fn of(first: u32, count: u32) -> Geometry {
        match count {
            INSTANCE => Geometry::Instance(first),
            count => Geometry::Prims { first, count },
        }
    }
}

/// Count of a geometry that is an instance.
const INSTANCE: u32 = u32::MAX;

/// One row per geometry, in the order of [`GeomId`].
#[derive(Clone, Debug, Default)]
pub struct Geometries {
    /// First primitive, or number of the instance.
    pub first: Column<u32>,
    /// Number of primitives; 2³² − 1 for an instance.
    pub count: Column<u32>,
    /// Bits that a ray's mask must share: see [`Scene::set_mask`](crate::Scene::set_mask).
    pub mask: Column<u32>,
    /// Meshes that were added as slices, prototypes among them, ascending: the first primitive, the
    /// first vertex, and the number of vertices.
    pub vertex_runs: Column<[u32; 3]>,
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

    pub(crate) fn iter(&self) -> impl Iterator<Item = (GeomId, Geometry)> {
        let rows = self.first.iter().zip(self.count.iter());
        (0..).zip(rows.map(|(&first, &count)| Geometry::of(first, count)))
    }

    /// The vertices of the mesh whose first primitive is this one.
    pub(crate) fn vertices(&self, first_prim: u32) -> Option<Range<usize>> {
        let run = self
            .vertex_runs
            .binary_search_by_key(&first_prim, |run| run[0]);
        let [_, first, count] = self.vertex_runs[run.ok()?];
        Some(first as usize..first as usize + count as usize)
    }

    /// The geometries that no ray hits.
    pub(crate) fn hidden(&self) -> impl Iterator<Item = Geometry> {
        let rows = self.iter().zip(self.mask.iter());
        rows.filter_map(|((_, geometry), &mask)| (mask == 0).then_some(geometry))
    }

    /// The geometry of this number.
    pub(crate) fn get(&self, id: GeomId) -> Option<Geometry> {
        let row = self.first.get(id as usize).zip(self.count.get(id as usize));
        row.map(|(&first, &count)| Geometry::of(first, count))
    }

    /// The first geometry that is neither a run of `prims` primitives after those before it, nor
    /// one of `instances` instances after those before it.
    pub(crate) fn first_wrong(&self, prims: usize, instances: usize) -> Option<GeomId> {
        let (mut end, mut next_instance) = (0, 0);
        let is_wrong = |&(_, geometry): &(GeomId, Geometry)| match geometry {
            Geometry::Prims { first, count } => {
                let overlaps = count > 0 && u64::from(first) < end;
                end = end.max(u64::from(first) + u64::from(count));
                overlaps || end > prims as u64
            }
            Geometry::Instance(k) => {
                let overlaps = k < next_instance;
                next_instance = k.saturating_add(1);
                overlaps || k as usize >= instances
            }
        };
        self.iter().find(is_wrong).map(|(id, _)| id)
    }

    pub(crate) fn push(&mut self, geometry: Geometry) -> GeomId {
        let id = self.len() as GeomId;
        let (first, count) = match geometry {
            Geometry::Prims { first, count } => (first, count),
            Geometry::Instance(number) => (number, INSTANCE),
        };
        self.first.push(first);
        self.count.push(count);
        self.mask.push(u32::MAX);
        id
    }
}
