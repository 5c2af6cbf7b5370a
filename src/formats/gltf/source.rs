//! The file as a source for the other modules: the document, its buffers' bytes, and the spans of
//! its rows in the text.

use super::container::{Container, ContainerFault};
use super::document::{GltfDocument, GltfName};
use super::{lenient_json, version};
use crate::diagnostics::{DiagnosticSink, Span, quoted, quoted_file};
use crate::folder::{Folder, Found};
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use serde_json::value::RawValue;
use std::cell::{OnceCell, RefCell};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::rc::Rc;

/// The file.
pub(super) struct GltfSource<'a> {
    json: &'a [u8],
    json_offset: usize,
    pub(super) document: GltfDocument,
    /// The first index of -1 that stands for none, for a warning.
    pub(super) minus_one: Option<ContainerFault>,
    buffers: Vec<Option<BufferBytes<'a>>>,
    /// Offsets of the rows of each list in `json`, found when a message first needs one.
    rows: OnceCell<Vec<(String, Vec<usize>)>>,
    /// Accessors whose sparse indices have been checked.
    checked: RefCell<HashSet<usize>>,
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
        // Chunks are padded with spaces, by some writers with zeros.
        let padding = |byte: &u8| byte.is_ascii_whitespace() || *byte == 0;
        let json = &bytes[parts.json.clone()];
        let end = json.iter().rposition(|byte| !padding(byte));
        let mut json = &json[..end.map_or(0, |last| last + 1)];
        if let Some(rest) = json.strip_prefix("\u{feff}".as_bytes()) {
            (json, json_offset) = (rest, json_offset + 3);
        }
        if json.is_empty() {
            return Err((Span::START, "the file is empty".into()));
        }
        version::check(json).map_err(|message| (Span::START, message))?;
        let span = |offset: usize| Span::at(json_offset + offset);
        let (document, minus_one) =
            lenient_json::read(json).map_err(|(offset, message)| (span(offset), message))?;
        Ok(GltfSource {
            json,
            json_offset,
            document,
            minus_one: minus_one.map(|(offset, message)| (span(offset), message)),
            buffers: Vec::new(),
            rows: OnceCell::new(),
            checked: RefCell::default(),
        })
    }

    /// Returns true at the first call for an accessor.
    pub(super) fn is_first_check(&self, accessor: usize) -> bool {
        self.checked.borrow_mut().insert(accessor)
    }

    /// Span of a row of one of the document's lists. The first call parses the text again, so it is
    /// for messages only.
    pub(super) fn span_of(&self, list: &str, row: usize) -> Span {
        let rows = self.rows.get_or_init(|| row_offsets(self.json));
        let offsets = rows.iter().find(|(name, _)| name == list);
        match offsets.and_then(|(_, offsets)| offsets.get(row)) {
            Some(offset) => Span::new(self.json_offset + offset, 1),
            None => Span::START,
        }
    }

    /// A row of one of the document's lists as messages call it, with its name.
    fn label(&self, list: &str, row: usize) -> String {
        let all = &self.document;
        let name = match list {
            "nodes" => all.nodes.get(row).map(|node| &node.name),
            "meshes" => all.meshes.get(row).map(|mesh| &mesh.name),
            "materials" => all.materials.get(row).map(|material| &material.name),
            _ => None,
        };
        match name.map(GltfName::text) {
            Some(name) if !name.is_empty() => format!("{list}[{row}] {}", quoted(&name)),
            _ => format!("{list}[{row}]"),
        }
    }

    /// Adds an error about a row.
    pub(super) fn error(&self, report: &mut DiagnosticSink, list: &str, row: usize, message: &str) {
        if !report.is_full() {
            let label = self.label(list, row);
            report.error(self.span_of(list, row), format!("{label}: {message}"));
        }
    }

    /// Adds a warning about a row.
    pub(super) fn warning(
        &self,
        report: &mut DiagnosticSink,
        list: &str,
        row: usize,
        message: &str,
    ) {
        let label = self.label(list, row);
        report.warning(self.span_of(list, row), format!("{label}: {message}"));
    }

    /// Reads every buffer: from the file's own chunk, from the text, or from a file next to it.
    /// Notes the files of all images.
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
                // No error yet; uses of the buffer report it. A placeholder for compressed data has
                // no bytes of its own.
                (None, _) => {
                    buffers.push(None);
                    continue;
                }
            };
            match &bytes {
                // A warning only: the views that lie within the bytes can be read. Each use of
                // another one reports an error.
                Ok(bytes) if (bytes.len() as u64) < buffer.byte_length => {
                    let message = format!(
                        "it should have {} bytes, but has {}",
                        buffer.byte_length,
                        bytes.len()
                    );
                    self.warning(report, "buffers", row, &message);
                }
                Ok(_) => {}
                Err(message) => self.error(report, "buffers", row, message),
            }
            buffers.push(bytes.ok());
        }
        self.buffers = buffers;
        let images = self
            .document
            .images
            .iter()
            .filter_map(|image| image.uri.as_deref());
        for uri in images.filter(|uri| parse_data_uri(uri).is_none()) {
            asset_dir.note(uri);
            asset_dir.note(&String::from_utf8_lossy(&percent_decoded(uri)));
        }
    }

    /// Bytes in all buffers together.
    pub(super) fn buffer_bytes(&self) -> u64 {
        let sizes = self.buffers.iter().flatten().map(|b| b.len() as u64);
        sizes.sum()
    }

    /// Bytes of the document.
    pub(super) fn document_bytes(&self) -> u64 {
        self.json.len() as u64
    }

    /// The bytes of a buffer view.
    pub(super) fn view(&self, row: usize) -> Result<&[u8], String> {
        let view = self.document.buffer_views.get(row);
        let view = view.ok_or_else(|| format!("there is no bufferViews[{row}]"))?;
        let buffer = self.buffers.get(view.buffer);
        let buffer = buffer.ok_or_else(|| format!("there is no buffers[{}]", view.buffer))?;
        // A buffer of compressed data may be accompanied by the same data, uncompressed.
        let compressed = view.extensions.meshopt.is_some() || view.extensions.khr_meshopt.is_some();
        let buffer = buffer.as_deref().ok_or_else(|| {
            if compressed {
                format!("bufferViews[{row}] is compressed by meshopt, which is not read here")
            } else {
                format!("buffers[{}] has no bytes", view.buffer)
            }
        })?;
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
fn row_offsets(json: &[u8]) -> Vec<(String, Vec<usize>)> {
    let members: BTreeMap<String, &RawValue> = serde_json::from_slice(json).unwrap_or_default();
    let offset = |row: &&RawValue| row.get().as_ptr() as usize - json.as_ptr() as usize;
    let lists = members.into_iter().filter_map(|(name, text)| {
        let rows: Vec<&RawValue> = serde_json::from_slice(text.get().as_bytes()).ok()?;
        Some((name, rows.iter().map(offset).collect()))
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
    let memory = asset_dir.memory();
    if let Some(data) = parse_data_uri(uri) {
        memory.take(data.most_bytes(), "for the buffers in the text")?;
        return data.bytes().map(Rc::new);
    }
    let name = file_name(uri, asset_dir);
    let unread = |reason: String| format!("cannot read {}: {reason}", quoted_file(&name));
    let file = asset_dir.find(&name).map_err(unread)?;
    if let Some(bytes) = files.get(&file) {
        return Ok(Rc::clone(bytes));
    }
    let bytes = asset_dir.read(&file).map_err(unread)?;
    let name = quoted_file(&name);
    memory.take(bytes.len() as u64, format_args!("to read {name}"))?;
    // No copy: the vector itself is shared.
    let bytes = Rc::new(bytes);
    files.insert(file, Rc::clone(&bytes));
    Ok(bytes)
}

/// The data of a `data:` URI.
pub(super) struct DataUri<'a> {
    text: &'a str,
    is_base64: bool,
}

/// The data that a URI holds itself, of whatever media type; `None` if it names something else.
pub(super) fn parse_data_uri(uri: &str) -> Option<DataUri<'_>> {
    const SCHEME: &str = "data:";
    let scheme = uri.get(..SCHEME.len())?;
    if !scheme.eq_ignore_ascii_case(SCHEME) {
        return None;
    }
    let (kind, text) = uri[SCHEME.len()..].split_once(',').unwrap_or_default();
    let last = kind.rsplit(';').next().unwrap_or_default();
    Some(DataUri {
        text,
        is_base64: last.trim().eq_ignore_ascii_case("base64"),
    })
}

impl DataUri<'_> {
    /// Upper bound on the bytes that it decodes to.
    pub(super) fn most_bytes(&self) -> u64 {
        self.text.len() as u64
    }

    /// Its bytes, or the reason why there are none.
    pub(super) fn bytes(&self) -> Result<Vec<u8>, String> {
        if !self.is_base64 {
            return Ok(percent_decoded(self.text));
        }
        BASE64.decode(self.text).or_else(|error| {
            // As in other URIs: escaped, broken into lines, or with the two characters that need no
            // escape.
            let mut text = percent_decoded(self.text);
            text.retain(|byte| !byte.is_ascii_whitespace());
            for byte in &mut text {
                *byte = match *byte {
                    b'-' => b'+',
                    b'_' => b'/',
                    other => other,
                };
            }
            let decoded = BASE64.decode(&text);
            decoded.map_err(|_| format!("its base64 text is broken: {error}"))
        })
    }
}

/// A relative URI as a file name: %20 means a space, unless the file's own name contains it.
pub(super) fn file_name(uri: &str, asset_dir: &Folder) -> String {
    let name = String::from_utf8_lossy(&percent_decoded(uri)).into_owned();
    if name != uri && asset_dir.find(&name).is_err() && asset_dir.find(uri).is_ok() {
        uri.to_owned()
    } else {
        name
    }
}

/// Bytes of a text in which `%` begins a byte in hexadecimal.
fn percent_decoded(text: &str) -> Vec<u8> {
    percent_encoding::percent_decode_str(text).collect()
}
