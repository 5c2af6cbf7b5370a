//! The header of a PLY file: the elements that follow, their counts, and their properties.

use crate::diagnostics::{ChunkRemarks, ParseError, Span, quoted_bytes};
use crate::text::mark_length;

/// Encoding of the rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Type {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Type {
    fn named(name: &[u8]) -> Option<Type> {
        Some(match name {
            b"char" | b"int8" => Type::I8,
            b"uchar" | b"uint8" => Type::U8,
            b"short" | b"int16" => Type::I16,
            b"ushort" | b"uint16" => Type::U16,
            b"int" | b"int32" => Type::I32,
            b"uint" | b"uint32" => Type::U32,
            b"float" | b"float32" => Type::F32,
            b"double" | b"float64" => Type::F64,
            _ => return None,
        })
    }

    /// Size in bytes in a binary file.
    pub(super) fn size(self) -> usize {
        match self {
            Type::I8 | Type::U8 => 1,
            Type::I16 | Type::U16 => 2,
            Type::I32 | Type::U32 | Type::F32 => 4,
            Type::F64 => 8,
        }
    }

    pub(super) fn is_whole(self) -> bool {
        !matches!(self, Type::F32 | Type::F64)
    }
}

/// One number, or a list of them behind their count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PropertyKind {
    One(Type),
    List { count: Type, item: Type },
}

impl PropertyKind {
    /// The type of the number, or of the list's items.
    pub(super) fn number_type(self) -> Type {
        match self {
            PropertyKind::One(kind) => kind,
            PropertyKind::List { item, .. } => item,
        }
    }

    /// Returns true if it is one number, which single precision holds without rounding.
    pub(super) fn is_single(self) -> bool {
        use Type::{F32, I8, I16, U8, U16};
        matches!(self, PropertyKind::One(I8 | U8 | I16 | U16 | F32))
    }
}

#[derive(Clone, Debug)]
pub(super) struct Property {
    pub(super) name: Vec<u8>,
    pub(super) kind: PropertyKind,
}

#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) name: Vec<u8>,
    /// Number of rows. Must not be trusted before the bytes have been counted.
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
    /// Span of its count.
    pub(super) span: Span,
}

impl Element {
    /// Bytes of a row in a binary file if all its lists are empty.
    pub(super) fn least_bytes(&self) -> usize {
        let smallest = |p: &Property| match p.kind {
            PropertyKind::One(kind) => kind.size(),
            PropertyKind::List { count, .. } => count.size(),
        };
        self.properties.iter().map(smallest).sum()
    }

    pub(super) fn has_lists(&self) -> bool {
        let is_list = |p: &Property| matches!(p.kind, PropertyKind::List { .. });
        self.properties.iter().any(is_list)
    }

    /// Index of a number among the properties.
    pub(super) fn number(&self, name: &[u8]) -> Option<usize> {
        let is_number = |p: &Property| p.name == name && matches!(p.kind, PropertyKind::One(_));
        self.properties.iter().position(is_number)
    }

    /// Indices of several numbers, if all of them are among the properties.
    pub(super) fn numbers<const N: usize>(&self, names: [&[u8]; N]) -> Option<[usize; N]> {
        let mut indices = [0; N];
        for (index, name) in indices.iter_mut().zip(names) {
            *index = self.number(name)?;
        }
        Some(indices)
    }

    /// Index of the list of a face's corners among the properties.
    pub(super) fn corners(&self) -> Option<usize> {
        let named = |p: &Property| p.name == b"vertex_indices" || p.name == b"vertex_index";
        let is_list = |p: &Property| matches!(p.kind, PropertyKind::List { .. });
        self.properties.iter().position(|p| named(p) && is_list(p))
    }
}

#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Offset of the first row.
    pub(super) body: usize,
    /// Warnings about its lines.
    pub(super) remarks: ChunkRemarks,
    /// Names of pictures, in the order of their numbers.
    pub(super) pictures: Vec<Span>,
    /// The character that ends a line; `\r` before a `\n` is a blank.
    pub(super) line_end: u8,
}

/// The length of the header, its last line end included; the whole file where it does not end.
pub(super) fn length(bytes: &[u8]) -> usize {
    let mut lines = HeaderLines::new(bytes);
    for line in lines.by_ref() {
        if bytes[line.range()].trim_ascii() == b"end_header" {
            break;
        }
    }
    lines.at
}

/// Lines of the header. The end of the first line determines the ends of all, so that a byte of the
/// body is never mistaken for one.
struct HeaderLines<'a> {
    bytes: &'a [u8],
    at: usize,
    line_end: u8,
}

impl<'a> HeaderLines<'a> {
    fn new(bytes: &'a [u8]) -> HeaderLines<'a> {
        let first = memchr::memchr2(b'\n', b'\r', bytes).unwrap_or(bytes.len());
        let is_cr = bytes[first..].starts_with(b"\r") && !bytes[first..].starts_with(b"\r\n");
        HeaderLines {
            bytes,
            at: mark_length(bytes),
            line_end: if is_cr { b'\r' } else { b'\n' },
        }
    }
}

impl Iterator for HeaderLines<'_> {
    type Item = Span;

    fn next(&mut self) -> Option<Span> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let length = memchr::memchr(self.line_end, rest).unwrap_or(rest.len());
        let span = Span::new(self.at, length);
        self.at = (self.at + length + 1).min(self.bytes.len());
        Some(span)
    }
}

/// Number of words of a line that are read: one more than any valid line has.
const MAX_WORDS: usize = 6;
/// Maximum number of elements of a header. More are treated as a mistake, because each is compared
/// with those before it.
const MAX_ELEMENTS: usize = 1000;

/// Maximum number of pictures that a header names: each is looked for in folders.
const MAX_PICTURES: usize = 1000;

/// A word of the header.
type HeaderWord<'a> = (Span, &'a [u8]);

fn words(bytes: &[u8], line: Span) -> Vec<HeaderWord<'_>> {
    let mut offset = line.offset;
    let words = bytes[line.range()].split(u8::is_ascii_whitespace);
    let words = words.map(|word| {
        let span = Span::new(offset, word.len());
        offset = span.end() + 1;
        (span, word)
    });
    let words = words.filter(|(_, word)| !word.is_empty());
    words.take(MAX_WORDS).collect()
}

/// The name of a picture, which may hold blanks, in a comment that gives one.
fn picture_name(comment: &[HeaderWord], bytes: &[u8], line: Span) -> Option<Span> {
    let [_, (_, keyword), (first, _), ..] = comment else {
        return None;
    };
    let name = bytes[first.offset..line.end()].trim_ascii_end();
    let named = keyword.eq_ignore_ascii_case(b"TextureFile");
    named.then(|| Span::new(first.offset, name.len()))
}

/// Reads the header.
pub(super) fn read(bytes: &[u8]) -> Result<Header, ChunkRemarks> {
    let mut lines = HeaderLines::new(bytes);
    let mut reader = PlyHeaderReader::default();
    let first = lines.find(|line| !bytes[line.range()].trim_ascii().is_empty());
    let magic = first.map_or(Vec::new(), |line| words(bytes, line));
    if magic.first().is_none_or(|(_, word)| *word != b"ply") {
        let span = first.map_or(Span::START, |line| {
            Span::new(line.offset, line.length.min(3))
        });
        let message = "this is not a PLY file: it does not begin with `ply`";
        reader.remarks.error(ParseError::new(span, message));
        return Err(reader.remarks);
    }
    let ended = reader.lines(bytes, &mut lines);
    let end = Span::at(lines.at);
    if !ended {
        let message = "the header does not end: `end_header` is missing";
        reader.remarks.error(ParseError::new(end, message));
    } else if reader.encoding.is_none() && !reader.remarks.has_errors() {
        let error = ParseError::new(end, "the header has no `format`");
        reader
            .remarks
            .error(error.with_help("write `format ascii 1.0`, for example, after `ply`"));
    }
    match reader.encoding {
        Some(encoding) if !reader.remarks.has_errors() => Ok(Header {
            encoding,
            elements: reader.elements,
            body: lines.at,
            remarks: reader.remarks,
            pictures: reader.pictures,
            line_end: lines.line_end,
        }),
        _ => Err(reader.remarks),
    }
}

#[derive(Default)]
struct PlyHeaderReader {
    encoding: Option<Encoding>,
    elements: Vec<Element>,
    pictures: Vec<Span>,
    remarks: ChunkRemarks,
}

impl PlyHeaderReader {
    /// Reads up to `end_header`, or until there are enough errors; false if the file ends first.
    fn lines(&mut self, bytes: &[u8], lines: &mut HeaderLines) -> bool {
        for line in lines {
            let words = words(bytes, line);
            if self.pictures.len() > MAX_PICTURES {
                let error = ParseError::new(line, format!("more than {MAX_PICTURES} pictures"));
                self.remarks.error(error);
                return true;
            }
            match words.first() {
                None | Some((_, b"obj_info")) => {}
                Some((_, b"comment")) => self.pictures.extend(picture_name(&words, bytes, line)),
                Some((_, b"end_header")) => return true,
                Some(_) => {
                    if let Err(error) = self.line(&words) {
                        self.remarks.error(error);
                    }
                    if self.remarks.is_full() {
                        return true;
                    }
                }
            }
        }
        false
    }

    fn line(&mut self, words: &[HeaderWord]) -> Result<(), ParseError> {
        let (span, keyword) = words[0];
        match keyword {
            b"format" => self.format(operands(words)?),
            b"element" => self.element(operands(words)?),
            b"property" => self.property(words),
            // Before the first element, it may be a comment without its word.
            _ if self.elements.is_empty() => {
                self.remarks.warn(
                    span,
                    "this is no line of a header: it is ignored",
                    "lines, this one first, are none of a header: they are ignored",
                );
                Ok(())
            }
            _ => {
                let keyword = quoted_bytes(keyword);
                Err(ParseError::new(
                    span,
                    format!("unknown header line {keyword}"),
                ))
            }
        }
    }

    fn format(
        &mut self,
        [(span, name), (version_place, version)]: [HeaderWord; 2],
    ) -> Result<(), ParseError> {
        let encoding = match name {
            b"ascii" => Encoding::Ascii,
            b"binary_little_endian" => Encoding::LittleEndian,
            b"binary_big_endian" => Encoding::BigEndian,
            _ => {
                let help = "`ascii`, `binary_little_endian` or `binary_big_endian`";
                return Err(ParseError::new(span, "unknown format").with_help(help));
            }
        };
        if version != b"1.0" {
            return Err(ParseError::new(version_place, "only version 1.0 is known"));
        }
        match self.encoding.replace(encoding) {
            None => Ok(()),
            Some(_) => Err(ParseError::new(span, "a second `format`")),
        }
    }

    fn element(
        &mut self,
        [(name_place, name), (span, count)]: [HeaderWord; 2],
    ) -> Result<(), ParseError> {
        if self.elements.len() >= MAX_ELEMENTS {
            let message = format!("more than {MAX_ELEMENTS} elements");
            return Err(ParseError::new(name_place, message));
        }
        let number = std::str::from_utf8(count).ok().and_then(|n| n.parse().ok());
        let again = self.elements.iter().any(|e| e.name == name);
        // Added even if it is faulty, so that its properties are not reported.
        self.elements.push(Element {
            name: name.to_vec(),
            count: number.unwrap_or(0),
            properties: Vec::new(),
            span,
        });
        match number {
            None => Err(ParseError::new(
                span,
                "the number of rows must be a whole number from 0 on",
            )),
            Some(_) if again => Err(ParseError::new(name_place, "a second element of this name")),
            Some(_) => Ok(()),
        }
    }

    fn property(&mut self, words: &[HeaderWord]) -> Result<(), ParseError> {
        let Some(element) = self.elements.last_mut() else {
            let message = "a `property` before the first `element`";
            return Err(ParseError::new(words[0].0, message));
        };
        let (kind, name) = if words.get(1).is_some_and(|(_, word)| *word == b"list") {
            let [_, count, item, (_, name)] = operands(words)?;
            let (count, item) = (type_of(count)?, type_of(item)?);
            (PropertyKind::List { count, item }, name)
        } else {
            let [kind, (_, name)] = operands(words)?;
            (PropertyKind::One(type_of(kind)?), name)
        };
        let name = name.to_vec();
        element.properties.push(Property { name, kind });
        Ok(())
    }
}

fn type_of((span, name): HeaderWord) -> Result<Type, ParseError> {
    Type::named(name).ok_or_else(|| {
        let name = quoted_bytes(name);
        let error = ParseError::new(span, format!("unknown type {name}"));
        error.with_help("char, uchar, short, ushort, int, uint, float or double")
    })
}

/// The words after the first; there must be exactly `N`.
fn operands<'a, const N: usize>(
    words: &[HeaderWord<'a>],
) -> Result<[HeaderWord<'a>; N], ParseError> {
    if let Some((span, _)) = words.get(N + 1) {
        return Err(ParseError::new(*span, "one operand too many"));
    }
    words[1..].try_into().map_err(|_| {
        let last = words[words.len() - 1].0;
        let span = Span::at(last.end());
        ParseError::new(span, "an operand is missing")
    })
}
