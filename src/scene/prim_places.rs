//! Places of geometries: rows that stay theirs until they are removed.

use std::ops::Range;

/// Kind of a place, which only its equals can take.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum PlaceKind {
    /// A geometry without primitives.
    Nothing,
    Mesh,
    Spheres,
    Instance,
    Prototype,
}

/// Rows of what was added as slices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PrimPlace {
    pub(crate) first_prim: u32,
    /// Number of primitives that fit.
    pub(crate) prims: u32,
    pub(crate) first_vertex: u32,
    /// Number of vertices that fit; none of spheres.
    pub(crate) vertices: u32,
}

/// A place of something that was removed, ordered by what fits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct FreePlace {
    pub(crate) kind: PlaceKind,
    pub(crate) prims: u32,
    pub(crate) vertices: u32,
    /// The geometry, or the prototype.
    pub(crate) number: u32,
}

impl PrimPlace {
    /// From a row of the column of places.
    pub(crate) fn of_row([first_prim, prims, first_vertex, vertices, _]: [u32; 5]) -> PrimPlace {
        PrimPlace {
            first_prim,
            prims,
            first_vertex,
            vertices,
        }
    }

    /// All primitives that fit.
    pub fn all_prims(&self) -> Range<u32> {
        self.first_prim..self.first_prim.saturating_add(self.prims)
    }
}
