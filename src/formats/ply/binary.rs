//! Rows of a binary file.
//!
//! Rows without lists, and faces that are all triangles, have a fixed length. Several threads
//! extract their numbers at once. Rows that are less regular, or faulty, are walked one by one.

use super::colors::FaceColors;
use super::columns::{
    RowChunk, TriangleRowLayout, checked, checked_columns, columns, fill, source, type_of_number,
};
use super::header::{Element, Encoding, PropertyKind, Type};
use super::lexer::whole;
use super::plan::{ElementUse, ReadPlan, VertexPlan};
use super::rows::{
    Body, FaceRow, FaceSink, check_corners, checked_normal, checked_position, too_short,
};
use super::uvs::{FaceUvProperties, FaceUvs, MAX_UVS};
use crate::diagnostics::{DiagnosticSink, Span};
use crate::faces::{Faces, VERTEX};
use crate::mesh::{NotFinite, ParseError, ParseErrors};
use crate::workers;
use glam::DVec3;
use phalanx_scene::{Column, Vec2s, Vec3s};

/// Reads the rows of all elements; errors are added to the report.
pub(super) fn read(
    bytes: &[u8],
    plan: &ReadPlan,
    threads: usize,
    chunk_bytes: usize,
    report: &mut DiagnosticSink,
) -> Body {
    let mut reader = PlyBinaryReader {
        bytes,
        at: plan.header.body,
        big_endian: plan.header.encoding == Encoding::BigEndian,
        threads,
        chunk_bytes,
        plan,
        body: Body::default(),
        errors: ParseErrors::default(),
    };
    for index in 0..plan.header.elements.len() {
        if let Err(error) = reader.element(index) {
            reader.errors.push(error);
        }
        if !reader.errors.is_empty() {
            reader.errors.emit(report);
            return reader.body;
        }
    }
    let surplus = bytes.len() - reader.at;
    if surplus > 0 {
        let span = Span::new(reader.at, surplus);
        report.warning(
            span,
            format!("{surplus} bytes behind the last row are ignored"),
        );
    }
    reader.body
}

struct PlyBinaryReader<'a> {
    bytes: &'a [u8],
    at: usize,
    big_endian: bool,
    threads: usize,
    chunk_bytes: usize,
    plan: &'a ReadPlan,
    body: Body,
    errors: ParseErrors,
}

/// A property of a row.
enum Field {
    /// Offset of the number.
    One(usize),
    /// Offset of its items, and their number.
    List(usize, usize),
}

impl<'a> PlyBinaryReader<'a> {
    fn element(&mut self, index: usize) -> Result<(), ParseError> {
        let element = &self.plan.header.elements[index];
        let least = element.least_bytes();
        if least == 0 {
            return Ok(());
        }
        let room = (self.bytes.len() - self.at) / least;
        if element.count > room as u64 {
            return Err(too_short(element, room as u64, self.bytes.len()));
        }
        let count = element.count as usize;
        match self.plan.purpose(index) {
            ElementUse::Vertices if element.has_lists() => self.walk_vertices(element),
            ElementUse::Vertices => {
                self.vertices(element, count);
                self.at += count * least;
                Ok(())
            }
            ElementUse::Faces(list) => match self.triangles(element, list, count) {
                Some(length) => {
                    self.at += length;
                    Ok(())
                }
                None => self.walk_faces(element, list, false),
            },
            ElementUse::Strips(list) => self.walk_faces(element, list, true),
            ElementUse::Nothing if element.has_lists() => self.walk(element, |_, _, _, _| {}),
            ElementUse::Nothing => {
                self.at += count * least;
                Ok(())
            }
        }
    }

    /// Reads vertices of a fixed length, for which there is memory.
    fn vertices(&mut self, element: &Element, count: usize) {
        let VertexPlan {
            position, origin, ..
        } = self.plan.vertices;
        let (columns, bad) = self.vectors(element, count, (position, origin), checked_position);
        self.body.vertices = columns;
        self.body.not_finite = bad;
        if let Some(normal) = self.plan.vertices.normal {
            let (columns, bad) =
                self.vectors(element, count, (normal, DVec3::ZERO), checked_normal);
            self.body.normals = Some(columns);
            self.body.bad_normals = bad;
        }
        if let Some(color) = self.plan.vertices.color {
            let [x, y, z] = self.numbers(element, count, color.numbers);
            self.body.colors = Some(Vec3s { x, y, z });
        }
        if let Some(uv) = self.plan.vertices.uv {
            let [x, y] = self.numbers(element, count, uv);
            self.body.uvs = Some(Vec2s { x, y });
        }
    }

    /// Some properties of each row of a fixed length, as they are.
    fn numbers<const N: usize>(
        &self,
        element: &Element,
        count: usize,
        properties: [usize; N],
    ) -> [Column<f32>; N] {
        let stride = element.least_bytes();
        let rows = &self.bytes[self.at..self.at + count * stride];
        let sources = properties.map(|index| source(element, index, 0));
        let blocks = self.blocks(stride);
        columns(rows, stride, sources, self.big_endian, blocks).map(Into::into)
    }

    /// The number of threads, and of rows of this length that one takes at a time.
    fn blocks(&self, stride: usize) -> (usize, usize) {
        (self.threads, (self.chunk_bytes / stride).max(1))
    }

    /// Three properties of each row, less an origin, replaced by `check` if they are unusable.
    fn vectors(
        &self,
        element: &Element,
        count: usize,
        (properties, origin): ([usize; 3], DVec3),
        check: impl Fn([f32; 3], u32, Span, &mut Vec<NotFinite>) -> [f32; 3] + Sync,
    ) -> (Vec3s, Vec<NotFinite>) {
        let stride = element.least_bytes();
        let rows = &self.bytes[self.at..self.at + count * stride];
        let sources = properties.map(|index| source(element, index, 0));
        let mut columns = [(); 3].map(|()| vec![0.0f32; count]);
        let (threads, size) = self.blocks(stride);
        let [x, y, z] = &mut columns;
        let outs = x
            .chunks_mut(size)
            .zip(y.chunks_mut(size))
            .zip(z.chunks_mut(size));
        let blocks = outs.zip(rows.chunks(size * stride)).enumerate();
        let blocks = blocks.map(|(k, (((x, y), z), rows))| RowChunk {
            first: k * size,
            out: [x, y, z],
            rows,
        });
        let bad = workers::map(threads, blocks.collect(), |mut block| {
            let sources = sources.into_iter().zip(origin.to_array());
            for (out, ((offset, kind), origin)) in block.out.iter_mut().zip(sources) {
                let kind = (kind, origin);
                fill(out, block.rows, stride, offset, kind, self.big_endian);
            }
            let span = |row: usize| Span::new(self.at + row * stride, stride);
            checked(&mut block, span, &check)
        });
        let [x, y, z] = columns.map(Into::into);
        (Vec3s { x, y, z }, bad.into_iter().flatten().collect())
    }

    /// Reads faces that are all correct and have three corners; returns their length in bytes.
    /// `None` for others.
    fn triangles(&mut self, element: &Element, list: usize, count: usize) -> Option<usize> {
        let PropertyKind::List {
            count: count_type,
            item,
        } = element.properties[list].kind
        else {
            return None;
        };
        if self.plan.face_uvs.picture.is_some() {
            return None;
        }
        let of = |index: usize| match element.properties[index].kind {
            PropertyKind::One(kind) => Some(kind.size()),
            PropertyKind::List { .. } => None,
        };
        let before = (0..list).map(of).sum::<Option<usize>>()?;
        let after = (list + 1..element.properties.len())
            .map(of)
            .sum::<Option<usize>>()?;
        let corners = before + count_type.size();
        let stride = corners + 3 * item.size() + after;
        let length = count.checked_mul(stride)?;
        let rows = self.bytes[self.at..].get(..length)?;
        let layout = TriangleRowLayout {
            stride,
            count: before,
            count_type,
            corners,
            item,
            big_endian: self.big_endian,
        };
        let bytes = self.plan.bytes_beyond(3, stride);
        if !self
            .plan
            .made
            .share()
            .take(bytes.saturating_mul(count as u64))
        {
            return Some(length);
        }
        let mut faces = Faces::default();
        // Zeroed pages of the system, which are first touched when they are written to.
        faces.columns[VERTEX] = vec![[0; 3]; count];
        let (threads, size) = self.blocks(stride);
        let outs = faces.columns[VERTEX].chunks_mut(size);
        let blocks = outs.zip(rows.chunks(size * stride)).enumerate();
        let blocks = blocks.map(|(k, (out, rows))| RowChunk {
            first: k * size,
            out,
            rows,
        });
        let vertices = self.plan.vertices.count;
        let right = workers::map(threads, blocks.collect(), |block| {
            layout
                .triangles(block.out, block.rows)
                .is_some_and(|highest| u64::from(highest) < vertices)
        });
        if !right.into_iter().all(|right| right) {
            return None;
        }
        self.body.faces.push(faces);
        let mut colors = FaceColors::default();
        if let Some(color) = self.plan.face_color {
            let sources = color.numbers.map(|index| source(element, index, 3));
            colors.rgb = columns(rows, stride, sources, self.big_endian, self.blocks(stride));
            colors.numbers = (0..count as u32).collect();
        }
        self.body.face_colors.push(colors);
        self.body.face_uvs.push(FaceUvs::default());
        Some(length)
    }

    /// Passes all rows, calling back for each property with the row, the property's index and its
    /// position.
    fn walk(
        &mut self,
        element: &Element,
        mut visit: impl FnMut(&mut Self, usize, usize, Field),
    ) -> Result<(), ParseError> {
        for row in 0..element.count {
            for (index, property) in element.properties.iter().enumerate() {
                let end = || too_short(element, row, self.bytes.len());
                let (field, next) = self.field(property.kind).ok_or_else(end)?;
                if next > self.bytes.len() {
                    return Err(end());
                }
                visit(self, row as usize, index, field);
                self.at = next;
            }
            if self.errors.is_full() {
                return Ok(());
            }
        }
        Ok(())
    }

    /// The property at this position, and the position of the next. `None` if it cannot end within
    /// the file.
    fn field(&self, kind: PropertyKind) -> Option<(Field, usize)> {
        let (count, item) = match kind {
            PropertyKind::One(kind) => return Some((Field::One(self.at), self.at + kind.size())),
            PropertyKind::List { count, item } => (count, item),
        };
        let items = usize::try_from(self.integer(self.at, count)?).ok()?;
        let first = self.at + count.size();
        let end = items.checked_mul(item.size())?.checked_add(first)?;
        Some((Field::List(first, items), end))
    }

    /// The whole number at a position, if it fits into the file. One with a fraction is less than
    /// any index.
    fn integer(&self, at: usize, kind: Type) -> Option<i64> {
        let bytes = self.bytes.get(at..at + kind.size())?;
        let mut value = 0u64;
        for k in 0..bytes.len() {
            let byte = if self.big_endian {
                bytes[k]
            } else {
                bytes[bytes.len() - 1 - k]
            };
            value = value << 8 | u64::from(byte);
        }
        Some(match kind {
            Type::I8 => i64::from(value as i8),
            Type::I16 => i64::from(value as i16),
            Type::I32 => i64::from(value as i32),
            Type::F32 => whole(f32::from_bits(value as u32).into()).unwrap_or(i64::MIN),
            Type::F64 => whole(f64::from_bits(value)).unwrap_or(i64::MIN),
            _ => value as i64,
        })
    }

    /// The number of this type at a position within the file, less an origin.
    fn number(&self, at: usize, kind: PropertyKind, origin: f64) -> f32 {
        let kind = type_of_number(kind);
        let mut value = [0.0];
        let row = &self.bytes[at..];
        fill(
            &mut value,
            row,
            kind.size(),
            0,
            (kind, origin),
            self.big_endian,
        );
        value[0]
    }

    /// The coordinates of a face's corners, from a position within the file.
    fn texture_numbers(&self, first: usize, count: usize, kind: PropertyKind, uvs: &mut Vec<f32>) {
        let size = type_of_number(kind).size();
        let number = |k| self.number(first + k * size, kind, 0.0);
        uvs.clear();
        uvs.extend((0..count.min(MAX_UVS)).map(number));
    }

    fn walk_faces(
        &mut self,
        element: &Element,
        list: usize,
        strips: bool,
    ) -> Result<(), ParseError> {
        let PropertyKind::List { item, .. } = element.properties[list].kind else {
            return Ok(());
        };
        let vertices = self.plan.vertices.count;
        let mut sink = FaceSink::default();
        let mut share = self.plan.made.share();
        let mut corners = Vec::new();
        let last = element.properties.len() - 1;
        let colored = self.plan.face_color.filter(|_| !strips);
        let FaceUvProperties {
            list: uv_list,
            picture: picture_index,
        } = match strips {
            true => FaceUvProperties::default(),
            false => self.plan.face_uvs,
        };
        let (mut face, mut color) = (None, [0.0; 3]);
        let (mut uvs, mut picture) = (Vec::new(), 0.0);
        self.walk(element, |reader, _, index, field| {
            let kind = element.properties[index].kind;
            match field {
                Field::List(first, count) if index == list => face = Some((first, count)),
                Field::List(first, count) if uv_list == Some(index) => {
                    reader.texture_numbers(first, count, kind, &mut uvs);
                }
                Field::List(..) => {}
                Field::One(at) if picture_index == Some(index) => {
                    picture = reader.number(at, kind, 0.0);
                }
                Field::One(at) => {
                    let channel = colored.and_then(|c| c.numbers.iter().position(|&k| k == index));
                    if let Some(channel) = channel {
                        color[channel] = reader.number(at, kind, 0.0);
                    }
                }
            }
            // The colour may stand on either side of the corners.
            let Some((first, count)) = face.take_if(|_| index == last) else {
                return;
            };
            let span = Span::new(first, count * item.size());
            // Strips may be long; their corners are held as numbers of eight bytes for a while.
            let (checked, held) = match strips {
                true => (Ok(()), 8 * count as u64),
                false => (check_corners(count, span), 0),
            };
            if let Err(error) = checked {
                return reader.errors.push(error);
            }
            if !share.take(reader.plan.bytes_beyond(count, span.length) + held) {
                return;
            }
            corners.clear();
            let at = |k: usize| reader.integer(first + k * item.size(), item);
            corners.extend((0..count).map_while(at));
            let added = match strips {
                true => sink.add_strips(&corners, vertices, span),
                false => {
                    let face = FaceRow {
                        corners: &corners,
                        color: colored.map(|_| color),
                        uvs: uv_list.map(|_| &uvs[..]),
                        picture: picture_index.map(|_| picture),
                    };
                    sink.add(face, vertices, span)
                }
            };
            if let Err(error) = added {
                reader.errors.push(error);
            }
        })?;
        self.body.faces.push(sink.faces);
        self.body.face_colors.push(sink.colors);
        self.body.face_uvs.push(sink.uvs);
        self.body.skipped.merge(sink.skipped);
        Ok(())
    }

    /// Reads vertices that have lists among their properties.
    fn walk_vertices(&mut self, element: &Element) -> Result<(), ParseError> {
        let VertexPlan {
            position,
            origin,
            normal,
            color,
            uv,
            ..
        } = self.plan.vertices;
        let wanted = position.into_iter().chain(normal.into_iter().flatten());
        let wanted = wanted.chain(color.into_iter().flat_map(|color| color.numbers));
        let wanted = wanted.chain(uv.into_iter().flatten());
        let wanted: Vec<usize> = wanted.collect();
        let mut columns = vec![Vec::new(); wanted.len()];
        let mut starts = Vec::new();
        self.walk(element, |reader, _, index, field| {
            if index == 0 {
                starts.push(reader.at);
            }
            let wanted = wanted.iter().enumerate();
            for (column, (k, _)) in columns
                .iter_mut()
                .zip(wanted)
                .filter(|(_, (_, w))| **w == index)
            {
                if let Field::One(at) = field {
                    let origin = origin.to_array().get(k).copied().unwrap_or(0.0);
                    let kind = element.properties[index].kind;
                    column.push(reader.number(at, kind, origin));
                }
            }
        })?;
        let at = |row: usize| Span::at(starts[row]);
        let mut columns = columns.into_iter();
        let mut three = || std::array::from_fn(|_| columns.next().unwrap_or_default());
        let (vertices, bad) = checked_columns(three(), at, &checked_position);
        (self.body.vertices, self.body.not_finite) = (vertices, bad);
        if normal.is_some() {
            let (normals, bad) = checked_columns(three(), at, &checked_normal);
            (self.body.normals, self.body.bad_normals) = (Some(normals), bad);
        }
        if color.is_some() {
            let [x, y, z] = three().map(Into::into);
            self.body.colors = Some(Vec3s { x, y, z });
        }
        if uv.is_some() {
            let [x, y, _] = three().map(Into::into);
            self.body.uvs = Some(Vec2s { x, y });
        }
        Ok(())
    }
}
