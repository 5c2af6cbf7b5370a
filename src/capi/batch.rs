//! Many rays a call, from and to rows of the caller's memory.

use crate::columns::{OutputColumn, PhxColumn};
use crate::hits::{AnswerColumns, PhxHits};
use crate::ray::PhxAccept;
use crate::rows::{PhxRows, RowSpan, WrittenRows, check_reserved, structure, structure_or_zeros};
use crate::status::{ApiError, PhxStatus, answer, guarded};
use crate::table::{HandleTable, Opaque};
use crate::tree::TREES;
use phalanx::{
    AcceptHit, BatchError, BatchFilter, Hit, HitLists, NO_PRIM, PerRay, RayBatch, RayRows,
};
use std::borrow::Cow;
use std::ffi::c_void;
use std::{mem, slice};

/// `phx_rays`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PhxRays {
    pub size: usize,
    pub count: usize,
    pub origin: PhxRows,
    pub direction: PhxRows,
    pub tmax: PhxRows,
}

/// `phx_batch`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PhxBatch {
    pub size: usize,
    pub tnear: PhxRows,
    pub mask: PhxRows,
    pub ignore: PhxRows,
    pub accept: PhxAccept,
    pub user: *mut c_void,
    pub threads: u32,
    pub reserved: u32,
}

impl From<BatchError> for ApiError {
    fn from(error: BatchError) -> ApiError {
        ApiError::argument(error.to_string())
    }
}

impl PhxRays {
    /// The rays as the library takes them: as they lie, or in `copies` if they must be.
    ///
    /// # Safety
    /// As the header says.
    unsafe fn batch<'r>(
        &self,
        tmax: PerRay<'r, f32>,
        outputs: &WrittenRows,
        copies: &'r mut Vec<[[f32; 3]; 2]>,
    ) -> Result<RayBatch<'r>, ApiError> {
        let origins = self.origin.check::<[f32; 3]>("origin", self.count)?;
        let directions = self.direction.check::<[f32; 3]>("direction", self.count)?;
        let stride = self.origin.stride;
        if stride != self.direction.stride
            || stride < size_of::<[f32; 3]>()
            || self.count == 0
            || outputs.overlap(&origins)
            || outputs.overlap(&directions)
        {
            // SAFETY: checked, and the caller's.
            let ray = |k| unsafe { [self.origin.get(k), self.direction.get(k)] };
            *copies = (0..self.count).map(ray).collect();
            let numbers = copies.as_flattened().as_flattened();
            return Ok(RayBatch::InRows(RayRows {
                origin: &numbers[..numbers.len().saturating_sub(3)],
                direction: numbers.get(3..).unwrap_or(&[]),
                stride: 6,
                tmax,
            }));
        }
        // SAFETY: checked, the caller's, and no output overlaps it.
        let [origin, direction] = [origins, directions].map(|span: RowSpan| unsafe {
            slice::from_raw_parts(span.start as *const f32, span.bytes / size_of::<f32>())
        });
        Ok(RayBatch::InRows(RayRows {
            origin,
            direction,
            stride: stride / size_of::<f32>(),
            tmax,
        }))
    }
}

/// The numbers of `count` rays: of none if there are no rows, of one if all have the same.
///
/// # Safety
/// As the header says.
unsafe fn numbers<'r, T: Copy>(
    what: &str,
    rows: PhxRows,
    count: usize,
    outputs: &WrittenRows,
) -> Result<Cow<'r, [T]>, ApiError> {
    let count = match rows.stride {
        _ if rows.data.is_null() => 0,
        0 => count.min(1),
        _ => count,
    };
    // SAFETY: the caller's.
    unsafe { rows.all(what, count, outputs) }
}

/// The same as the library takes them, with a number for all where there is none.
fn per_ray<'r, T: Copy>(numbers: &'r [T], without: T) -> PerRay<'r, T> {
    match numbers {
        [] => PerRay::All(without),
        [one] => PerRay::All(*one),
        each => PerRay::Each(each),
    }
}

/// The caller's pointer, which goes to each of its calls.
#[derive(Clone, Copy)]
struct UserPointer(*mut c_void);

// SAFETY: the library does not follow it.
unsafe impl Sync for UserPointer {}

impl UserPointer {
    fn get(&self) -> *mut c_void {
        self.0
    }
}

/// Passes on the rays of a batch, its filter if it has one, and its threads.
///
/// # Safety
/// As the header says.
unsafe fn with_batch<T>(
    (rays, batch): (PhxRays, *const PhxBatch),
    outputs: &WrittenRows,
    trace: impl FnOnce(RayBatch, Option<BatchFilter>, usize) -> Result<T, ApiError>,
) -> Result<T, ApiError> {
    outputs.check_apart()?;
    // SAFETY: the caller's.
    let batch = unsafe { structure_or_zeros(batch) }?;
    check_reserved(batch.reserved)?;
    let (count, mut copies) = (rays.count, Vec::new());
    // SAFETY: the caller's.
    let (tmax, tnear, mask, ignore) = unsafe {
        (
            numbers("tmax", rays.tmax, count, outputs)?,
            numbers("tnear", batch.tnear, count, outputs)?,
            numbers("mask", batch.mask, count, outputs)?,
            numbers("ignore", batch.ignore, count, outputs)?,
        )
    };
    // SAFETY: the caller's.
    let input = unsafe { rays.batch(per_ray(&tmax, f32::INFINITY), outputs, &mut copies) }?;
    let user = UserPointer(batch.user);
    let accept =
        (batch.accept).map(|accept| move |k: usize, hit: &Hit| accept(user.get(), k, hit) != 0);
    let filter = BatchFilter {
        tnear: per_ray(&tnear, 0.0),
        mask: per_ray(&mask, u32::MAX),
        ignore: per_ray(&ignore, NO_PRIM),
        accept: accept.as_ref().map(|accept| accept as &AcceptHit),
    };
    let accepts_all = accept.is_none() && tnear.is_empty() && mask.is_empty() && ignore.is_empty();
    let filter = (!accepts_all).then_some(filter);
    trace(input, filter, batch.threads as usize)
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_intersect_batch(
    tree: *const Opaque,
    rays: *const PhxRays,
    batch: *const PhxBatch,
    hits: *const PhxHits,
) -> PhxStatus {
    guarded(|| {
        let bvh = &*TREES.get(tree)?.for_many()?;
        // SAFETY: the caller's.
        let (rays, hits) = unsafe { (structure(rays)?, structure(hits)?) };
        let (count, mut outputs) = (rays.count, WrittenRows::none());
        let columns = AnswerColumns::check(&hits, bvh, count, &mut outputs)?;
        let trace = |rays: RayBatch, filter: Option<BatchFilter>, threads: usize| {
            // SAFETY: the caller's, checked; each ray's rows are written once.
            let put = |k: usize, hit: Option<Hit>| unsafe { columns.put((bvh, &rays), k, hit) };
            // SAFETY: the caller's, checked.
            Ok(match (filter, unsafe { columns.slices(count) }) {
                (Some(filter), _) => bvh.intersect_batch_filtered_each(rays, &filter, threads, put),
                (None, Some(mut slices)) => bvh.intersect_batch(rays, &mut slices, threads),
                (None, None) => bvh.intersect_batch_each(rays, threads, put),
            }?)
        };
        // SAFETY: the caller's.
        unsafe { with_batch((rays, batch), &outputs, trace) }
    })
}

/// Checks the only column of a call, and lets `write` answer all rays of a batch there.
///
/// # Safety
/// As the header says, and `A` is laid out as `T`.
unsafe fn fill<T: Copy, A: Copy + Default + PartialEq + Into<T>>(
    (rays, batch): (*const PhxRays, *const PhxBatch),
    (name, column, misses): (&'static str, PhxColumn, [T; 2]),
    write: impl FnOnce(RayBatch, Option<BatchFilter>, usize, &mut [A]) -> Result<(), BatchError>,
) -> Result<(), ApiError> {
    // SAFETY: the caller's.
    let rays = unsafe { structure(rays) }?;
    let (count, mut outputs) = (rays.count, WrittenRows::none());
    let column: Option<OutputColumn<T>> = column.check(name, count, misses, &mut outputs)?;
    let column = column.ok_or_else(|| ApiError::argument(format!("{name} is null")))?;
    // SAFETY: the caller's, checked.
    unsafe {
        with_batch((rays, batch), &outputs, |rays, filter, threads| {
            column.fill(count, |answers| Ok(write(rays, filter, threads, answers)?))
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_occluded_batch(
    tree: *const Opaque,
    rays: *const PhxRays,
    batch: *const PhxBatch,
    blocked: PhxColumn,
) -> PhxStatus {
    guarded(|| {
        let bvh = &*TREES.get(tree)?.for_many()?;
        let column = ("blocked", blocked, [0u8, u8::MAX]);
        // SAFETY: the caller's.
        unsafe {
            fill(
                (rays, batch),
                column,
                |rays, filter, threads, flags: &mut [bool]| match filter {
                    None => bvh.occluded_batch(rays, flags, threads),
                    Some(filter) => bvh.occluded_batch_filtered(rays, &filter, flags, threads),
                },
            )
        }
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_count_batch(
    tree: *const Opaque,
    rays: *const PhxRays,
    batch: *const PhxBatch,
    counts: PhxColumn,
) -> PhxStatus {
    guarded(|| {
        let bvh = &*TREES.get(tree)?.for_many()?;
        let column = ("counts", counts, [0, u32::MAX]);
        // SAFETY: the caller's.
        unsafe {
            fill(
                (rays, batch),
                column,
                |rays, filter, threads, counts: &mut [u32]| {
                    let Some(filter) = filter else {
                        return bvh.count_batch(rays, counts, threads);
                    };
                    let lists = bvh.all_hits_batch_filtered(rays, &filter, threads)?;
                    let lengths = lists
                        .starts
                        .windows(2)
                        .map(|ends| (ends[1] - ends[0]) as u32);
                    counts
                        .iter_mut()
                        .zip(lengths)
                        .for_each(|(count, length)| *count = length);
                    Ok(())
                },
            )
        }
    })
}

static LISTS: HandleTable<HitLists> = HandleTable::new(0x4c, "list of hits");

/// `phx_hit_lists`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PhxHitLists {
    pub size: usize,
    pub ray_count: usize,
    pub hit_count: usize,
    pub starts: *const usize,
    pub t: *const f32,
    pub u: *const f32,
    pub v: *const f32,
    pub prim_id: *const u32,
    pub geom_id: *const u32,
    pub memory: *mut Opaque,
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_all_hits_batch(
    tree: *const Opaque,
    rays: *const PhxRays,
    batch: *const PhxBatch,
    lists: *mut PhxHitLists,
) -> PhxStatus {
    let trace = |rays: RayBatch, filter: Option<BatchFilter>, threads: usize| {
        let bvh = &*TREES.get(tree)?.for_many()?;
        Ok(match filter {
            None => bvh.all_hits_batch(rays, threads),
            Some(filter) => bvh.all_hits_batch_filtered(rays, &filter, threads),
        }?)
    };
    // SAFETY: the caller's.
    unsafe {
        answer("lists", lists, || {
            let PhxHitLists { size, memory, .. } = structure(lists)?;
            if !memory.is_null() {
                let words = "the lists are in use: phx_hit_lists_free empties them";
                return Err(ApiError::argument(words));
            }
            let all = with_batch((structure(rays)?, batch), WrittenRows::NONE, trace)?;
            Ok(PhxHitLists {
                size,
                ray_count: all.starts.len() - 1,
                hit_count: all.t.len(),
                starts: all.starts.as_ptr(),
                t: all.t.as_ptr(),
                u: all.u.as_ptr(),
                v: all.v.as_ptr(),
                prim_id: all.prim_id.as_ptr(),
                geom_id: all.geom_id.as_ptr(),
                memory: LISTS.insert(all)?,
            })
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_hit_lists_free(lists: *mut PhxHitLists) -> PhxStatus {
    if lists.is_null() {
        return PhxStatus::Ok;
    }
    // SAFETY: the caller's; zeros are valid.
    unsafe {
        answer("lists", lists, || {
            let PhxHitLists { size, memory, .. } = structure(lists)?;
            if !memory.is_null() {
                LISTS.remove(memory)?;
            }
            Ok(PhxHitLists {
                size,
                ..mem::zeroed()
            })
        })
    }
}
