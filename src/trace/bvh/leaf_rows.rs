//! LeafRows of primitives in leaf order: each chunk writes its own, in their final memory.

use super::build_input::BuildInput;
use super::clustering::ChunkTree;
use super::huge_pages::{consecutive, zeroed_on_huge_pages};
use super::prim_ref::PrimIndex;
use super::{LeafKind, LeafPrims};
use bytemuck::Zeroable;
use phalanx_scene::{Column, PrimKind};
use rayon::prelude::*;

/// The rows of all objects of chunks, chunk by chunk.
pub(super) fn leaf_rows(input: &BuildInput, chunks: &[ChunkTree]) -> LeafPrims {
    let rows = LeafRows { input, chunks };
    LeafPrims {
        triangles: rows.of(LeafKind::TRIANGLE, |object| input.triangle(object)),
        spheres: rows.of(LeafKind::SPHERE, |object| input.sphere(object)),
        ellipsoids: rows.of(LeafKind::Prim(PrimKind::Ellipsoid), |object| {
            input.ellipsoid(object)
        }),
        cones: rows.of(LeafKind::Prim(PrimKind::Cone), |object| input.cone(object)),
        instances: rows.of(LeafKind::Instance, |object| input.instance(object)),
    }
}

struct LeafRows<'a> {
    input: &'a BuildInput<'a>,
    chunks: &'a [ChunkTree],
}

impl LeafRows<'_> {
    /// The column of a kind.
    fn of<T>(&self, kind: LeafKind, row: impl Fn(PrimIndex) -> T + Sync) -> Column<T>
    where
        T: Zeroable + Send,
    {
        let own = |chunk: &ChunkTree| chunk.slots[kind.number()] as usize;
        let mut column: Vec<T> = zeroed_on_huge_pages(self.chunks.iter().map(own).sum());
        let slices = consecutive(&mut column, self.chunks.iter().map(own));
        let parts = self.chunks.par_iter().zip(slices);
        parts.for_each(|(chunk, part)| {
            let all_one = part.len() == chunk.objects.len();
            let objects = chunk.objects.iter().copied();
            let of_kind = |&object: &PrimIndex| all_one || self.input.kind(object) == kind;
            for (place, object) in part.iter_mut().zip(objects.filter(of_kind)) {
                *place = row(object);
            }
        });
        column.into()
    }
}
