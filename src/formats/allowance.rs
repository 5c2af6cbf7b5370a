//! Memory for what a scene file makes beyond itself: files that it names, pictures decoded, meshes copied. It is asked for
//! before it is used.

use std::cell::{Cell, RefCell};

/// Bytes that may be used, and those that are.
#[derive(Debug)]
pub(super) struct Allowance {
    most: u64,
    used: Cell<u64>,
    refused: RefCell<Option<Refusal>>,
}

/// A use that there was no memory for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Refusal {
    /// Its purpose, as in "to decode the texture `a.png`".
    pub(super) what: String,
    /// Bytes with it.
    pub(super) needed: u64,
    /// Bytes that may be used.
    pub(super) allowed: u64,
}

impl Allowance {
    /// This many bytes; any number if none is given.
    pub(super) fn of(most: Option<u64>) -> Allowance {
        Allowance {
            most: most.unwrap_or(u64::MAX),
            used: Cell::new(0),
            refused: RefCell::new(None),
        }
    }

    /// Takes bytes for as long as the scene is there. The error is for a message that says what they are for.
    pub(super) fn take(&self, bytes: u64, what: impl FnOnce() -> String) -> Result<(), String> {
        self.lend(bytes, what)?;
        self.used.set(self.used.get().saturating_add(bytes));
        Ok(())
    }

    /// Asks whether bytes can be had for a while. As [`Allowance::take`].
    pub(super) fn lend(&self, bytes: u64, what: impl FnOnce() -> String) -> Result<(), String> {
        let needed = self.used.get().saturating_add(bytes);
        if needed <= self.most {
            return Ok(());
        }
        let mut refused = self.refused.borrow_mut();
        let refusal = refused.get_or_insert_with(|| Refusal {
            what: what(),
            needed,
            allowed: self.most,
        });
        Err(refusal.message())
    }

    /// The use that was refused first.
    pub(super) fn refusal(&self) -> Option<Refusal> {
        self.refused.borrow().clone()
    }
}

impl Refusal {
    fn message(&self) -> String {
        let (needed, what, allowed) = (self.needed, &self.what, self.allowed);
        format!("about {needed} bytes would be needed {what}, and {allowed} are allowed")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_taken_counts_and_what_is_lent_does_not() {
        let allowance = Allowance::of(Some(100));
        let what = || String::from("for a test");
        assert_eq!(allowance.lend(100, what), Ok(()));
        assert_eq!(allowance.take(60, what), Ok(()));
        assert!(allowance.lend(41, what).is_err());
        assert_eq!(allowance.take(40, what), Ok(()));
        let refused = allowance.refusal().expect("one");
        assert_eq!((refused.needed, refused.allowed), (101, 100));
        assert_eq!(Allowance::of(None).take(u64::MAX, what), Ok(()));
    }
}
