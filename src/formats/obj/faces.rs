//! Faces of an OBJ file: corners with the numbers of their vertices, UVs and normals.

use super::chunk::ObjReader;
use crate::diagnostics::{ParseError, Span};
use crate::mesh::faces::{
    FaceCorner, MAX_CORNERS, NONE, NORMAL, RELATIVE_ZERO, UV, VERTEX, check_corners, extra_bytes,
};
use crate::text::decimal;

impl ObjReader<'_> {
    #[inline]
    pub(super) fn face(&mut self) -> Result<(), ParseError> {
        self.corners.clear();
        self.out_of_range = [false; 3];
        self.cursor.skip_blanks();
        let start = self.cursor.at;
        // Corners beyond the limit are counted for the message.
        let mut count = 0;
        while !self.cursor.at_statement_end() {
            let corner = self.corner()?;
            count += 1;
            if count <= MAX_CORNERS {
                self.corners.push(corner);
            }
        }
        let span = Span::between(start, self.cursor.at);
        match count {
            0 => Err(self.cursor.missing("a corner")),
            1 | 2 => {
                self.skip_line(span);
                Ok(())
            }
            _ => {
                check_corners(count, span)?;
                self.make_corners_alike(span);
                // A file counts three times, once of them for itself: see `--max-memory`.
                let numbers = self.corners[0].numbers;
                let attributes = numbers[1..].iter().filter(|&&n| n != NONE).count();
                let paid = 2 * span.length as u64;
                let bytes = extra_bytes(count, attributes as u64, paid);
                if self.share.take(bytes) {
                    self.chunk.mesh.faces.add(&self.corners);
                }
                Ok(())
            }
        }
    }

    /// Removes UVs or normals that only some corners of a face have.
    #[inline]
    fn make_corners_alike(&mut self, span: Span) {
        for attribute in [UV, NORMAL] {
            let there = |c: &FaceCorner| c.numbers[attribute] != NONE;
            let count = self.corners.iter().filter(|c| there(c)).count();
            if count == 0 || count == self.corners.len() {
                continue;
            }
            // If a number is out of range, there is already a warning.
            if !self.out_of_range[attribute] {
                self.chunk.remarks.warn(
                    span,
                    "this face has a texture coordinate or a normal at some corners only, and is drawn without it",
                    "faces, this one first, have a texture coordinate or a normal at some corners only, and are drawn without it",
                );
            }
            for corner in &mut self.corners {
                corner.numbers[attribute] = NONE;
                corner.relative &= !(1 << attribute);
            }
        }
    }

    /// Reads `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    #[inline]
    fn corner(&mut self) -> Result<FaceCorner, ParseError> {
        let start = self.cursor.at;
        let mut corner = FaceCorner {
            numbers: [NONE; 3],
            relative: 0,
        };
        self.number(VERTEX, &mut corner, start)?;
        for attribute in [UV, NORMAL] {
            if self.cursor.peek() != Some(b'/') {
                break;
            }
            self.cursor.at += 1;
            if self.cursor.peek().is_some_and(|b| b != b'/' && b > b' ') {
                self.number(attribute, &mut corner, start)?;
            }
        }
        match self.cursor.peek() {
            Some(byte) if byte > b' ' && byte != b'#' && byte != b'\\' => {
                Err(self.no_corner(start))
            }
            _ => Ok(corner),
        }
    }

    #[cold]
    fn no_corner(&mut self, start: usize) -> ParseError {
        self.cursor.at = start;
        let word = self.cursor.word();
        let message = format!("{} is not a corner", self.cursor.quoted(word));
        ParseError::new(word, message)
            .with_help("write `v`, `v/vt`, `v//vn` or `v/vt/vn` with whole numbers")
    }

    /// Reads a number from 1 on, or one that counts back from the last row so far, which is -1.
    #[inline]
    fn number(
        &mut self,
        attribute: usize,
        corner: &mut FaceCorner,
        start: usize,
    ) -> Result<(), ParseError> {
        let (number, end) = decimal::integer(self.cursor.text, self.cursor.at);
        if end == self.cursor.at {
            return Err(self.no_corner(start));
        }
        if number > 0 && number <= self.limits.total[attribute] {
            let row = (number - 1) as u32;
            self.chunk.highest[attribute] = self.chunk.highest[attribute].max(row + 1);
            corner.numbers[attribute] = row;
        } else {
            let row = self.chunk.counts()[attribute] as i64 + number;
            if number >= 0 || row < -self.limits.before[attribute] {
                if attribute == VERTEX {
                    return Err(self.no_vertex(number, end));
                }
                let span = Span::between(self.cursor.at, end);
                self.chunk.bad_references[attribute].add(span);
                self.out_of_range[attribute] = true;
                self.cursor.at = end;
                return Ok(());
            }
            self.chunk.lowest[attribute] = self.chunk.lowest[attribute].min(row);
            corner.numbers[attribute] = (row as u32).wrapping_add(RELATIVE_ZERO);
            corner.relative |= 1 << attribute;
        }
        self.cursor.at = end;
        Ok(())
    }

    #[cold]
    fn no_vertex(&self, number: i64, end: usize) -> ParseError {
        let span = Span::between(self.cursor.at, end);
        if number == 0 {
            let message = "0 is no row: they are numbered from 1, or from -1 backward";
            return ParseError::new(span, message);
        }
        let so_far = self.limits.before[VERTEX] + self.chunk.counts()[VERTEX] as i64;
        let (have, scope) =
            if number < 0 { (so_far, " so far") } else { (self.limits.total[VERTEX], "") };
        let number = self.cursor.quoted(span);
        let message = format!("{number} is out of range: there are {have} vertices{scope}");
        ParseError::new(span, message)
    }
}
