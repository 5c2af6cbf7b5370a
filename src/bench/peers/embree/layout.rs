//! Memory layout of the data that is passed to Embree and back.
//!
//! Layouts were read from `rtcore_ray.h`, `rtcore_common.h` and `rtcore_scene.h` of 3.13.5 and
//! 4.4.0. Rays and hits are the same in both. Both can be compiled with more than one level of
//! instances, which lengthens `RTCHit`, and version 4 with arrays of instances, which adds a row to
//! it. Both only append, so that some space after the hit is enough. In version 3 more levels also
//! move a field of the context; then instances are missed, with no other consequences.

use std::ffi::c_void;
use std::ptr::{null, null_mut};

/// `RTC_INVALID_GEOMETRY_ID`.
pub(super) const INVALID: u32 = u32::MAX;

/// The first half of `RTCRay`, `RTCRay8` or `RTCRay16`: rows of origin x y z, tnear, direction x y
/// z, time.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
pub(super) struct RayHeader<const N: usize>(pub(super) [[f32; N]; 8]);

/// `RTCRayHit`, `RTCRayHit8` or `RTCRayHit16`; it begins with an `RTCRay` of the same width.
#[repr(C, align(64))]
pub(super) struct RayHit<const N: usize> {
    pub(super) header: RayHeader<N>,
    /// Input: the largest distance of a hit. Output: the distance of the hit, or −∞ where an
    /// occlusion query found one.
    pub(super) tfar: [f32; N],
    mask: [u32; N],
    id: [u32; N],
    flags: [u32; N],
    ng: [[f32; N]; 3],
    pub(super) u: [f32; N],
    pub(super) v: [f32; N],
    /// Primitive id. In and, where nothing is hit, out: [`INVALID`].
    pub(super) prim: [u32; N],
    /// Geometry id. In and, where nothing is hit, out: [`INVALID`].
    pub(super) geometry: [u32; N],
    /// The instance that was hit, or [`INVALID`]; undefined where nothing is hit.
    pub(super) instance: [u32; N],
    /// Space for further levels of instances, and for version 4's arrays of instances, in libraries
    /// compiled for those.
    context_stack: [[u32; N]; 17],
}

impl<const N: usize> RayHit<N> {
    pub(super) fn new() -> RayHit<N> {
        RayHit {
            header: RayHeader([[0.0; N]; 8]),
            tfar: [0.0; N],
            mask: [u32::MAX; N],
            id: [0; N],
            flags: [0; N],
            ng: [[0.0; N]; 3],
            u: [0.0; N],
            v: [0.0; N],
            prim: [INVALID; N],
            geometry: [INVALID; N],
            instance: [INVALID; N],
            context_stack: [[INVALID; N]; 17],
        }
    }
}

/// Mask of the valid rays of a packet: −1 or 0.
#[repr(C, align(64))]
pub(super) struct Valid<const N: usize>(pub(super) [i32; N]);

/// Arguments of a query, for either version. Values that both versions need are written twice;
/// unused options stay zero.
pub(super) struct QueryArguments {
    pub(super) arguments: Arguments4,
    pub(super) context: Context3,
}

/// `RTCIntersectArguments` and `RTCOccludedArguments` of version 4.
#[repr(C)]
pub(super) struct Arguments4 {
    flags: u32,
    features: u32,
    /// Null: the library creates a context.
    context: *mut c_void,
    filter: *const c_void,
    callback: *const c_void,
    /// Factor that is only read where the library is compiled for curves of least width.
    min_width_distance_factor: f32,
}

/// `RTCIntersectContext` of version 3, for one level of instances.
#[repr(C)]
pub(super) struct Context3 {
    flags: u32,
    filter: *const c_void,
    instance: u32,
    /// Factor that is only read where the library is compiled for curves of least width.
    min_width_distance_factor: f32,
    /// Space for further levels of instances, in libraries compiled for that.
    room: [u32; 16],
}

impl QueryArguments {
    /// Arguments for coherent rays, or for any.
    pub(super) fn new(coherent: bool) -> QueryArguments {
        QueryArguments {
            arguments: Arguments4 {
                flags: u32::from(coherent) << 16,
                features: u32::MAX,
                context: null_mut(),
                filter: null(),
                callback: null(),
                min_width_distance_factor: 0.0,
            },
            context: Context3 {
                flags: u32::from(coherent),
                filter: null(),
                instance: INVALID,
                min_width_distance_factor: 0.0,
                room: [0; 16],
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::offset_of;

    /// Checks the offsets against the headers, in rows of N words.
    fn check_layout<const N: usize>() {
        let row = 4 * N;
        assert_eq!(offset_of!(RayHit<N>, tfar), 8 * row);
        assert_eq!(offset_of!(RayHit<N>, flags), 11 * row);
        assert_eq!(offset_of!(RayHit<N>, ng), 12 * row);
        assert_eq!(offset_of!(RayHit<N>, u), 15 * row);
        assert_eq!(offset_of!(RayHit<N>, prim), 17 * row);
        assert_eq!(offset_of!(RayHit<N>, geometry), 18 * row);
        assert_eq!(offset_of!(RayHit<N>, instance), 19 * row);
        assert!(size_of::<RayHit<N>>() >= (20 + 16) * row);
    }

    #[test]
    fn layouts_are_those_of_the_headers() {
        check_layout::<1>();
        check_layout::<8>();
        check_layout::<16>();
        assert_eq!(size_of::<RayHeader<1>>(), 32);
        assert_eq!(offset_of!(Arguments4, context), 8);
        assert_eq!(offset_of!(Arguments4, callback), 24);
        assert_eq!(offset_of!(Context3, filter), 8);
        assert_eq!(offset_of!(Context3, instance), 16);
    }
}
