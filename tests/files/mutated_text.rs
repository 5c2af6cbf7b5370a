//! Files with changed tokens or bytes, and invariants of every answer about them.

use phalanx::formats::{Diagnostic, Loaded, MAX_DIAGNOSTICS};
use proptest::prelude::*;
use proptest::sample::Index;

/// Tokens that have broken readers before, for any format.
const SPICE: [&str; 19] = [
    "nan",
    "inf",
    "-1",
    "0",
    "1e39",
    "1e-46",
    "3.4e38",
    "-3.4e38",
    "1e20",
    "1e-20",
    "99999999999999999999",
    "4294967296",
    "1.5",
    "#",
    "\n",
    "\r",
    "\u{feff}",
    "\0",
    "é",
];

/// Asserts that a scene is valid, that diagnostics are in file order, and that each passes `check`.
pub fn check_answer(answer: Result<Loaded, Vec<Diagnostic>>, check: impl Fn(&Diagnostic)) {
    let diagnostics = match answer {
        Ok(loaded) => {
            loaded.scene.validate().expect("what loads is valid");
            loaded.warnings
        }
        Err(errors) => {
            assert!(!errors.is_empty(), "errors are told");
            errors
        }
    };
    assert!(diagnostics.len() <= MAX_DIAGNOSTICS);
    assert!(
        diagnostics.is_sorted_by_key(|d| d.offset),
        "{diagnostics:?}"
    );
    diagnostics.iter().for_each(check);
}

/// [`check_answer`] for a text: each diagnostic's span is within it, on its line.
pub fn check_text_answer(text: &str, answer: Result<Loaded, Vec<Diagnostic>>) {
    check_answer(answer, |d| {
        let span = text.get(d.offset..d.offset + d.length);
        assert!(span.is_some(), "{d:?} lies outside of {text:?}");
        let line = text.split('\n').nth(d.line - 1).expect("the line exists");
        assert!(
            d.column > 0 && d.column <= line.chars().count() + 1,
            "{d:?}"
        );
        let before = &text[..d.offset];
        assert_eq!(d.line, 1 + before.matches('\n').count(), "{d:?}");
    });
}

/// Mutation of one token.
#[derive(Clone, Debug)]
enum TokenMutation {
    Delete,
    Duplicate,
    Replace(String),
}

/// Mutations of one token; `words` are the format's own.
fn mutation(words: &'static [&'static str]) -> impl Strategy<Value = TokenMutation> {
    let spice: Vec<&str> = SPICE.iter().chain(words).copied().collect();
    let spice = prop::sample::select(spice).prop_map(String::from);
    prop_oneof![
        1 => Just(TokenMutation::Delete),
        1 => Just(TokenMutation::Duplicate),
        4 => spice.prop_map(TokenMutation::Replace),
        1 => any::<f32>().prop_map(|x| TokenMutation::Replace(x.to_string())),
        1 => ".{0,8}".prop_map(TokenMutation::Replace),
    ]
}

/// Applies the mutation to token `offset` (modulo their number); white space stays as it is.
fn mutated(text: &str, offset: usize, mutation: &TokenMutation) -> String {
    let mut tokens: Vec<String> = text
        .split_inclusive([' ', '\n'])
        .map(String::from)
        .collect();
    if tokens.is_empty() {
        return String::new();
    }
    let offset = offset % tokens.len();
    match mutation {
        TokenMutation::Delete => drop(tokens.remove(offset)),
        TokenMutation::Duplicate => tokens.insert(offset, tokens[offset].clone()),
        TokenMutation::Replace(token) => {
            let length = tokens[offset].trim_end().len();
            tokens[offset].replace_range(..length, token);
        }
    }
    tokens.concat()
}

/// The valid text with one to seven mutations, truncated one time in five.
pub fn mutants(
    valid: &'static str,
    words: &'static [&'static str],
) -> impl Strategy<Value = String> {
    let mutations = prop::collection::vec((any::<usize>(), mutation(words)), 1..8);
    let cut = prop::option::weighted(0.2, any::<Index>());
    (mutations, cut).prop_map(move |(mutations, cut)| {
        let mut text = String::from(valid);
        for (position, mutation) in &mutations {
            text = mutated(&text, *position, mutation);
        }
        if let Some(cut) = cut {
            let mut length = cut.index(text.len() + 1);
            while !text.is_char_boundary(length) {
                length -= 1;
            }
            text.truncate(length);
        }
        text
    })
}
