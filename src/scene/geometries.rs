//! The numbers by which hits name what was added together.

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

/// One entry per geometry, in the order of [`GeomId`].
#[derive(Clone, Debug, Default)]
pub struct Geometries(Vec<Geometry>);

impl Geometries {
    /// Number of geometries.
    #[inline]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Tells if nothing was added as a geometry.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = (GeomId, &Geometry)> {
        (0..).zip(&self.0)
    }

    pub(crate) fn push(&mut self, geometry: Geometry) -> GeomId {
        let id = self.0.len() as GeomId;
        self.0.push(geometry);
        id
    }
}
