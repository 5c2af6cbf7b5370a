//! Secondary rays of hits: selects the bounces that are worth tracing, and queues them.

use super::bounce_queue::BounceQueue;
use super::ray_batch::QueueSlice;
use super::wavefront_context::WavefrontContext;
use crate::shade::{SecondaryRays as Outgoing, ShadeMaterial, Surface, bounces, sample_glossy};
use bumpalo::Bump;
use phalanx_scene::sampling::{BounceKind, child_seed};
use phalanx_trace::simd::{F32x8, Lanes, Vec3x8};

/// Queues the mirror rays of all hits, then the refracted ones, except those that are not worth
/// tracing.
pub(super) fn spawn_secondary_rays(
    context: &mut WavefrontContext,
    arena: &Bump,
    rays: &QueueSlice,
    groups: &[Surface],
    bounces: &mut BounceQueue,
) {
    let ways = groups.iter().map(|at| {
        let m = ShadeMaterial::of(context.scene, at.material);
        usize::from(m.ks != glam::Vec3::ZERO) + usize::from(m.kt != glam::Vec3::ZERO)
    });
    let ways = ways.max().unwrap_or(0);
    if ways == 0 {
        return bounces.clear();
    }
    let columns = context.columns;
    let outgoing =
        arena.alloc_slice_fill_with(groups.len(), |k| outgoing(context, rays, &groups[k]));
    let shares = columns.shares.then(|| {
        let outgoing = groups.iter().zip(&mut *outgoing);
        let kept = outgoing.map(|(at, out)| {
            let whole = ShadeMaterial::of(context.scene, at.material).secondary_weight();
            drop_below_min_weight(context.min_weight, rays.shares(at), whole, out)
        });
        &*arena.alloc_slice_fill_iter(kept)
    });
    bounces.fill(rays.packets.len(), ways, columns, |queue| {
        for (k, (at, (out, _))) in groups.iter().zip(&*outgoing).enumerate() {
            let (mask, weight) = (out.reflect, out.reflect_weight);
            if columns.seeds {
                queue.push_seeds(mask, &child_seed(rays.seeds(&at.ray), BounceKind::Mirror));
            }
            if let Some(shares) = shares {
                queue.push_shares(mask, &shares[k][0]);
            }
            queue.push(mask, out.reflect_org, out.reflect_dir, weight, &at.ray);
        }
        let mirrored = queue.len();
        for (k, (at, (out, kt))) in groups.iter().zip(&*outgoing).enumerate() {
            let (mask, weight) = (out.refract, Vec3x8::splat(kt.x, kt.y, kt.z));
            if columns.seeds {
                queue.push_seeds(
                    mask,
                    &child_seed(rays.seeds(&at.ray), BounceKind::Refracted),
                );
            }
            if let Some(shares) = shares {
                queue.push_shares(mask, &shares[k][1]);
            }
            queue.push(mask, out.refract_org, out.refract_dir, weight, &at.ray);
        }
        context.stats.rays.reflection += mirrored as u64;
        context.stats.rays.refraction += (queue.len() - mirrored) as u64;
        mirrored
    });
}

/// The bounces of eight hits, and the weight of those that are refracted.
fn outgoing(context: &WavefrontContext, rays: &QueueSlice, at: &Surface) -> (Outgoing, glam::Vec3) {
    let material = ShadeMaterial::of(context.scene, at.material);
    let mut out = bounces(&material, at);
    if context.columns.seeds {
        let gloss = context.scene.materials.gloss[at.material as usize];
        if gloss > 0.0 {
            sample_glossy(&mut out, at, gloss, rays.seeds(&at.ray), context.sample);
        }
    }
    (out, material.kt)
}

/// Returns the shares of mirror rays and of refracted ones, and drops rays whose share is less than
/// `min_weight` in every component. `whole` is the divisor that turns weights into parts of what a
/// hit sends in all.
fn drop_below_min_weight(
    min_weight: f32,
    share: Vec3x8,
    whole: glam::Vec3,
    (out, kt): &mut (Outgoing, glam::Vec3),
) -> [Vec3x8; 2] {
    let least = F32x8::splat(min_weight);
    // NaN counts as below the minimum.
    let slight = |c: F32x8| !c.abs().ge(least);
    let slight = |rgb: &Vec3x8| slight(rgb.x) & slight(rgb.y) & slight(rgb.z);
    let of_whole = |w: Vec3x8| {
        let [x, y, z] = whole.to_array().map(F32x8::splat);
        Vec3x8::new(w.x / x, w.y / y, w.z / z)
    };
    let reflected = share.mul_elementwise(of_whole(out.reflect_weight));
    let refracted = share.mul_elementwise(of_whole(Vec3x8::splat(kt.x, kt.y, kt.z)));
    out.reflect = out.reflect & !slight(&reflected);
    out.refract = out.refract & !slight(&refracted);
    [reflected, refracted]
}
