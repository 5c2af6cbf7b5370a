//! One ray a call.

use crate::rows::{check_reserved, read, structure};
use crate::scene::reading;
use crate::status::{ApiError, PhxStatus, answer, guarded, place};
use crate::table::Opaque;
use crate::tree::TREES;
use phalanx::{Bvh, NO_GEOM, NO_PRIM, RayFilter, refine};
pub use phalanx::{Hit as PhxHit, Ray as PhxRay, RefinedHit as PhxRefinedHit};
use std::ffi::{c_int, c_void};

/// `phx_accept`.
pub type PhxAccept =
    Option<extern "C" fn(user: *mut c_void, ray: usize, hit: *const PhxHit) -> c_int>;

/// `phx_filter`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PhxFilter {
    pub size: usize,
    pub tnear: f32,
    pub mask: u32,
    pub ignore: u32,
    pub reserved: u32,
    pub accept: PhxAccept,
    pub user: *mut c_void,
}

/// A ray of the caller's, with its filter if it has one, through a tree.
///
/// # Safety
/// As the header says of each function.
#[inline(always)]
unsafe fn query<T>(
    (tree, ray, filter): (*const Opaque, *const PhxRay, *const PhxFilter),
    trace: impl FnOnce(&Bvh, &PhxRay, Option<&RayFilter>) -> T,
) -> Result<T, ApiError> {
    let bvh = TREES.get(tree)?.for_one()?;
    // SAFETY: the caller's.
    let ray = unsafe { read("ray", ray) }?;
    if filter.is_null() {
        return Ok(trace(bvh, ray, None));
    }
    // SAFETY: the caller's.
    unsafe { with_filter(filter, |filter| trace(bvh, ray, Some(filter))) }
}

/// Passes on the caller's filter. Not inlined, because rays without one would save its registers.
///
/// # Safety
/// As the header says.
#[inline(never)]
unsafe fn with_filter<T>(
    filter: *const PhxFilter,
    trace: impl FnOnce(&RayFilter) -> T,
) -> Result<T, ApiError> {
    // SAFETY: the caller's.
    let given = unsafe { structure(filter) }?;
    check_reserved(given.reserved)?;
    if given.mask == 0 {
        let words = "phx_filter.mask is 0, and no hit would count: begin with PHX_FILTER";
        return Err(ApiError::argument(words));
    }
    let accept = |hit: &PhxHit| (given.accept).is_none_or(|accept| accept(given.user, 0, hit) != 0);
    Ok(trace(&RayFilter {
        tnear: given.tnear,
        mask: given.mask,
        ignore: given.ignore,
        accept: &accept,
    }))
}

/// A miss.
pub const MISS: PhxHit = PhxHit {
    t: f32::INFINITY,
    u: 0.0,
    v: 0.0,
    prim_id: NO_PRIM,
    geom_id: NO_GEOM,
};

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_intersect(
    tree: *const Opaque,
    ray: *const PhxRay,
    filter: *const PhxFilter,
    hit: *mut PhxHit,
) -> PhxStatus {
    // SAFETY: the caller's.
    unsafe {
        guarded(|| {
            let place = place("hit", hit)?;
            query((tree, ray, filter), |bvh, ray, filter| {
                let is_hit = match filter {
                    None => bvh.intersect_into(ray, place),
                    Some(filter) => {
                        let hit = bvh.intersect_filtered(ray, filter);
                        hit.map(|hit| *place = hit).is_some()
                    }
                };
                if !is_hit {
                    *place = MISS;
                }
            })
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_occluded(
    tree: *const Opaque,
    ray: *const PhxRay,
    filter: *const PhxFilter,
    blocked: *mut c_int,
) -> PhxStatus {
    // SAFETY: the caller's.
    unsafe {
        guarded(|| {
            let place = place("blocked", blocked)?;
            query((tree, ray, filter), |bvh, ray, filter| {
                let is_blocked = match filter {
                    None => bvh.occluded(ray),
                    Some(filter) => bvh.occluded_filtered(ray, filter),
                };
                *place = is_blocked.into();
            })
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_all_hits(
    tree: *const Opaque,
    ray: *const PhxRay,
    filter: *const PhxFilter,
    hits: *mut PhxHit,
    capacity: usize,
    count: *mut usize,
) -> PhxStatus {
    let all = |bvh: &Bvh, ray: &PhxRay, filter: Option<&RayFilter>| {
        bvh.all_hits_filtered(ray, filter.unwrap_or(&RayFilter::default()))
    };
    // SAFETY: the caller's, for `capacity` hits.
    unsafe {
        answer("count", count, || {
            if capacity > 0 && (hits.is_null() || !hits.is_aligned()) {
                return Err(ApiError::argument("hits is null or misaligned"));
            }
            let all = query((tree, ray, filter), all)?;
            hits.copy_from(all.as_ptr(), all.len().min(capacity));
            Ok(all.len())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_refine(
    scene: *const Opaque,
    origin: *const [f64; 3],
    direction: *const [f64; 3],
    hit: *const PhxHit,
    refined: *mut PhxRefinedHit,
) -> PhxStatus {
    // SAFETY: the caller's.
    unsafe {
        answer("refined", refined, || {
            let (origin, direction) = (read("origin", origin)?, read("direction", direction)?);
            let (hit, scene) = (read("hit", hit)?, reading(scene)?);
            if u64::from(hit.prim_id) >= scene.id_count() {
                let words = format!("the scene has no primitive {}", hit.prim_id);
                return Err(ApiError::argument(words));
            }
            Ok(refine(&scene, *origin, *direction, hit))
        })
    }
}
