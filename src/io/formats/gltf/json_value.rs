//! Reader of documents that bend the format's rules, as some programs write them: it takes whole
//! numbers written as `5126.0` or `1e0`, and `null` or an index of -1 for a member that is absent.
//! Its messages name the row and what belongs there.

use super::syntax;
use crate::formats::diagnostics::quoted;
use serde::Deserialize;
use serde::de::value::BorrowedStrDeserializer;
use serde::de::{
    DeserializeSeed, Deserializer, Error, IntoDeserializer, MapAccess, SeqAccess, Visitor,
};
use serde_json::value::RawValue;
use std::borrow::Cow;
use std::cell::RefCell;
use std::fmt;

/// An offset in the document, and a message.
pub(super) type DocumentFault = (usize, String);

/// Reads a structure from the text of a document. The second result says where an index of -1
/// stands for none, if there is one.
pub(super) fn read<'a, T: Deserialize<'a>>(
    json: &'a [u8],
) -> Result<(T, Option<DocumentFault>), DocumentFault> {
    let text = serde_json::from_slice::<&RawValue>(json);
    let text = text.map_err(|error| syntax::located(json, &error))?;
    let progress = Progress {
        start: json.as_ptr() as usize,
        path: RefCell::default(),
        fault: RefCell::default(),
        minus_one: RefCell::default(),
    };
    let value = JsonValue {
        text: text.get(),
        progress: &progress,
    };
    match T::deserialize(value) {
        Ok(read) => Ok((read, progress.minus_one.take())),
        Err(error) => {
            let fault = progress.fault.take();
            Err(fault.unwrap_or_else(|| (0, syntax::plain(&error))))
        }
    }
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

/// State while a document is read.
struct Progress<'a> {
    /// Address of the document's first byte.
    start: usize,
    /// Steps from the document to the value that is being read.
    path: RefCell<Vec<PathStep<'a>>>,
    /// The first fault. The library's own errors know neither the row nor its offset.
    fault: RefCell<Option<DocumentFault>>,
    /// The first index of -1.
    minus_one: RefCell<Option<DocumentFault>>,
}

enum PathStep<'a> {
    Name(Cow<'a, str>),
    Row(usize),
}

impl Progress<'_> {
    fn offset(&self, text: &str) -> usize {
        text.as_ptr() as usize - self.start
    }

    /// Keeps a fault, unless there is one already, and returns an error that stands for it.
    fn fail(&self, text: &str, message: &str) -> serde_json::Error {
        let fault = || (self.offset(text), self.located(message));
        self.fault.borrow_mut().get_or_insert_with(fault);
        serde_json::Error::custom(message)
    }

    /// A message with the path before it, as in `nodes[3].mesh: …`.
    fn located(&self, message: &str) -> String {
        let path = self.path.borrow();
        let mut name = String::new();
        for step in path.iter() {
            match step {
                PathStep::Name(member) if name.is_empty() => name.push_str(member),
                PathStep::Name(member) => name.extend([".", member]),
                PathStep::Row(row) => name.push_str(&format!("[{row}]")),
            }
        }
        match name.is_empty() {
            true => format!("the document: {message}"),
            false => {
                // Names are the file's, of any length and with any letters.
                let shown = quoted(&name);
                let shown = shown.strip_prefix('`').and_then(|s| s.strip_suffix('`'));
                format!("{}: {message}", shown.unwrap_or(&name))
            }
        }
    }

    fn is_within_attributes(&self) -> bool {
        let path = self.path.borrow();
        let last = path.iter().rev().find_map(|step| match step {
            PathStep::Name(name) => Some(name.as_ref()),
            PathStep::Row(_) => None,
        });
        last.is_some_and(|name| ATTRIBUTES.contains(&name))
    }
}

/// A value by its text.
#[derive(Clone, Copy)]
struct JsonValue<'a, 'p> {
    text: &'a str,
    progress: &'p Progress<'a>,
}

/// Kind of a value, by its first byte.
#[derive(Clone, Copy, PartialEq, Eq)]
enum JsonKind {
    Object,
    List,
    Text,
    Number,
    Bool,
    Null,
}

impl JsonKind {
    fn of(text: &str) -> JsonKind {
        match text.as_bytes().first() {
            Some(b'{') => JsonKind::Object,
            Some(b'[') => JsonKind::List,
            Some(b'"') => JsonKind::Text,
            Some(b't' | b'f') => JsonKind::Bool,
            Some(b'n') | None => JsonKind::Null,
            Some(_) => JsonKind::Number,
        }
    }
}

impl fmt::Display for JsonKind {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            JsonKind::Object => "an object",
            JsonKind::List => "a list",
            JsonKind::Text => "a text",
            JsonKind::Number => "a number",
            JsonKind::Bool => "true or false",
            JsonKind::Null => "null",
        })
    }
}

/// Largest whole number that a number with a fraction or an exponent stands for without doubt.
const MAX_EXACT: f64 = 9_007_199_254_740_992.0;

impl<'a> JsonValue<'a, '_> {
    fn fail(self, message: &str) -> serde_json::Error {
        self.progress.fail(self.text, message)
    }

    /// Fails unless the value is of a kind, which `wanted` names.
    fn expect(self, kind: JsonKind, wanted: &str) -> Result<(), serde_json::Error> {
        let found = JsonKind::of(self.text);
        match found == kind {
            true => Ok(()),
            false => Err(self.fail(&format!("it should be {wanted}, not {found}"))),
        }
    }

    /// Puts an error of the library about this value into words, unless that is done already.
    fn explained<T>(self, read: Result<T, serde_json::Error>) -> Result<T, serde_json::Error> {
        read.map_err(|error| self.fail(&syntax::plain(&error)))
    }

    fn whole_number(self, most: u64) -> Result<u64, serde_json::Error> {
        self.expect(JsonKind::Number, "a whole number")?;
        if let Ok(number) = self.text.parse::<u64>()
            && number <= most
        {
            return Ok(number);
        }
        let number = self.text.parse::<f64>().unwrap_or(f64::NAN);
        let is_whole = number >= 0.0 && number.fract() == 0.0 && number < MAX_EXACT;
        match is_whole && number as u64 <= most {
            true => Ok(number as u64),
            false if number > most as f64 => Err(self.fail("the number is too large")),
            false => {
                let shown = quoted(self.text);
                Err(self.fail(&format!(
                    "it should be a whole number from 0 on, not {shown}"
                )))
            }
        }
    }

    fn list<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, serde_json::Error> {
        let progress = self.progress;
        let mut inner = serde_json::Deserializer::from_str(self.text);
        inner.deserialize_seq(TolerantVisitor { visitor, progress })
    }

    fn object<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, serde_json::Error> {
        self.expect(JsonKind::Object, "an object")?;
        let progress = self.progress;
        let mut inner = serde_json::Deserializer::from_str(self.text);
        let read = inner.deserialize_map(TolerantVisitor { visitor, progress });
        self.explained(read)
    }
}

impl<'a> Deserializer<'a> for JsonValue<'a, '_> {
    type Error = serde_json::Error;

    /// Reads a value of unknown structure, such as an extension that is kept for its name.
    fn deserialize_any<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, Self::Error> {
        let mut inner = serde_json::Deserializer::from_str(self.text);
        self.explained(inner.deserialize_any(visitor))
    }

    fn deserialize_ignored_any<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, Self::Error> {
        visitor.visit_unit()
    }

    fn deserialize_option<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, Self::Error> {
        match JsonKind::of(self.text) {
            JsonKind::Null => visitor.visit_none(),
            _ => visitor.visit_some(self),
        }
    }

    fn deserialize_bool<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, Self::Error> {
        self.expect(JsonKind::Bool, "true or false")?;
        visitor.visit_bool(self.text == "true")
    }

    fn deserialize_u32<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, Self::Error> {
        let number = self.whole_number(u64::from(u32::MAX))?;
        visitor.visit_u64(number)
    }

    fn deserialize_u64<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, Self::Error> {
        let number = self.whole_number(u64::MAX)?;
        visitor.visit_u64(number)
    }

    fn deserialize_f64<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, Self::Error> {
        self.expect(JsonKind::Number, "a number")?;
        let mut inner = serde_json::Deserializer::from_str(self.text);
        self.explained(inner.deserialize_f64(visitor))
    }

    fn deserialize_str<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, Self::Error> {
        self.expect(JsonKind::Text, "a text")?;
        let mut inner = serde_json::Deserializer::from_str(self.text);
        self.explained(inner.deserialize_str(visitor))
    }

    fn deserialize_string<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, Self::Error> {
        self.deserialize_str(visitor)
    }

    fn deserialize_seq<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, Self::Error> {
        self.expect(JsonKind::List, "a list")?;
        let read = self.list(visitor);
        self.explained(read)
    }

    fn deserialize_tuple<V: Visitor<'a>>(
        self,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Self::Error> {
        let wanted = format!("a list of {length} numbers");
        self.expect(JsonKind::List, &wanted)?;
        let read = self.list(visitor);
        read.map_err(|_| self.fail(&format!("it should be {wanted}")))
    }

    fn deserialize_map<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, Self::Error> {
        self.object(visitor)
    }

    fn deserialize_struct<V: Visitor<'a>>(
        self,
        _name: &'static str,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Self::Error> {
        self.object(visitor)
    }

    serde::forward_to_deserialize_any! {
        <V: Visitor<'a>>
        i8 i16 i32 i64 i128 u8 u16 u128 f32 char bytes byte_buf unit unit_struct newtype_struct
        tuple_struct enum identifier
    }
}

/// Hands a visitor each value as a [`JsonValue`].
struct TolerantVisitor<'a, 'p, V> {
    visitor: V,
    progress: &'p Progress<'a>,
}

impl<'a, V: Visitor<'a>> Visitor<'a> for TolerantVisitor<'a, '_, V> {
    type Value = V::Value;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.visitor.expecting(f)
    }

    fn visit_seq<A: SeqAccess<'a>>(self, rows: A) -> Result<V::Value, A::Error> {
        self.visitor.visit_seq(JsonRows {
            rows,
            next: 0,
            progress: self.progress,
        })
    }

    fn visit_map<A: MapAccess<'a>>(self, members: A) -> Result<V::Value, A::Error> {
        self.visitor.visit_map(JsonMembers {
            members,
            value: None,
            progress: self.progress,
        })
    }
}

struct JsonRows<'a, 'p, A> {
    rows: A,
    next: usize,
    progress: &'p Progress<'a>,
}

impl<'a, A: SeqAccess<'a>> SeqAccess<'a> for JsonRows<'a, '_, A> {
    type Error = A::Error;

    fn next_element_seed<S: DeserializeSeed<'a>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, A::Error> {
        let Some(row) = self.rows.next_element::<&'a RawValue>()? else {
            return Ok(None);
        };
        let step = PathStep::Row(self.next);
        self.next += 1;
        read_step(self.progress, step, row.get(), seed).map(Some)
    }
}

struct JsonMembers<'a, 'p, A> {
    members: A,
    /// The member whose name has been read.
    value: Option<(Cow<'a, str>, &'a str)>,
    progress: &'p Progress<'a>,
}

/// A name without a copy, if it has no escapes.
#[derive(Deserialize)]
struct MemberName<'a>(#[serde(borrow)] Cow<'a, str>);

impl<'a, A: MapAccess<'a>> JsonMembers<'a, '_, A> {
    /// Returns true if a value stands for an absent member: `null`, or an index of -1.
    fn is_absent(&self, name: &str, text: &str) -> bool {
        if text == "null" {
            return true;
        }
        let is_index = OPTIONAL_INDICES.contains(&name) || self.progress.is_within_attributes();
        if !is_index || text.parse::<f64>() != Ok(-1.0) {
            return false;
        }
        let progress = self.progress;
        let told = || {
            let message = format!("its {} is -1, which is read as none", quoted(name));
            (progress.offset(text), progress.located(&message))
        };
        progress.minus_one.borrow_mut().get_or_insert_with(told);
        true
    }
}

impl<'a, A: MapAccess<'a>> MapAccess<'a> for JsonMembers<'a, '_, A> {
    type Error = A::Error;

    fn next_key_seed<S: DeserializeSeed<'a>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, A::Error> {
        while let Some((name, value)) = self.members.next_entry::<MemberName<'a>, &'a RawValue>()? {
            if self.is_absent(&name.0, value.get()) {
                continue;
            }
            let read = match &name.0 {
                Cow::Borrowed(name) => seed.deserialize(BorrowedStrDeserializer::new(name)),
                Cow::Owned(name) => seed.deserialize(name.as_str().into_deserializer()),
            };
            self.value = Some((name.0, value.get()));
            return read.map(Some);
        }
        Ok(None)
    }

    fn next_value_seed<S: DeserializeSeed<'a>>(&mut self, seed: S) -> Result<S::Value, A::Error> {
        let Some((name, text)) = self.value.take() else {
            return Err(A::Error::custom("a value without a name"));
        };
        read_step(self.progress, PathStep::Name(name), text, seed)
    }
}

/// Reads a value one step further down.
fn read_step<'a, S: DeserializeSeed<'a>, E: Error>(
    progress: &Progress<'a>,
    step: PathStep<'a>,
    text: &'a str,
    seed: S,
) -> Result<S::Value, E> {
    progress.path.borrow_mut().push(step);
    let read = seed.deserialize(JsonValue { text, progress });
    // The error itself has been kept.
    let read = read.map_err(E::custom);
    progress.path.borrow_mut().pop();
    read
}
