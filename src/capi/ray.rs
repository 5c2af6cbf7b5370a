//! One ray a call.

use crate::rows::{check_reserved, read, structure};
use crate::scene::reading;
use crate::status::{ApiError, PhxStatus, answer};
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
    plain: impl FnOnce(&Bvh, &PhxRay) -> T,
    filtered: impl FnOnce(&Bvh, &PhxRay, &RayFilter) -> T,
) -> Result<T, ApiError> {
    let bvh = TREES.get(tree)?.for_one()?;
    // SAFETY: the caller's.
    let ray = unsafe { read("ray", ray) }?;
    if filter.is_null() {
        return Ok(plain(bvh, &ray));
    }
    // SAFETY: the caller's.
    let given = unsafe { structure(filter) }?;
    check_reserved(given.reserved)?;
    let accept = |hit: &PhxHit| {
        given
            .accept
            .is_none_or(|accept| accept(given.user, 0, hit) != 0)
    };
    let filter = RayFilter {
        tnear: given.tnear,
        mask: given.mask,
        ignore: given.ignore,
        accept: &accept,
    };
    Ok(filtered(bvh, &ray, &filter))
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
        answer("hit", hit, || {
            let hit = query((tree, ray, filter), Bvh::intersect, Bvh::intersect_filtered)?;
            Ok(hit.unwrap_or(MISS))
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
        answer("blocked", blocked, || {
            let blocked = query((tree, ray, filter), Bvh::occluded, Bvh::occluded_filtered)?;
            Ok(blocked.into())
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
    let plain = |bvh: &Bvh, ray: &PhxRay| bvh.all_hits_filtered(ray, &RayFilter::default());
    // SAFETY: the caller's, for `capacity` hits.
    unsafe {
        answer("count", count, || {
            if capacity > 0 && (hits.is_null() || !hits.is_aligned()) {
                return Err(ApiError::argument("hits is null or misaligned"));
            }
            let all = query((tree, ray, filter), plain, Bvh::all_hits_filtered)?;
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
            Ok(refine(&scene, origin, direction, &hit))
        })
    }
}
