//! Single rays from packets, one after another.

use super::ray_state::{RayState, SingleHit, SingleRaySetup, row_offset};
use crate::intersect::aabb::RaySlabs;
use crate::intersect::shear::Shear;
use crate::packet::{RayPacket, RayQueue};
use crate::simd::{F32x8, LANES, LaneMask, LaneU32, Lanes, Mask8, U32x8, Vec3x8};
use crate::traverse::counters::Counters;
use bytemuck::Zeroable;

/// Rays that a stream reads in packets.
pub(crate) trait RayOctets {
    /// The rays of a packet, and the lanes to be traced.
    fn packet(&self, packet: usize) -> (RayPacket<F32x8>, Mask8);

    /// Distance from which on hits of a ray, by its number, do not count.
    fn limit(&self, ray: usize) -> f32;
}

/// Rays of a queue that end at one distance.
pub(super) struct QueueRays<'q, 'a> {
    pub(super) rays: &'q RayQueue<'a>,
    pub(super) tmax: f32,
}

impl RayOctets for QueueRays<'_, '_> {
    #[inline(always)]
    fn packet(&self, packet: usize) -> (RayPacket<F32x8>, Mask8) {
        self.rays.packet(packet, self.tmax)
    }

    #[inline(always)]
    fn limit(&self, _ray: usize) -> f32 {
        self.tmax
    }
}

/// Stream of rays, one after another; test data are computed packet by packet.
pub(super) struct RayStream<'s, S, I> {
    rays: &'s S,
    packets: I,
    /// Code of the node where rays begin.
    root: u32,
    /// Rays of the current packet, by lane.
    ready: [SingleRaySetup; LANES],
    /// Remaining lanes of the packet.
    left: u32,
    packet: usize,
}

impl<'s, S: RayOctets, I: Iterator<Item = usize>> RayStream<'s, S, I> {
    pub(super) fn new(rays: &'s S, packets: I, root: u32) -> RayStream<'s, S, I> {
        RayStream {
            rays,
            packets,
            root,
            ready: [SingleRaySetup::zeroed(); LANES],
            left: 0,
            packet: 0,
        }
    }

    /// Places the next ray at its first node; false if there is none.
    #[inline(always)]
    pub(super) fn next(&mut self, state: &mut RayState, work: &mut impl Counters) -> bool {
        while self.left == 0 {
            if !self.advance(work) {
                return false;
            }
        }
        let lane = self.left.trailing_zeros() as usize % LANES;
        self.left &= self.left - 1;
        let number = self.packet * LANES + lane;
        *state = RayState {
            ray: self.ready[lane],
            best: SingleHit::none_before(self.rays.limit(number)),
            bottom: state.bottom,
            top: state.bottom,
            current: self.root,
            number,
        };
        true
    }

    #[inline(never)]
    fn advance(&mut self, work: &mut impl Counters) -> bool {
        let Some(packet) = self.packets.next() else {
            return false;
        };
        let (rays, active) = self.rays.packet(packet);
        work.begin(1, active.bits().count_ones());
        self.packet = packet;
        self.left = active.bits();
        self.ready = ready(&rays, active);
        true
    }
}

/// Test data of a packet's rays: their columns, transposed to rows.
#[inline(always)]
pub(super) fn ready(rays: &RayPacket<F32x8>, active: Mask8) -> [SingleRaySetup; LANES] {
    let (org, dir) = (rays.org, rays.dir);
    let [rdir, lo, hi] = RaySlabs::columns(org, dir);
    let down = [dir.x, dir.y, dir.z].map(|d| d.lt(F32x8::ZERO));
    let [first, last] = [[lo, hi], [hi, lo]].map(|[down_side, up_side]| {
        Vec3x8::new(
            down[0].select(down_side.x, up_side.x),
            down[1].select(down_side.y, up_side.y),
            down[2].select(down_side.z, up_side.z),
        )
    });
    let by_way = |axis: usize, [down_one, up_one]: [u32; 2]| {
        down[axis].select_u32(U32x8::splat(down_one), U32x8::splat(up_one))
    };
    let row = |axis: usize, sides: [u32; 2]| {
        F32x8::from_bits(by_way(axis, sides.map(|side| row_offset(side, axis))))
    };
    let (near, far) = (|axis| row(axis, [1, 0]), |axis| row(axis, [0, 1]));
    let up = |axis: usize| by_way(axis, [0, 1 << axis]);
    let up = F32x8::from_bits(up(0).or(up(1)).or(up(2)).or(U32x8::splat(1 << 3)));
    let shear = Shear::new(org, dir, active);
    let (axes, frame_org) = shear.columns();
    let [slope_x, slope_y, scale, steepness] = shear.slopes();
    let [kx, ky, kz] = axes.map(F32x8::from_bits);
    // The order is that of the fields of a `SingleRaySetup`.
    let columns = [
        [
            rdir.x, rdir.y, rdir.z, first.x, first.y, first.z, last.x, last.y,
        ],
        [
            last.z,
            near(0),
            near(1),
            near(2),
            far(0),
            far(1),
            far(2),
            kx,
        ],
        [
            ky,
            kz,
            frame_org.x,
            frame_org.y,
            frame_org.z,
            slope_x,
            slope_y,
            scale,
        ],
        [steepness, org.x, org.y, org.z, dir.x, dir.y, dir.z, up],
    ];
    let rows = columns.map(F32x8::transposed);
    std::array::from_fn(|lane| bytemuck::cast(rows.each_ref().map(|run| run[lane])))
}
