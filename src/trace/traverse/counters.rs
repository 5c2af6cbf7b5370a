//! Counters of a traversal's work, without a clock.
//!
//! The counter is a type parameter of the traversal: [`PacketCount`] costs an addition a packet, as
//! it always did, and [`TraversalStats`] counts everything. Counts do not depend on the machine or
//! its instruction set. So kernels can be compared, also with earlier versions, on any machine.

use crate::bvh::{LeafKind, LeafPrims, Node, SphereBlock, TriangleBlock, WideNode};
use std::mem::size_of;

/// Counter of all or part of a traversal's work.
pub trait Counters: Copy + Default {
    /// True if every step is counted. Such kernels need not be fast: they find closest hits and
    /// occlusion alone, by calls, and one traversal serves them for every tree.
    const COUNTS_STEPS: bool;
    /// Counts begun packets of eight lanes, of which `active` lanes carry rays.
    fn begin(&mut self, packets: u64, active: u32);
    /// Counts a visited node: `lanes` lanes are tested against two boxes.
    fn node(&mut self, lanes: u64);
    /// Counts a visited leaf: `lanes` lanes are tested against `prims` primitives.
    fn leaf(&mut self, kind: LeafKind, lanes: u64, prims: usize);
    /// Counts a visited wide node: `tests` boxes are tested against a ray or a sub-beam.
    fn wide_node(&mut self, tests: u64);
    /// Counts a visited block: `tests` primitives are tested against a ray.
    fn block(&mut self, kind: LeafKind, tests: u64);
    /// Counts `tests` tests of primitives against a ray, in blocks that were counted before.
    fn tests(&mut self, tests: u64);
    /// Adds the counts of another counter.
    fn add(&mut self, other: &Self);
    /// All counts; 0 for those that are not kept.
    fn stats(&self) -> TraversalStats;
}

/// Counter of packets only: what every render counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PacketCount {
    /// Packets of eight lanes traced.
    pub packets: u64,
}

impl Counters for PacketCount {
    const COUNTS_STEPS: bool = false;
    #[inline(always)]
    fn begin(&mut self, packets: u64, _: u32) {
        self.packets += packets;
    }
    #[inline(always)]
    fn node(&mut self, _: u64) {}
    #[inline(always)]
    fn leaf(&mut self, _: LeafKind, _: u64, _: usize) {}
    #[inline(always)]
    fn wide_node(&mut self, _: u64) {}
    #[inline(always)]
    fn block(&mut self, _: LeafKind, _: u64) {}
    #[inline(always)]
    fn tests(&mut self, _: u64) {}
    #[inline(always)]
    fn add(&mut self, other: &PacketCount) {
        self.packets += other.packets;
    }
    fn stats(&self) -> TraversalStats {
        TraversalStats {
            packets: self.packets,
            ..TraversalStats::default()
        }
    }
}

/// Counter of all work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TraversalStats {
    /// Packets of eight lanes traced.
    pub packets: u64,
    /// Lanes of them that carried a ray.
    pub active_lanes: u64,
    /// Nodes visited, once for all lanes of a traversal.
    pub node_visits: u64,
    /// Lanes × boxes tested.
    pub box_tests: u64,
    /// Leaves visited, once for all lanes of a traversal; empty ones count, too.
    pub leaf_visits: u64,
    /// Lanes × primitives tested, instances among them.
    pub prim_tests: u64,
    /// Bytes of the nodes and primitives that were read, regardless of caches.
    pub bytes: u64,
}

impl TraversalStats {
    /// Share of lanes that carried a ray, in \[0, 1\].
    pub fn occupancy(&self) -> Option<f64> {
        let lanes = 8 * self.packets;
        (lanes > 0).then(|| self.active_lanes as f64 / lanes as f64)
    }
}

impl Counters for TraversalStats {
    const COUNTS_STEPS: bool = true;

    fn begin(&mut self, packets: u64, active: u32) {
        self.packets += packets;
        self.active_lanes += u64::from(active);
    }

    fn node(&mut self, lanes: u64) {
        self.node_visits += 1;
        self.box_tests += 2 * lanes;
        self.bytes += size_of::<Node>() as u64;
    }

    fn leaf(&mut self, kind: LeafKind, lanes: u64, prims: usize) {
        self.leaf_visits += 1;
        self.prim_tests += lanes * prims as u64;
        self.bytes += (LeafPrims::row_size(kind) * prims) as u64;
    }

    fn wide_node(&mut self, tests: u64) {
        self.node_visits += 1;
        self.box_tests += tests;
        self.bytes += size_of::<WideNode>() as u64;
    }

    fn block(&mut self, kind: LeafKind, tests: u64) {
        self.leaf_visits += 1;
        self.prim_tests += tests;
        self.bytes += match kind {
            LeafKind::SPHERE => size_of::<SphereBlock>() as u64,
            _ => size_of::<TriangleBlock>() as u64,
        };
    }

    fn tests(&mut self, tests: u64) {
        self.prim_tests += tests;
    }

    fn add(&mut self, other: &TraversalStats) {
        self.packets += other.packets;
        self.active_lanes += other.active_lanes;
        self.node_visits += other.node_visits;
        self.box_tests += other.box_tests;
        self.leaf_visits += other.leaf_visits;
        self.prim_tests += other.prim_tests;
        self.bytes += other.bytes;
    }

    fn stats(&self) -> TraversalStats {
        *self
    }
}
