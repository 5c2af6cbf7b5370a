//! Triangles that shadow rays may hit: looked at, and then tested, those of several blocks at a time.
//!
//! For any hit the order does not matter, so blocks wait until there are [`BLOCKS`] of them. How many pairs of a cell and a
//! triangle one leaves cannot be foretold, and a loop that ends where nobody expects it takes as long as three looks.

use super::Group;
use super::block::{Pair, places};
use super::descend::Descent;
use super::look::{Look, Seen};
use super::pairs::{BLOCKS, Pairs};
use crate::bvh::{LeafKind, TriangleBlock};
use crate::simd::{LANES, LaneMask, Lanes, NATIVE};
use crate::traverse::goal::Goal;
use crate::traverse::tally::Tally;
use crate::traverse::triangle::MIXED;

/// What waits.
pub(super) struct Waiting<'a> {
    /// Blocks, and the cells that may meet them.
    blocks: [Option<&'a TriangleBlock>; BLOCKS],
    cells: [u64; BLOCKS],
    count: usize,
    looks: [Look; BLOCKS],
    pub(super) pairs: Pairs,
}

impl Waiting<'_> {
    pub(super) fn none() -> Self {
        Waiting {
            blocks: [None; BLOCKS],
            cells: [0; BLOCKS],
            count: 0,
            looks: [Look::NONE; BLOCKS],
            pairs: Pairs::none(),
        }
    }
}

impl<'a, L: Lanes, G: Goal<L>, T: Tally> Descent<'_, 'a, L, G, T> {
    /// Puts off a block that some cells may meet.
    #[inline(always)]
    pub(super) fn await_test(
        &mut self,
        block: &'a TriangleBlock,
        cells: u64,
        waiting: &mut Waiting<'a>,
    ) {
        let slot = waiting.count % BLOCKS;
        (waiting.blocks[slot], waiting.cells[slot]) = (Some(block), cells);
        waiting.count += 1;
        if waiting.count == BLOCKS {
            self.test_waiting(waiting);
        }
    }

    /// Looks at the triangles that wait, and tests what is left of them.
    #[inline(never)]
    pub(super) fn test_waiting(&mut self, waiting: &mut Waiting<'a>) {
        waiting.pairs.count = 0;
        let waits = waiting.blocks.iter().zip(waiting.cells).take(waiting.count);
        for (slot, (block, cells)) in waits.enumerate() {
            let Some(block) = block else { continue };
            self.work.block(LeafKind::Triangle, 0);
            let places = places(block);
            let seen = self.frame.triangles(&places, &self.frame.relative(&places));
            let look = &mut waiting.looks[slot];
            *look = Look::new(self.frame, self.cells.around(), &seen, &places);
            let mut left = cells;
            while left != 0 {
                let cell = left.trailing_zeros() as usize;
                left &= left - 1;
                let lanes = self.cells.sees(cell, look, &seen.own);
                waiting.pairs.add(cell, slot, lanes);
            }
        }
        let (looks, pairs) = (&waiting.looks, &mut waiting.pairs);
        pairs.retain(|cell, place| {
            let group = self.cells.group(cell);
            // SAFETY: a cell is of a packet of this beam, each of which has its place in all three.
            let (rays, seen, goal) = unsafe {
                (
                    self.groups.get_unchecked(group),
                    self.projected.get_unchecked(group),
                    self.goals.get_unchecked(group),
                )
            };
            let seen = Seen {
                p: seen[1],
                q: seen[2],
                org: &rays.rays.org,
            };
            let may = looks[place / NATIVE % BLOCKS].may_hit(place % NATIVE, &seen);
            (may & goal.limit().gt(L::ZERO)).any()
        });
        let mut touched = 0u64;
        for k in 0..pairs.count {
            let (cell, place) = pairs.get(k);
            let group = self.cells.group(cell);
            let (slot, lane) = (place / NATIVE % BLOCKS, place % NATIVE);
            let Some(block) = waiting.blocks[slot] else {
                continue;
            };
            // SAFETY: as above.
            let rays = unsafe { self.groups.get_unchecked(group) };
            // SAFETY: as above.
            let goal = unsafe { self.goals.get_unchecked_mut(group) };
            let met = match rays.shear.axis {
                MIXED => test_apart(block, lane, rays, goal),
                _ => test::<L, false>(block, lane, rays, goal),
            };
            touched |= u64::from(met) << cell;
        }
        self.work.tests((pairs.count * L::PACKETS * LANES) as u64);
        waiting.count = 0;
        self.touch(touched);
    }
}

/// For rays whose dominant axes differ. Apart, because it is rare and wants many registers.
#[cold]
#[inline(never)]
fn test_apart<L: Lanes>(
    block: &TriangleBlock,
    lane: usize,
    rays: &Group<L>,
    goal: &mut impl Goal<L>,
) -> bool {
    test::<L, true>(block, lane, rays, goal)
}

/// Whether any ray of a packet meets a triangle, so that the goal took it.
#[inline(always)]
fn test<L: Lanes, const APART: bool>(
    block: &TriangleBlock,
    lane: usize,
    rays: &Group<L>,
    goal: &mut impl Goal<L>,
) -> bool {
    let corners = rays.shear.less_origins::<APART>(block, lane);
    Pair { rays, block, lane }.meet(corners, goal)
}
