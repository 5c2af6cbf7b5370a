//! Whatever the bytes, the reader answers, and every place it names lies in the file.

use phalanx::formats::{Diagnostic, MAX_DIAGNOSTICS, read_nff};
use proptest::prelude::*;

/// A file with every record in it.
const VALID: &str = "\
# a comment
b 0.078 0.361 0.753
v
from 2.1 1.3 1.7
at 0 0 0
up 0 0 1
angle 45
hither 0.01
resolution 12 8
l 4 3 2
l 1 -4 4 1 .5 1
f 1 0.75 0.33 0.8 0 100000 0 1
p 4
12 12 -0.5
-12 12 -0.5
-12 -12 -0.5
12 -12 -0.5
f 1 0.9 0.7 0.5 0.5 3.0827 0.5 1.5 # glass
s 0 0 0 0.5
c 0 0 0 0.15 0 0 1 0.1005
c 0 0 2 -1
0 0 3 -.5
pp 3
0 0 0 0 0 1
1 0 0 0 0 1
0 1 0 0 0 1
tess 4
p 5
0 0 0
4 0 0
4 4 0
2 1 0
0 4 0
";

/// Tokens that have broken readers before.
const SPICE: [&str; 26] = [
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
    "p",
    "pp",
    "v",
    "s",
    "resolution",
    "l",
    "nff",
];

fn check_places(text: &str, diagnostics: &[Diagnostic]) {
    assert!(!diagnostics.is_empty() && diagnostics.len() <= MAX_DIAGNOSTICS);
    assert!(
        diagnostics.is_sorted_by_key(|d| d.offset),
        "{diagnostics:?}"
    );
    for d in diagnostics {
        let place = text.get(d.offset..d.offset + d.length);
        assert!(place.is_some(), "{d:?} lies outside of {text:?}");
        let before = &text[..d.offset];
        assert_eq!(d.line, 1 + before.matches('\n').count(), "{d:?}");
    }
}

fn check(text: &str) {
    match read_nff(text) {
        Ok(loaded) => {
            loaded.scene.validate().expect("what loads is valid");
            if !loaded.warnings.is_empty() {
                check_places(text, &loaded.warnings);
            }
        }
        Err(errors) => check_places(text, &errors),
    }
}

/// A mutation of one token.
#[derive(Clone, Debug)]
enum NffMutation {
    Delete,
    Duplicate,
    Replace(String),
}

fn change() -> impl Strategy<Value = NffMutation> {
    let spice = prop::sample::select(&SPICE[..]).prop_map(String::from);
    prop_oneof![
        1 => Just(NffMutation::Delete),
        1 => Just(NffMutation::Duplicate),
        4 => spice.prop_map(NffMutation::Replace),
        1 => any::<f32>().prop_map(|x| NffMutation::Replace(x.to_string())),
        1 => ".{0,8}".prop_map(NffMutation::Replace),
    ]
}

/// Applies the change to token `at` (modulo their number); white space stays as it is.
fn changed(text: &str, at: usize, change: &NffMutation) -> String {
    let mut pieces: Vec<String> = text
        .split_inclusive([' ', '\n'])
        .map(String::from)
        .collect();
    if pieces.is_empty() {
        return String::new();
    }
    let at = at % pieces.len();
    match change {
        NffMutation::Delete => drop(pieces.remove(at)),
        NffMutation::Duplicate => pieces.insert(at, pieces[at].clone()),
        NffMutation::Replace(token) => {
            let kept = pieces[at].trim_end().len();
            pieces[at].replace_range(..kept, token);
        }
    }
    pieces.concat()
}

#[test]
fn the_unchanged_file_is_valid() {
    let loaded = read_nff(VALID).unwrap();
    assert_eq!(loaded.scene.prim_count(), 2 + 1 + 2 + 1 + 3);
    assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
}

#[test]
fn every_beginning_of_a_file_is_answered() {
    for end in 0..=VALID.len() {
        check(&VALID[..end]);
    }
}

proptest! {
    #[test]
    fn changed_tokens_never_panic(
        changes in prop::collection::vec((any::<usize>(), change()), 1..8),
        cut in prop::option::weighted(0.2, any::<prop::sample::Index>()),
    ) {
        let mut text = String::from(VALID);
        for (at, change) in &changes {
            text = changed(&text, *at, change);
        }
        if let Some(cut) = cut {
            let mut kept = cut.index(text.len() + 1);
            while !text.is_char_boundary(kept) {
                kept -= 1;
            }
            text.truncate(kept);
        }
        check(&text);
    }

    #[test]
    fn arbitrary_text_never_panics(
        text in "(\\PC|[ \t\r\n#]|(p|pp|s|c|f|l|b|v|from|angle)|-?[0-9]{1,3}){0,60}",
    ) {
        check(&text);
    }
}
