//! Text files with tokens deleted, doubled and replaced, and what must hold of every diagnostic.

use phalanx::formats::{Diagnostic, MAX_DIAGNOSTICS};
use proptest::prelude::*;
use proptest::sample::Index;

/// Tokens that have broken readers before, whatever the format.
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

/// Asserts that each diagnostic's place lies in the text, on its line.
pub fn check_places(text: &str, diagnostics: &[Diagnostic]) {
    assert!(!diagnostics.is_empty() && diagnostics.len() <= MAX_DIAGNOSTICS);
    for d in diagnostics {
        let place = text.get(d.offset..d.offset + d.length);
        assert!(place.is_some(), "{d:?} lies outside of {text:?}");
        let line = text.split('\n').nth(d.line - 1).expect("the line exists");
        assert!(
            d.column > 0 && d.column <= line.chars().count() + 1,
            "{d:?}"
        );
        let before = &text[..d.offset];
        assert_eq!(d.line, 1 + before.matches('\n').count(), "{d:?}");
    }
}

/// One token's fate.
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

/// Applies the mutation to token `at` (modulo their number); white space stays as it is.
fn mutated(text: &str, at: usize, mutation: &TokenMutation) -> String {
    let mut pieces: Vec<String> = text
        .split_inclusive([' ', '\n'])
        .map(String::from)
        .collect();
    if pieces.is_empty() {
        return String::new();
    }
    let at = at % pieces.len();
    match mutation {
        TokenMutation::Delete => drop(pieces.remove(at)),
        TokenMutation::Duplicate => pieces.insert(at, pieces[at].clone()),
        TokenMutation::Replace(token) => {
            let kept = pieces[at].trim_end().len();
            pieces[at].replace_range(..kept, token);
        }
    }
    pieces.concat()
}

/// The valid text with one to seven mutations, one time in five cut off somewhere.
pub fn mutants(
    valid: &'static str,
    words: &'static [&'static str],
) -> impl Strategy<Value = String> {
    let mutations = prop::collection::vec((any::<usize>(), mutation(words)), 1..8);
    let cut = prop::option::weighted(0.2, any::<Index>());
    (mutations, cut).prop_map(move |(mutations, cut)| {
        let mut text = String::from(valid);
        for (at, mutation) in &mutations {
            text = mutated(&text, *at, mutation);
        }
        if let Some(cut) = cut {
            let mut kept = cut.index(text.len() + 1);
            while !text.is_char_boundary(kept) {
                kept -= 1;
            }
            text.truncate(kept);
        }
        text
    })
}
