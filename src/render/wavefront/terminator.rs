//! Smooth surfaces above the hits of a wave, from which shadow rays leave.

use super::hit_grouping::{HitGroups, hits_at};
use super::wavefront_context::WavefrontContext;
use crate::shade::{ShadeLight, TerminatorShift};
use bumpalo::Bump;
use phalanx_scene::SMOOTH_REACH;
use phalanx_trace::packet::{HitPacket, RayQueue};
use phalanx_trace::simd::{LANES, LaneMask, Lanes, Mask8, Vec3x8};

/// The smooth surface above each surface of the wave, without the lanes where something is in the
/// way; empty if the scene's shadows follow its facets. The rays that test the way carry no light,
/// so they are not counted as shadow rays. Surfaces that no light may face need none.
pub(super) fn find_smooth_surfaces<'arena>(
    context: &mut WavefrontContext,
    arena: &'arena Bump,
    groups: &HitGroups,
    hits: &[HitPacket],
) -> &'arena [Option<TerminatorShift>] {
    let (scene, t) = (context.scene, &context.scene.triangles);
    if !scene.smooth_shadows || t.normals.is_empty() || t.vertex_normals.is_empty() {
        return &[];
    }
    let surfaces = groups.surfaces;
    let lights = arena.alloc_slice_fill_with(scene.lights.len(), |k| ShadeLight::of(scene, k));
    let mut queue = RayQueue::with_capacity(arena, surfaces.len() * LANES);
    let shifts = arena.alloc_slice_fill_with(surfaces.len(), |k| {
        let at = &surfaces[k];
        if !lights.iter().any(|light| light.may_face(at).any()) {
            return None;
        }
        let above = TerminatorShift::of(scene, at, &hits_at(at, hits))?;
        let far = above.smooth & above.shift.max_abs().gt(at.offset);
        let org = at.point + at.ng.scale(at.offset);
        let lanes = std::array::from_fn(|lane| (k * LANES + lane) as u32);
        queue.push(far, org, above.shift, Vec3x8::ZERO, &lanes);
        Some(above)
    });
    let blocked = arena.alloc_slice_fill_copy(queue.packets(), 0);
    let all = 0..blocked.len();
    (context.traversal).occluded(&queue, all, SMOOTH_REACH, blocked);
    for (packet, &blocked) in blocked.iter().enumerate() {
        let (_, lanes) = queue.payload(packet);
        let blocked = Mask8::from_bits(u32::from(blocked));
        for lane in blocked.lanes().map(|lane| lanes[lane] as usize) {
            if let Some(above) = &mut shifts[lane / LANES] {
                above.smooth = above.smooth & !Mask8::from_bits(1 << (lane % LANES));
            }
        }
    }
    shifts
}
