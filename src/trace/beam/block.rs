//! The triangles of a block, ready to be tested one by one against packets of a beam.

use super::Group;
use super::frame::{Frame, TriangleView};
use crate::bvh::TriangleBlock;
use crate::lanes::{Lanes, NATIVE, Native, Vec3Native};
use crate::trace::aabb::Stay;
use crate::trace::goal::Goal;
use crate::trace::triangle::{self, Columns, OwnBox};

/// Their boxes, by corner, by axis; see [`Columns`].
type Planes = [[Native; 4]; 2];

/// The triangles of a block, for rays that all start at the apex.
pub(super) struct Triangles<'a> {
    pub(super) seen: TriangleView,
    /// Less the origin.
    corners: Columns,
    /// The own boxes.
    own: Planes,
    prim_id: &'a [u32; NATIVE],
}

impl<'a> Triangles<'a> {
    #[inline(always)]
    pub(super) fn new(frame: &Frame, block: &'a TriangleBlock) -> Triangles<'a> {
        let [x, y, z] = frame.center;
        let center = Vec3Native::splat(x, y, z);
        let places = places(block);
        let relative = [places[0] - center, places[1] - center, places[2] - center];
        let own = triangle::own_boxes(places);
        let columns = |v: Vec3Native| [v.x, v.y, v.z, Native::ZERO];
        Triangles {
            seen: frame.triangles(&relative, &own),
            corners: relative.map(columns),
            own: own.map(columns),
            prim_id: &block.prim_id,
        }
    }

    /// Whether any ray of a packet meets one of them, so that the goal took it.
    #[inline(always)]
    pub(super) fn test<L: Lanes>(
        &self,
        lane: usize,
        rays: &Group<L>,
        goal: &mut impl Goal<L>,
    ) -> bool {
        self.meet::<L, false>(lane, rays, goal)
    }

    /// The same for rays whose dominant axes differ. Apart, because it is rare and wants many registers.
    #[cold]
    #[inline(never)]
    pub(super) fn test_apart<L: Lanes>(
        &self,
        lane: usize,
        rays: &Group<L>,
        goal: &mut impl Goal<L>,
    ) -> bool {
        self.meet::<L, true>(lane, rays, goal)
    }

    #[inline(always)]
    fn meet<L: Lanes, const APART: bool>(
        &self,
        lane: usize,
        rays: &Group<L>,
        goal: &mut impl Goal<L>,
    ) -> bool {
        let corners = rays.shear.in_order::<APART>(&self.corners, lane);
        let own = LaneBox {
            rays,
            own: &self.own,
            lane,
        };
        // Most of what is left by now is met, and which is not nobody can foretell.
        let hit = triangle::meet_likely(corners, rays.shear.slopes(), &own);
        goal.take(&hit, self.prim_id[lane % NATIVE])
    }
}

/// The corners of a block's triangles.
#[inline(always)]
pub(super) fn places(block: &TriangleBlock) -> [Vec3Native; 3] {
    let place = |c: &[[f32; NATIVE]; 3]| {
        let [x, y, z] = c.map(Native::new);
        Vec3Native::new(x, y, z)
    };
    let [a, b, c] = &block.corners;
    [place(a), place(b), place(c)]
}

/// The own box of one triangle of a block.
struct LaneBox<'a, L: Lanes> {
    rays: &'a Group<L>,
    own: &'a Planes,
    lane: usize,
}

impl<L: Lanes> OwnBox<L> for LaneBox<'_, L> {
    #[inline(always)]
    fn stay(&self) -> Stay<L> {
        let plane = |side: usize, axis: usize| self.own[side][axis].lane(self.lane % NATIVE);
        let corner = |side: usize| [plane(side, 0), plane(side, 1), plane(side, 2)];
        self.rays.slabs().stay(&[corner(0), corner(1)])
    }

    #[inline(always)]
    fn usual(&self) -> bool {
        self.rays.shear.usual
    }
}
