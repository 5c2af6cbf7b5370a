//! Dimensions shared by the elements of the building.

use crate::modern::props::LocalFrame;
use glam::{DVec3, dvec3};

/// Seed of all random numbers.
pub(super) const SEED: u64 = 0xa791_0000;
/// Details at which small parts appear, larger ones first: scenes of few triangles have hardly
/// enough for walls and columns.
pub(super) const ARCHIVOLTS: f64 = 0.1;
pub(super) const BASES: f64 = 0.2;
pub(super) const BALUSTERS: f64 = 0.3;
pub(super) const VASES: f64 = 0.4;
pub(super) const RAFTERS: f64 = 0.5;
pub(super) const DOORS: f64 = 0.6;
pub(super) const LANTERNS: f64 = 0.7;
pub(super) const CARVINGS: f64 = 0.8;
pub(super) const LAMPS: f64 = 0.9;
/// Width of a bay, from column to column.
pub(super) const BAY: f64 = 3.0;
/// Bays across the court.
pub(super) const BREADTH: u32 = 4;
/// Half the width of the court, to the columns' axes.
pub(super) const HALF: f64 = BAY * BREADTH as f64 / 2.0;
/// Depth of the aisles, from the columns' axes to the outer wall.
pub(super) const AISLE: f64 = 3.4;
/// Half the thickness of the arcade's wall.
pub(super) const THICK: f64 = 0.27;
/// Projection of the roof into the court.
pub(super) const EAVE: f64 = 0.85;
/// Heights of the eave's lower edge, and of the roof where it meets the outer wall.
pub(super) const ROOF: (f64, f64) = (9.3, 11.0);

/// Heights of a storey, and the radius of its arches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Storey {
    pub(super) floor: f64,
    /// Height at which the arches spring from the columns.
    pub(super) spring: f64,
    /// Upper end of the arcade's wall.
    pub(super) top: f64,
    pub(super) arch: f64,
    /// Radius of the columns, and height of what they stand on.
    pub(super) column: f64,
    pub(super) pedestal: f64,
}

pub(super) const GROUND: Storey = Storey {
    floor: 0.0,
    spring: 3.1,
    top: 4.8,
    arch: 1.12,
    column: 0.235,
    pedestal: 0.14,
};

pub(super) const UPPER: Storey = Storey {
    floor: 5.1,
    spring: 7.45,
    top: 9.0,
    arch: 1.16,
    column: 0.165,
    pedestal: 1.0,
};

/// One side of the court: x runs to the right for an observer in the court, z toward him.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wing {
    pub(super) frame: LocalFrame,
    pub(super) bays: u32,
    /// Extent of its floors beyond both ends: the corners belong to the short sides.
    pub(super) ends: f64,
    pub(super) number: u64,
}

impl Wing {
    pub(super) fn length(&self) -> f64 {
        BAY * f64::from(self.bays)
    }
}

/// The sides of a court of this many bays in length: far, right, near, left.
pub(super) fn wings(bays: u32) -> [Wing; 4] {
    let long = BAY * f64::from(bays) / 2.0;
    let wing = |number, x, z, right, toward, bays, ends| Wing {
        frame: LocalFrame::upright(dvec3(x, 0.0, z), right, toward),
        bays,
        ends,
        number,
    };
    let (x, z) = (DVec3::X, DVec3::Z);
    [
        wing(0, -HALF, -long, x, z, BREADTH, AISLE),
        wing(1, HALF, -long, z, -x, bays, 0.0),
        wing(2, HALF, long, -x, -z, BREADTH, AISLE),
        wing(3, -HALF, long, -z, x, bays, 0.0),
    ]
}
