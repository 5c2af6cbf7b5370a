//! One piece of an OBJ file, read without knowing the others.

use super::cursor::Cursor;
use crate::formats::allowance::Share;
use crate::formats::decimal;
use crate::formats::faces::{
    Corner, Faces, MAX_CORNERS, NONE, NORMAL, RELATIVE_ZERO, TEXTURE_PLACE, VERTEX, bytes_beyond,
};
use crate::formats::mesh::{Fault, Faults, NotFinite, Tally};
use crate::formats::report::Place;
use glam::DVec3;

/// What a piece may refer to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Rows of each attribute before the piece.
    pub(super) before: [i64; 3],
    /// Rows of each attribute in the file.
    pub(super) total: [i64; 3],
}

impl Limits {
    /// For a first reading: nothing that fits the columns is out of range.
    pub(super) const UNKNOWN: Limits = Limits {
        before: [i32::MAX as i64; 3],
        total: [i32::MAX as i64; 3],
    };
}

/// What a piece holds.
#[derive(Debug, Default)]
pub(super) struct Piece {
    pub(super) vertices: [Vec<f32>; 3],
    pub(super) normals: [Vec<f32>; 3],
    pub(super) uvs: [Vec<f32>; 2],
    pub(super) faces: Faces,
    /// Where `usemtl` stands: the first triangle that it is for, and the name.
    pub(super) switches: Vec<(usize, Place)>,
    /// The operands of each `mtllib`.
    pub(super) libraries: Vec<Place>,
    /// Vertices that are not finite, by their numbers in the piece; their rows are zero.
    pub(super) not_finite: Vec<NotFinite>,
    /// Normals that are not finite or zero.
    pub(super) bad_normals: Vec<NotFinite>,
    /// Texture places that are not finite; their rows are zero.
    pub(super) bad_uvs: Tally,
    pub(super) skipped: Skipped,
    pub(super) faults: Faults,
    /// The largest absolute numbers, counted from 1.
    pub(super) highest: [u32; 3],
    /// The relative numbers that reach back farthest, counted from the first row of the piece.
    pub(super) lowest: [i64; 3],
}

/// What is left out.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Skipped {
    /// Faces of fewer than three corners, lines and points.
    pub(super) lines: Tally,
    /// Curves and surfaces.
    pub(super) free_forms: Tally,
    /// Statements of no OBJ file.
    pub(super) unknown: Tally,
}

impl Skipped {
    pub(super) fn merge(&mut self, later: Skipped) {
        self.lines.merge(later.lines);
        self.free_forms.merge(later.free_forms);
        self.unknown.merge(later.unknown);
    }
}

impl Piece {
    /// Rows of each attribute.
    pub(super) fn counts(&self) -> [usize; 3] {
        [
            self.vertices[0].len(),
            self.uvs[0].len(),
            self.normals[0].len(),
        ]
    }
}

/// Reads the piece of `text` that begins at `start` and ends with it. Vertices are taken from
/// `origin`, where there is one. Faces are made as long as there is memory for them in `share`.
pub(super) fn read<'a>(
    text: &'a [u8],
    start: usize,
    limits: Limits,
    origin: Option<DVec3>,
    share: Share<'a>,
) -> Piece {
    let mut reader = Reader {
        cursor: Cursor { text, at: start },
        limits,
        origin,
        share,
        piece: Piece::default(),
        corners: Vec::new(),
    };
    loop {
        reader.cursor.skip_to_statement();
        if reader.cursor.is_at_end() {
            return reader.piece;
        }
        if let Err(fault) = reader.statement() {
            reader.piece.faults.push(fault);
        }
        // What is left: a comment, or what follows a fault.
        reader.cursor.skip_statement();
    }
}

struct Reader<'a> {
    cursor: Cursor<'a>,
    limits: Limits,
    /// The origin that is taken from vertices, if the scene is moved.
    origin: Option<DVec3>,
    share: Share<'a>,
    piece: Piece,
    /// Those of the face at hand.
    corners: Vec<Corner>,
}

impl Reader<'_> {
    #[inline]
    fn statement(&mut self) -> Result<(), Fault> {
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
                self.texture_place()
            }
            [b'#', ..] => Ok(()),
            _ => self.rare_statement(),
        }
    }

    /// By its name as a word.
    fn rare_statement(&mut self) -> Result<(), Fault> {
        // A byte order mark is no part of the first name.
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
            b"vt" => return self.texture_place(),
            b"f" | b"fo" => return self.face(),
            b"usemtl" => {
                let material = self.cursor.rest_of_line();
                self.piece.switches.push((self.piece.faces.len(), material));
            }
            b"mtllib" => {
                let files = self.cursor.rest_of_line();
                self.piece.libraries.push(files);
            }
            b"l" | b"p" => self.piece.skipped.lines.add(name),
            b"g" | b"o" | b"s" | b"mg" | b"lod" | b"bevel" | b"c_interp" | b"d_interp"
            | b"maplib" | b"usemap" | b"shadow_obj" | b"trace_obj" | b"ctech" | b"stech"
            | b"call" | b"csh" => {}
            b"vp" | b"cstype" | b"deg" | b"bmat" | b"step" | b"curv" | b"curv2" | b"surf"
            | b"parm" | b"trim" | b"hole" | b"scrv" | b"sp" | b"end" | b"con" => {
                self.piece.skipped.free_forms.add(name)
            }
            _ => self.piece.skipped.unknown.add(name),
        }
        Ok(())
    }

    /// x, y, z; a weight and colours may follow, and are ignored.
    #[inline]
    fn vertex(&mut self) -> Result<(), Fault> {
        self.cursor.skip_blanks();
        let start = self.cursor.at;
        let place = match self.origin {
            None => self.vector::<3>(),
            Some(origin) => self.moved(origin),
        };
        // Takes the number of a faulty one, so that no face is blamed for it.
        let [x, y, z] = *place.as_ref().unwrap_or(&[0.0; 3]);
        let finite = x.is_finite() && y.is_finite() && z.is_finite();
        let row = if finite { [x, y, z] } else { [0.0; 3] };
        if !finite {
            let number = self.piece.vertices[0].len() as u32;
            let place = Place {
                offset: start,
                length: self.cursor.at - start,
            };
            self.piece.not_finite.push(NotFinite { number, place });
        }
        push(&mut self.piece.vertices, row);
        place?;
        if self.cursor.at_statement_end() {
            return Ok(());
        }
        self.weight_and_colors()
    }

    /// One number, or three and more: what follows a vertex.
    fn weight_and_colors(&mut self) -> Result<(), Fault> {
        let mut count = 0;
        let mut second = None;
        while !self.cursor.at_statement_end() {
            let start = self.cursor.at;
            self.cursor.float()?;
            count += 1;
            if count == 2 {
                second = Some(Place {
                    offset: start,
                    length: self.cursor.at - start,
                });
            }
        }
        match second {
            Some(place) if count == 2 => Err(Fault::new(place, "five numbers make no vertex")
                .with_help("three, four with a weight, or six and more with a colour")),
            _ => Ok(()),
        }
    }

    #[inline]
    fn normal(&mut self) -> Result<(), Fault> {
        self.cursor.skip_blanks();
        let start = self.cursor.at;
        let vector = self.vector::<3>();
        let [x, y, z] = *vector.as_ref().unwrap_or(&[0.0, 0.0, 1.0]);
        let usable =
            x.is_finite() && y.is_finite() && z.is_finite() && (x != 0.0 || y != 0.0 || z != 0.0);
        if !usable {
            let number = self.piece.normals[0].len() as u32;
            let place = Place {
                offset: start,
                length: self.cursor.at - start,
            };
            self.piece.bad_normals.push(NotFinite { number, place });
        }
        push(
            &mut self.piece.normals,
            if usable { [x, y, z] } else { [0.0, 0.0, 1.0] },
        );
        vector?;
        self.no_more()
    }

    /// u, perhaps v, perhaps w, which is ignored. OBJ's v is 0 at the bottom, the scene's at the top.
    #[inline]
    fn texture_place(&mut self) -> Result<(), Fault> {
        self.cursor.skip_blanks();
        let start = self.cursor.at;
        let place = self.one_to_three();
        let [u, v] = *place.as_ref().unwrap_or(&[0.0; 2]);
        let finite = u.is_finite() && v.is_finite();
        if !finite {
            let length = self.cursor.at - start;
            self.piece.bad_uvs.add(Place {
                offset: start,
                length,
            });
        }
        push(
            &mut self.piece.uvs,
            if finite { [u, 1.0 - v] } else { [0.0; 2] },
        );
        place?;
        self.no_more()
    }

    #[inline]
    fn one_to_three(&mut self) -> Result<[f32; 2], Fault> {
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

    /// The place of a vertex, taken from an origin before it is rounded.
    fn moved(&mut self, origin: DVec3) -> Result<[f32; 3], Fault> {
        let mut place = DVec3::ZERO;
        for axis in 0..3 {
            place[axis] = self.cursor.double()? - origin[axis];
        }
        Ok(place.as_vec3().to_array())
    }

    #[inline]
    fn vector<const N: usize>(&mut self) -> Result<[f32; N], Fault> {
        let mut out = [0.0; N];
        for number in &mut out {
            *number = self.cursor.float()?;
        }
        Ok(out)
    }

    #[inline]
    fn no_more(&mut self) -> Result<(), Fault> {
        if self.cursor.at_statement_end() {
            return Ok(());
        }
        let place = self.cursor.word();
        let message = format!("{} is one operand too many", self.cursor.quoted(place));
        Err(Fault::new(place, message))
    }

    #[inline]
    fn face(&mut self) -> Result<(), Fault> {
        self.corners.clear();
        self.cursor.skip_blanks();
        let start = self.cursor.at;
        // Those beyond are counted for the message.
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
        let place = Place {
            offset: start,
            length: self.cursor.at - start,
        };
        match count {
            0 => Err(self.cursor.missing("a corner")),
            _ if !alike(TEXTURE_PLACE) || !alike(NORMAL) => Err(Fault::new(
                place,
                "some corners of this face have a texture place or a normal, others have none",
            )),
            1 | 2 => {
                self.piece.skipped.lines.add(place);
                Ok(())
            }
            count if count > MAX_CORNERS => Err(Fault::new(
                place,
                format!("a face of {count} corners: at most {MAX_CORNERS}"),
            )),
            _ => {
                // A file counts three times, once for itself: see `--max-memory`.
                let attributes = first[1..].iter().filter(|&&number| number != NONE).count();
                let paid = 2 * place.length as u64;
                let bytes = bytes_beyond(count, attributes as u64, paid);
                if self.share.take(bytes) {
                    self.piece.faces.add(&self.corners);
                }
                Ok(())
            }
        }
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    #[inline]
    fn corner(&mut self) -> Result<Corner, Fault> {
        let start = self.cursor.at;
        let mut corner = Corner {
            numbers: [NONE; 3],
            relative: 0,
        };
        self.number(VERTEX, &mut corner, start)?;
        for attribute in [TEXTURE_PLACE, NORMAL] {
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
    fn no_corner(&mut self, start: usize) -> Fault {
        self.cursor.at = start;
        let word = self.cursor.word();
        let message = format!("{} is not a corner", self.cursor.quoted(word));
        Fault::new(word, message)
            .with_help("write `v`, `v/vt`, `v//vn` or `v/vt/vn` with whole numbers")
    }

    /// A number from 1 on, or one that counts back from the last row so far, which is -1.
    #[inline]
    fn number(&mut self, attribute: usize, corner: &mut Corner, start: usize) -> Result<(), Fault> {
        let (number, end) = decimal::integer(self.cursor.text, self.cursor.at);
        if end == self.cursor.at {
            return Err(self.no_corner(start));
        }
        if number > 0 && number <= self.limits.total[attribute] {
            let row = (number - 1) as u32;
            self.piece.highest[attribute] = self.piece.highest[attribute].max(row + 1);
            corner.numbers[attribute] = row;
        } else {
            let row = self.piece.counts()[attribute] as i64 + number;
            if number >= 0 || row < -self.limits.before[attribute] {
                return Err(self.out_of_range(attribute, number, end));
            }
            self.piece.lowest[attribute] = self.piece.lowest[attribute].min(row);
            corner.numbers[attribute] = (row as u32).wrapping_add(RELATIVE_ZERO);
            corner.relative |= 1 << attribute;
        }
        self.cursor.at = end;
        Ok(())
    }

    #[cold]
    fn out_of_range(&self, attribute: usize, number: i64, end: usize) -> Fault {
        let place = Place {
            offset: self.cursor.at,
            length: end - self.cursor.at,
        };
        if number == 0 {
            return Fault::new(
                place,
                "0 is no row: they are numbered from 1, or from -1 backward",
            );
        }
        let what = ["vertices", "texture places", "normals"][attribute];
        let (have, scope) = match number < 0 {
            true => (
                self.limits.before[attribute] + self.piece.counts()[attribute] as i64,
                " so far",
            ),
            false => (self.limits.total[attribute], ""),
        };
        Fault::new(
            place,
            format!(
                "{} is out of range: there are {have} {what}{scope}",
                self.cursor.quoted(place)
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
