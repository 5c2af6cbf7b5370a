//! Eight triangles, ready to be tested one by one against packets of a beam.

use super::frame::{Frame, TriangleView};
use crate::bvh::TriangleBlock;
use crate::lanes::{F32x8, LANES, Lanes, Vec3Lanes, Vec3x8};
use crate::trace::aabb::{Slabs, Stay};
use crate::trace::goal::{Goal, Prepared};
use crate::trace::triangle::{self, Columns, OwnBox};

/// A box or two corners of eight, by corner, by axis; see [`Columns`].
type Planes = [[F32x8; 4]; 2];

/// The triangles of a block. `SHARED` says that all rays start at the apex: then what belongs to the triangle and the origin
/// alone is made once.
pub(super) struct Triangles<'a, const SHARED: bool> {
    pub(super) seen: TriangleView,
    /// Less the origin, where it is shared.
    corners: Columns,
    /// The own boxes; less the origin moved up and down, where it is shared: see [`Slabs::stay_from`].
    own: Planes,
    prim_id: &'a [u32; LANES],
}

impl<'a, const SHARED: bool> Triangles<'a, SHARED> {
    #[inline(always)]
    pub(super) fn new(frame: &Frame, block: &'a TriangleBlock) -> Triangles<'a, SHARED> {
        let [x, y, z] = frame.center;
        let center = Vec3x8::splat(x, y, z);
        let place = |c: &[[f32; LANES]; 3]| {
            let [x, y, z] = c.map(F32x8::new);
            Vec3x8::new(x, y, z)
        };
        let [a, b, c] = &block.corners;
        let places = [place(a), place(b), place(c)];
        let relative = [places[0] - center, places[1] - center, places[2] - center];
        let [lo, hi] = triangle::own_boxes(places);
        let seen = frame.triangles(&relative, &[[lo.x, lo.y, lo.z], [hi.x, hi.y, hi.z]]);
        // Lower planes less the origin moved up: away from the box.
        let [down, up] = Slabs::moved(center);
        let own = if SHARED {
            [lo - up, hi - down]
        } else {
            [lo, hi]
        };
        Triangles {
            seen,
            corners: columns(if SHARED { &relative } else { &places }),
            own: columns(&own),
            prim_id: &block.prim_id,
        }
    }

    /// Whether any ray of a packet meets one of them; if so, the goal is told.
    #[inline(always)]
    pub(super) fn test<L: Lanes>(
        &self,
        lane: usize,
        rays: &Prepared<L>,
        goal: &mut impl Goal<L>,
    ) -> bool {
        let corners = if SHARED {
            rays.shear.in_order(&self.corners, lane)
        } else {
            rays.shear.less_origins(&self.corners, lane)
        };
        self.meet(lane, corners, rays, goal)
    }

    /// The same for rays whose dominant axes differ. Apart, because it is rare and wants many registers.
    #[cold]
    #[inline(never)]
    pub(super) fn test_mixed<L: Lanes>(
        &self,
        lane: usize,
        rays: &Prepared<L>,
        goal: &mut impl Goal<L>,
    ) -> bool {
        let corners = if SHARED {
            rays.shear.in_mixed_order(&self.corners, lane)
        } else {
            rays.shear.less_origins_mixed(&self.corners, lane)
        };
        self.meet(lane, corners, rays, goal)
    }

    #[inline(always)]
    fn meet<L: Lanes>(
        &self,
        lane: usize,
        corners: [Vec3Lanes<L>; 3],
        rays: &Prepared<L>,
        goal: &mut impl Goal<L>,
    ) -> bool {
        let own = LaneBox::<_, SHARED> {
            slabs: &rays.slabs,
            planes: &self.own,
            lane,
        };
        match triangle::meet(corners, rays.shear.slopes(), &own) {
            Some(hit) => {
                goal.take(&hit, self.prim_id[lane % LANES]);
                true
            }
            None => false,
        }
    }
}

/// The own box of one triangle of a block.
struct LaneBox<'a, L: Lanes, const SHARED: bool> {
    slabs: &'a Slabs<L>,
    planes: &'a Planes,
    lane: usize,
}

impl<L: Lanes, const SHARED: bool> OwnBox<L> for LaneBox<'_, L, SHARED> {
    #[inline(always)]
    fn stay(&self) -> Stay<L> {
        if SHARED {
            return self.slabs.stay_from(self.planes, self.lane);
        }
        let plane = |side: usize, axis: usize| self.planes[side][axis].lane(self.lane % LANES);
        let corner = |side: usize| [plane(side, 0), plane(side, 1), plane(side, 2)];
        self.slabs.stay(&[corner(0), corner(1)])
    }
}

/// In memory, to be read lane by lane.
#[inline(always)]
fn columns<const N: usize>(vectors: &[Vec3x8; N]) -> [[F32x8; 4]; N] {
    vectors.map(|v| [v.x, v.y, v.z, F32x8::ZERO])
}
