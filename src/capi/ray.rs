//! One ray a call.

use crate::rows::{OutPointer, SizedStruct, read, structure};
use crate::scene::reading;
use crate::status::{ApiError, PhxStatus, guarded};
use crate::table::Opaque;
use crate::tree::TREES;
use phalanx::{Bvh, NO_GEOM, NO_PRIM, RayFilter, refine};
use std::ffi::{c_int, c_void};

/// `phx_ray`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PhxRay {
    pub origin: [f32; 3],
    pub tmax: f32,
    pub direction: [f32; 3],
}

/// `phx_hit`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PhxHit {
    pub t: f32,
    pub u: f32,
    pub v: f32,
    pub prim_id: u32,
    pub geom_id: u32,
}

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

// SAFETY: numbers, and pointers that may be null.
unsafe impl SizedStruct for PhxFilter {
    const NAME: &'static str = "phx_filter";
}

impl PhxRay {
    #[inline(always)]
    fn ray(&self) -> phalanx::Ray {
        phalanx::Ray {
            origin: self.origin,
            direction: self.direction,
            tmax: self.tmax,
        }
    }
}

impl From<phalanx::Hit> for PhxHit {
    #[inline(always)]
    fn from(hit: phalanx::Hit) -> PhxHit {
        let phalanx::Hit {
            t,
            u,
            v,
            prim_id,
            geom_id,
        } = hit;
        PhxHit {
            t,
            u,
            v,
            prim_id,
            geom_id,
        }
    }
}

impl From<PhxHit> for phalanx::Hit {
    fn from(hit: PhxHit) -> phalanx::Hit {
        let PhxHit {
            t,
            u,
            v,
            prim_id,
            geom_id,
        } = hit;
        phalanx::Hit {
            t,
            u,
            v,
            prim_id,
            geom_id,
        }
    }
}

/// A ray of the caller's, with its filter if it has one, through a tree.
///
/// # Safety
/// As the header says of each function.
#[inline(always)]
unsafe fn query<T>(
    (tree, ray, filter): (*const Opaque, *const PhxRay, *const PhxFilter),
    plain: impl FnOnce(&Bvh, &phalanx::Ray) -> T,
    filtered: impl FnOnce(&Bvh, &phalanx::Ray, &RayFilter) -> T,
) -> Result<T, ApiError> {
    let bvh = TREES.get(tree)?.for_one()?;
    // SAFETY: the caller's.
    let ray = unsafe { read("ray", ray) }?.ray();
    if filter.is_null() {
        return Ok(plain(bvh, &ray));
    }
    // SAFETY: the caller's.
    let filter = unsafe { structure(filter) }?;
    let accept = |hit: &phalanx::Hit| match filter.accept {
        Some(accept) => accept(filter.user, 0, &PhxHit::from(*hit)) != 0,
        None => true,
    };
    let filter = RayFilter {
        tnear: filter.tnear,
        mask: filter.mask,
        ignore: filter.ignore,
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
    guarded(|| {
        let place = OutPointer::of("hit", hit)?;
        // SAFETY: the caller's.
        unsafe {
            let hit = query((tree, ray, filter), Bvh::intersect, Bvh::intersect_filtered)?;
            place.write(hit.map_or(MISS, PhxHit::from));
        }
        Ok(())
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_occluded(
    tree: *const Opaque,
    ray: *const PhxRay,
    filter: *const PhxFilter,
    blocked: *mut c_int,
) -> PhxStatus {
    guarded(|| {
        let place = OutPointer::of("blocked", blocked)?;
        // SAFETY: the caller's.
        unsafe {
            let blocked = query((tree, ray, filter), Bvh::occluded, Bvh::occluded_filtered)?;
            place.write(blocked.into());
        }
        Ok(())
    })
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
    guarded(|| {
        let place = OutPointer::of("count", count)?;
        if capacity > 0 {
            OutPointer::of("hits", hits)?;
        }
        let all = |bvh: &Bvh, ray: &phalanx::Ray| bvh.all_hits_filtered(ray, &RayFilter::default());
        // SAFETY: the caller's.
        unsafe {
            let all = query((tree, ray, filter), all, Bvh::all_hits_filtered)?;
            for (k, hit) in all.iter().take(capacity).enumerate() {
                hits.add(k).write((*hit).into());
            }
            place.write(all.len());
        }
        Ok(())
    })
}

/// `phx_refined_hit`.
#[repr(C)]
pub struct PhxRefinedHit {
    pub t: f64,
    pub point: [f64; 3],
    pub normal: [f64; 3],
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_refine(
    scene: *const Opaque,
    origin: *const [f64; 3],
    direction: *const [f64; 3],
    hit: *const PhxHit,
    refined: *mut PhxRefinedHit,
) -> PhxStatus {
    guarded(|| {
        let place = OutPointer::of("refined", refined)?;
        // SAFETY: the caller's.
        let (origin, direction, hit) = unsafe {
            (
                read("origin", origin)?,
                read("direction", direction)?,
                read("hit", hit)?,
            )
        };
        let scene = reading(scene)?;
        if u64::from(hit.prim_id) >= scene.id_count() {
            return Err(ApiError::argument(format!(
                "the scene has no primitive {}",
                hit.prim_id
            )));
        }
        let phalanx::RefinedHit { t, point, normal } =
            refine(&scene, origin, direction, &hit.into());
        // SAFETY: the caller's.
        unsafe { place.write(PhxRefinedHit { t, point, normal }) };
        Ok(())
    })
}
