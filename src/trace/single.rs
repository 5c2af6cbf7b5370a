//! Rays on their own down the wide tree, several at a time: a lane is a child of a node, or a primitive of a block.
//!
//! Rays that have parted share neither nodes nor leaves, and most lanes of a packet would idle. Eight children of one
//! node are always there. What a ray on its own waits for is memory and the outcome of its last comparison; so a dozen
//! and more go side by side in steps, all at their nodes, then all at their blocks, then all to what is next, and while
//! one waits another's numbers are there. Nothing branches on what a box test says: all eight children are written
//! above the stack's top in the order of their distances, and the top moves by how many are met.

use super::aabb::{Slabs, Stay};
use super::goal::{AnyHit, Best, Closest, Prepared};
use super::order::{self, Entry};
use super::packet::Tracer;
use super::prefetch::prefetch;
use super::tally::{Packets, Tally};
use super::triangle::{OwnBox, Shear};
use super::{sphere, triangle};
use crate::bvh::{Bvh, LeafKind, SphereBlock, Target, TriangleBlock, Wide};
use crate::lanes::{F32x8, LANES, LaneMask, Lanes, Mask8, U32x8, Vec3x8};
use crate::packet::{HitPacket, NO_PRIM, RayPacket, RayQueue};
use std::ops::Range;

/// Rays side by side.
const CONTEXTS: usize = 16;

/// Packets whose occlusion is asked at once.
const BATCH: usize = 256;

/// One ray under way.
#[derive(Clone, Copy)]
struct Context {
    /// What the slab test needs: see [`Slabs`].
    rdir: [f32; 3],
    first: [f32; 3],
    last: [f32; 3],
    near: [usize; 3],
    /// The axes in the order of the ray's frame, the origin in that order, slopes and scale: see [`Shear`].
    axes: [usize; 3],
    frame_org: [f32; 3],
    slopes: [f32; 3],
    org: [f32; 3],
    dir: [f32; 3],
    best: Hit,
    /// Entries on its stack.
    top: usize,
    /// Where it is.
    current: u32,
    /// Which ray of the queue it is.
    ray: usize,
}

/// The closest hit so far of one ray, as in [`Best`].
#[derive(Clone, Copy)]
struct Hit {
    t: f32,
    v: f32,
    w: f32,
    det: f32,
    prim_id: u32,
}

/// Traces rays of a queue on their own, and counts by `T`.
pub(super) struct Singles<'a, T = Packets> {
    wide: &'a Wide,
    /// For what has no blocks.
    packets: Tracer<'a, F32x8, T>,
    contexts: [Context; CONTEXTS],
    /// A stack for each context, `room` entries long.
    stacks: Vec<Entry>,
    room: usize,
    work: T,
}

impl<'a, T: Tally> Singles<'a, T> {
    pub(super) fn new(bvh: &'a Bvh) -> Singles<'a, T> {
        let wide = bvh.wide();
        // A node takes one entry and writes eight.
        let room = wide.depth() * (LANES - 1) + LANES + 1;
        Singles {
            wide,
            packets: Tracer::counting(bvh),
            contexts: [Context::IDLE; CONTEXTS],
            stacks: vec![0; room * CONTEXTS],
            room,
            work: T::default(),
        }
    }

    /// The closest hits of some packets of a queue, one [`HitPacket`] each.
    pub(super) fn closest(
        &mut self,
        rays: &RayQueue,
        packets: Range<usize>,
        hits: &mut [HitPacket],
    ) {
        let start = packets.start * LANES;
        for hit in hits.iter_mut() {
            *hit = HitPacket::miss();
        }
        self.trace::<false>(rays, packets, f32::INFINITY, |context| {
            let found = &context.best;
            if found.t < f32::INFINITY {
                let at = context.ray - start;
                hits[at / LANES].set(
                    at % LANES,
                    [found.t, found.v / found.det, found.w / found.det],
                    found.prim_id,
                );
            }
        });
    }

    /// Tells `answer`, for some packets of a queue, which lanes (as bits) of each meet nothing before `tmax`.
    pub(super) fn unoccluded(
        &mut self,
        rays: &RayQueue,
        packets: Range<usize>,
        tmax: f32,
        mut answer: impl FnMut(usize, u8),
    ) {
        // As many at once as there is room for on the stack.
        for first in packets.clone().step_by(BATCH) {
            let batch = first..packets.end.min(first + BATCH);
            let mut seen = [0u8; BATCH];
            self.trace::<true>(rays, batch.clone(), tmax, |context| {
                let at = context.ray - first * LANES;
                seen[at / LANES % BATCH] |=
                    u8::from(context.best.prim_id == NO_PRIM) << (at % LANES);
            });
            for (packet, seen) in batch.zip(seen) {
                answer(packet, seen);
            }
        }
    }

    /// Counters since it was made.
    pub(super) fn work(&self) -> T {
        let mut work = self.work;
        work.add(&self.packets.work);
        work
    }

    #[inline(always)]
    fn trace<const ANY: bool>(
        &mut self,
        rays: &RayQueue,
        packets: Range<usize>,
        tmax: f32,
        mut done: impl FnMut(&Context),
    ) {
        let mut source = Source::new(rays, packets, tmax);
        let (mut at_nodes, mut at_leaves) = (List::EMPTY, List::EMPTY);
        for k in 0..CONTEXTS {
            if source.next(&mut self.contexts[k], &mut self.work) {
                at_nodes.push(k);
            }
        }
        while at_nodes.len + at_leaves.len > 0 {
            for k in at_nodes.all() {
                self.open(k);
            }
            for k in at_leaves.all() {
                self.leaf::<ANY>(k);
            }
            let (nodes, leaves) = (at_nodes, at_leaves);
            (at_nodes, at_leaves) = (List::EMPTY, List::EMPTY);
            for k in nodes.all().chain(leaves.all()) {
                if !self.pop(k) {
                    done(&self.contexts[k]);
                    if !source.next(&mut self.contexts[k], &mut self.work) {
                        continue;
                    }
                }
                let leaf = !matches!(Target::of_code(self.contexts[k].current), Target::Node(_));
                at_nodes.push_if(k, !leaf);
                at_leaves.push_if(k, leaf);
            }
        }
    }

    /// Writes the children of the node that a ray is at above its stack's top, farthest first.
    #[inline(always)]
    fn open(&mut self, k: usize) {
        let context = &mut self.contexts[k];
        self.work.wide_node(LANES as u64);
        // SAFETY: a code of the tree is of a row that exists, and this one says node; node 0 exists.
        let node = unsafe { self.wide.nodes().get_unchecked(context.current as usize) };
        let stay = context.stay(&node.boxes);
        let met = stay.within(F32x8::splat(context.best.t));
        let count = met.bits().count_ones() as usize;
        // SAFETY: a node is entered from the root or from an entry that was taken off the stack; so `top` is at most 7
        // for each level above this node's, and there is room for eight more.
        let above = unsafe {
            let first = self.stacks.as_mut_ptr().add(k * self.room + context.top);
            &mut *first.cast::<[Entry; LANES]>()
        };
        order::write(met, stay.enter, &node.children, above);
        context.top += count;
    }

    /// The next entry that the ray still reaches; false if there is none.
    #[inline(always)]
    fn pop(&mut self, k: usize) -> bool {
        let context = &mut self.contexts[k];
        while context.top > 0 {
            context.top -= 1;
            // SAFETY: `top` entries were written.
            let entry = *unsafe { self.stacks.get_unchecked(k * self.room + context.top) };
            if f32::from_bits((entry >> 32) as u32) <= context.best.t {
                context.current = entry as u32;
                self.fetch(k);
                return true;
            }
        }
        false
    }

    /// Asks for what a ray comes to next, which is looked at when all the others have moved, too.
    #[inline(always)]
    fn fetch(&self, k: usize) {
        match Target::of_code(self.contexts[k].current) {
            Target::Node(index) => prefetch(self.wide.nodes(), index),
            Target::Triangles(index) => prefetch(self.wide.triangles(), index),
            Target::Spheres(index) => prefetch(self.wide.spheres(), index),
            Target::Other(_) => {}
        }
    }

    #[inline(always)]
    fn leaf<const ANY: bool>(&mut self, k: usize) {
        let context = &mut self.contexts[k];
        match Target::of_code(context.current) {
            Target::Triangles(index) => {
                self.work.block(LeafKind::Triangle, LANES as u64);
                // SAFETY: a code of the tree is of a row that exists.
                let block = unsafe { self.wide.triangles().get_unchecked(index as usize) };
                context.triangles::<ANY>(block);
            }
            Target::Spheres(index) => {
                self.work.block(LeafKind::Sphere, LANES as u64);
                // SAFETY: as above.
                let block = unsafe { self.wide.spheres().get_unchecked(index as usize) };
                context.spheres::<ANY>(block);
            }
            Target::Other(index) => self.other::<ANY>(k, index),
            Target::Node(_) => {}
        }
    }

    /// A leaf of what has no blocks, by the packet's tests, in one lane.
    #[inline(never)]
    fn other<const ANY: bool>(&mut self, k: usize, index: u32) {
        let leaf = self.wide.others()[index as usize];
        let slots = leaf.first as usize..(leaf.first + leaf.count) as usize;
        let context = &mut self.contexts[k];
        let ray = RayPacket {
            org: Vec3x8::splat(context.org[0], context.org[1], context.org[2]),
            dir: Vec3x8::splat(context.dir[0], context.dir[1], context.dir[2]),
            tmax: F32x8::splat(f32::INFINITY),
        };
        let active = Mask8::first(1);
        let prepared = Prepared::new(&ray, active);
        let limit = active.select(
            F32x8::splat(context.best.t),
            F32x8::splat(f32::NEG_INFINITY),
        );
        if ANY {
            let mut goal = AnyHit::new(limit, active);
            self.packets
                .leaf_alone(&prepared, &mut goal, leaf.kind, slots);
            if goal.blocked().any() {
                context.block();
            }
        } else {
            let mut goal = Closest {
                best: context.best.spread(limit),
            };
            self.packets
                .leaf_alone(&prepared, &mut goal, leaf.kind, slots);
            context.best = Hit::of(&goal.best);
        }
    }
}

impl Context {
    const IDLE: Context = Context {
        rdir: [0.0; 3],
        first: [0.0; 3],
        last: [0.0; 3],
        near: [0; 3],
        axes: [0; 3],
        frame_org: [0.0; 3],
        slopes: [0.0; 3],
        org: [0.0; 3],
        dir: [0.0; 3],
        best: Hit {
            t: 0.0,
            v: 0.0,
            w: 0.0,
            det: 1.0,
            prim_id: NO_PRIM,
        },
        top: 0,
        current: 0,
        ray: 0,
    };

    /// The ray's stays in eight boxes: the arithmetic of [`Slabs::stay_ordered`], with the lanes' parts exchanged.
    #[inline(always)]
    fn stay(&self, boxes: &[[[f32; LANES]; 3]; 2]) -> Stay<F32x8> {
        let enter = |axis: usize| {
            let plane = F32x8::new(boxes[self.near[axis] & 1][axis]);
            (plane - F32x8::splat(self.first[axis])) * F32x8::splat(self.rdir[axis])
        };
        let leave = |axis: usize| {
            let plane = F32x8::new(boxes[(self.near[axis] & 1) ^ 1][axis]);
            (plane - F32x8::splat(self.last[axis])) * F32x8::splat(self.rdir[axis])
        };
        Stay {
            enter: enter(0).max(enter(1)).max(enter(2)).max(F32x8::ZERO),
            leave: leave(0).min(leave(1)).min(leave(2)),
        }
    }

    #[inline(always)]
    fn triangles<const ANY: bool>(&mut self, block: &TriangleBlock) {
        let [kx, ky, kz] = self.axes.map(|axis| axis % 3);
        let column = |corner: usize, axis: usize| F32x8::new(block.corners[corner][axis]);
        let corner = |c: usize| {
            Vec3x8::new(
                column(c, kx) - F32x8::splat(self.frame_org[0]),
                column(c, ky) - F32x8::splat(self.frame_org[1]),
                column(c, kz) - F32x8::splat(self.frame_org[2]),
            )
        };
        let corners = [corner(0), corner(1), corner(2)];
        let slopes = self.slopes.map(F32x8::splat);
        let own = BlockBox {
            context: self,
            block,
        };
        let found = triangle::meet(corners, slopes, &own);
        if let Some(hit) = found {
            self.take::<ANY>(hit.valid, hit.t, [hit.v, hit.w, hit.det], &block.prim_id);
        }
    }

    #[inline(always)]
    fn spheres<const ANY: bool>(&mut self, block: &SphereBlock) {
        let column = |axis: usize| F32x8::splat(self.org[axis]) - F32x8::new(block.center[axis]);
        let from_center = Vec3x8::new(column(0), column(1), column(2));
        let dir = Vec3x8::splat(self.dir[0], self.dir[1], self.dir[2]);
        if let Some(roots) = sphere::roots(from_center, dir, F32x8::new(block.radius)) {
            let (valid, t) = sphere::nearest(roots, self.stay(&block.own_box));
            let bare = [F32x8::ZERO, F32x8::ZERO, F32x8::ONE];
            self.take::<ANY>(valid, t, bare, &block.prim_id);
        }
    }

    /// [`Context::stay`], for boxes that are in registers.
    #[inline(always)]
    fn stay_in(&self, [lo, hi]: [Vec3x8; 2]) -> Stay<F32x8> {
        let enter = |axis: usize, lo: F32x8, hi: F32x8| {
            let near = if self.near[axis] == 0 { lo } else { hi };
            (near - F32x8::splat(self.first[axis])) * F32x8::splat(self.rdir[axis])
        };
        let leave = |axis: usize, lo: F32x8, hi: F32x8| {
            let far = if self.near[axis] == 0 { hi } else { lo };
            (far - F32x8::splat(self.last[axis])) * F32x8::splat(self.rdir[axis])
        };
        let (x, y, z) = ((0, lo.x, hi.x), (1, lo.y, hi.y), (2, lo.z, hi.z));
        let first = enter(x.0, x.1, x.2).max(enter(y.0, y.1, y.2));
        let last = leave(x.0, x.1, x.2).min(leave(y.0, y.1, y.2));
        Stay {
            enter: first.max(enter(z.0, z.1, z.2)).max(F32x8::ZERO),
            leave: last.min(leave(z.0, z.1, z.2)),
        }
    }

    /// Takes what is closer than the best, or as close with a smaller number.
    #[inline(always)]
    fn take<const ANY: bool>(
        &mut self,
        valid: Mask8,
        t: F32x8,
        weights: [F32x8; 3],
        ids: &[u32; LANES],
    ) {
        let limit = F32x8::splat(self.best.t);
        if ANY {
            if (valid & t.lt(limit)).any() {
                self.block();
            }
            return;
        }
        let near = valid & t.le(limit);
        if !near.any() {
            return;
        }
        let (t, [v, w, det]) = (t.to_array(), weights.map(F32x8::to_array));
        for lane in near.lanes() {
            let id = ids[lane];
            if t[lane] < self.best.t || (t[lane] == self.best.t && id < self.best.prim_id) {
                self.best = Hit {
                    t: t[lane],
                    v: v[lane],
                    w: w[lane],
                    det: det[lane],
                    prim_id: id,
                };
            }
        }
    }

    /// Something is in the way: nothing is left to visit.
    fn block(&mut self) {
        self.best.prim_id = 0;
        self.top = 0;
    }
}

/// The own boxes of a block's triangles.
struct BlockBox<'a> {
    context: &'a Context,
    block: &'a TriangleBlock,
}

impl OwnBox<F32x8> for BlockBox<'_> {
    #[inline(always)]
    fn stay(&self) -> Stay<F32x8> {
        let [a, b, c] = &self.block.corners;
        let all = |corner: &[[f32; LANES]; 3]| {
            Vec3x8::new(
                F32x8::new(corner[0]),
                F32x8::new(corner[1]),
                F32x8::new(corner[2]),
            )
        };
        self.context.stay_in(triangle::own_boxes([all(a), all(b), all(c)]))
    }
}

impl Hit {
    /// In every lane, `limit` being its distance.
    fn spread(&self, limit: F32x8) -> Best<F32x8> {
        Best {
            t: limit,
            v: F32x8::splat(self.v),
            w: F32x8::splat(self.w),
            det: F32x8::splat(self.det),
            prim_id: <U32x8 as crate::lanes::LaneIds<Mask8>>::splat(self.prim_id),
        }
    }

    /// Of the first lane.
    fn of(best: &Best<F32x8>) -> Hit {
        Hit {
            t: best.t.lane(0),
            v: best.v.lane(0),
            w: best.w.lane(0),
            det: best.det.lane(0),
            prim_id: best.prim_id.lane(0),
        }
    }
}

/// Numbers of contexts.
#[derive(Clone, Copy)]
struct List {
    numbers: [u8; CONTEXTS],
    len: usize,
}

impl List {
    const EMPTY: List = List {
        numbers: [0; CONTEXTS],
        len: 0,
    };

    #[inline(always)]
    fn push(&mut self, number: usize) {
        self.push_if(number, true);
    }

    /// Written always, kept where it holds: no branch.
    #[inline(always)]
    fn push_if(&mut self, number: usize, holds: bool) {
        // Each context is in one list only, so it is never full before.
        self.numbers[self.len % CONTEXTS] = number as u8;
        self.len += usize::from(holds);
    }

    #[inline(always)]
    fn all(&self) -> impl Iterator<Item = usize> {
        let List { numbers, len } = *self;
        (0..len).map(move |k| usize::from(numbers[k % CONTEXTS]) % CONTEXTS)
    }
}

/// Rays of a queue one after the other, what tests need of them made packet by packet.
struct Source<'q, 'a> {
    rays: &'q RayQueue<'a>,
    packets: Range<usize>,
    tmax: f32,
    /// Of the packet at hand, by lane.
    slabs: [[[f32; LANES]; 3]; 3],
    shear: [[[f32; LANES]; 3]; 2],
    org: [[f32; LANES]; 3],
    dir: [[f32; LANES]; 3],
    axis: [usize; LANES],
    /// Lanes of it that are left.
    left: u32,
    packet: usize,
}

impl<'q, 'a> Source<'q, 'a> {
    fn new(rays: &'q RayQueue<'a>, packets: Range<usize>, tmax: f32) -> Source<'q, 'a> {
        Source {
            rays,
            packets,
            tmax,
            slabs: [[[0.0; LANES]; 3]; 3],
            shear: [[[0.0; LANES]; 3]; 2],
            org: [[0.0; LANES]; 3],
            dir: [[0.0; LANES]; 3],
            axis: [0; LANES],
            left: 0,
            packet: 0,
        }
    }

    /// Puts the next ray at the tree's root; false if there is none.
    #[inline(always)]
    fn next(&mut self, context: &mut Context, work: &mut impl Tally) -> bool {
        while self.left == 0 {
            if !self.advance(work) {
                return false;
            }
        }
        let lane = self.left.trailing_zeros() as usize % LANES;
        self.left &= self.left - 1;
        let of = |columns: &[[f32; LANES]; 3]| columns.map(|column| column[lane]);
        let [rdir, lo, hi] = [&self.slabs[0], &self.slabs[1], &self.slabs[2]].map(of);
        let dir = of(&self.dir);
        let near = dir.map(|d| usize::from(d < 0.0));
        let pick = |axis: usize, side: usize| {
            if near[axis] == side {
                lo[axis]
            } else {
                hi[axis]
            }
        };
        let axes = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];
        *context = Context {
            rdir,
            first: [pick(0, 1), pick(1, 1), pick(2, 1)],
            last: [pick(0, 0), pick(1, 0), pick(2, 0)],
            near,
            axes: axes[self.axis[lane] % 3],
            frame_org: of(&self.shear[0]),
            slopes: of(&self.shear[1]),
            org: of(&self.org),
            dir,
            best: Hit {
                t: self.tmax,
                v: 0.0,
                w: 0.0,
                det: 1.0,
                prim_id: NO_PRIM,
            },
            top: 0,
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
        self.axis = axis;
        self.shear = columns.map(rows);
        (self.org, self.dir) = (rows(rays.org), rows(rays.dir));
        true
    }
}
