//! Many rays a call, from and to rows of the caller's memory.

use crate::ray::{MISS, PhxAccept, PhxHit};
use crate::rows::{
    OutPointer, OutputColumn, OutputColumns, PhxColumn, PhxRows, RowSpan, SizedStruct, structure,
    structure_if,
};
use crate::scene::reading;
use crate::status::{ApiError, PhxStatus, guarded};
use crate::table::{HandleTable, Opaque};
use crate::tree::TREES;
use phalanx::glam::{DAffine3, DVec3};
use phalanx::scene::PrimKind;
use phalanx::{
    AcceptHit, BatchError, BatchFilter, Bvh, HitColumns, HitLists, NO_PRIM, PerRay, RayBatch,
    RayBuffer, RayColumns, RayRows, Scene, refine,
};
use std::ffi::c_void;
use std::slice;
use std::sync::RwLockReadGuard;

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

/// `phx_hits`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PhxHits {
    pub size: usize,
    pub t: PhxColumn,
    pub u: PhxColumn,
    pub v: PhxColumn,
    pub prim_id: PhxColumn,
    pub geom_id: PhxColumn,
    pub local_prim_id: PhxColumn,
    pub inst_id: PhxColumn,
    pub normal: PhxColumn,
    pub scene: *const Opaque,
}

// SAFETY: numbers, rows, and pointers that may be null.
unsafe impl SizedStruct for PhxRays {
    const NAME: &'static str = "phx_rays";
}
// SAFETY: as before.
unsafe impl SizedStruct for PhxBatch {
    const NAME: &'static str = "phx_batch";
}
// SAFETY: as before.
unsafe impl SizedStruct for PhxHits {
    const NAME: &'static str = "phx_hits";
}

impl From<BatchError> for ApiError {
    fn from(error: BatchError) -> ApiError {
        ApiError::argument(error.to_string())
    }
}

/// CopiedNumbers of what the library does not take as it lies.
#[derive(Default)]
struct CopiedNumbers {
    rays: RayBuffer,
    tmax: Vec<f32>,
    tnear: Vec<f32>,
    mask: Vec<u32>,
    ignore: Vec<u32>,
}

impl PhxRays {
    /// The rays as the library takes them: as they lie, or copied if they must be.
    ///
    /// # Safety
    /// As the header says.
    unsafe fn batch<'r>(
        &self,
        outputs: &OutputColumns,
        copies: &'r mut CopiedNumbers,
    ) -> Result<RayBatch<'r>, ApiError> {
        let PhxRays {
            count,
            origin,
            direction,
            tmax,
            ..
        } = *self;
        let CopiedNumbers {
            rays, tmax: limits, ..
        } = copies;
        // SAFETY: the caller's.
        let tmax = unsafe { per_ray("tmax", tmax, count, (f32::INFINITY, outputs), limits) }?;
        let spans = [
            origin.check::<[f32; 3]>("origin", count)?,
            direction.check::<[f32; 3]>("direction", count)?,
        ];
        let stride = origin.stride;
        let is_rows = count > 0 && stride == direction.stride && stride >= size_of::<[f32; 3]>();
        if is_rows && !spans.iter().any(|span| outputs.overlap(span)) {
            // SAFETY: checked, the caller's, and no output overlaps it.
            let [origin, direction] = spans.map(|RowSpan { start, bytes, .. }| unsafe {
                slice::from_raw_parts(start as *const f32, bytes / size_of::<f32>())
            });
            let stride = stride / size_of::<f32>();
            return Ok(RayBatch::InRows(RayRows {
                origin,
                direction,
                stride,
                tmax,
            }));
        }
        *rays = RayBuffer::with_capacity(count);
        for k in 0..count {
            // SAFETY: checked, and the caller's.
            let [origin, direction]: [[f32; 3]; 2] = unsafe { [origin.get(k), direction.get(k)] };
            rays.push(&phalanx::Ray::new(origin, direction));
        }
        Ok(RayBatch::InColumns(RayColumns {
            tmax,
            ..rays.columns()
        }))
    }
}

/// Numbers of rays, copied if they must be; `none` for all where there are no rows.
///
/// # Safety
/// As the header says.
unsafe fn per_ray<'r, T: Copy>(
    what: &str,
    rows: PhxRows,
    count: usize,
    (none, outputs): (T, &OutputColumns),
    copy: &'r mut Vec<T>,
) -> Result<PerRay<'r, T>, ApiError> {
    if rows.data.is_null() {
        return Ok(PerRay::All(none));
    }
    let span = rows.check::<T>(what, count)?;
    // SAFETY: checked, the caller's, and borrowed only if no output overlaps it.
    Ok(unsafe {
        if count == 0 {
            PerRay::All(none)
        } else if rows.stride == 0 {
            PerRay::All(rows.get(0))
        } else if rows.stride == size_of::<T>() && !outputs.overlap(&span) {
            PerRay::Each(slice::from_raw_parts(rows.data.cast(), count))
        } else {
            copy.extend((0..count).map(|k| rows.get::<T>(k)));
            PerRay::Each(copy)
        }
    })
}

/// Passes on the rays of a batch, its filter if it has one, and its threads.
///
/// # Safety
/// As the header says.
unsafe fn with_batch<T>(
    (rays, batch): (*const PhxRays, *const PhxBatch),
    outputs: &OutputColumns,
    trace: impl FnOnce(RayBatch, Option<BatchFilter>, usize) -> Result<T, ApiError>,
) -> Result<T, ApiError> {
    outputs.check_apart()?;
    // SAFETY: the caller's.
    let (rays, batch) = unsafe { (structure(rays)?, structure_if(batch)?) };
    let (mut copies, mut numbers) = (CopiedNumbers::default(), CopiedNumbers::default());
    // SAFETY: the caller's.
    let input = unsafe { rays.batch(outputs, &mut copies) }?;
    let Some(batch) = batch else {
        return trace(input, None, 0);
    };
    let (user, count) = (User(batch.user), rays.count);
    let accept = batch.accept.map(|accept| {
        move |ray: usize, hit: &phalanx::Hit| accept(user.get(), ray, &PhxHit::from(*hit)) != 0
    });
    let rows = [batch.tnear, batch.mask, batch.ignore];
    let is_filtered = accept.is_some() || rows.iter().any(|rows| !rows.data.is_null());
    // SAFETY: the caller's.
    let filter = unsafe {
        BatchFilter {
            tnear: per_ray(
                "tnear",
                batch.tnear,
                count,
                (0.0, outputs),
                &mut numbers.tnear,
            )?,
            mask: per_ray(
                "mask",
                batch.mask,
                count,
                (u32::MAX, outputs),
                &mut numbers.mask,
            )?,
            ignore: per_ray(
                "ignore",
                batch.ignore,
                count,
                (NO_PRIM, outputs),
                &mut numbers.ignore,
            )?,
            accept: accept.as_ref().map(|accept| accept as &AcceptHit),
        }
    };
    trace(input, is_filtered.then_some(filter), batch.threads as usize)
}

/// The caller's pointer, which goes to each of its calls.
#[derive(Clone, Copy)]
struct User(*mut c_void);

// SAFETY: the library does not follow it.
unsafe impl Sync for User {}

impl User {
    fn get(&self) -> *mut c_void {
        self.0
    }
}

/// The columns of `phx_hits`, checked.
struct HitColumnsOut<'s> {
    t: Option<OutputColumn<f32>>,
    u: Option<OutputColumn<f32>>,
    v: Option<OutputColumn<f32>>,
    prim_id: Option<OutputColumn<u32>>,
    geom_id: Option<OutputColumn<u32>>,
    local_prim_id: Option<OutputColumn<u32>>,
    inst_id: Option<OutputColumn<u32>>,
    normal: Option<OutputColumn<[f32; 3]>>,
    scene: Option<RwLockReadGuard<'s, Scene>>,
}

impl HitColumnsOut<'_> {
    fn check(hits: &PhxHits, count: usize, outputs: &mut OutputColumns) -> Result<Self, ApiError> {
        let mut number =
            |name, column: &PhxColumn, miss| column.check(name, count, [miss, -1.0], outputs);
        let (t, u, v) = (
            number("t", &hits.t, MISS.t)?,
            number("u", &hits.u, 0.0)?,
            number("v", &hits.v, 0.0)?,
        );
        let mut id = |name, column: &PhxColumn| column.check(name, count, [NO_PRIM; 2], outputs);
        Ok(HitColumnsOut {
            t,
            u,
            v,
            prim_id: id("prim_id", &hits.prim_id)?,
            geom_id: id("geom_id", &hits.geom_id)?,
            local_prim_id: id("local_prim_id", &hits.local_prim_id)?,
            inst_id: id("inst_id", &hits.inst_id)?,
            normal: hits
                .normal
                .check("normal", count, [[0.0; 3], [-1.0; 3]], outputs)?,
            scene: None,
        })
    }
}

impl HitColumnsOut<'_> {
    /// All columns that the library knows, and none else, side by side.
    ///
    /// # Safety
    /// The caller's memory, for `count` rows.
    unsafe fn slices(&self, count: usize) -> Option<HitColumns<'_>> {
        if self.local_prim_id.is_some() || self.scene.is_some() {
            return None;
        }
        // SAFETY: the caller's; columns do not overlap.
        unsafe {
            Some(HitColumns {
                t: self.t.as_ref()?.slice(count)?,
                u: self.u.as_ref()?.slice(count)?,
                v: self.v.as_ref()?.slice(count)?,
                prim_id: self.prim_id.as_ref()?.slice(count)?,
                geom_id: self.geom_id.as_ref()?.slice(count)?,
            })
        }
    }

    /// Writes the hit of ray `k`.
    ///
    /// # Safety
    /// The caller's memory, which has a row `k` that no other thread writes.
    unsafe fn put(&self, (bvh, rays): (&Bvh, &RayBatch), k: usize, hit: Option<phalanx::Hit>) {
        // SAFETY: the caller's.
        unsafe {
            put(&self.t, k, hit.map(|hit| hit.t));
            put(&self.u, k, hit.map(|hit| hit.u));
            put(&self.v, k, hit.map(|hit| hit.v));
            put(&self.prim_id, k, hit.map(|hit| hit.prim_id));
            put(&self.geom_id, k, hit.map(|hit| hit.geom_id));
            if let Some(column) = &self.local_prim_id {
                let first = |hit: &phalanx::Hit| bvh.first_prim(hit.geom_id).unwrap_or(0);
                column.put(k, hit.map(|hit| hit.prim_id - first(&hit)));
            }
            let Some(scene) = &self.scene else { return };
            let is_instance = |hit: &phalanx::Hit| hit.prim_id as usize >= scene.prim_count();
            put(
                &self.inst_id,
                k,
                hit.filter(is_instance).map(|hit| hit.geom_id),
            );
            if let Some(column) = &self.normal {
                column.put(k, hit.map(|hit| normal_of(scene, &rays.ray(k), &hit)));
            }
        }
    }
}

/// Writes an answer if it is wanted.
///
/// # Safety
/// As [`OutputColumn::put`].
#[inline(always)]
unsafe fn put<T: Copy>(column: &Option<OutputColumn<T>>, k: usize, answer: Option<T>) {
    if let Some(column) = column {
        // SAFETY: the caller's.
        unsafe { column.put(k, answer) }
    }
}

/// Normal of a surface: of a triangle twice its area long, of anything else of length 1.
fn normal_of(scene: &Scene, ray: &phalanx::Ray, hit: &phalanx::Hit) -> [f32; 3] {
    let resolved = scene.resolve(hit.prim_id);
    let prim = scene.prims[resolved.prim as usize];
    if prim.kind() != PrimKind::Triangle {
        let refined = refine(
            scene,
            ray.origin.map(f64::from),
            ray.direction.map(f64::from),
            hit,
        );
        return refined.normal.map(|c| c as f32);
    }
    let mut corners = scene
        .triangles
        .corners(prim.index())
        .map(|corner| corner.as_dvec3());
    if let Some(instance) = resolved.instance {
        let [x, y, z, offset] =
            (scene.instances.world_columns(instance as usize)).map(|c| c.as_dvec3());
        let to_world = DAffine3::from_cols(x, y, z, offset);
        corners = corners.map(|corner| to_world.transform_point3(corner));
    }
    let [a, b, c]: [DVec3; 3] = corners;
    (b - a).cross(c - a).as_vec3().into()
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
        let (count, hits) = unsafe { (structure(rays)?.count, structure(hits)?) };
        let mut outputs = OutputColumns::default();
        let mut columns = HitColumnsOut::check(&hits, count, &mut outputs)?;
        if columns.inst_id.is_some() || columns.normal.is_some() {
            let scene = reading(hits.scene)?;
            if !bvh.is_current(&scene) {
                return Err(ApiError::argument(
                    "the tree is not that of the scene as it is now",
                ));
            }
            columns.scene = Some(scene);
        }
        // SAFETY: the caller's, checked; each ray's rows are written once.
        unsafe {
            with_batch((rays, batch), &outputs, |rays, filter, threads| {
                if let (None, Some(mut slices)) = (&filter, columns.slices(count)) {
                    return Ok(bvh.intersect_batch(rays, &mut slices, threads)?);
                }
                let put = |k: usize, hit: Option<phalanx::Hit>| columns.put((bvh, &rays), k, hit);
                Ok(match filter {
                    None => bvh.intersect_batch_each(rays, threads, put),
                    Some(filter) => bvh.intersect_batch_filtered_each(rays, &filter, threads, put),
                }?)
            })
        }
    })
}

/// A column that a call is for.
fn wanted<T: Copy>(
    column: &PhxColumn,
    (name, count): (&'static str, usize),
    misses: [T; 2],
    outputs: &mut OutputColumns,
) -> Result<OutputColumn<T>, ApiError> {
    let null = || ApiError::argument(format!("{name} is null"));
    column.check(name, count, misses, outputs)?.ok_or_else(null)
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
        // SAFETY: the caller's.
        let count = unsafe { structure(rays) }?.count;
        let mut outputs = OutputColumns::default();
        let column = wanted(&blocked, ("blocked", count), [0u8, u8::MAX], &mut outputs)?;
        let mut flags = vec![false; count];
        // SAFETY: the caller's, checked.
        unsafe {
            with_batch((rays, batch), &outputs, |rays, filter, threads| {
                Ok(match filter {
                    None => bvh.occluded_batch(rays, &mut flags, threads),
                    Some(filter) => bvh.occluded_batch_filtered(rays, &filter, &mut flags, threads),
                }?)
            })?;
            (flags.iter().enumerate()).for_each(|(k, flag)| column.put(k, flag.then_some(1)));
        }
        Ok(())
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
        // SAFETY: the caller's.
        let count = unsafe { structure(rays) }?.count;
        let mut outputs = OutputColumns::default();
        let column = wanted(&counts, ("counts", count), [0, u32::MAX], &mut outputs)?;
        let mut numbers = vec![0; count];
        // SAFETY: the caller's, checked.
        unsafe {
            with_batch(
                (rays, batch),
                &outputs,
                |rays, filter, threads| match filter {
                    None => Ok(bvh.count_batch(rays, &mut numbers, threads)?),
                    Some(filter) => {
                        let lists = bvh.all_hits_batch_filtered(rays, &filter, threads)?;
                        let counts = (0..count).map(|k| lists.rows(k).len() as u32);
                        numbers
                            .iter_mut()
                            .zip(counts)
                            .for_each(|(place, count)| *place = count);
                        Ok(())
                    }
                },
            )?;
            let number = |n: &u32| (*n > 0).then_some(*n);
            (numbers.iter().enumerate()).for_each(|(k, n)| column.put(k, number(n)));
        }
        Ok(())
    })
}

static LISTS: HandleTable<Lists> = HandleTable::new(0x4c, "list of hits");

/// Memory of `phx_hit_lists`.
#[expect(dead_code, reason = "C reads it")]
struct Lists {
    starts: Vec<usize>,
    hits: Vec<PhxHit>,
}

/// `phx_hit_lists`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PhxHitLists {
    pub size: usize,
    pub ray_count: usize,
    pub hit_count: usize,
    pub starts: *const usize,
    pub hits: *const PhxHit,
    pub memory: *mut Opaque,
}

// SAFETY: numbers, and pointers that may be null.
unsafe impl SizedStruct for PhxHitLists {
    const NAME: &'static str = "phx_hit_lists";
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_all_hits_batch(
    tree: *const Opaque,
    rays: *const PhxRays,
    batch: *const PhxBatch,
    lists: *mut PhxHitLists,
) -> PhxStatus {
    guarded(|| {
        let bvh = &*TREES.get(tree)?.for_many()?;
        // SAFETY: the caller's.
        let (count, mut out) = unsafe { (structure(rays)?.count, structure(lists)?) };
        // SAFETY: the caller's.
        let HitLists {
            starts,
            t,
            u,
            v,
            prim_id,
            geom_id,
        } = unsafe {
            with_batch(
                (rays, batch),
                &OutputColumns::default(),
                |rays, filter, threads| {
                    Ok(match filter {
                        None => bvh.all_hits_batch(rays, threads),
                        Some(filter) => bvh.all_hits_batch_filtered(rays, &filter, threads),
                    }?)
                },
            )
        }?;
        let hit = |k: usize| PhxHit {
            t: t[k],
            u: u[k],
            v: v[k],
            prim_id: prim_id[k],
            geom_id: geom_id[k],
        };
        let hits: Vec<PhxHit> = (0..t.len()).map(hit).collect();
        (out.ray_count, out.hit_count) = (count, hits.len());
        (out.starts, out.hits) = (starts.as_ptr(), hits.as_ptr());
        out.memory = LISTS.insert(Lists { starts, hits })?;
        // SAFETY: the caller's.
        unsafe { OutPointer::of("lists", lists)?.write(out) };
        Ok(())
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_hit_lists_free(lists: *mut PhxHitLists) -> PhxStatus {
    guarded(|| {
        // SAFETY: the caller's.
        let known = unsafe { structure(lists) }?;
        if !known.memory.is_null() {
            LISTS.remove(known.memory)?;
        }
        // SAFETY: zeros are valid, and the memory is the caller's.
        unsafe {
            OutPointer::of("lists", lists)?.write(PhxHitLists {
                size: known.size,
                ..std::mem::zeroed()
            })
        };
        Ok(())
    })
}
