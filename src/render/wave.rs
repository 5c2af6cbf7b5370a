//! One wave of rays, whole: trace, shade, ask the lights, bounce. What becomes of the bounces, and when they are folded, is
//! told in `levels`.

use super::bounce::bounce;
use super::kept::Kept;
use super::levels::Bounces;
use super::sights::{Known, Sights};
use super::stats::RenderStats;
use crate::shade::{Batch, Material, Surface, UNTINTED, light_places, sample_light, surface, tint};
use bumpalo::Bump;
use phalanx_scene::{PrimKind, Scene};
use phalanx_trace::Traversal;
use phalanx_trace::packet::{HitPacket, NO_PRIM, QueueColumns, RayPacket, RayQueue, packets_for};
use phalanx_trace::simd::{F32x8, LANES, LaneMask, LaneU32, Lanes, Mask8, U32x8, Vec3x8};
use std::ops::Range;

/// What every wave needs.
pub(super) struct Engine<'a> {
    pub(super) scene: &'a Scene,
    pub(super) traversal: Traversal<'a>,
    pub(super) stats: RenderStats,
    /// Which of a pixel's camera rays the wave follows.
    pub(super) sample: u32,
    /// Rays whose share of their camera ray is less than this in every component are not traced.
    pub(super) min_weight: f32,
    /// The columns of the queues of bounces.
    pub(super) columns: QueueColumns,
}

/// Radiance of eight rays.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
pub(super) struct Colors(pub(super) [[f32; LANES]; 3]);

impl Colors {
    pub(super) const BLACK: Colors = Colors([[0.0; LANES]; 3]);

    /// Of each plane, the lower four lanes and the upper four.
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
pub(super) struct RayView<'q, 'arena> {
    pub(super) queue: &'q RayQueue<'arena>,
    pub(super) packets: Range<usize>,
}

impl RayView<'_, '_> {
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

/// Traces a wave, writes what its rays gather without bounces to `colors`, packet by packet, and queues their bounces, where
/// any are allowed. `kept` receives what is to be known of the rays beside that, and `sights` what they see of the lights,
/// where they know some of it.
pub(super) fn wave(
    engine: &mut Engine,
    arena: &Bump,
    rays: RayView,
    colors: &mut [Colors],
    mut kept: Option<&mut Kept>,
    sights: Option<&mut Sights>,
    bounces: Option<&mut Bounces>,
) {
    // Trace.
    let hits = arena.alloc_slice_fill_copy(rays.packets.len(), HitPacket::miss());
    let packets = rays.packets.clone();
    engine.traversal.closest(rays.queue, packets, hits);
    if let Some(kept) = &mut kept {
        kept.hits.copy_from_slice(hits);
    }
    // Shade.
    let (surfaces, tints) = surfaces(arena, engine.scene, &rays, hits, colors);
    emit_own(engine.scene, surfaces, tints, colors);
    // Ask the lights, in the order of the file.
    let known = sights.map(|sights| sights.met(arena, surfaces, hits));
    ask_lights(engine, arena, &rays, (surfaces, tints), known, colors);
    if let Some(kept) = kept {
        kept.take(engine.scene, surfaces, tints, colors);
    }
    if let Some(bounces) = bounces {
        bounce(engine, arena, &rays, surfaces, bounces);
    }
}

/// A [`Batch`] in one word: kind in the upper two bits, then whether instances show it, then the material.
type BatchWord = u32;

const INSTANCED: BatchWord = 1 << 29;

fn batch_of(scene: &Scene, prim_id: u32) -> BatchWord {
    let placed = scene.placed(prim_id);
    let kind = scene.prims[placed.prim as usize].kind() as u32;
    let instanced = if placed.instance.is_some() {
        INSTANCED
    } else {
        0
    };
    kind << 30 | instanced | scene.prim_material(placed.prim)
}

/// The batch of every hit of a scene of one kind and one material, such as a scanned mesh: two look-ups less a hit.
fn only_batch(scene: &Scene) -> Option<BatchWord> {
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
    one.then(|| batch_of(scene, 0))
}

/// A hit that has to be regrouped: its batch in the upper half, the ray's index in the wave in the lower.
type Key = u64;

fn key_batch(key: Key) -> BatchWord {
    (key >> 32) as BatchWord
}

/// Gives missing rays the background and every hit its surface. A packet whose lanes all hit one kind and material is
/// shaded as it stands; the other hits are sorted by kind and material, and shaded eight at a time.
///
/// The second list holds the texture colour of each surface; it is empty where the scene has no textures, so that such
/// a scene pays nothing for them.
pub(super) fn surfaces<'arena>(
    arena: &'arena Bump,
    scene: &Scene,
    rays: &RayView,
    hits: &[HitPacket],
    colors: &mut [Colors],
) -> (&'arena [Surface], &'arena [Vec3x8]) {
    let whole = arena.alloc_slice_fill_copy(hits.len(), (0u32, 0 as BatchWord));
    let loose = arena.alloc_slice_fill_copy(hits.len() * LANES, 0 as Key);
    let (mut wholes, mut looses) = (0, 0);
    let only = only_batch(scene);
    let background = scene.background.to_array().map(|c| [c; LANES]);
    for (packet, hit) in hits.iter().enumerate() {
        let active = rays.active(packet);
        let missed = active & hit.prim_id.eq(U32x8::splat(NO_PRIM));
        if missed.bits() == 0xff {
            colors[packet] = Colors(background);
            continue;
        }
        for lane in missed.lanes() {
            colors[packet].set(lane, scene.background.to_array());
        }
        let met = active & !missed;
        if let (Some(batch), 0xff) = (only, met.bits()) {
            whole[wholes] = (packet as u32, batch);
            wholes += 1;
            continue;
        }
        let start = looses;
        for lane in met.lanes() {
            let batch = only.unwrap_or_else(|| batch_of(scene, hit.prim_id.lane(lane))) as Key;
            loose[looses] = batch << 32 | (packet * LANES + lane) as Key;
            looses += 1;
        }
        let mine = &loose[start..looses];
        if mine.len() == LANES && mine.iter().all(|&k| key_batch(k) == key_batch(mine[0])) {
            whole[wholes] = (packet as u32, key_batch(mine[0]));
            (wholes, looses) = (wholes + 1, start);
        }
    }
    let (whole, loose) = (&whole[..wholes], &mut loose[..looses]);
    loose.sort_unstable();
    let runs = || loose.chunk_by(|a, b| key_batch(*a) == key_batch(*b));
    let count = runs().map(|run| packets_for(run.len())).sum::<usize>();
    let batches = || runs().flat_map(|run| run.chunks(LANES));
    let mut next = batches();
    let surfaces = arena.alloc_slice_fill_with(wholes + count, |k| match whole.get(k) {
        Some(&(packet, batch)) => whole_surface(scene, rays, hits, packet as usize, batch),
        None => loose_surface(scene, rays, hits, next.next().unwrap_or_default()),
    });
    if scene.textures.is_empty() {
        return (surfaces, &[]);
    }
    let mut next = batches();
    let tints = arena.alloc_slice_fill_with(wholes + count, |k| match whole.get(k) {
        Some(&(packet, batch)) => tint_of(scene, batch, &hits[packet as usize]),
        None => loose_tint(scene, rays, hits, next.next().unwrap_or_default()),
    });
    (surfaces, tints)
}

fn tint_of(scene: &Scene, batch: BatchWord, hits: &HitPacket) -> Vec3x8 {
    let batch = unpack(batch);
    match batch.kind {
        PrimKind::Triangle => tint(scene, batch.material, hits),
        _ => UNTINTED,
    }
}

fn loose_tint(scene: &Scene, rays: &RayView, hits: &[HitPacket], batch: &[Key]) -> Vec3x8 {
    let (_, hits) = gather(rays, hits, &rays_of(batch));
    tint_of(scene, key_batch(batch[0]), &hits)
}

fn whole_surface(
    scene: &Scene,
    rays: &RayView,
    hits: &[HitPacket],
    packet: usize,
    batch: BatchWord,
) -> Surface {
    let ray = std::array::from_fn(|lane| (packet * LANES + lane) as u32);
    let (rays, active) = rays.packet(packet);
    surface(scene, unpack(batch), &rays, &hits[packet], active, ray)
}

fn loose_surface(scene: &Scene, rays: &RayView, hits: &[HitPacket], batch: &[Key]) -> Surface {
    let ray = rays_of(batch);
    let active = Mask8::first(batch.len());
    let unpacked = unpack(key_batch(batch[0]));
    let (rays, hits) = gather(rays, hits, &ray);
    surface(scene, unpacked, &rays, &hits, active, ray)
}

/// The rays of a batch; lanes past its end repeat its last hit.
fn rays_of(batch: &[Key]) -> [u32; LANES] {
    std::array::from_fn(|k| batch[k.min(batch.len() - 1)] as u32)
}

fn unpack(batch: BatchWord) -> Batch {
    Batch {
        kind: PrimKind::from_number(batch >> 30),
        instanced: batch & INSTANCED != 0,
        material: batch & (INSTANCED - 1),
    }
}

/// Collects eight rays and hits from wherever they are.
fn gather(rays: &RayView, hits: &[HitPacket], ray: &[u32; LANES]) -> (RayPacket, HitPacket) {
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
fn emit_own(scene: &Scene, surfaces: &[Surface], tints: &[Vec3x8], colors: &mut [Colors]) {
    for (k, at) in surfaces.iter().enumerate() {
        let Material { ka, ke, .. } = Material::of(scene, at.material);
        let own = (ka + ke).to_array();
        if let (None, Some(packet)) = (tints.get(k), at.whole_packet()) {
            colors[packet] = Colors(own.map(|c| [c; LANES]));
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
            colors[ray / LANES].set(ray % LANES, own);
        }
    }
}

/// Adds each light's term where nothing stands in its way.
fn ask_lights(
    engine: &mut Engine,
    arena: &Bump,
    rays: &RayView,
    (surfaces, tints): (&[Surface], &[Vec3x8]),
    mut known: Option<Known>,
    colors: &mut [Colors],
) {
    let mut queue = RayQueue::with_capacity(arena, surfaces.len() * LANES);
    let room = arena.alloc_slice_fill_copy(surfaces.len(), 0);
    for light in 0..engine.scene.lights.len() {
        queue.clear();
        let places = |seeds| light_places(engine.scene, light, seeds, engine.sample);
        let (area, one) = (engine.scene.lights.has_area(light), places([0; LANES]));
        for (k, at) in surfaces.iter().enumerate() {
            let material = Material::of(engine.scene, at.material);
            let place = if area {
                places(rays.seeds(&at.ray))
            } else {
                one
            };
            let sample = sample_light(engine.scene, light, place, &material, tints.get(k), at);
            let asked = match &mut known {
                Some(known) => {
                    known.answer(light, (k, at), sample.needed, &sample.radiance, colors)
                }
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
        for (packet, &blocked) in blocked.iter().enumerate() {
            let (radiance, hit) = queue.payload(packet);
            let lit = queue.active(packet) & !Mask8::from_bits(u32::from(blocked));
            for lane in lit.lanes() {
                let ray = hit[lane] as usize;
                colors[ray / LANES].add(ray % LANES, [0, 1, 2].map(|c| radiance[c][lane]));
                if let Some(known) = &mut known {
                    known.saw(light, hit[lane]);
                }
            }
        }
    }
}

/// Adds the weighted answers of some packets of bounces to the hits that sent them.
pub(super) fn fold(
    queue: &RayQueue,
    packets: Range<usize>,
    answers: &[Colors],
    colors: &mut [Colors],
) {
    for (packet, answer) in packets.zip(answers) {
        let active = queue.active(packet);
        let (weight, parent) = queue.payload(packet);
        for lane in active.lanes() {
            let ray = parent[lane] as usize;
            let rgb = [0, 1, 2].map(|c| weight[c][lane] * answer.0[c][lane]);
            colors[ray / LANES].add(ray % LANES, rgb);
        }
    }
}
