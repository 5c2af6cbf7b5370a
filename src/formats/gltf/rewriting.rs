//! Reader of documents that bend the format's rules, as some programs write them: it accepts
//! integers written as `5126.0` or `1e0`, and `null` or an index of -1 for an absent member. The
//! text is rewritten according to the rules, and then read. Messages name the row and what is
//! expected there.

use super::syntax;
use crate::diagnostics::quoted_file;
use serde::de::DeserializeOwned;
use serde_json::value::RawValue;
use std::collections::BTreeMap;

/// An offset in the document, and a message.
pub(super) type DocumentFault = (usize, String);

/// Reads a structure from the text of a document. The second result is the position of an index of
/// -1 that means none, if there is one.
pub(super) fn read<T: DeserializeOwned>(
    json: &[u8],
) -> Result<(T, Option<DocumentFault>), DocumentFault> {
    let text = serde_json::from_slice::<&RawValue>(json);
    let text = text.map_err(|error| syntax::located(json, &error))?.get();
    let told = |value: &str, path: &str, message: &str| {
        let offset = value.as_ptr() as usize - json.as_ptr() as usize;
        (offset, format!("{path}: {message}"))
    };
    if !text.starts_with('{') {
        let message = syntax::wrong_kind("an object", text);
        return Err(told(text, DOCUMENT, &message));
    }
    let mut minus_one = None;
    let mut read = read_strictly(text, &rewritten(text, false));
    if let Err(fault) = &read
        && is_minus_one(fault.value)
    {
        let message = "it is -1, which is read as none";
        minus_one = Some(told(fault.value, &fault.path, message));
        read = read_strictly(text, &rewritten(text, true));
    }
    let read = read.map_err(|fault| told(fault.value, &fault.path, &fault.message));
    Ok((read?, minus_one))
}

/// Name of the document itself, where messages have a path.
const DOCUMENT: &str = "the document";

/// A fault of a value.
struct ValueFault<'a> {
    value: &'a str,
    path: String,
    message: String,
}

/// Reads a document that has been rewritten. Faults have the values of the text before that.
fn read_strictly<'a, T: DeserializeOwned>(
    text: &'a str,
    rewritten: &str,
) -> Result<T, ValueFault<'a>> {
    // From bytes, like documents that keep the rules, so that the reader is compiled once.
    serde_json::from_slice(rewritten.as_bytes()).map_err(|error| fault(text, rewritten, &error))
}

/// The value at which an error was found. The rewritten text is a single line, so that a column is
/// an offset.
fn fault<'a>(text: &'a str, rewritten: &str, error: &serde_json::Error) -> ValueFault<'a> {
    // The first row too many, or the name of a second member: the fault is that of the whole.
    let is_inside = syntax::is_inside_value(error);
    let mut path = path_to(rewritten, error.column().saturating_sub(is_inside.into()));
    if is_inside {
        path.pop();
    }
    let child = |value: &'a str, step: &String| {
        let mut all = children(value).into_iter();
        all.find(|(name, _)| name == step).map(|(_, child)| child)
    };
    let value = path.iter().try_fold(text, child).unwrap_or(text);
    // Names come from the file, with any length and any characters.
    let path = match path.concat().trim_start_matches('.') {
        "" => DOCUMENT.to_owned(),
        path => quoted_file(path).trim_matches('`').to_owned(),
    };
    let message = syntax::of_value(error, value);
    ValueFault {
        value,
        path,
        message,
    }
}

/// Steps to the value that begins or ends at an offset of JSON without blanks.
fn path_to(json: &str, offset: usize) -> Vec<String> {
    // The current step into each open list or object, and its number in a list.
    let mut path = Vec::new();
    let mut at = 0;
    while at < offset {
        let (token, rest) = json[at..].split_at(token_length(&json.as_bytes()[at..]));
        at += token.len();
        match (token, path.last_mut()) {
            ("{", _) => path.push((String::new(), None)),
            ("[", _) => path.push(("[0]".to_owned(), Some(0))),
            ("}" | "]", _) => _ = path.pop(),
            (",", Some((step, Some(row)))) => {
                *row += 1;
                *step = format!("[{row}]");
            }
            (_, Some((step, _))) if rest.starts_with(':') => {
                let name: String = serde_json::from_slice(token.as_bytes()).unwrap_or_default();
                *step = format!(".{name}");
            }
            _ => {}
        }
    }
    path.into_iter().map(|(step, _)| step).collect()
}

/// The rows of a list or the members of an object, each with its step in a path.
fn children(text: &str) -> Vec<(String, &str)> {
    if let Ok(rows) = serde_json::from_slice::<Vec<&RawValue>>(text.as_bytes()) {
        let rows = rows.iter().enumerate();
        return rows.map(|(k, row)| (format!("[{k}]"), row.get())).collect();
    }
    let members: BTreeMap<String, &RawValue> =
        serde_json::from_slice(text.as_bytes()).unwrap_or_default();
    let members = members.iter();
    members
        .map(|(name, member)| (format!(".{name}"), member.get()))
        .collect()
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

/// Members that are lists of indices.
const INDEX_LISTS: [&str; 3] = ["children", "joints", "nodes"];

/// Largest whole number that a number with a fraction or an exponent stands for without doubt.
const MAX_EXACT: f64 = 9_007_199_254_740_992.0;

/// JSON without faults of syntax, rewritten by the format's rules. Indices of -1 are omitted if
/// they stand for none.
fn rewritten(json: &str, minus_one_is_none: bool) -> String {
    let mut text = String::with_capacity(json.len());
    // The current or last member, the length of the text before it, and the members that contain
    // the open lists and objects.
    let (mut name, mut start, mut outer) = ("", 0, Vec::new());
    let mut rest = json.trim_ascii();
    while !rest.is_empty() {
        let (token, after) = rest.split_at(token_length(rest.as_bytes()));
        rest = after.trim_ascii_start();
        let is_member = text.ends_with(':');
        match token {
            // Written before the next item, unless that is omitted.
            "," => continue,
            ":" => {}
            "}" | "]" => {
                outer.pop();
            }
            "null" if is_member => {
                text.truncate(start);
                continue;
            }
            _ if is_member => {
                let is_index = OPTIONAL_INDICES.contains(&name)
                    || outer.last().is_some_and(|name| ATTRIBUTES.contains(name));
                if minus_one_is_none && is_index && is_minus_one(token) {
                    text.truncate(start);
                    continue;
                }
            }
            _ => {
                start = text.len();
                name = if rest.starts_with(':') {
                    token.trim_matches('"')
                } else {
                    outer.last().copied().unwrap_or_default()
                };
                if !text.is_empty() && !text.ends_with(['{', '[']) {
                    text.push(',');
                }
            }
        }
        if let "{" | "[" = token {
            outer.push(name);
        }
        // The sign of a zero may matter in a vector.
        let may_be_index = is_member || INDEX_LISTS.contains(&name) || !token.starts_with('-');
        match whole_number(token).filter(|_| may_be_index) {
            Some(number) => text.push_str(&number.to_string()),
            None => text.push_str(token),
        }
    }
    text
}

/// Length of the first token of JSON without faults.
fn token_length(json: &[u8]) -> usize {
    let length = match json[0] {
        b'"' => {
            let mut end = 1;
            // Data URIs turn whole buffers into strings.
            while let Some(next) = memchr::memchr2(b'"', b'\\', &json[end.min(json.len())..]) {
                end += next + 1;
                if json[end - 1] == b'"' {
                    break;
                }
                end += 1;
            }
            end
        }
        b'{' | b'}' | b'[' | b']' | b',' | b':' => 1,
        _ => {
            let in_token = |byte: &u8| byte.is_ascii_alphanumeric() || b"+-.".contains(byte);
            json.iter().take_while(|byte| in_token(byte)).count()
        }
    };
    length.clamp(1, json.len())
}

fn is_minus_one(token: &str) -> bool {
    token.starts_with('-') && token.parse() == Ok(-1.0)
}

/// The whole number that a token with a fraction or an exponent stands for.
fn whole_number(token: &str) -> Option<u64> {
    if !token.contains(['.', 'e', 'E', '-']) {
        return None;
    }
    let number: f64 = token.parse().ok()?;
    let is_whole = number.fract() == 0.0 && (0.0..MAX_EXACT).contains(&number);
    is_whole.then_some(number as u64)
}
