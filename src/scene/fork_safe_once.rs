//! Values that are made once, in programs that fork.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// A [`OnceLock`] for programs that fork. A forked process has the memory of its parent, but only
/// the thread that forked: if another thread was making the value, nobody finishes it, and a
/// `OnceLock` would wait for ever. Here that process makes the value again, in a cell of its own. A
/// value that was finished before the fork is the child's, too.
///
/// Processes are told apart by their numbers. What remains is a fork within the few instructions in
/// which a process that was forked adds its cell to the list.
#[derive(Debug)]
pub struct ForkSafeOnce<T> {
    /// Number of the process that makes the value, or has made it; 0 before.
    process: AtomicU32,
    value: OnceLock<T>,
    /// The cell of a process that was forked from that one.
    child: OnceLock<Box<ForkSafeOnce<T>>>,
}

impl<T> ForkSafeOnce<T> {
    /// A cell without a value.
    pub const fn new() -> ForkSafeOnce<T> {
        ForkSafeOnce {
            process: AtomicU32::new(0),
            value: OnceLock::new(),
            child: OnceLock::new(),
        }
    }

    /// The value, if it has been made, by this process or before it was forked.
    #[inline]
    pub fn get(&self) -> Option<&T> {
        self.value.get().or_else(|| self.child.get()?.get())
    }

    /// As [`ForkSafeOnce::get`], to change the value.
    pub fn get_mut(&mut self) -> Option<&mut T> {
        let child = &mut self.child;
        self.value.get_mut().or_else(|| child.get_mut()?.get_mut())
    }

    /// The value, made by this thread if there is none, while others of this process wait.
    #[inline]
    pub fn get_or_init(&self, make: impl FnOnce() -> T) -> &T {
        self.get().unwrap_or_else(|| self.get_own_or_init(make))
    }

    /// A value that this process has made, even if there is one from before it was forked.
    pub fn get_own_or_init(&self, make: impl FnOnce() -> T) -> &T {
        // One number for all on systems that cannot fork, of which some have none.
        let here = if cfg!(unix) { std::process::id() } else { 1 };
        let mut cell = self;
        while let Err(other) = cell.process.compare_exchange(0, here, Relaxed, Relaxed)
            && other != here
        {
            cell = cell.child.get_or_init(Box::default);
        }
        cell.value.get_or_init(make)
    }
}

impl<T> Default for ForkSafeOnce<T> {
    fn default() -> ForkSafeOnce<T> {
        ForkSafeOnce::new()
    }
}

impl<T: Clone> Clone for ForkSafeOnce<T> {
    fn clone(&self) -> ForkSafeOnce<T> {
        let cell = ForkSafeOnce::new();
        let _ = self.get().map(|value| cell.get_or_init(|| value.clone()));
        cell
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Barrier;
    use std::sync::atomic::AtomicUsize;

    /// A cell of another process, which has made this value.
    fn from_parent(value: Option<u32>) -> ForkSafeOnce<u32> {
        ForkSafeOnce {
            process: AtomicU32::new(u32::MAX),
            value: value.map_or_else(OnceLock::new, OnceLock::from),
            child: OnceLock::new(),
        }
    }

    #[test]
    fn threads_share_what_one_of_them_makes() {
        let (cell, made) = (ForkSafeOnce::new(), AtomicUsize::new(0));
        let all = Barrier::new(8);
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    all.wait();
                    assert_eq!(*cell.get_or_init(|| made.fetch_add(1, Relaxed)), 0);
                });
            }
        });
        assert_eq!(made.into_inner(), 1);
    }

    /// The threads of the other process are this one's here, but for what the cell knows.
    #[test]
    fn what_another_process_is_making_is_not_waited_for() {
        let cell = from_parent(None);
        let (begun, queried) = (Barrier::new(2), Barrier::new(2));
        std::thread::scope(|scope| {
            scope.spawn(|| {
                cell.value.get_or_init(|| {
                    begun.wait();
                    queried.wait();
                    1
                })
            });
            begun.wait();
            let own = cell.get_or_init(|| 2);
            let again = (
                cell.get(),
                cell.get_or_init(|| 3),
                cell.get_own_or_init(|| 4),
            );
            queried.wait();
            assert_eq!((own, again), (&2, (Some(&2), &2, &2)));
        });
    }

    #[test]
    fn what_another_process_has_made_is_used_unless_it_must_be_made_here() {
        let mut cell = from_parent(Some(1));
        assert_eq!((cell.get(), cell.get_or_init(|| 2)), (Some(&1), &1));
        assert_eq!(cell.get_own_or_init(|| 3), &3);
        assert_eq!(cell.get_own_or_init(|| 4), &3);
        assert_eq!(
            (cell.clone().get(), cell.get_mut()),
            (Some(&1), Some(&mut 1))
        );
        let mut cell = from_parent(None);
        assert_eq!((cell.clone().get(), cell.get_mut()), (None, None));
        assert_eq!(cell.get_or_init(|| 6), &6);
        assert_eq!(
            (cell.clone().get(), cell.get_mut()),
            (Some(&6), Some(&mut 6))
        );
    }
}
