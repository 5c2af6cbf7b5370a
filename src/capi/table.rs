//! Handles: numbers in the guise of pointers, which are never followed, so that null, stale and
//! foreign ones are refused in words.

use crate::status::{ApiError, PhxStatus};
use std::collections::VecDeque;
use std::ptr::{null_mut, without_provenance_mut};
use std::sync::atomic::{AtomicPtr, AtomicU32, Ordering};
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
    /// Odd while there is an object.
    generation: AtomicU32,
    object: AtomicPtr<T>,
}

/// The type behind a handle in C, of which there is no value.
#[repr(C)]
pub struct Opaque([u8; 0]);

impl<T> HandleTable<T> {
    pub const fn new(kind: u8, name: &'static str) -> HandleTable<T> {
        HandleTable {
            kind,
            name,
            slots: [const {
                HandleSlot {
                    generation: AtomicU32::new(0),
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
            let none = || ApiError::argument(format!("there are {SLOTS} {}s already", self.name));
            again.pop_front().ok_or_else(none)?
        };
        let place = &self.slots[slot];
        let object = Box::into_raw(Box::new(object));
        place.object.store(object, Ordering::Relaxed);
        let generation = place.generation.fetch_add(1, Ordering::Release) + 1;
        let number = (generation as usize) << 24 | slot << 8 | usize::from(self.kind);
        Ok(without_provenance_mut(number))
    }

    /// The object of a handle.
    #[inline(always)]
    pub fn get(&self, handle: *const Opaque) -> Result<&T, ApiError> {
        match self.slot(handle) {
            Some((slot, generation)) if slot.generation.load(Ordering::Acquire) == generation => {
                // SAFETY: the object came from a box, and only `remove` frees it, after the
                // generation has gone on. Nobody may destroy what another thread uses.
                Ok(unsafe { &*slot.object.load(Ordering::Relaxed) })
            }
            _ => Err(self.refuse(handle)),
        }
    }

    /// Frees the object of a handle.
    pub fn remove(&self, handle: *const Opaque) -> Result<(), ApiError> {
        let (slot, generation) = self.slot(handle).ok_or_else(|| self.refuse(handle))?;
        let next = generation.wrapping_add(1);
        let (success, failure) = (Ordering::AcqRel, Ordering::Relaxed);
        let gone = (slot.generation).compare_exchange(generation, next, success, failure);
        gone.map_err(|_| self.refuse(handle))?;
        // SAFETY: as in `get`, and only one thread has made the generation go on.
        drop(unsafe { Box::from_raw(slot.object.swap(null_mut(), Ordering::Relaxed)) });
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        free.1.push_back(handle.addr() >> 8 & (SLOTS - 1));
        Ok(())
    }

    /// The slot that a handle of this kind names, and the generation of its object.
    #[inline(always)]
    fn slot(&self, handle: *const Opaque) -> Option<(&HandleSlot<T>, u32)> {
        let number = handle.addr();
        let generation = u32::try_from(number >> 24).ok()?;
        let is_one = number as u8 == self.kind && generation % 2 == 1;
        is_one.then(|| (&self.slots[number >> 8 & (SLOTS - 1)], generation))
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
