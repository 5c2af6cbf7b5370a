//! Reader of the document, also if it bends the format's rules as some programs do: integers may be
//! written as `5126.0` or `1e0`, and an absent member as `null` or an index of -1. A document that
//! is refused as it is gets repaired, and read again.

use super::document::GltfDocument;
use crate::diagnostics::{quoted, quoted_file};
use serde::{Serialize, Serializer};
use serde_json::value::RawValue;
use serde_json::{Deserializer, Error};
use serde_path_to_error::{Path, Segment};
use std::collections::BTreeMap;

/// An offset in the document, and a message.
pub(super) type DocumentFault = (usize, String);

/// Reads the document. The second result is the position of an index of -1 that means none, if
/// there is one.
pub(super) fn read(json: &[u8]) -> Result<(GltfDocument, Option<DocumentFault>), DocumentFault> {
    let mut reader = Deserializer::from_slice(json);
    let strict = serde_path_to_error::deserialize(&mut reader);
    // Lists would pass as structures without names.
    let is_object = json.trim_ascii_start().starts_with(b"{");
    match strict {
        Ok(document) if is_object && reader.end().is_ok() => return Ok((document, None)),
        // Repaired documents have no second member of a name.
        Err(error) if plain(error.inner()).starts_with("duplicate field") => {
            return Err(located(json, error.inner()));
        }
        _ => {}
    }
    let raw: &RawValue = serde_json::from_slice(json).map_err(|error| located(json, &error))?;
    let offset = |value: &str| value.as_ptr() as usize - json.as_ptr() as usize;
    if !is_object {
        let json_text = quoted(raw.get());
        let message = format!("the document: expected an object, not {json_text}");
        return Err((offset(raw.get()), message));
    }
    let value = |error: &PathError| value_at(raw.get(), error.path());
    let fault = |error: &PathError, message: &str| {
        let message = format!("{}: {message}", shown(error.path()));
        (offset(value(error)), message)
    };
    let mut document = read_repaired(raw, false);
    let mut minus_one = None;
    if let Err(error) = &document
        && is_minus_one(value(error))
    {
        minus_one = Some(fault(error, "it is -1, which is read as none"));
        document = read_repaired(raw, true);
    }
    match document {
        Ok(document) => Ok((document, minus_one)),
        Err(error) => Err(fault(&error, &misfit(error.inner(), value(&error)))),
    }
}

type PathError = serde_path_to_error::Error<Error>;

/// Reads a document after repairs, by way of text, so that the compiler makes one reader only.
fn read_repaired(raw: &RawValue, minus_one_is_none: bool) -> Result<GltfDocument, PathError> {
    let repaired = Repaired::new(raw, "", minus_one_is_none, 0);
    let text = serde_json::to_vec(&repaired).unwrap_or_default();
    serde_path_to_error::deserialize(&mut Deserializer::from_slice(&text))
}

/// Members that are indices and may be left out.
const OPTIONAL_INDICES: [&str; 13] = [
    "bufferView",
    "camera",
    "index",
    "indices",
    "inverseBindMatrices",
    "light",
    "material",
    "mesh",
    "sampler",
    "scene",
    "skeleton",
    "skin",
    "source",
];

/// Members that hold indices by names of attributes, or lists of such objects.
const ATTRIBUTES: [&str; 2] = ["attributes", "targets"];

/// Largest integer that a number with a fraction or an exponent stands for without doubt.
const MAX_EXACT: f64 = 9_007_199_254_740_992.0;

/// Most lists and objects around a value that is repaired.
const MAX_DEPTH: usize = 100;

/// A value that keeps the format's rules. Members are those that are there.
#[derive(Serialize)]
#[serde(untagged)]
enum Repaired<'a> {
    /// Members in the order of the file, so that its first fault is found first.
    #[serde(serialize_with = "as_object")]
    Object(Vec<(String, Repaired<'a>)>),
    List(Vec<Repaired<'a>>),
    Integer(u64),
    Other(&'a RawValue),
}

impl<'a> Repaired<'a> {
    /// Repairs a value that belongs to the member `name`. Indices of -1 are omitted if they stand
    /// for none.
    fn new(raw: &'a RawValue, name: &str, minus_one_is_none: bool, depth: usize) -> Repaired<'a> {
        let text = raw.get();
        if depth > MAX_DEPTH {
            return Repaired::Other(raw);
        }
        let inner = |raw, name: &str| Repaired::new(raw, name, minus_one_is_none, depth + 1);
        if let Some(mut members) = members(text) {
            let holds_indices = ATTRIBUTES.contains(&name);
            members.retain(|name, member| {
                let is_index = holds_indices || OPTIONAL_INDICES.contains(&name.as_str());
                let is_none = minus_one_is_none && is_index && is_minus_one(member.get());
                member.get() != "null" && !is_none
            });
            let mut members: Vec<_> = members.into_iter().collect();
            members.sort_by_key(|(_, member)| member.get().as_ptr());
            let members = members.into_iter().map(|(name, member)| {
                // The sign of a zero matters in vectors only.
                let is_zero = member.get().parse() == Ok(0.0);
                let member = if is_zero { Repaired::Integer(0) } else { inner(member, &name) };
                (name, member)
            });
            Repaired::Object(members.collect())
        } else if let Some(rows) = rows(text) {
            Repaired::List(rows.into_iter().map(|row| inner(row, name)).collect())
        } else {
            let number = text.parse().ok().filter(|number: &f64| {
                number.is_sign_positive() && number.fract() == 0.0 && *number < MAX_EXACT
            });
            number.map_or(Repaired::Other(raw), |number| {
                Repaired::Integer(number as u64)
            })
        }
    }
}

fn as_object<S: Serializer>(
    members: &[(String, Repaired)],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_map(members.iter().map(|(name, member)| (name, member)))
}

fn members(text: &str) -> Option<BTreeMap<String, &RawValue>> {
    serde_json::from_slice(text.as_bytes()).ok()
}

fn rows(text: &str) -> Option<Vec<&RawValue>> {
    serde_json::from_slice(text.as_bytes()).ok()
}

fn is_minus_one(text: &str) -> bool {
    text.parse() == Ok(-1.0)
}

/// A path for messages. Names come from the file, with any length and any characters.
fn shown(path: &Path) -> String {
    match quoted_file(&path.to_string()).trim_matches('`') {
        "." => "the document".to_owned(),
        path => path.to_owned(),
    }
}

/// The text of the value at a path, or of the innermost one around it.
fn value_at<'a>(text: &'a str, path: &Path) -> &'a str {
    path.iter().fold(text, |text, segment| {
        let child = match segment {
            Segment::Seq { index } => rows(text).and_then(|rows| rows.get(*index).copied()),
            Segment::Map { key } => members(text).and_then(|members| members.get(key).copied()),
            _ => None,
        };
        child.map_or(text, RawValue::get)
    })
}

/// Message for a value that does not fit.
fn misfit(error: &Error, value: &str) -> String {
    let message = plain(error);
    let expected = match message.rsplit_once(", expected ") {
        Some((_, "u32")) => "a whole number from 0 to 2^32 - 1",
        Some((_, "usize" | "u64")) => "a whole number from 0 on",
        Some((_, "f64")) => "a number",
        Some((_, "a sequence")) => "a list",
        Some((_, "a string")) => "a text",
        Some((_, "a boolean")) => "true or false",
        Some((_, kind)) if kind.starts_with("an array") => &kind.replace("an array", "a list"),
        // A map, or a structure by its name.
        Some(_) => "an object",
        None if message == MORE => "a shorter list",
        None => return message,
    };
    // The text of an object or a list over several lines would not fit a message.
    let actual = match value.as_bytes().first() {
        Some(b'{') if value.contains('\n') => "an object".to_owned(),
        Some(b'[') if value.contains('\n') => "a list".to_owned(),
        _ => quoted(value),
    };
    format!("expected {expected}, not {actual}")
}

/// The library's message for text after the end of the document, or rows after the last one.
const MORE: &str = "trailing characters";

/// The offset of a fault of syntax, and a message.
fn located(json: &[u8], error: &Error) -> DocumentFault {
    let lines = json.split_inclusive(|byte| *byte == b'\n');
    let line_start: usize = lines
        .take(error.line().saturating_sub(1))
        .map(<[u8]>::len)
        .sum();
    let offset = (line_start + error.column()).saturating_sub(1);
    let message = match plain(error).as_str() {
        "expected ident" | "expected value" => "expected a value".to_owned(),
        "key must be a string" => "expected a name in double quotes".to_owned(),
        "invalid unicode code point" => "the document is not UTF-8".to_owned(),
        MORE => "there is more text after the end of the document".to_owned(),
        message => message.replace("EOF while parsing", "the document ends within"),
    };
    (offset.min(json.len()), message)
}

/// The library's message without its line and column.
fn plain(error: &Error) -> String {
    let message = error.to_string();
    let end = message.rfind(" at line ");
    message[..end.unwrap_or(message.len())].to_owned()
}
