//! One chunk of an OBJ file, read independently of the others.

use super::colors::ChunkColors;
use super::cursor::{Cursor, KEYWORD_BYTES};
use crate::diagnostics::{ChunkRemarks, ParseError, Span, WarningTally};
use crate::memory::LedgerShare;
use crate::mesh::chunk::{MeshChunk, push};
use crate::mesh::faces::FaceCorner;
use crate::mesh::named_runs::change;
use crate::text::decimal;
use crate::text::mark_length;
use glam::DVec3;

/// Warning of a statement that OBJ files do not have.
pub(super) const UNKNOWN: [&str; 2] = [
    "this statement is unknown, and skipped",
    "statements are unknown, this one first, and skipped",
];

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
    /// The vertices and faces. Faulty rows have their numbers in the chunk.
    pub(super) mesh: MeshChunk,
    /// Changes of the material by `usemtl`: the first triangle with the new one, and the span of
    /// its name.
    pub(super) switches: Vec<(usize, Span)>,
    /// Changes of the object by `o` and `g`: the first triangle of the new one, the span of its
    /// name, and true for `o`. A `g` after an `o` is left out.
    pub(super) objects: Vec<(usize, (Span, bool))>,
    /// The operands of each `mtllib`.
    pub(super) libraries: Vec<Span>,
    /// Numbers of UVs and normals that the file does not have.
    pub(super) bad_references: [WarningTally; 3],
    pub(super) colors: ChunkColors,
    /// Changes of the smoothing group by `s`: the first triangle with the new one, and its number,
    /// 0 for none.
    pub(super) smoothing: Vec<(usize, u32)>,
    pub(super) remarks: ChunkRemarks,
    /// Largest absolute number of each attribute, counted from 1.
    pub(super) highest: [u32; 3],
    /// Relative number of each attribute that reaches back farthest, counted from the first row of
    /// the chunk.
    pub(super) lowest: [i64; 3],
}

impl ObjChunk {
    /// Rows of each attribute.
    pub(super) fn counts(&self) -> [usize; 3] {
        let MeshChunk {
            vertices,
            uvs,
            normals,
            ..
        } = &self.mesh;
        [vertices[0].len(), uvs[0].len(), normals[0].len()]
    }
}

/// Reads the chunk of `text` from `start` to its end. `origin`, if there is one, is subtracted from
/// vertices. Faces are made as long as there is memory for them in `share`.
pub(super) fn read<'a>(
    text: &'a [u8],
    start: usize,
    limits: IndexLimits,
    origin: Option<DVec3>,
    share: LedgerShare<'a>,
) -> ObjChunk {
    // A byte order mark is not part of the first name.
    let offset = if start == 0 { mark_length(text) } else { start };
    let mut reader = ObjReader {
        cursor: Cursor { text, at: offset },
        limits,
        origin,
        share,
        chunk: ObjChunk::default(),
        corners: Vec::new(),
        out_of_range: [false; 3],
    };
    loop {
        reader.cursor.skip_to_statement();
        if reader.cursor.is_at_end() {
            return reader.chunk;
        }
        if let Err(error) = reader.statement() {
            reader.chunk.remarks.error(error);
        }
        // The rest is a comment, or follows a fault.
        reader.cursor.skip_statement();
    }
}

pub(super) struct ObjReader<'a> {
    pub(super) cursor: Cursor<'a>,
    pub(super) limits: IndexLimits,
    /// The origin that is subtracted from vertices, if the scene is moved.
    origin: Option<DVec3>,
    pub(super) share: LedgerShare<'a>,
    pub(super) chunk: ObjChunk,
    /// Corners of the current face.
    pub(super) corners: Vec<FaceCorner>,
    /// Attributes of which the current face has a number out of range.
    pub(super) out_of_range: [bool; 3],
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
            [b'#', rest @ ..] => {
                if rest.starts_with(b"MRGB") {
                    self.painted_colors();
                }
                Ok(())
            }
            _ => self.rare_statement(),
        }
    }

    /// Reads a statement by its name as a word.
    fn rare_statement(&mut self) -> Result<(), ParseError> {
        let name = self.cursor.word();
        let mut lower = [0; KEYWORD_BYTES];
        match self.cursor.keyword(name, &mut lower) {
            b"v" => return self.vertex(),
            b"vn" => return self.normal(),
            b"vt" => return self.texture_uv(),
            b"f" | b"fo" => return self.face(),
            b"usemtl" => {
                let material = self.cursor.rest_of_line();
                self.chunk
                    .switches
                    .push((self.chunk.mesh.faces.len(), material));
            }
            b"mtllib" => {
                let files = self.cursor.rest_of_line();
                self.chunk.libraries.push(files);
            }
            b"s" => self.smoothing_group(),
            b"l" | b"p" => self.skip_line(name),
            word @ (b"o" | b"g") => {
                let is_object = word == b"o";
                let name = self.cursor.rest_of_line();
                let chunk = &mut self.chunk;
                let in_object = chunk.objects.last().is_some_and(|(_, last)| last.1);
                if is_object || !in_object {
                    change(
                        &mut chunk.objects,
                        chunk.mesh.faces.len(),
                        (name, is_object),
                    );
                }
            }
            b"mg" | b"lod" | b"bevel" | b"c_interp" | b"d_interp" | b"maplib" | b"usemap"
            | b"shadow_obj" | b"trace_obj" | b"ctech" | b"stech" | b"call" | b"csh" => {}
            b"vp" | b"cstype" | b"deg" | b"bmat" | b"step" | b"curv" | b"curv2" | b"surf"
            | b"parm" | b"trim" | b"hole" | b"scrv" | b"sp" | b"end" | b"con" => {
                self.chunk.remarks.warn(
                    name,
                    "this statement of a curve or surface is skipped",
                    "statements of curves and surfaces are skipped, this one first",
                );
            }
            _ => self.chunk.remarks.warn(name, UNKNOWN[0], UNKNOWN[1]),
        }
        Ok(())
    }

    /// Reads the number of a smoothing group, or `off`.
    fn smoothing_group(&mut self) {
        let word = self.cursor.word();
        let group = match self.cursor.bytes(word) {
            b"on" => 1,
            text => decimal::integer(text, 0).0.clamp(0, i64::from(u32::MAX)) as u32,
        };
        let first = self.chunk.mesh.faces.len();
        match self.chunk.smoothing.last_mut() {
            Some(last) if last.0 == first => last.1 = group,
            Some(last) if last.1 == group => {}
            _ => self.chunk.smoothing.push((first, group)),
        }
    }

    /// Reads x, y and z; a weight or a colour may follow.
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
        let row = *position.as_ref().unwrap_or(&[0.0; 3]);
        let number = self.chunk.mesh.vertices[0].len() as u32;
        let span = Span::between(start, self.cursor.at);
        self.chunk.mesh.add_vertex(row, number, span);
        position?;
        if self.cursor.at_statement_end() {
            return Ok(());
        }
        self.weight_or_color()
    }

    #[inline]
    fn normal(&mut self) -> Result<(), ParseError> {
        self.cursor.skip_blanks();
        let start = self.cursor.at;
        let vector = self.vector::<3>();
        let row = *vector.as_ref().unwrap_or(&[0.0, 0.0, 1.0]);
        let number = self.chunk.mesh.normals[0].len() as u32;
        let span = Span::between(start, self.cursor.at);
        self.chunk.mesh.add_normal(row, number, span);
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
            self.chunk.remarks.warn(
                Span::between(start, self.cursor.at),
                "this texture coordinate is not finite: (0, 0) is used instead",
                "texture coordinates are not finite, this one first: (0, 0) is used instead",
            );
        }
        push(
            &mut self.chunk.mesh.uvs,
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
        let start = self.cursor.at;
        self.cursor.float()?;
        self.note_surplus(start);
        Ok(())
    }

    /// Notes an operand that the statement does not have, and passes the rest.
    #[cold]
    pub(super) fn note_surplus(&mut self, start: usize) {
        self.chunk.remarks.warn(
            Span::between(start, self.cursor.at),
            "this is one operand too many: it is not used",
            "statements have operands too many, this one first: they are not used",
        );
    }

    /// Notes a face of too few corners, or a line or point.
    pub(super) fn skip_line(&mut self, span: Span) {
        self.chunk.remarks.warn(
            span,
            "this face of two corners, line or point is skipped",
            "faces of two corners, lines or points are skipped, this one first",
        );
    }
}
