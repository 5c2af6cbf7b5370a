//! Names from files and from callers: of objects, of materials and of cameras.
//!
//! Materials of equal bits share a row, whatever their names, so that hits are shaded together.
//! Therefore a material's name belongs to the primitives that have it, like that of their object.

use crate::column::Column;
use std::borrow::Cow;
use std::collections::HashMap;
use std::fmt;
use std::ops::Range;

/// Stands for no name: 2³² − 1.
pub const NO_NAME: u32 = u32::MAX;

/// Most bytes of a name; longer ones are cut. It bounds what a file can make a message, a table or
/// a picture's header hold.
const MAX_NAME_BYTES: usize = 1024;

/// Names, each stored once, and the runs of primitives that have them.
#[derive(Clone, Default)]
pub struct NameTable {
    /// All names, one after another, in UTF-8.
    pub text: Column<u8>,
    /// End of each name in the text.
    pub ends: Column<u32>,
    /// Runs of stored primitives, ascending: the first primitive, and the numbers of its object's
    /// and its material's names, or [`NO_NAME`]. Primitives before the first run have no names.
    pub runs: Column<[u32; 3]>,
    /// Numbers of the names that have been looked up; those of a mapped file are added at the first
    /// new one.
    known: HashMap<Box<str>, u32>,
}

impl fmt::Debug for NameTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = (0..self.len() as u32).map(|name| self.get(name));
        f.debug_list().entries(names).entries(&self.runs).finish()
    }
}

impl NameTable {
    /// Number of names.
    #[inline]
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Returns true if nothing has a name.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The name of a number; `None` for [`NO_NAME`].
    pub fn get(&self, name: u32) -> Option<&str> {
        let end = *self.ends.get(name as usize)?;
        let start = match name {
            0 => 0,
            _ => self.ends[name as usize - 1],
        };
        let bytes = self.text.get(start as usize..end as usize)?;
        std::str::from_utf8(bytes).ok()
    }

    /// The number of a name, which is added if it is new. Equal names have equal numbers. Bytes
    /// that are not UTF-8 are read as Latin-1, so that different names stay different. A name of
    /// nothing but blanks is [`NO_NAME`].
    ///
    /// ```
    /// # mod phalanx { pub mod scene { pub use phalanx_scene::*; } pub use phalanx_scene::*; }
    /// let mut names = phalanx::scene::NameTable::default();
    /// let lid = names.intern(b"lid");
    /// assert_eq!((lid, names.intern(b" lid\r")), (0, 0));
    /// let old = names.intern(b"Fl\xe4che");
    /// assert_eq!(names.get(old), Some("Fläche"));
    /// assert_eq!(names.intern(b" "), phalanx::scene::NO_NAME);
    /// ```
    pub fn intern(&mut self, name: &[u8]) -> u32 {
        let name = name.trim_ascii();
        let text = match std::str::from_utf8(name) {
            Ok(text) => Cow::Borrowed(text),
            Err(_) => Cow::Owned(name.iter().map(|&byte| char::from(byte)).collect()),
        };
        let mut end = text.len().min(MAX_NAME_BYTES);
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        let text = &text[..end];
        let end = self.text.len() + text.len();
        if text.is_empty() {
            return NO_NAME;
        }
        for number in self.known.len()..self.len() {
            let known = self.get(number as u32).unwrap_or_default().into();
            self.known.insert(known, number as u32);
        }
        if let Some(&number) = self.known.get(text) {
            return number;
        }
        let (Ok(end), number) = (u32::try_from(end), self.len() as u32) else {
            return NO_NAME;
        };
        self.text.extend_from(text.as_bytes());
        self.ends.push(end);
        self.known.insert(text.into(), number);
        number
    }

    /// Names the object of stored primitives, and their material if one is given. Primitives that
    /// are added later have no names.
    pub fn name_run(&mut self, prims: Range<u32>, object: u32, material: Option<u32>) {
        let nothing = object == NO_NAME && material.is_none_or(|name| name == NO_NAME);
        if prims.is_empty() || nothing && self.runs.is_empty() {
            return;
        }
        let first = self.begin_run(prims.start);
        let end = self.begin_run(prims.end);
        for [_, old_object, old_material] in &mut self.runs[first..end] {
            *old_object = object;
            *old_material = material.unwrap_or(*old_material);
        }
    }

    /// The row of the run that begins at a primitive. The run before is divided if there is none.
    fn begin_run(&mut self, prim: u32) -> usize {
        let row = self.runs.partition_point(|run| run[0] < prim);
        if self.runs.get(row).is_none_or(|run| run[0] != prim) {
            let [object, material] = prim
                .checked_sub(1)
                .map_or([NO_NAME; 2], |p| self.of_prim(p));
            self.runs.make_mut().insert(row, [prim, object, material]);
        }
        row
    }

    /// Numbers of the names of a stored primitive's object and material.
    #[inline]
    pub fn of_prim(&self, prim: u32) -> [u32; 2] {
        match self.runs.partition_point(|run| run[0] <= prim) {
            0 => [NO_NAME; 2],
            after => [1, 2].map(|k| self.runs[after - 1][k]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_text_of_bounded_length_stored_once() {
        let mut names = NameTable::default();
        let long = "\u{e9}".repeat(MAX_NAME_BYTES);
        let given: [&[u8]; 6] = [
            b"a\0\x1b[2J",
            "ü".as_bytes(),
            b"\xfc",
            b"\xff\xfe",
            long.as_bytes(),
            b"b",
        ];
        let ids = given.map(|name| names.intern(name));
        assert_eq!(ids, [0, 1, 1, 2, 3, 4]);
        assert_eq!(names.get(0), Some("a\0\u{1b}[2J"));
        assert_eq!(names.get(2), Some("\u{ff}\u{fe}"));
        assert_eq!(names.get(3), Some(&long[..MAX_NAME_BYTES]));
        assert_eq!(names.intern(format!("x{long}").as_bytes()), 5);
        assert_eq!(names.get(5).map(str::len), Some(MAX_NAME_BYTES - 1));
        assert_eq!(
            [b"" as &[u8], b" \t\r\n"].map(|name| names.intern(name)),
            [NO_NAME; 2]
        );
        assert_eq!([names.get(6), names.get(NO_NAME)], [None; 2]);
        // As after mapping a file: the numbers are found again.
        let mut mapped = NameTable {
            known: HashMap::new(),
            ..names.clone()
        };
        assert_eq!(
            [b"b" as &[u8], b"c", b"\xfc"].map(|name| mapped.intern(name)),
            [4, 6, 1]
        );
    }

    #[test]
    fn runs_are_divided_and_end_with_their_primitives() {
        let mut names = NameTable::default();
        let [a, b, m] = [b"a", b"b", b"m"].map(|name| names.intern(name));
        names.name_run(4..4, a, None);
        names.name_run(0..9, NO_NAME, None);
        assert!(names.runs.is_empty());
        names.name_run(2..6, a, Some(m));
        names.name_run(3..5, b, None);
        names.name_run(6..7, NO_NAME, Some(m));
        names.name_run(0..1, b, None);
        let none = NO_NAME;
        let want = [
            [b, none],
            [none; 2],
            [a, m],
            [b, m],
            [b, m],
            [a, m],
            [none, m],
            [none; 2],
        ];
        let numbers: Vec<_> = (0..8).map(|prim| names.of_prim(prim)).collect();
        assert_eq!(numbers, want);
        names.name_run(0..7, none, None);
        assert_eq!(names.of_prim(4), [none, m]);
        assert!(names.runs.is_sorted_by(|x, y| x[0] < y[0]));
    }
}
