//! Trees: built, updated, copied.

use crate::rows::structure_or_zeros;
use crate::scene::reading;
use crate::status::{ApiError, PhxStatus, answer, guarded, misplaced};
use crate::table::{HandleTable, Opaque};
use phalanx::{BuildSettings, Bvh, Quality, UpdateMode, UpdateReport};
use std::cell::UnsafeCell;
use std::mem;
use std::ops::Deref;
use std::sync::{PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard, TryLockError};

pub static TREES: HandleTable<Tree> = HandleTable::new(0x54, "tree");

/// A tree, and who uses it. Single rays take no lock, for speed: the header forbids to update or
/// destroy their tree meanwhile.
pub struct Tree {
    bvh: UnsafeCell<Bvh>,
    /// Read by batches and copies, written by changes; poisoned by a change that has panicked.
    users: RwLock<()>,
}

// SAFETY: `bvh` is changed by who holds `users` alone, beside whom there are no batches, and no
// single rays may be.
unsafe impl Sync for Tree {}

/// A tree while it is used for longer than a ray.
pub struct UsedTree<'t>(
    &'t Bvh,
    #[expect(dead_code, reason = "held")] RwLockReadGuard<'t, ()>,
);

impl Deref for UsedTree<'_> {
    type Target = Bvh;

    fn deref(&self) -> &Bvh {
        self.0
    }
}

impl Tree {
    /// The tree, for one ray.
    #[inline(always)]
    pub fn for_one(&self) -> Result<&Bvh, ApiError> {
        if self.users.is_poisoned() {
            return Err(refuse("", TryLockError::Poisoned(PoisonError::new(()))));
        }
        // SAFETY: nobody may change it during a query.
        Ok(unsafe { &*self.bvh.get() })
    }

    /// The tree, for longer.
    pub fn for_many(&self) -> Result<UsedTree<'_>, ApiError> {
        let guard = self.users.try_read();
        let guard = guard.map_err(|error| refuse("the tree is being updated", error))?;
        // SAFETY: nobody changes it while there are users.
        Ok(UsedTree(unsafe { &*self.bvh.get() }, guard))
    }

    /// Takes the tree for a change, unless it is used.
    fn take(&self) -> Result<RwLockWriteGuard<'_, ()>, ApiError> {
        let guard = self.users.try_write();
        guard.map_err(|error| refuse("the tree is used by a batch or an update", error))
    }
}

#[cold]
fn refuse<T>(busy: &str, error: TryLockError<T>) -> ApiError {
    match error {
        TryLockError::WouldBlock => ApiError(PhxStatus::Busy, busy.into()),
        TryLockError::Poisoned(_) => ApiError(
            PhxStatus::Internal,
            "an update of the tree has failed".into(),
        ),
    }
}

/// `phx_build_settings`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PhxBuildSettings {
    pub size: usize,
    pub quality: i32,
    pub threads: u32,
}

/// `phx_update_settings`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PhxUpdateSettings {
    pub size: usize,
    pub mode: i32,
}

/// `phx_update_result`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PhxUpdateResult {
    pub size: usize,
    pub geom_ids: *mut u32,
    pub capacity: usize,
    pub refitted: u32,
    pub built: u32,
    pub removed: u32,
    pub work: i32,
    pub cost_growth: f64,
}

impl PhxUpdateSettings {
    fn mode(self) -> Result<UpdateMode, ApiError> {
        match self.mode {
            0 => Ok(UpdateMode::Auto),
            1 => Ok(UpdateMode::RefitOnly),
            2 => Ok(UpdateMode::Rebuild),
            other => Err(ApiError::argument(format!("mode is {other}: 0, 1 or 2"))),
        }
    }
}

impl PhxUpdateResult {
    /// Takes a report.
    ///
    /// # Safety
    /// `geom_ids` is null, or memory of `capacity` numbers.
    unsafe fn set(&mut self, report: &UpdateReport, bvh: &Bvh) {
        let lists = [&report.refitted, &report.built, &report.removed];
        [self.refitted, self.built, self.removed] = lists.map(|list| list.len() as u32);
        self.work = report.work as i32;
        self.cost_growth = bvh.cost_growth();
        if !self.geom_ids.is_null() {
            let ids = lists.into_iter().flatten().take(self.capacity);
            for (k, &id) in ids.enumerate() {
                // SAFETY: the caller's.
                unsafe { self.geom_ids.add(k).write(id) };
            }
        }
    }
}

impl PhxBuildSettings {
    fn checked(self) -> Result<BuildSettings, ApiError> {
        let quality = match self.quality {
            0 => Quality::Medium,
            1 => Quality::Fast,
            2 => Quality::Best,
            other => return Err(ApiError::argument(format!("quality is {other}: 0, 1 or 2"))),
        };
        let threads = self.threads as usize;
        Ok(BuildSettings { quality, threads })
    }
}

/// Keeps a tree, and returns its handle.
fn keep(bvh: Bvh) -> Result<*mut Opaque, ApiError> {
    let (bvh, users) = (bvh.into(), RwLock::default());
    TREES.insert(Tree { bvh, users })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_tree_build(
    scene: *const Opaque,
    settings: *const PhxBuildSettings,
    tree: *mut *mut Opaque,
) -> PhxStatus {
    // SAFETY: the caller's.
    unsafe {
        answer("tree", tree, || {
            let settings = structure_or_zeros(settings)?.checked()?;
            let bvh = Bvh::build_with(&*reading(scene)?, &settings);
            // The first query would do it, and others wait.
            bvh.build_wide(settings.threads);
            keep(bvh)
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_tree_clone(tree: *const Opaque, copy: *mut *mut Opaque) -> PhxStatus {
    // SAFETY: the caller's.
    unsafe {
        answer("copy", copy, || {
            keep(Bvh::clone(&*TREES.get(tree)?.for_many()?))
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_tree_update(
    tree: *mut Opaque,
    scene: *const Opaque,
    settings: *const PhxUpdateSettings,
    result: *mut PhxUpdateResult,
) -> PhxStatus {
    guarded(|| {
        // SAFETY: the caller's.
        let (mode, mut given) = unsafe {
            let mode = structure_or_zeros(settings)?.mode()?;
            (mode, structure_or_zeros(result.cast_const())?)
        };
        if !given.geom_ids.is_aligned() {
            return Err(misplaced("geom_ids"));
        }
        let (scene, tree) = (reading(scene)?, TREES.get(tree)?);
        let _guard = tree.take()?;
        // SAFETY: there are no batches, none begins, and single rays may not be.
        let bvh = unsafe { &mut *tree.bvh.get() };
        let report = bvh.update_with(&scene, mode)?;
        if !result.is_null() {
            // SAFETY: the caller's.
            unsafe {
                given.set(&report, bvh);
                result.write(given);
            }
        }
        Ok(())
    })
}

#[unsafe(no_mangle)]
pub extern "C" fn phx_tree_destroy(tree: *mut Opaque) -> PhxStatus {
    guarded(|| {
        if tree.is_null() {
            return Ok(());
        }
        let known = TREES.get(tree)?;
        if !known.users.is_poisoned() {
            // It stays taken, so that nobody begins to use it.
            mem::forget(known.take()?);
        }
        TREES.remove(tree)
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_tree_get_first_prim(
    tree: *const Opaque,
    geom_id: u32,
    prim_id: *mut u32,
) -> PhxStatus {
    // SAFETY: the caller's.
    unsafe {
        answer("prim_id", prim_id, || {
            let first = TREES.get(tree)?.for_one()?.first_prim(geom_id);
            let none = || ApiError::argument(format!("geometry {geom_id} has no primitives here"));
            first.ok_or_else(none)
        })
    }
}
