//! For any bytes, the reader returns, and every span it reports is within the file.

use crate::mutated_text::{check_answer, check_text_answer, mutants};
use phalanx::formats::{LoadError, Options, load, read_test};
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

/// Words of the format that have broken readers before.
const WORDS: [&str; 6] = ["size", "camera", "scale", "sphere", "popTransform", "../x"];

fn check(text: &str) {
    check_text_answer(text, read_test(text));
}

#[test]
fn the_unchanged_file_is_valid() {
    let loaded = read_test(VALID).unwrap();
    assert_eq!(loaded.scene.prim_count(), 4);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
}

proptest! {
    #[test]
    fn changed_tokens_never_panic(text in mutants(VALID, &WORDS)) {
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
        offset in any::<prop::sample::Index>(),
        amid in any::<bool>(),
    ) {
        let mut file = if amid { VALID.as_bytes().to_vec() } else { Vec::new() };
        let offset = offset.index(file.len() + 1);
        file.splice(offset..offset, bytes);
        let scratch = tempfile::tempdir().unwrap();
        let path = scratch.path().join("a.test");
        std::fs::write(&path, &file).unwrap();
        match load(&path, &Options::default()) {
            Ok(loaded) => check_answer(Ok(loaded), |_| ()),
            Err(LoadError::Scene { text, diagnostics, .. }) => {
                check_text_answer(&text, Err(diagnostics));
            }
            Err(other) => panic!("{other}"),
        }
    }
}
