//! One whole wave of rays: trace, shade, trace shadow rays, bounce. The further processing of the
//! bounces, and their accumulation, is in `levels`.

use super::aov_buffer::AovBuffer;
use super::levels::BounceQueue;
use super::secondary::spawn_secondary_rays;
use super::shadow_cache::{CachedLights, ShadowCache};
use super::stats::RenderStats;
use crate::shade::{
    ShadeGroup, ShadeMaterial, Surface, WHITE, sample_light, sample_light_position, surface,
    texture_color,
};
use bumpalo::Bump;
use phalanx_scene::{PrimKind, Scene};
use phalanx_trace::Traversal;
use phalanx_trace::packet::{HitPacket, NO_PRIM, QueueColumns, RayPacket, RayQueue, packets_for};
use phalanx_trace::simd::{F32x8, LANES, LaneMask, LaneU32, Lanes, Mask8, U32x8, Vec3x8};
use std::ops::Range;

/// Shared state of all waves.
pub(super) struct WavefrontContext<'a> {
    pub(super) scene: &'a Scene,
    pub(super) traversal: Traversal<'a>,
    pub(super) stats: RenderStats,
    /// Index of the camera ray of each pixel that the wave follows.
    pub(super) sample: u32,
    /// Least share of a ray: rays whose share of their camera ray is less than this in every
    /// component are not traced.
    pub(super) min_weight: f32,
    /// The columns of the queues of bounces.
    pub(super) columns: QueueColumns,
}

/// Radiance of eight rays.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
pub(super) struct RadianceX8(pub(super) [[f32; LANES]; 3]);

impl RadianceX8 {
    pub(super) const BLACK: RadianceX8 = RadianceX8([[0.0; LANES]; 3]);

    /// Lower four lanes and upper four lanes of each plane.
    pub(super) fn plane_halves(&self) -> [[&[f32; LANES / 2]; 2]; 3] {
        self.0.each_ref().map(|plane| match plane.as_chunks().0 {
            [lower, upper] => [lower, upper],
            _ => unreachable!("eight lanes are two times four"),
        })
    }

    pub(super) fn lane(&self, lane: usize) -> [f32; 3] {
        [self.0[0][lane], self.0[1][lane], self.0[2][lane]]
    }

    fn set(&mut self, lane: usize, rgb: [f32; 3]) {
        for (plane, value) in self.0.iter_mut().zip(rgb) {
            plane[lane] = value;
        }
    }

    pub(super) fn add(&mut self, lane: usize, rgb: [f32; 3]) {
        for (plane, value) in self.0.iter_mut().zip(rgb) {
            plane[lane] += value;
        }
    }
}

/// Some packets of a queue.
pub(super) struct QueueSlice<'q, 'arena> {
    pub(super) queue: &'q RayQueue<'arena>,
    pub(super) packets: Range<usize>,
}

impl QueueSlice<'_, '_> {
    fn packet(&self, index: usize) -> (RayPacket, Mask8) {
        self.queue.packet(self.packets.start + index, f32::INFINITY)
    }

    fn active(&self, index: usize) -> Mask8 {
        self.queue.active(self.packets.start + index)
    }

    /// Seeds of some rays of the wave.
    pub(super) fn seeds(&self, rays: &[u32; LANES]) -> [u32; LANES] {
        rays.map(|ray| {
            let (packet, lane) = (ray as usize / LANES, ray as usize % LANES);
            self.queue.seed(self.packets.start + packet, lane)
        })
    }

    /// Shares of the rays that hit eight points.
    pub(super) fn shares(&self, at: &Surface) -> Vec3x8 {
        let mut rgb = [[0.0; LANES]; 3];
        for (lane, &ray) in at.ray.iter().enumerate() {
            let (packet, at) = (ray as usize / LANES, ray as usize % LANES);
            let one = self.queue.share(self.packets.start + packet, at);
            for (column, value) in rgb.iter_mut().zip(one) {
                column[lane] = value;
            }
        }
        let [x, y, z] = rgb.map(F32x8::new);
        Vec3x8::new(x, y, z)
    }
}

/// Traces a wave, writes the radiance of its rays without bounces to `radiance`, packet by packet,
/// and queues their bounces, where any are allowed. `aovs` receives the other outputs of the rays.
/// `cache` supplies the visibility of lights where it is known, and records it.
pub(super) fn trace_wavefront(
    engine: &mut WavefrontContext,
    arena: &Bump,
    rays: QueueSlice,
    radiance: &mut [RadianceX8],
    mut aovs: Option<&mut AovBuffer>,
    cache: Option<&mut ShadowCache>,
    bounces: Option<&mut BounceQueue>,
) {
    // Trace.
    let hits = arena.alloc_slice_fill_copy(rays.packets.len(), HitPacket::miss());
    let packets = rays.packets.clone();
    engine.traversal.closest(rays.queue, packets, hits);
    if let Some(aovs) = &mut aovs {
        aovs.hits.copy_from_slice(hits);
    }
    // Shade.
    let (groups, tints) = group_hits(arena, engine.scene, &rays, hits, radiance);
    add_ambient_and_emission(engine.scene, groups, tints, radiance);
    // Trace shadow rays, in the order of the lights in the file.
    let known = cache.map(|cache| cache.lookup(arena, groups, hits));
    trace_shadow_rays(engine, arena, &rays, (groups, tints), known, radiance);
    if let Some(aovs) = aovs {
        aovs.record_surfaces(engine.scene, groups, tints, radiance);
    }
    if let Some(bounces) = bounces {
        spawn_secondary_rays(engine, arena, &rays, groups, bounces);
    }
}

/// A [`ShadeGroup`] in one word: kind in the upper two bits, then the bit for instances, then the
/// material.
type ShadeKey = u32;

const INSTANCED: ShadeKey = 1 << 29;

fn shade_key(scene: &Scene, prim_id: u32) -> ShadeKey {
    let placed = scene.resolve(prim_id);
    let kind = scene.prims[placed.prim as usize].kind() as u32;
    let instanced = if placed.instance.is_some() {
        INSTANCED
    } else {
        0
    };
    kind << 30 | instanced | scene.prim_material(placed.prim)
}

/// The key of every hit of a scene of one kind and one material, such as a scanned mesh. It saves
/// two look-ups a hit.
fn uniform_key(scene: &Scene) -> Option<ShadeKey> {
    if !scene.instances.is_empty() {
        return None;
    }
    let of_first_kind = match scene.prims.first()?.kind() {
        PrimKind::Sphere => scene.spheres.len(),
        PrimKind::Ellipsoid => scene.ellipsoids.len(),
        PrimKind::Triangle => scene.triangles.len(),
        PrimKind::Cone => scene.cones.len(),
    };
    let one = scene.materials.len() == 1 && of_first_kind == scene.prim_count();
    one.then(|| shade_key(scene, 0))
}

/// A hit that has to be regrouped: its key in the upper half, the ray's index in the wave in the
/// lower.
type HitKey = u64;

fn shade_key_of(key: HitKey) -> ShadeKey {
    (key >> 32) as ShadeKey
}

/// Gives missing rays the background and every hit its surface. A packet whose lanes all hit one
/// kind and material is shaded as it stands; the other hits are sorted by kind and material, and
/// shaded eight at a time.
///
/// The second list holds the texture colour of each surface; it is empty where the scene has no
/// textures, so that such a scene pays nothing for them.
pub(super) fn group_hits<'arena>(
    arena: &'arena Bump,
    scene: &Scene,
    rays: &QueueSlice,
    hits: &[HitPacket],
    radiance: &mut [RadianceX8],
) -> (&'arena [Surface], &'arena [Vec3x8]) {
    let whole = arena.alloc_slice_fill_copy(hits.len(), (0u32, 0 as ShadeKey));
    let loose = arena.alloc_slice_fill_copy(hits.len() * LANES, 0 as HitKey);
    let (mut wholes, mut looses) = (0, 0);
    let only = uniform_key(scene);
    let background = scene.background.to_array().map(|c| [c; LANES]);
    for (packet, hit) in hits.iter().enumerate() {
        let active = rays.active(packet);
        let missed = active & hit.prim_id.eq(U32x8::splat(NO_PRIM));
        if missed.bits() == 0xff {
            radiance[packet] = RadianceX8(background);
            continue;
        }
        for lane in missed.lanes() {
            radiance[packet].set(lane, scene.background.to_array());
        }
        let met = active & !missed;
        if let (Some(batch), 0xff) = (only, met.bits()) {
            whole[wholes] = (packet as u32, batch);
            wholes += 1;
            continue;
        }
        let start = looses;
        for lane in met.lanes() {
            let batch = only.unwrap_or_else(|| shade_key(scene, hit.prim_id.lane(lane))) as HitKey;
            loose[looses] = batch << 32 | (packet * LANES + lane) as HitKey;
            looses += 1;
        }
        let mine = &loose[start..looses];
        if mine.len() == LANES
            && mine
                .iter()
                .all(|&k| shade_key_of(k) == shade_key_of(mine[0]))
        {
            whole[wholes] = (packet as u32, shade_key_of(mine[0]));
            (wholes, looses) = (wholes + 1, start);
        }
    }
    let (whole, loose) = (&whole[..wholes], &mut loose[..looses]);
    loose.sort_unstable();
    let runs = || loose.chunk_by(|a, b| shade_key_of(*a) == shade_key_of(*b));
    let count = runs().map(|run| packets_for(run.len())).sum::<usize>();
    let batches = || runs().flat_map(|run| run.chunks(LANES));
    let mut next = batches();
    let groups = arena.alloc_slice_fill_with(wholes + count, |k| match whole.get(k) {
        Some(&(packet, batch)) => full_surface(scene, rays, hits, packet as usize, batch),
        None => partial_surface(scene, rays, hits, next.next().unwrap_or_default()),
    });
    if scene.textures.is_empty() {
        return (groups, &[]);
    }
    let mut next = batches();
    let tints = arena.alloc_slice_fill_with(wholes + count, |k| match whole.get(k) {
        Some(&(packet, batch)) => texture_color_of(scene, batch, &hits[packet as usize]),
        None => partial_tint(scene, rays, hits, next.next().unwrap_or_default()),
    });
    (groups, tints)
}

fn texture_color_of(scene: &Scene, batch: ShadeKey, hits: &HitPacket) -> Vec3x8 {
    let batch = unpack_key(batch);
    match batch.kind {
        PrimKind::Triangle => texture_color(scene, batch.material, hits),
        _ => WHITE,
    }
}

fn partial_tint(scene: &Scene, rays: &QueueSlice, hits: &[HitPacket], batch: &[HitKey]) -> Vec3x8 {
    let (_, hits) = gather(rays, hits, &rays_of(batch));
    texture_color_of(scene, shade_key_of(batch[0]), &hits)
}

fn full_surface(
    scene: &Scene,
    rays: &QueueSlice,
    hits: &[HitPacket],
    packet: usize,
    batch: ShadeKey,
) -> Surface {
    let ray = std::array::from_fn(|lane| (packet * LANES + lane) as u32);
    let (rays, active) = rays.packet(packet);
    surface(scene, unpack_key(batch), &rays, &hits[packet], active, ray)
}

fn partial_surface(
    scene: &Scene,
    rays: &QueueSlice,
    hits: &[HitPacket],
    batch: &[HitKey],
) -> Surface {
    let ray = rays_of(batch);
    let active = Mask8::first(batch.len());
    let unpacked = unpack_key(shade_key_of(batch[0]));
    let (rays, hits) = gather(rays, hits, &ray);
    surface(scene, unpacked, &rays, &hits, active, ray)
}

/// The rays of a batch; lanes past its end repeat its last hit.
fn rays_of(batch: &[HitKey]) -> [u32; LANES] {
    std::array::from_fn(|k| batch[k.min(batch.len() - 1)] as u32)
}

fn unpack_key(batch: ShadeKey) -> ShadeGroup {
    ShadeGroup {
        kind: PrimKind::from_number(batch >> 30),
        instanced: batch & INSTANCED != 0,
        material: batch & (INSTANCED - 1),
    }
}

/// Gathers eight rays and hits, which may be anywhere in the wave.
fn gather(rays: &QueueSlice, hits: &[HitPacket], ray: &[u32; LANES]) -> (RayPacket, HitPacket) {
    let mut org = [[0.0; LANES]; 3];
    let mut dir = [[0.0; LANES]; 3];
    let mut tuv = [[0.0; LANES]; 3];
    let mut prim_id = [0; LANES];
    for (k, &index) in ray.iter().enumerate() {
        let (packet, lane) = (index as usize / LANES, index as usize % LANES);
        let (o, d) = rays.queue.ray(rays.packets.start + packet, lane);
        let hit = &hits[packet];
        for axis in 0..3 {
            org[axis][k] = o[axis];
            dir[axis][k] = d[axis];
        }
        for (column, value) in tuv.iter_mut().zip([&hit.t, &hit.u, &hit.v]) {
            column[k] = value.lane(lane);
        }
        prim_id[k] = hit.prim_id.lane(lane);
    }
    let vec =
        |c: [[f32; LANES]; 3]| Vec3x8::new(F32x8::new(c[0]), F32x8::new(c[1]), F32x8::new(c[2]));
    let [t, u, v] = tuv.map(F32x8::new);
    (
        RayPacket {
            org: vec(org),
            dir: vec(dir),
            tmax: F32x8::splat(f32::INFINITY),
        },
        HitPacket {
            t,
            u,
            v,
            prim_id: U32x8::new(prim_id),
        },
    )
}

/// Starts every hit's sum with Ka + Ke, or with Ka times the texture's colour + Ke.
fn add_ambient_and_emission(
    scene: &Scene,
    groups: &[Surface],
    tints: &[Vec3x8],
    radiance: &mut [RadianceX8],
) {
    for (k, at) in groups.iter().enumerate() {
        let ShadeMaterial { ka, ke, .. } = ShadeMaterial::of(scene, at.material);
        let own = (ka + ke).to_array();
        if let (None, Some(packet)) = (tints.get(k), at.whole_packet()) {
            radiance[packet] = RadianceX8(own.map(|c| [c; LANES]));
            continue;
        }
        for lane in at.active.lanes() {
            let own = match tints.get(k) {
                Some(t) => {
                    let t = glam::Vec3::new(t.x.lane(lane), t.y.lane(lane), t.z.lane(lane));
                    (ka * t + ke).to_array()
                }
                None => own,
            };
            let ray = at.ray[lane] as usize;
            radiance[ray / LANES].set(ray % LANES, own);
        }
    }
}

/// Adds each light's term where nothing occludes it.
fn trace_shadow_rays(
    engine: &mut WavefrontContext,
    arena: &Bump,
    rays: &QueueSlice,
    (groups, tints): (&[Surface], &[Vec3x8]),
    mut known: Option<CachedLights>,
    colors: &mut [RadianceX8],
) {
    let mut queue = RayQueue::with_capacity(arena, groups.len() * LANES);
    let room = arena.alloc_slice_fill_copy(groups.len(), 0);
    for light in 0..engine.scene.lights.len() {
        queue.clear();
        let places = |seeds| sample_light_position(engine.scene, light, seeds, engine.sample);
        let (area, one) = (engine.scene.lights.is_area(light), places([0; LANES]));
        for (k, at) in groups.iter().enumerate() {
            let material = ShadeMaterial::of(engine.scene, at.material);
            let position = if area {
                places(rays.seeds(&at.ray))
            } else {
                one
            };
            let sample = sample_light(engine.scene, light, position, &material, tints.get(k), at);
            let asked = match &mut known {
                Some(known) => known.apply(light, (k, at), sample.needed, &sample.radiance, colors),
                None => sample.needed,
            };
            queue.push(asked, sample.org, sample.dir, sample.radiance, &at.ray);
        }
        engine.stats.rays.shadow += queue.len() as u64;
        let tmax = if engine.scene.lights.directional[light] {
            f32::INFINITY
        } else {
            1.0
        };
        let all = 0..queue.packets();
        let blocked = &mut room[..all.len()];
        engine.traversal.occluded(&queue, all, tmax, blocked);
        add_unoccluded(&queue, blocked, colors, |hit| {
            if let Some(known) = &mut known {
                known.record_visible(light, hit);
            }
        });
    }
}

/// Adds the radiance that rays carry to the hits that sent them, where nothing blocks the ray, and
/// passes those hits to `record`. `blocked` holds lanes as bits, a byte for each packet.
#[inline]
pub(super) fn add_unoccluded(
    queue: &RayQueue,
    blocked: &[u8],
    colors: &mut [RadianceX8],
    mut record: impl FnMut(u32),
) {
    for (packet, &blocked) in blocked.iter().enumerate() {
        let (radiance, hit) = queue.payload(packet);
        let open = queue.active(packet) & !Mask8::from_bits(u32::from(blocked));
        for lane in open.lanes() {
            let ray = hit[lane] as usize;
            colors[ray / LANES].add(ray % LANES, [0, 1, 2].map(|c| radiance[c][lane]));
            record(hit[lane]);
        }
    }
}

/// Adds the weighted radiance of some packets of bounces to the hits that sent them.
pub(super) fn accumulate(
    queue: &RayQueue,
    packets: Range<usize>,
    answers: &[RadianceX8],
    radiance: &mut [RadianceX8],
) {
    for (packet, answer) in packets.zip(answers) {
        let active = queue.active(packet);
        let (weight, parent) = queue.payload(packet);
        for lane in active.lanes() {
            let ray = parent[lane] as usize;
            let rgb = [0, 1, 2].map(|c| weight[c][lane] * answer.0[c][lane]);
            radiance[ray / LANES].add(ray % LANES, rgb);
        }
    }
}
