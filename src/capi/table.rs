//! Handles: numbers in the guise of pointers, which are never followed, so that null, stale and
//! foreign ones are refused in words.

use crate::status::{ApiError, PhxStatus};
use std::collections::VecDeque;
use std::ptr::{null_mut, without_provenance_mut};
use std::sync::atomic::{AtomicPtr, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Maximum number of objects of a kind at a time.
const SLOTS: usize = 1 << 16;

/// Objects of one kind. The bits of a handle, from the lowest: 8 for the kind, 16 for the slot, 32
/// for the slot's generation.
pub struct HandleTable<T> {
    kind: u8,
    name: &'static str,
    slots: [HandleSlot<T>; SLOTS],
    /// Number of slots that were ever used, and those of them that are free, oldest first.
    free: Mutex<(usize, VecDeque<usize>)>,
}

struct HandleSlot<T> {
    /// Handle of the object, or of the last one that was here.
    handle: AtomicUsize,
    /// Null while there is none.
    object: AtomicPtr<T>,
}

/// The type behind a handle in C, of which there is no value.
#[repr(C)]
pub struct Opaque([u8; 0]);

impl<T> HandleTable<T> {
    pub const fn new(kind: u8, name: &'static str) -> HandleTable<T> {
        HandleTable {
            // So that two libraries in one program do not take each other's handles.
            kind: kind | (cfg!(feature = "render") as u8) << 7,
            name,
            slots: [const {
                HandleSlot {
                    handle: AtomicUsize::new(0),
                    object: AtomicPtr::new(null_mut()),
                }
            }; SLOTS],
            free: Mutex::new((0, VecDeque::new())),
        }
    }

    /// Keeps an object and returns its handle.
    pub fn insert(&self, object: T) -> Result<*mut Opaque, ApiError> {
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        let (used, again) = &mut *free;
        let slot = if *used < SLOTS {
            *used += 1;
            *used - 1
        } else {
            let none = || {
                ApiError::argument(format!(
                    "there are {SLOTS} objects already, each a {}",
                    self.name
                ))
            };
            again.pop_front().ok_or_else(none)?
        };
        let place = &self.slots[slot];
        let generation = (place.handle.load(Ordering::Relaxed) >> 24) as u32;
        let generation = generation.wrapping_add(1) as usize;
        let handle = generation << 24 | slot << 8 | usize::from(self.kind);
        place.handle.store(handle, Ordering::Relaxed);
        let object = Box::into_raw(Box::new(object));
        place.object.store(object, Ordering::Release);
        Ok(without_provenance_mut(handle))
    }

    /// The object of a handle.
    #[inline(always)]
    pub fn get(&self, handle: *const Opaque) -> Result<&T, ApiError> {
        let slot = self.slot(handle);
        let object = slot.object.load(Ordering::Acquire);
        if slot.handle.load(Ordering::Relaxed) != handle.addr() || object.is_null() {
            return Err(self.refuse(handle));
        }
        // SAFETY: the object came from a box, and only `remove` frees it, which nobody may call
        // while another thread uses it.
        Ok(unsafe { &*object })
    }

    /// Frees the object of a handle.
    pub fn remove(&self, handle: *const Opaque) -> Result<(), ApiError> {
        let slot = self.slot(handle);
        let object = match slot.handle.load(Ordering::Relaxed) == handle.addr() {
            true => slot.object.swap(null_mut(), Ordering::AcqRel),
            false => null_mut(),
        };
        if object.is_null() {
            return Err(self.refuse(handle));
        }
        // SAFETY: as in `get`, and only one thread has found the object here.
        drop(unsafe { Box::from_raw(object) });
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        free.1.push_back(handle.addr() >> 8 & (SLOTS - 1));
        Ok(())
    }

    /// The slot that a handle would be of.
    #[inline(always)]
    fn slot(&self, handle: *const Opaque) -> &HandleSlot<T> {
        &self.slots[handle.addr() >> 8 & (SLOTS - 1)]
    }

    #[cold]
    fn refuse(&self, handle: *const Opaque) -> ApiError {
        let name = self.name;
        let words = if handle.is_null() {
            format!("the {name} is null")
        } else {
            format!("{handle:p} is no {name}, or one that has been destroyed")
        };
        ApiError(PhxStatus::Handle, words)
    }
}
