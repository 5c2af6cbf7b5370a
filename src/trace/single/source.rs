//! Rays of a queue, one after the other.

use super::context::{Context, Hit};
use crate::lanes::{F32x8, LANES, LaneMask, Vec3x8};
use crate::packet::{NO_PRIM, RayQueue};
use crate::trace::aabb::Slabs;
use crate::trace::tally::Tally;
use crate::trace::triangle::{FRAMES, Shear};

/// Rays of a queue one after the other, what tests need of them made packet by packet.
pub(super) struct Source<'q, 'a, I> {
    rays: &'q RayQueue<'a>,
    packets: I,
    tmax: f32,
    /// Of the packet at hand, by lane.
    slabs: [[[f32; LANES]; 3]; 3],
    shear: [[[f32; LANES]; 3]; 2],
    org: [[f32; LANES]; 3],
    dir: [[f32; LANES]; 3],
    axis: [usize; LANES],
    usual: bool,
    /// Lanes of it that are left.
    left: u32,
    packet: usize,
}

impl<'q, 'a, I: Iterator<Item = usize>> Source<'q, 'a, I> {
    pub(super) fn new(rays: &'q RayQueue<'a>, packets: I, tmax: f32) -> Source<'q, 'a, I> {
        Source {
            rays,
            packets,
            tmax,
            slabs: [[[0.0; LANES]; 3]; 3],
            shear: [[[0.0; LANES]; 3]; 2],
            org: [[0.0; LANES]; 3],
            dir: [[0.0; LANES]; 3],
            axis: [0; LANES],
            usual: false,
            left: 0,
            packet: 0,
        }
    }

    /// Puts the next ray at the tree's root; false if there is none.
    #[inline(always)]
    pub(super) fn next(&mut self, context: &mut Context, work: &mut impl Tally) -> bool {
        while self.left == 0 {
            if !self.advance(work) {
                return false;
            }
        }
        let lane = self.left.trailing_zeros() as usize % LANES;
        self.left &= self.left - 1;
        // By reference: copies would be made of whole columns, and read before they are written.
        let of = |columns: &[[f32; LANES]; 3]| columns.each_ref().map(|column| column[lane]);
        let [rdir, lo, hi] = [&self.slabs[0], &self.slabs[1], &self.slabs[2]].map(of);
        let dir = of(&self.dir);
        let side_of = dir.map(|d| usize::from(d < 0.0));
        let pick = |axis: usize, side: usize| {
            if side_of[axis] == side {
                lo[axis]
            } else {
                hi[axis]
            }
        };
        *context = Context {
            rdir,
            first: [pick(0, 1), pick(1, 1), pick(2, 1)],
            last: [pick(0, 0), pick(1, 0), pick(2, 0)],
            near: std::array::from_fn(|axis| side_of[axis] * 3 + axis),
            far: std::array::from_fn(|axis| (1 - side_of[axis]) * 3 + axis),
            up: std::array::from_fn(|axis| axis == 3 || side_of[axis] == 0),
            axes: FRAMES[self.axis[lane] & 3],
            frame_org: of(&self.shear[0]),
            slopes: of(&self.shear[1]),
            usual: self.usual,
            org: of(&self.org),
            dir,
            best: Hit {
                t: self.tmax,
                v: 0.0,
                w: 0.0,
                det: 1.0,
                prim_id: NO_PRIM,
            },
            top: context.bottom,
            bottom: context.bottom,
            current: 0,
            ray: self.packet * LANES + lane,
        };
        true
    }

    #[inline(never)]
    fn advance(&mut self, work: &mut impl Tally) -> bool {
        let Some(packet) = self.packets.next() else {
            return false;
        };
        let (rays, active) = self.rays.packet::<F32x8>(packet, self.tmax);
        work.begin(1, active.bits().count_ones());
        let rows = |v: Vec3x8| [v.x.to_array(), v.y.to_array(), v.z.to_array()];
        self.packet = packet;
        self.left = active.bits();
        self.slabs = Slabs::columns(rays.org, rays.dir).map(rows);
        let shear = Shear::new(rays.org, rays.dir, active);
        let (axis, columns) = shear.columns();
        self.usual = shear.usual;
        self.axis = axis;
        self.shear = columns.map(rows);
        (self.org, self.dir) = (rows(rays.org), rows(rays.dir));
        true
    }
}
