//! Trees: built, updated, copied.

use crate::rows::{OutPointer, SizedStruct, structure_if};
use crate::scene::reading;
use crate::status::{ApiError, PhxStatus, guarded};
use crate::table::{HandleTable, Opaque};
use phalanx::{BuildSettings, Bvh, Quality};
use std::cell::UnsafeCell;
use std::ops::Deref;
use std::sync::atomic::{AtomicU32, Ordering};

pub static TREES: HandleTable<Tree> = HandleTable::new(0x54, "tree");

/// A tree, and who uses it. Single rays do not count themselves, for speed: the header forbids to
/// update or destroy their tree meanwhile.
pub struct Tree {
    bvh: UnsafeCell<Bvh>,
    /// Number of batches and copies, or one of the two below.
    users: AtomicU32,
}

/// A change is under way.
const CHANGING: u32 = u32::MAX;
/// A change has panicked.
const BROKEN: u32 = u32::MAX - 1;

// SAFETY: `bvh` is changed by `change` alone, beside which there are no counted users, and no
// others may be.
unsafe impl Sync for Tree {}

/// A counted use of a tree.
pub struct Use<'t>(&'t Tree);

impl Tree {
    fn new(bvh: Bvh) -> Tree {
        Tree {
            bvh: UnsafeCell::new(bvh),
            users: AtomicU32::new(0),
        }
    }

    /// The tree, for one ray.
    #[inline(always)]
    pub fn for_one(&self) -> Result<&Bvh, ApiError> {
        match self.users.load(Ordering::Acquire) {
            // SAFETY: nobody changes it now, nor may during a query.
            0..BROKEN => Ok(unsafe { &*self.bvh.get() }),
            users => Err(refuse(users)),
        }
    }

    /// The tree, for longer.
    pub fn for_many(&self) -> Result<Use<'_>, ApiError> {
        let next = |users: u32| (users < BROKEN - 1).then(|| users + 1);
        let counted = (self.users).fetch_update(Ordering::Acquire, Ordering::Relaxed, next);
        counted.map(|_| Use(self)).map_err(refuse)
    }

    /// Changes the tree, unless it is used.
    fn change(&self, change: impl FnOnce(&mut Bvh)) -> Result<(), ApiError> {
        self.take(0)?;
        let end = ChangeGuard(&self.users);
        // SAFETY: there are no counted users, new ones are refused, and others may not be.
        change(unsafe { &mut *self.bvh.get() });
        drop(end);
        Ok(())
    }

    /// Begins a change in a state of `users`.
    fn take(&self, users: u32) -> Result<(), ApiError> {
        let (success, failure) = (Ordering::Acquire, Ordering::Relaxed);
        let taken = (self.users).compare_exchange(users, CHANGING, success, failure);
        taken.map(drop).map_err(refuse)
    }
}

/// The end of a change, good or bad.
struct ChangeGuard<'t>(&'t AtomicU32);

impl Drop for ChangeGuard<'_> {
    fn drop(&mut self) {
        let users = if std::thread::panicking() { BROKEN } else { 0 };
        self.0.store(users, Ordering::Release);
    }
}

impl Deref for Use<'_> {
    type Target = Bvh;

    fn deref(&self) -> &Bvh {
        // SAFETY: no change begins while there are users.
        unsafe { &*self.0.bvh.get() }
    }
}

impl Drop for Use<'_> {
    fn drop(&mut self) {
        self.0.users.fetch_sub(1, Ordering::Release);
    }
}

#[cold]
fn refuse(users: u32) -> ApiError {
    match users {
        CHANGING => ApiError(PhxStatus::Busy, "the tree is being updated".into()),
        BROKEN => ApiError(
            PhxStatus::Internal,
            "an update of the tree has failed".into(),
        ),
        users => ApiError(PhxStatus::Busy, format!("{users} batches use the tree")),
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

// SAFETY: numbers.
unsafe impl SizedStruct for PhxBuildSettings {
    const NAME: &'static str = "phx_build_settings";
}

/// `phx_update_settings`: none yet.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PhxUpdateSettings {
    pub size: usize,
}

/// `phx_update_result`: nothing yet.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PhxUpdateResult {
    pub size: usize,
}

// SAFETY: a number.
unsafe impl SizedStruct for PhxUpdateSettings {
    const NAME: &'static str = "phx_update_settings";
}
// SAFETY: a number.
unsafe impl SizedStruct for PhxUpdateResult {
    const NAME: &'static str = "phx_update_result";
}

impl PhxBuildSettings {
    fn checked(self) -> Result<BuildSettings, ApiError> {
        let quality = match self.quality {
            0 => Quality::Fast,
            1 => Quality::Medium,
            2 => Quality::Best,
            other => return Err(ApiError::argument(format!("quality is {other}: 0, 1 or 2"))),
        };
        let threads = self.threads as usize;
        Ok(BuildSettings { quality, threads })
    }
}

/// Keeps a tree, and writes its handle.
///
/// # Safety
/// Null, or memory of the caller's.
unsafe fn keep(tree: *mut *mut Opaque, make: impl FnOnce() -> Result<Bvh, ApiError>) -> PhxStatus {
    guarded(|| {
        let place = OutPointer::of("the place for a tree", tree)?;
        let tree = TREES.insert(Tree::new(make()?))?;
        // SAFETY: the caller's.
        unsafe { place.write(tree) };
        Ok(())
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_tree_build(
    scene: *const Opaque,
    settings: *const PhxBuildSettings,
    tree: *mut *mut Opaque,
) -> PhxStatus {
    // SAFETY: the caller's.
    unsafe {
        keep(tree, || {
            let settings = structure_if(settings)?
                .map(PhxBuildSettings::checked)
                .transpose()?;
            Ok(Bvh::build_with(
                &*reading(scene)?,
                &settings.unwrap_or_default(),
            ))
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_tree_clone(tree: *const Opaque, copy: *mut *mut Opaque) -> PhxStatus {
    // SAFETY: the caller's.
    unsafe { keep(copy, || Ok(Bvh::clone(&*TREES.get(tree)?.for_many()?))) }
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
        unsafe { (structure_if(settings)?, structure_if(result)?) };
        let scene = reading(scene)?;
        TREES.get(tree)?.change(|bvh| bvh.update(&scene))
    })
}

#[unsafe(no_mangle)]
pub extern "C" fn phx_tree_destroy(tree: *mut Opaque) -> PhxStatus {
    guarded(|| {
        if tree.is_null() {
            return Ok(());
        }
        let known = TREES.get(tree)?;
        // It stays taken, so that nobody begins to use it.
        known.take(BROKEN).or_else(|_| known.take(0))?;
        TREES.remove(tree)
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_tree_get_first_prim(
    tree: *const Opaque,
    geom_id: u32,
    prim_id: *mut u32,
) -> PhxStatus {
    guarded(|| {
        let place = OutPointer::of("prim_id", prim_id)?;
        let first = TREES.get(tree)?.for_one()?.first_prim(geom_id);
        let none = || ApiError::argument(format!("geometry {geom_id} has no primitives here"));
        // SAFETY: the caller's.
        unsafe { place.write(first.ok_or_else(none)?) };
        Ok(())
    })
}
