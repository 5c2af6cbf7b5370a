//! A page as its tags, after checking that they are well formed: strict where browsers forgive.

use html5gum::{DefaultEmitter, Token, Tokenizer};
use std::collections::BTreeMap;

/// Elements without an end.
const VOID: [&str; 3] = ["meta", "link", "img"];

/// An element's start.
pub struct Tag {
    pub name: String,
    pub attributes: BTreeMap<String, String>,
}

/// Parts of a page.
#[derive(Default)]
pub struct Parsed {
    pub tags: Vec<Tag>,
    /// All text, except for that of the style sheet.
    pub text: String,
    pub style: String,
}

/// Parses a page; panics if it is not well formed: parse errors, elements that are unclosed or
/// closed out of order, duplicate identifiers.
pub fn parse(page: &str) -> Parsed {
    let mut parsed = Parsed::default();
    let mut open: Vec<String> = Vec::new();
    let mut emitter = DefaultEmitter::default();
    emitter.naively_switch_states(true);
    for token in Tokenizer::new_with_emitter(page, emitter) {
        match token.expect("a page in memory can be read") {
            Token::StartTag(tag) => {
                let name = text(&tag.name);
                if !tag.self_closing && !VOID.contains(&name.as_str()) {
                    open.push(name.clone());
                }
                let attributes = tag.attributes.iter();
                let attributes = attributes.map(|(key, value)| (text(key), text(value)));
                parsed.tags.push(Tag {
                    name,
                    attributes: attributes.collect(),
                });
            }
            Token::EndTag(tag) => {
                assert_eq!(open.pop(), Some(text(&tag.name)), "after {}", parsed.tail());
            }
            Token::String(string) if open.last().is_some_and(|name| name == "style") => {
                parsed.style.push_str(&text(&string));
            }
            Token::String(string) => parsed.text.push_str(&text(&string)),
            Token::Error(error) => panic!("{error:?} after {}", parsed.tail()),
            Token::Comment(_) | Token::Doctype(_) => {}
        }
    }
    assert!(open.is_empty(), "never closed: {open:?}");
    let mut ids: Vec<&str> = parsed.values("id").collect();
    let all = ids.len();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), all, "an identifier is given twice");
    parsed
}

impl Parsed {
    /// Elements with a name.
    pub fn named<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Tag> {
        self.tags.iter().filter(move |tag| tag.name == name)
    }

    /// Values of an attribute on any element.
    pub fn values<'a>(&'a self, attribute: &'a str) -> impl Iterator<Item = &'a str> {
        let tags = self.tags.iter();
        tags.filter_map(move |tag| tag.attributes.get(attribute))
            .map(String::as_str)
    }

    /// The last words, to locate an error.
    fn tail(&self) -> String {
        let start = self
            .text
            .char_indices()
            .rev()
            .nth(80)
            .map_or(0, |(start, _)| start);
        self.text[start..].to_owned()
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}
