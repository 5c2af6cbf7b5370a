//! Hits grouped by kind and material: eight surfaces of one kind and material are shaded together.

use super::ray_batch::QueueSlice;
use crate::shade::{
    MaterialRow, ShadeGroup, ShadeMaterial, Surface, TerminatorShift, VariedMaterial, surface,
};
use bumpalo::Bump;
use phalanx_scene::{PrimKind, Scene};
use phalanx_trace::packet::{HitPacket, NO_PRIM, RayPacket, packets_for};
use phalanx_trace::simd::{F32x8, LANES, LaneMask, LaneU32, Lanes, Mask8, U32x8};

/// The hits of a wave, as surfaces of eight.
#[derive(Clone, Copy)]
pub(crate) struct HitGroups<'arena> {
    pub(crate) surfaces: &'arena [Surface],
    /// The hits of the wave, one packet per packet of rays.
    pub(super) hits: &'arena [HitPacket],
    /// The row of each surface's material.
    rows: &'arena [MaterialRow],
    /// The varied parameters of each surface's material; empty if the scene has neither textures
    /// nor vertex colours, so that such a scene does not pay for them.
    varied: &'arena [VariedMaterial],
    /// The smooth surface above each surface, for shadow rays; empty if there is none.
    pub(super) above: &'arena [Option<TerminatorShift>],
}

impl<'arena> HitGroups<'arena> {
    /// Reads the materials of surfaces, and applies textures and vertex colours where there are
    /// any.
    pub(super) fn new(
        arena: &'arena Bump,
        scene: &Scene,
        surfaces: &'arena [Surface],
        hits: &'arena [HitPacket],
    ) -> HitGroups<'arena> {
        let is_unvaried = scene.textures.is_empty() && scene.triangles.colors.is_empty();
        let varied: &[VariedMaterial] = if is_unvaried {
            &[]
        } else {
            arena.alloc_slice_fill_iter(surfaces.iter().map(|surface| {
                VariedMaterial::of(scene, surface.material, &hits_at(surface, hits))
            }))
        };
        HitGroups {
            surfaces,
            hits,
            rows: material_rows(arena, scene, surfaces),
            varied,
            above: &[],
        }
    }

    /// The material of the surface `k`.
    #[inline(always)]
    pub(super) fn material(&self, k: usize) -> ShadeMaterial<'_> {
        ShadeMaterial {
            row: &self.rows[k],
            varied: self.varied.get(k),
        }
    }
}

/// A [`ShadeGroup`] in one word: kind in the upper bits, then the bit for instances, then the
/// material.
type ShadeKey = u32;

const KIND_SHIFT: u32 = ShadeKey::BITS - PrimKind::BITS;

const INSTANCED: ShadeKey = 1 << (KIND_SHIFT - 1);

fn shade_key(scene: &Scene, prim_id: u32) -> ShadeKey {
    let placed = scene.resolve(prim_id);
    let kind = scene.prims[placed.prim as usize].kind() as u32;
    let instanced = if placed.instance.is_some() { INSTANCED } else { 0 };
    kind << KIND_SHIFT | instanced | scene.prim_material(placed.prim)
}

/// The key of every hit of a scene of one kind and one material, such as a scanned mesh. It saves
/// two look-ups per hit.
fn uniform_key(scene: &Scene) -> Option<ShadeKey> {
    if !scene.instances.is_empty() {
        return None;
    }
    let of_first_kind = scene.count(scene.prims.first()?.kind());
    let one = scene.materials.len() == 1 && of_first_kind == scene.prim_count();
    one.then(|| shade_key(scene, 0))
}

/// A hit to be regrouped: its key in the upper half, the ray's index in the wave in the lower.
type HitKey = u64;

fn shade_key_of(key: HitKey) -> ShadeKey {
    (key >> 32) as ShadeKey
}

/// Computes the surface of every hit. A packet whose lanes all hit one kind and material is shaded
/// as it is; the other hits are sorted by kind and material, and shaded eight at a time.
pub(crate) fn group_hits<'arena>(
    arena: &'arena Bump,
    scene: &Scene,
    rays: &QueueSlice,
    hits: &[HitPacket],
) -> &'arena [Surface] {
    let (full, partial) = sort_hits(arena, scene, rays, hits);
    let runs = || partial.chunk_by(|a, b| shade_key_of(*a) == shade_key_of(*b));
    let batches = || runs().flat_map(|run| run.chunks(LANES));
    let count = full.len() + runs().map(|run| packets_for(run.len())).sum::<usize>();
    let mut next = batches();
    arena.alloc_slice_fill_with(count, |k| match full.get(k) {
        Some(&(packet, key)) => full_surface(scene, rays, hits, packet as usize, key),
        None => partial_surface(scene, rays, hits, next.next().unwrap_or_default()),
    })
}

/// The rows of the surfaces' materials, each read when it differs from the one before.
fn material_rows<'arena>(
    arena: &'arena Bump,
    scene: &Scene,
    surfaces: &[Surface],
) -> &'arena [MaterialRow] {
    let mut current: Option<(u32, MaterialRow)> = None;
    arena.alloc_slice_fill_iter(surfaces.iter().map(|surface| {
        let row = match current {
            Some((index, row)) if index == surface.material => row,
            _ => MaterialRow::of(scene, surface.material),
        };
        current = Some((surface.material, row));
        row
    }))
}

/// Returns the packets whose lanes all hit one kind and material, and the other hits, sorted.
fn sort_hits<'arena>(
    arena: &'arena Bump,
    scene: &Scene,
    rays: &QueueSlice,
    hits: &[HitPacket],
) -> (&'arena [(u32, ShadeKey)], &'arena [HitKey]) {
    let full = arena.alloc_slice_fill_copy(hits.len(), (0u32, 0 as ShadeKey));
    let partial = arena.alloc_slice_fill_copy(hits.len() * LANES, 0 as HitKey);
    let (mut fulls, mut partials) = (0, 0);
    let only = uniform_key(scene);
    for (packet, hit) in hits.iter().enumerate() {
        let met = rays.active(packet) & !hit.prim_id.eq(U32x8::splat(NO_PRIM));
        if let (Some(key), 0xff) = (only, met.bits()) {
            full[fulls] = (packet as u32, key);
            fulls += 1;
            continue;
        }
        let start = partials;
        for lane in met.lanes() {
            let key = only.unwrap_or_else(|| shade_key(scene, hit.prim_id.lane(lane))) as HitKey;
            partial[partials] = key << 32 | (packet * LANES + lane) as HitKey;
            partials += 1;
        }
        let mine = &partial[start..partials];
        if mine.len() == LANES
            && mine
                .iter()
                .all(|&k| shade_key_of(k) == shade_key_of(mine[0]))
        {
            full[fulls] = (packet as u32, shade_key_of(mine[0]));
            (fulls, partials) = (fulls + 1, start);
        }
    }
    let partial = &mut partial[..partials];
    partial.sort_unstable();
    (&full[..fulls], partial)
}

fn full_surface(
    scene: &Scene,
    rays: &QueueSlice,
    hits: &[HitPacket],
    packet: usize,
    key: ShadeKey,
) -> Surface {
    let ray = std::array::from_fn(|lane| (packet * LANES + lane) as u32);
    let (rays, active) = rays.packet(packet);
    surface(scene, unpack_key(key), &rays, &hits[packet], active, ray)
}

fn partial_surface(
    scene: &Scene,
    rays: &QueueSlice,
    hits: &[HitPacket],
    batch: &[HitKey],
) -> Surface {
    // Lanes past the end of the batch repeat its last hit.
    let ray = std::array::from_fn(|k| batch[k.min(batch.len() - 1)] as u32);
    let active = Mask8::first(batch.len());
    let unpacked = unpack_key(shade_key_of(batch[0]));
    let (rays, hits) = gather(rays, hits, &ray);
    surface(scene, unpacked, &rays, &hits, active, ray)
}

fn unpack_key(key: ShadeKey) -> ShadeGroup {
    ShadeGroup {
        kind: PrimKind::from_number(key >> KIND_SHIFT),
        instanced: key & INSTANCED != 0,
        material: key & (INSTANCED - 1),
    }
}

/// Gathers eight rays and hits, which may be anywhere in the wave.
fn gather(rays: &QueueSlice, hits: &[HitPacket], ray: &[u32; LANES]) -> (RayPacket, HitPacket) {
    let (org, dir) = rays.queue.gather(rays.packets.start, ray);
    let tmax = F32x8::splat(f32::INFINITY);
    (RayPacket { org, dir, tmax }, hits_of(hits, ray))
}

/// The hits of a surface.
pub(super) fn hits_at(surface: &Surface, hits: &[HitPacket]) -> HitPacket {
    match surface.whole_packet() {
        Some(packet) => hits[packet],
        None => hits_of(hits, &surface.ray),
    }
}

/// Gathers the hits of eight rays.
fn hits_of(hits: &[HitPacket], ray: &[u32; LANES]) -> HitPacket {
    let hit_of = |k: usize| (&hits[ray[k] as usize / LANES], ray[k] as usize % LANES);
    let column = |pick: fn(&HitPacket) -> &F32x8| {
        F32x8::from_lanes(|k| {
            let (hit, lane) = hit_of(k);
            pick(hit).lane(lane)
        })
    };
    let prim_id = std::array::from_fn(|k| {
        let (hit, lane) = hit_of(k);
        hit.prim_id.lane(lane)
    });
    HitPacket {
        t: column(|hit| &hit.t),
        u: column(|hit| &hit.u),
        v: column(|hit| &hit.v),
        prim_id: U32x8::new(prim_id),
    }
}
