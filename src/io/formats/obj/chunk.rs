//! One chunk of an OBJ file, read independently of the others.

use super::cursor::Cursor;
use crate::formats::decimal;
use crate::formats::diagnostics::Span;
use crate::formats::faces::{
    FaceCorner, Faces, MAX_CORNERS, NONE, NORMAL, RELATIVE_ZERO, UV, VERTEX, extra_bytes,
};
use crate::formats::memory_budget::BudgetShare;
use crate::formats::mesh::{NotFinite, Occurrences, ParseError, ParseErrors};
use glam::DVec3;

/// Limits of the numbers to which a chunk may refer.
#[derive(Clone, Copy, Debug)]
pub(super) struct IndexLimits {
    /// Rows of each attribute before the chunk.
    pub(super) before: [i64; 3],
    /// Rows of each attribute in the file.
    pub(super) total: [i64; 3],
}

impl IndexLimits {
    /// Limits for a first reading: every number that fits the columns is in range.
    pub(super) const UNKNOWN: IndexLimits = IndexLimits {
        before: [i32::MAX as i64; 3],
        total: [i32::MAX as i64; 3],
    };
}

/// Contents of a chunk.
#[derive(Debug, Default)]
pub(super) struct ObjChunk {
    pub(super) vertices: [Vec<f32>; 3],
    pub(super) normals: [Vec<f32>; 3],
    pub(super) uvs: [Vec<f32>; 2],
    pub(super) faces: Faces,
    /// Changes of the material by `usemtl`: the first triangle with the new one, and the span of
    /// its name.
    pub(super) switches: Vec<(usize, Span)>,
    /// The operands of each `mtllib`.
    pub(super) libraries: Vec<Span>,
    /// Vertices that are not finite, by their numbers in the chunk; their rows are zero.
    pub(super) not_finite: Vec<NotFinite>,
    /// Normals that are not finite or zero.
    pub(super) bad_normals: Vec<NotFinite>,
    /// UVs that are not finite; their rows are zero.
    pub(super) bad_uvs: Occurrences,
    pub(super) skipped: Skipped,
    pub(super) errors: ParseErrors,
    /// Largest absolute number of each attribute, counted from 1.
    pub(super) highest: [u32; 3],
    /// Relative number of each attribute that reaches back farthest, counted from the first row of
    /// the chunk.
    pub(super) lowest: [i64; 3],
}

/// Statements that are left out.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Skipped {
    /// Faces of fewer than three corners, lines and points.
    pub(super) lines: Occurrences,
    /// Curves and surfaces.
    pub(super) free_forms: Occurrences,
    /// Statements that OBJ files do not have.
    pub(super) unknown: Occurrences,
}

impl Skipped {
    pub(super) fn merge(&mut self, later: Skipped) {
        self.lines.merge(later.lines);
        self.free_forms.merge(later.free_forms);
        self.unknown.merge(later.unknown);
    }
}

impl ObjChunk {
    /// Rows of each attribute.
    pub(super) fn counts(&self) -> [usize; 3] {
        [
            self.vertices[0].len(),
            self.uvs[0].len(),
            self.normals[0].len(),
        ]
    }
}

/// Reads the chunk of `text` from `start` to its end. `origin`, if there is one, is subtracted from
/// vertices. Faces are made as long as there is memory for them in `share`.
pub(super) fn read<'a>(
    text: &'a [u8],
    start: usize,
    limits: IndexLimits,
    origin: Option<DVec3>,
    share: BudgetShare<'a>,
) -> ObjChunk {
    let mut reader = ObjReader {
        cursor: Cursor { text, at: start },
        limits,
        origin,
        share,
        chunk: ObjChunk::default(),
        corners: Vec::new(),
    };
    loop {
        reader.cursor.skip_to_statement();
        if reader.cursor.is_at_end() {
            return reader.chunk;
        }
        if let Err(error) = reader.statement() {
            reader.chunk.errors.push(error);
        }
        // The rest is a comment, or follows a fault.
        reader.cursor.skip_statement();
    }
}

struct ObjReader<'a> {
    cursor: Cursor<'a>,
    limits: IndexLimits,
    /// The origin that is subtracted from vertices, if the scene is moved.
    origin: Option<DVec3>,
    share: BudgetShare<'a>,
    chunk: ObjChunk,
    /// Corners of the current face.
    corners: Vec<FaceCorner>,
}

impl ObjReader<'_> {
    #[inline]
    fn statement(&mut self) -> Result<(), ParseError> {
        let rest = &self.cursor.text[self.cursor.at..];
        match rest {
            [b'v', b' ' | b'\t', ..] => {
                self.cursor.at += 1;
                self.vertex()
            }
            [b'f', b' ' | b'\t', ..] => {
                self.cursor.at += 1;
                self.face()
            }
            [b'v', b'n', b' ' | b'\t', ..] => {
                self.cursor.at += 2;
                self.normal()
            }
            [b'v', b't', b' ' | b'\t', ..] => {
                self.cursor.at += 2;
                self.texture_uv()
            }
            [b'#', ..] => Ok(()),
            _ => self.rare_statement(),
        }
    }

    /// Reads a statement by its name as a word.
    fn rare_statement(&mut self) -> Result<(), ParseError> {
        // A byte order mark is not part of the first name.
        if self.cursor.at == 0 && self.cursor.text.starts_with(b"\xef\xbb\xbf") {
            self.cursor.at = 3;
            self.cursor.skip_to_statement();
            return if self.cursor.is_at_end() {
                Ok(())
            } else {
                self.statement()
            };
        }
        let name = self.cursor.word();
        match self.cursor.bytes(name) {
            b"v" => return self.vertex(),
            b"vn" => return self.normal(),
            b"vt" => return self.texture_uv(),
            b"f" | b"fo" => return self.face(),
            b"usemtl" => {
                let material = self.cursor.rest_of_line();
                self.chunk.switches.push((self.chunk.faces.len(), material));
            }
            b"mtllib" => {
                let files = self.cursor.rest_of_line();
                self.chunk.libraries.push(files);
            }
            b"l" | b"p" => self.chunk.skipped.lines.add(name),
            b"g" | b"o" | b"s" | b"mg" | b"lod" | b"bevel" | b"c_interp" | b"d_interp"
            | b"maplib" | b"usemap" | b"shadow_obj" | b"trace_obj" | b"ctech" | b"stech"
            | b"call" | b"csh" => {}
            b"vp" | b"cstype" | b"deg" | b"bmat" | b"step" | b"curv" | b"curv2" | b"surf"
            | b"parm" | b"trim" | b"hole" | b"scrv" | b"sp" | b"end" | b"con" => {
                self.chunk.skipped.free_forms.add(name)
            }
            _ => self.chunk.skipped.unknown.add(name),
        }
        Ok(())
    }

    /// Reads x, y and z; a weight and colours may follow, and are ignored.
    #[inline]
    fn vertex(&mut self) -> Result<(), ParseError> {
        self.cursor.skip_blanks();
        let start = self.cursor.at;
        let position = match self.origin {
            None => self.vector::<3>(),
            Some(origin) => self.moved(origin),
        };
        // A faulty vertex still gets its row, so that later numbers, and the faces that use them,
        // stay right.
        let [x, y, z] = *position.as_ref().unwrap_or(&[0.0; 3]);
        let finite = x.is_finite() && y.is_finite() && z.is_finite();
        let row = if finite { [x, y, z] } else { [0.0; 3] };
        if !finite {
            let number = self.chunk.vertices[0].len() as u32;
            let span = Span::between(start, self.cursor.at);
            self.chunk.not_finite.push(NotFinite { number, span });
        }
        push(&mut self.chunk.vertices, row);
        position?;
        if self.cursor.at_statement_end() {
            return Ok(());
        }
        self.weight_and_colors()
    }

    /// Passes the numbers after a vertex: one, or three and more.
    fn weight_and_colors(&mut self) -> Result<(), ParseError> {
        let mut count = 0;
        let mut second = None;
        while !self.cursor.at_statement_end() {
            let start = self.cursor.at;
            self.cursor.float()?;
            count += 1;
            if count == 2 {
                second = Some(Span::between(start, self.cursor.at));
            }
        }
        match second {
            Some(span) if count == 2 => Err(ParseError::new(span, "five numbers make no vertex")
                .with_help("three, four with a weight, or six and more with a colour")),
            _ => Ok(()),
        }
    }

    #[inline]
    fn normal(&mut self) -> Result<(), ParseError> {
        self.cursor.skip_blanks();
        let start = self.cursor.at;
        let vector = self.vector::<3>();
        let [x, y, z] = *vector.as_ref().unwrap_or(&[0.0, 0.0, 1.0]);
        let usable =
            x.is_finite() && y.is_finite() && z.is_finite() && (x != 0.0 || y != 0.0 || z != 0.0);
        if !usable {
            let number = self.chunk.normals[0].len() as u32;
            let span = Span::between(start, self.cursor.at);
            self.chunk.bad_normals.push(NotFinite { number, span });
        }
        push(
            &mut self.chunk.normals,
            if usable { [x, y, z] } else { [0.0, 0.0, 1.0] },
        );
        vector?;
        self.no_more()
    }

    /// Reads u, perhaps v, and perhaps w, which is ignored. OBJ's v is 0 at the bottom, the scene's
    /// at the top.
    #[inline]
    fn texture_uv(&mut self) -> Result<(), ParseError> {
        self.cursor.skip_blanks();
        let start = self.cursor.at;
        let position = self.one_to_three();
        let [u, v] = *position.as_ref().unwrap_or(&[0.0; 2]);
        let finite = u.is_finite() && v.is_finite();
        if !finite {
            let span = Span::between(start, self.cursor.at);
            self.chunk.bad_uvs.add(span);
        }
        push(
            &mut self.chunk.uvs,
            if finite { [u, 1.0 - v] } else { [0.0; 2] },
        );
        position?;
        self.no_more()
    }

    #[inline]
    fn one_to_three(&mut self) -> Result<[f32; 2], ParseError> {
        let u = self.cursor.float()?;
        if self.cursor.at_statement_end() {
            return Ok([u, 0.0]);
        }
        let v = self.cursor.float()?;
        if !self.cursor.at_statement_end() {
            self.cursor.float()?;
        }
        Ok([u, v])
    }

    /// The position of a vertex, from which an origin is subtracted before it is rounded.
    fn moved(&mut self, origin: DVec3) -> Result<[f32; 3], ParseError> {
        let mut position = DVec3::ZERO;
        for axis in 0..3 {
            position[axis] = self.cursor.double()? - origin[axis];
        }
        Ok(position.as_vec3().to_array())
    }

    #[inline]
    fn vector<const N: usize>(&mut self) -> Result<[f32; N], ParseError> {
        let mut out = [0.0; N];
        for number in &mut out {
            *number = self.cursor.float()?;
        }
        Ok(out)
    }

    #[inline]
    fn no_more(&mut self) -> Result<(), ParseError> {
        if self.cursor.at_statement_end() {
            return Ok(());
        }
        let span = self.cursor.word();
        let message = format!("{} is one operand too many", self.cursor.quoted(span));
        Err(ParseError::new(span, message))
    }

    #[inline]
    fn face(&mut self) -> Result<(), ParseError> {
        self.corners.clear();
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
        let first = self.corners.first().map_or([0; 3], |c| c.numbers);
        let alike = |k: usize| {
            self.corners
                .iter()
                .all(|c| (c.numbers[k] == NONE) == (first[k] == NONE))
        };
        let span = Span::between(start, self.cursor.at);
        match count {
            0 => Err(self.cursor.missing("a corner")),
            _ if !alike(UV) || !alike(NORMAL) => Err(ParseError::new(
                span,
                "some corners of this face have a texture place or a normal, others have none",
            )),
            1 | 2 => {
                self.chunk.skipped.lines.add(span);
                Ok(())
            }
            count if count > MAX_CORNERS => Err(ParseError::new(
                span,
                format!("a face of {count} corners: at most {MAX_CORNERS}"),
            )),
            _ => {
                // A file counts three times, once of them for itself: see `--max-memory`.
                let attributes = first[1..].iter().filter(|&&number| number != NONE).count();
                let paid = 2 * span.length as u64;
                let bytes = extra_bytes(count, attributes as u64, paid);
                if self.share.take(bytes) {
                    self.chunk.faces.add(&self.corners);
                }
                Ok(())
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
                return Err(self.out_of_range(attribute, number, end));
            }
            self.chunk.lowest[attribute] = self.chunk.lowest[attribute].min(row);
            corner.numbers[attribute] = (row as u32).wrapping_add(RELATIVE_ZERO);
            corner.relative |= 1 << attribute;
        }
        self.cursor.at = end;
        Ok(())
    }

    #[cold]
    fn out_of_range(&self, attribute: usize, number: i64, end: usize) -> ParseError {
        let span = Span::between(self.cursor.at, end);
        if number == 0 {
            return ParseError::new(
                span,
                "0 is no row: they are numbered from 1, or from -1 backward",
            );
        }
        let what = ["vertices", "texture places", "normals"][attribute];
        let (have, scope) = match number < 0 {
            true => (
                self.limits.before[attribute] + self.chunk.counts()[attribute] as i64,
                " so far",
            ),
            false => (self.limits.total[attribute], ""),
        };
        ParseError::new(
            span,
            format!(
                "{} is out of range: there are {have} {what}{scope}",
                self.cursor.quoted(span)
            ),
        )
    }
}

#[inline]
fn push<const N: usize>(columns: &mut [Vec<f32>; N], row: [f32; N]) {
    for (column, number) in columns.iter_mut().zip(row) {
        column.push(number);
    }
}
