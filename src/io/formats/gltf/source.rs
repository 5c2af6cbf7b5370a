//! The file as a source for the other modules: the document, its buffers' bytes, and the spans of
//! its rows in the text.

use super::container::{Container, ContainerFault};
use super::document::{GltfDocument, Versioned};
use crate::formats::diagnostics::{DiagnosticSink, Span, quoted};
use crate::formats::folder::{Folder, Found};
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use serde_json::value::RawValue;
use std::borrow::Cow;
use std::cell::OnceCell;
use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

/// The file.
pub(super) struct GltfSource<'a> {
    json: &'a [u8],
    json_offset: usize,
    pub(super) document: GltfDocument,
    buffers: Vec<Option<BufferBytes<'a>>>,
    /// Offsets of the rows of each list in `json`, found when a message first needs one.
    rows: OnceCell<BTreeMap<String, Vec<usize>>>,
}

/// Bytes of a buffer: in the file itself, or of another one.
#[derive(Clone)]
enum BufferBytes<'a> {
    Own(&'a [u8]),
    Other(Rc<Vec<u8>>),
}

impl std::ops::Deref for BufferBytes<'_> {
    type Target = [u8];
    fn deref(&self) -> &[u8] {
        match self {
            BufferBytes::Own(bytes) => bytes,
            BufferBytes::Other(bytes) => bytes,
        }
    }
}

/// Decoder of data in the text: padded or not, and lenient about the bits past the end.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

impl<'a> GltfSource<'a> {
    /// Parses the document and checks that its version is supported.
    pub(super) fn parse(
        bytes: &'a [u8],
        parts: &Container,
    ) -> Result<GltfSource<'a>, ContainerFault> {
        let mut json_offset = parts.json.start;
        let mut json = bytes[parts.json.clone()].trim_ascii_end();
        if let Some(rest) = json.strip_prefix("\u{feff}".as_bytes()) {
            (json, json_offset) = (rest, json_offset + 3);
        }
        if json.is_empty() {
            return Err((Span::START, "the file is empty".into()));
        }
        let parsed = serde_json::from_slice::<GltfDocument>(json);
        let asset = match &parsed {
            Ok(document) => &document.asset,
            // A document of another version may differ in everything else, and its version is the
            // more useful error.
            Err(_) => {
                &serde_json::from_slice::<Versioned>(json)
                    .unwrap_or_default()
                    .asset
            }
        };
        let needed = asset.min_version.as_ref().or(asset.version.as_ref());
        if let Some(version) = needed.filter(|v| !v.starts_with("2.")) {
            let version = quoted(version);
            return Err((
                Span::START,
                format!("glTF {version} is not read here, only 2.0"),
            ));
        }
        let document = parsed.map_err(|error| {
            let offset = json_offset + offset_of(json, error.line(), error.column());
            (Span::at(offset), plain(&error))
        })?;
        if document.asset.version.is_none() {
            return Err((
                Span::START,
                "not a glTF file: it has no `asset.version`".into(),
            ));
        }
        Ok(GltfSource {
            json,
            json_offset,
            document,
            buffers: Vec::new(),
            rows: OnceCell::new(),
        })
    }

    /// Span of a row of one of the document's lists. The first call parses the text once more, so
    /// it is for messages only.
    pub(super) fn span_of(&self, list: &str, row: usize) -> Span {
        let rows = self.rows.get_or_init(|| row_offsets(self.json));
        match rows.get(list).and_then(|offsets| offsets.get(row)) {
            Some(offset) => Span::new(self.json_offset + offset, 1),
            None => Span::START,
        }
    }

    /// Adds an error about a row.
    pub(super) fn error(&self, report: &mut DiagnosticSink, list: &str, row: usize, message: &str) {
        if !report.is_full() {
            report.error(self.span_of(list, row), format!("{list}[{row}]: {message}"));
        }
    }

    /// Reads every buffer: from the file's own chunk, from the text, or from a file beside it.
    pub(super) fn load_buffers(
        &mut self,
        binary: Option<&'a [u8]>,
        asset_dir: &Folder,
        report: &mut DiagnosticSink,
    ) {
        let mut files = HashMap::new();
        let mut buffers = Vec::with_capacity(self.document.buffers.len());
        for (row, buffer) in self.document.buffers.iter().enumerate() {
            let bytes = match (&buffer.uri, binary) {
                (Some(uri), _) => fetch(uri, asset_dir, &mut files).map(BufferBytes::Other),
                (None, Some(chunk)) if row == 0 => Ok(BufferBytes::Own(chunk)),
                // No error yet; a use of the buffer reports it. A buffer that stands in for
                // compressed data has no bytes of its own.
                (None, _) => {
                    buffers.push(None);
                    continue;
                }
            };
            let bytes = bytes.and_then(|bytes| match buffer.byte_length <= bytes.len() as u64 {
                true => Ok(bytes),
                false => Err(format!(
                    "it should have {} bytes, but has {}",
                    buffer.byte_length,
                    bytes.len()
                )),
            });
            if let Err(message) = &bytes {
                self.error(report, "buffers", row, message);
            }
            buffers.push(bytes.ok());
        }
        self.buffers = buffers;
    }

    /// Bytes in all buffers together.
    pub(super) fn buffer_bytes(&self) -> u64 {
        let sizes = self.buffers.iter().flatten().map(|b| b.len() as u64);
        sizes.sum()
    }

    /// The bytes of a buffer view.
    pub(super) fn view(&self, row: usize) -> Result<&[u8], String> {
        let view = self.document.buffer_views.get(row);
        let view = view.ok_or_else(|| format!("there is no bufferViews[{row}]"))?;
        if view.extensions.meshopt.is_some() || view.extensions.khr_meshopt.is_some() {
            return Err(format!(
                "bufferViews[{row}] is compressed by meshopt, which is not read here"
            ));
        }
        let buffer = self.buffers.get(view.buffer);
        let buffer = buffer.ok_or_else(|| format!("there is no buffers[{}]", view.buffer))?;
        let buffer = buffer
            .as_deref()
            .ok_or_else(|| format!("buffers[{}] has no bytes", view.buffer))?;
        let start = usize::try_from(view.byte_offset).ok();
        let length = usize::try_from(view.byte_length).ok();
        let range = start.and_then(|start| Some(start..start.checked_add(length?)?));
        let bytes = range.and_then(|range| buffer.get(range));
        bytes.ok_or_else(|| {
            format!(
                "bufferViews[{row}] reaches beyond the {} bytes of buffers[{}]",
                buffer.len(),
                view.buffer
            )
        })
    }
}

/// Offsets of the rows of every list of a document.
fn row_offsets(json: &[u8]) -> BTreeMap<String, Vec<usize>> {
    let members: BTreeMap<Cow<str>, &RawValue> = serde_json::from_slice(json).unwrap_or_default();
    let offset = |row: &&RawValue| row.get().as_ptr() as usize - json.as_ptr() as usize;
    let lists = members.into_iter().filter_map(|(name, text)| {
        let rows: Vec<&RawValue> = serde_json::from_str(text.get()).ok()?;
        Some((name.into_owned(), rows.iter().map(offset).collect()))
    });
    lists.collect()
}

/// The bytes of a URI: data in the text itself, or a file of the scene file's folder, which is read
/// once.
fn fetch(
    uri: &str,
    asset_dir: &Folder,
    files: &mut HashMap<Found, Rc<Vec<u8>>>,
) -> Result<Rc<Vec<u8>>, String> {
    let budget = asset_dir.allowance();
    if let Some(data) = parse_data_uri(uri) {
        let what = || "for the buffers in the text".to_owned();
        budget.take(data.most_bytes(), what)?;
        return data.bytes().map(Rc::new);
    }
    let name = file_name(uri);
    let unread = |reason: String| format!("cannot read {}: {reason}", quoted(&name));
    let file = asset_dir.find(&name).map_err(unread)?;
    if let Some(bytes) = files.get(&file) {
        return Ok(Rc::clone(bytes));
    }
    let bytes = asset_dir.read(&file).map_err(unread)?;
    let size = bytes.len() as u64;
    budget.take(size, || format!("to read {}", quoted(&name)))?;
    // No copy: the vector itself is shared.
    let bytes = Rc::new(bytes);
    files.insert(file, Rc::clone(&bytes));
    Ok(bytes)
}

/// The data of a `data:` URI.
pub(super) struct DataUri<'a> {
    /// `None` if it is not base64.
    text: Option<&'a str>,
}

/// The data that a URI holds itself; `None` if it names something else.
pub(super) fn parse_data_uri(uri: &str) -> Option<DataUri<'_>> {
    let rest = uri.strip_prefix("data:")?;
    let parts = rest.split_once(',');
    let text = parts.filter(|(kind, _)| kind.ends_with(";base64"));
    Some(DataUri {
        text: text.map(|(_, data)| data),
    })
}

impl DataUri<'_> {
    /// Upper bound on the bytes that it decodes to.
    pub(super) fn most_bytes(&self) -> u64 {
        self.text.map_or(0, |text| text.len() as u64)
    }

    /// Its bytes, or the reason why there are none.
    pub(super) fn bytes(&self) -> Result<Vec<u8>, String> {
        let text = self.text.ok_or("a data URI that is not base64")?;
        let decoded = BASE64.decode(text);
        decoded.map_err(|error| format!("its base64 text is broken: {error}"))
    }
}

/// A relative URI as a file name: %20 stands for a blank.
pub(super) fn file_name(uri: &str) -> String {
    let (mut bytes, mut rest) = (Vec::with_capacity(uri.len()), uri.as_bytes());
    while let [first, after @ ..] = rest {
        let escaped = (*first == b'%').then(|| after.get(..2)).flatten();
        let escaped = escaped.and_then(|hex| std::str::from_utf8(hex).ok());
        match escaped.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &after[2..];
            }
            None => {
                bytes.push(*first);
                rest = after;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Offset of a line and column (from 1, in bytes).
fn offset_of(json: &[u8], line: usize, column: usize) -> usize {
    let mut breaks = json.iter().enumerate().filter(|&(_, &byte)| byte == b'\n');
    let start = match line.checked_sub(2) {
        Some(nth) => breaks.nth(nth).map_or(json.len(), |(at, _)| at + 1),
        None => 0,
    };
    (start + column.saturating_sub(1)).min(json.len())
}

/// The parser's message without its own line and column.
fn plain(error: &serde_json::Error) -> String {
    let message = error.to_string();
    let end = message.rfind(" at line ").unwrap_or(message.len());
    message[..end].to_owned()
}
