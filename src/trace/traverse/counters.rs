//! What a traversal did, counted without a clock.
//!
//! The counter is a type parameter of the traversal: [`PacketCount`] costs what it always cost, an
//! addition a packet, and [`TraversalStats`] counts everything. Counts do not depend on the machine
//! or its instruction set, so kernels can be compared, and held against yesterday's, on any.

use crate::bvh::{
    LeafCone, LeafEllipsoid, LeafInstance, LeafKind, LeafSphere, LeafTriangle, Node, SphereBlock,
    TriangleBlock, WideNode,
};
use std::mem::size_of;

/// Counts what a traversal does, or part of it.
pub trait Counters: Copy + Default {
    /// Packets begin: so many of eight lanes, `active` lanes of which carry rays.
    fn begin(&mut self, packets: u64, active: u32);
    /// A node is visited: `lanes` lanes are tested against two boxes.
    fn node(&mut self, lanes: u64);
    /// A leaf is visited: `lanes` lanes are tested against `prims` primitives.
    fn leaf(&mut self, kind: LeafKind, lanes: u64, prims: usize);
    /// A wide node is visited, and `tests` boxes are tested against a ray or a cell of a beam.
    fn wide_node(&mut self, tests: u64);
    /// A block is visited, and `tests` primitives are tested against a ray.
    fn block(&mut self, kind: LeafKind, tests: u64);
    /// So many primitives, of blocks that were visited before, are tested against a ray.
    fn tests(&mut self, tests: u64);
    /// Adds what another counted.
    fn add(&mut self, other: &Self);
}

/// Packets only: what every render counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PacketCount {
    /// Packets of eight lanes traced.
    pub packets: u64,
}

impl Counters for PacketCount {
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
}

/// Everything.
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
    /// Bytes of nodes and primitives that were asked for, caches not considered.
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
        self.bytes += (slot_bytes(kind) * prims) as u64;
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
            LeafKind::Sphere => size_of::<SphereBlock>() as u64,
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
}

fn slot_bytes(kind: LeafKind) -> usize {
    match kind {
        LeafKind::Sphere => size_of::<LeafSphere>(),
        LeafKind::Ellipsoid => size_of::<LeafEllipsoid>(),
        LeafKind::Triangle => size_of::<LeafTriangle>(),
        LeafKind::Cone => size_of::<LeafCone>(),
        LeafKind::Instance => size_of::<LeafInstance>(),
    }
}
