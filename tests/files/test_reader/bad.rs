//! Bad files, and messages about them.

use crate::folders::folder;
use phalanx::formats::{LoadError, MAX_DIAGNOSTICS, Options, load, read_test};

#[test]
fn twenty_errors_are_reported_in_file_order_then_reading_stops() {
    let mut text = String::from("size 4 4\n");
    for _ in 0..30 {
        text.push_str("sphere a b 0 1\n");
    }
    let errors = read_test(&text).unwrap_err();
    assert_eq!(errors.len(), MAX_DIAGNOSTICS);
    assert_eq!(MAX_DIAGNOSTICS, 20);
    let positions: Vec<_> = errors.iter().map(|e| (e.line, e.column)).collect();
    let expected: Vec<_> = (0..20).map(|k| (2 + k / 2, 8 + 2 * (k % 2))).collect();
    assert_eq!(positions, expected);
}

#[test]
fn an_error_spans_its_token() {
    let text = "size 4 4\r\ncamera 0 0 5 0 0 0 0 1 0 45\r\nambient 1 x12 0\r\n";
    let errors = read_test(text).unwrap_err();
    let [error] = &errors[..] else {
        panic!("{errors:?}")
    };
    assert_eq!(&text[error.offset..][..error.length], "x12");
}

#[test]
fn a_faulty_vertex_keeps_its_number() {
    let body = "vertex 0 0 0\nvertex 1 0 oops\nvertex 0 1 0\ntri 0 1 2\n";
    let errors = read_test(&format!("{}{body}", super::HEAD)).unwrap_err();
    assert_eq!(errors.len(), 1, "{errors:?}");
}

#[test]
fn a_path_that_is_no_file_is_an_io_error_with_a_plain_reason() {
    let missing = load(
        &folder("tests/files/bad").join("there_is_no_such_file.xyz"),
        &Options::default(),
    )
    .unwrap_err();
    assert!(matches!(missing, LoadError::Io { .. }), "{missing}");
    let scratch = tempfile::tempdir().unwrap();
    let named_like_a_scene = scratch.path().join("scene.test");
    std::fs::create_dir(&named_like_a_scene).unwrap();
    for path in [named_like_a_scene.as_path(), scratch.path()] {
        let LoadError::Io { source, .. } = load(path, &Options::default()).unwrap_err() else {
            panic!("{path:?} is a directory")
        };
        assert_eq!(source.to_string(), "is a directory");
    }
}

#[test]
fn the_ending_chooses_the_format_in_any_case() {
    let scratch = tempfile::tempdir().unwrap();
    let text = format!("{}sphere 0 0 0 1\n", super::HEAD);
    for name in ["a.test", "a.TEST", "a.b.Test"] {
        let path = scratch.path().join(name);
        std::fs::write(&path, &text).unwrap();
        assert_eq!(
            load(&path, &Options::default()).unwrap().scene.prim_count(),
            1,
            "{name}"
        );
    }
    for name in ["a.txt", "test", ".test", "a.test~"] {
        let path = scratch.path().join(name);
        std::fs::write(&path, &text).unwrap();
        let error = load(&path, &Options::default()).unwrap_err();
        assert!(matches!(error, LoadError::UnknownFormat { .. }), "{name}");
    }
}
