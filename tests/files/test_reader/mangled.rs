//! Whatever the bytes, the reader answers, and every place it names lies in the file.

use phalanx::formats::{Diagnostic, LoadError, MAX_DIAGNOSTICS, Options, load, read_test};
use proptest::prelude::*;

/// A file with every command in it.
const VALID: &str = "\
size 8 8 # pixels
maxdepth 3
output a picture.png
camera 0 0 9 0 0 0 0 1 0 40
maxverts 3
maxvertnorms 3
ambient .1 +.1 1e-1
diffuse 1 0 0
specular 0 1 0
emission 0 0 1
transmission .5 .5 .5
shininess 20
ior 1.5
attenuation 1 0 .5
point 0 4 0 1 1 1
directional 0 0 1 1 1 1
pushTransform
translate 1 2 3
rotate 0 1 0 30
scale 2 3 4
vertex 0 0 0
vertex 1 0 0
vertex 0 1 0
tri 0 1 2
vertexnormal 0 0 0 0 0 1
vertexnormal 1 0 0 0 0 1
vertexnormal 0 1 0 0 0 1
trinormal 0 1 2
sphere 0 0 0 1
popTransform
sphere 0 0 0 1
";

/// Tokens that have broken readers before.
const SPICE: [&str; 25] = [
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
    "size",
    "camera",
    "scale",
    "sphere",
    "popTransform",
    "../x",
];

fn check_places(text: &str, diagnostics: &[Diagnostic]) {
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

fn check(text: &str) {
    match read_test(text) {
        Ok(loaded) => {
            loaded.scene.validate().expect("what loads is valid");
            if !loaded.warnings.is_empty() {
                check_places(text, &loaded.warnings);
            }
        }
        Err(errors) => {
            check_places(text, &errors);
            assert!(errors.is_sorted_by_key(|e| e.line), "{errors:?}");
        }
    }
}

/// A mutation of one token.
#[derive(Clone, Debug)]
enum TestMutation {
    Delete,
    Duplicate,
    Replace(String),
}

fn change() -> impl Strategy<Value = TestMutation> {
    let spice = prop::sample::select(&SPICE[..]).prop_map(String::from);
    prop_oneof![
        1 => Just(TestMutation::Delete),
        1 => Just(TestMutation::Duplicate),
        4 => spice.prop_map(TestMutation::Replace),
        1 => any::<f32>().prop_map(|x| TestMutation::Replace(x.to_string())),
        1 => ".{0,8}".prop_map(TestMutation::Replace),
    ]
}

/// Applies the change to token `at` (modulo their number); white space stays as it is.
fn changed(text: &str, at: usize, change: &TestMutation) -> String {
    let mut pieces: Vec<String> = text
        .split_inclusive([' ', '\n'])
        .map(String::from)
        .collect();
    if pieces.is_empty() {
        return String::new();
    }
    let at = at % pieces.len();
    match change {
        TestMutation::Delete => drop(pieces.remove(at)),
        TestMutation::Duplicate => pieces.insert(at, pieces[at].clone()),
        TestMutation::Replace(token) => {
            let kept = pieces[at].trim_end().len();
            pieces[at].replace_range(..kept, token);
        }
    }
    pieces.concat()
}

#[test]
fn the_unchanged_file_is_valid() {
    let loaded = read_test(VALID).unwrap();
    assert_eq!(loaded.scene.prim_count(), 4);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
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
    fn arbitrary_text_never_panics(text in "(\\PC|[ \t\r\n#]|size|tri|-?[0-9]{1,3}){0,60}") {
        check(&text);
    }
}

proptest! {
    // Each case writes a file.
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn arbitrary_bytes_never_panic(
        bytes in prop::collection::vec(any::<u8>(), 0..80),
        at in any::<prop::sample::Index>(),
        amid in any::<bool>(),
    ) {
        let mut file = if amid { VALID.as_bytes().to_vec() } else { Vec::new() };
        let at = at.index(file.len() + 1);
        file.splice(at..at, bytes);
        let scratch = tempfile::tempdir().unwrap();
        let path = scratch.path().join("a.test");
        std::fs::write(&path, &file).unwrap();
        match load(&path, &Options::default()) {
            Ok(loaded) => loaded.scene.validate().expect("what loads is valid"),
            Err(LoadError::Scene { text, diagnostics, .. }) => check_places(&text, &diagnostics),
            Err(other) => panic!("{other}"),
        }
    }
}
