//! For any bytes, the reader returns, and every span it reports is within the file.

use crate::mutated_text::{check_text_answer, mutants};
use phalanx::formats::read_nff;
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

/// Words of the format that have broken readers before.
const WORDS: [&str; 7] = ["p", "pp", "v", "s", "resolution", "l", "nff"];

fn check(text: &str) {
    check_text_answer(text, read_nff(text));
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
    fn changed_tokens_never_panic(text in mutants(VALID, &WORDS)) {
        check(&text);
    }

    #[test]
    fn arbitrary_text_never_panics(
        text in "(\\PC|[ \t\r\n#]|(p|pp|s|c|f|l|b|v|from|angle)|-?[0-9]{1,3}){0,60}",
    ) {
        check(&text);
    }
}
