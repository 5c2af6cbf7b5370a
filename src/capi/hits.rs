//! Columns of a batch's closest hits, and what is computed for them.

use crate::columns::{OutputColumn, PhxColumn};
use crate::ray::MISS;
use crate::rows::WrittenRows;
use crate::scene::reading;
use crate::status::ApiError;
use crate::table::Opaque;
use phalanx::{Bvh, Hit, HitColumns, NO_PRIM, Ray, RayBatch, Scene, refine, world_corners};
use std::sync::RwLockReadGuard;

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

/// The columns, checked; those that are not wanted are `None`.
pub struct AnswerColumns<'s> {
    t: Option<OutputColumn<f32>>,
    u: Option<OutputColumn<f32>>,
    v: Option<OutputColumn<f32>>,
    prim_id: Option<OutputColumn<u32>>,
    geom_id: Option<OutputColumn<u32>>,
    local_prim_id: Option<OutputColumn<u32>>,
    inst_id: Option<OutputColumn<u32>>,
    normal: Option<OutputColumn<[f32; 3]>>,
    /// Where a column needs it.
    scene: Option<RwLockReadGuard<'s, Scene>>,
}

impl AnswerColumns<'_> {
    pub fn check(
        hits: &PhxHits,
        bvh: &Bvh,
        count: usize,
        outputs: &mut WrittenRows,
    ) -> Result<Self, ApiError> {
        let no_normal = [[0.0; 3], [-1.0; 3]];
        let normal = hits.normal.check("normal", count, no_normal, outputs)?;
        let mut number =
            |name, column: &PhxColumn, miss: f32| column.check(name, count, [miss, -1.0], outputs);
        let t = number("t", &hits.t, MISS.t)?;
        let u = number("u", &hits.u, MISS.u)?;
        let v = number("v", &hits.v, MISS.v)?;
        let mut id = |name, column: &PhxColumn| column.check(name, count, [NO_PRIM; 2], outputs);
        let columns = AnswerColumns {
            t,
            u,
            v,
            prim_id: id("prim_id", &hits.prim_id)?,
            geom_id: id("geom_id", &hits.geom_id)?,
            local_prim_id: id("local_prim_id", &hits.local_prim_id)?,
            inst_id: id("inst_id", &hits.inst_id)?,
            normal,
            scene: None,
        };
        if columns.inst_id.is_none() && columns.normal.is_none() {
            return Ok(columns);
        }
        if hits.scene.is_null() {
            let words = "phx_hits.scene is null, and inst_id and normal need it";
            return Err(ApiError::argument(words));
        }
        let scene = reading(hits.scene)?;
        if !bvh.is_current(&scene) {
            let words = "the tree is not that of the scene as it is now: see phx_tree_update";
            return Err(ApiError::argument(words));
        }
        Ok(AnswerColumns {
            scene: Some(scene),
            ..columns
        })
    }

    /// The columns that the library knows, if there are all of them, plain ones, and no others.
    ///
    /// # Safety
    /// The caller's memory, for `count` rows.
    pub unsafe fn slices(&self, count: usize) -> Option<HitColumns<'_>> {
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
    #[inline(always)]
    pub unsafe fn put(&self, (bvh, rays): (&Bvh, &RayBatch), k: usize, hit: Option<Hit>) {
        // SAFETY: the caller's.
        unsafe {
            put(&self.t, k, hit, |hit| hit.t);
            put(&self.u, k, hit, |hit| hit.u);
            put(&self.v, k, hit, |hit| hit.v);
            put(&self.prim_id, k, hit, |hit| hit.prim_id);
            put(&self.geom_id, k, hit, |hit| hit.geom_id);
            put(&self.local_prim_id, k, hit, |hit| {
                hit.prim_id - bvh.first_prim(hit.geom_id).unwrap_or(0)
            });
            let Some(scene) = &self.scene else { return };
            let in_instance = hit.filter(|hit| hit.prim_id as usize >= scene.prim_count());
            put(&self.inst_id, k, in_instance, |hit| hit.geom_id);
            put(&self.normal, k, hit, |hit| {
                normal_of(scene, &rays.ray(k), &hit)
            });
        }
    }
}

/// Writes a part of a hit if it is wanted.
///
/// # Safety
/// As [`OutputColumn::put`].
#[inline(always)]
unsafe fn put<T: Copy>(
    column: &Option<OutputColumn<T>>,
    k: usize,
    hit: Option<Hit>,
    part: impl FnOnce(Hit) -> T,
) {
    if let Some(column) = column {
        // SAFETY: the caller's.
        unsafe { column.put(k, hit.map(part)) }
    }
}

/// Normal of a surface: of a triangle twice its area long, of anything else of length 1.
fn normal_of(scene: &Scene, ray: &Ray, hit: &Hit) -> [f32; 3] {
    if let Some([a, b, c]) = world_corners(scene, hit.prim_id) {
        return (b - a).cross(c - a).as_vec3().into();
    }
    let [origin, direction] = [ray.origin, ray.direction].map(|v| v.map(f64::from));
    refine(scene, origin, direction, hit)
        .normal
        .map(|c| c as f32)
}
