//! The list of what was wrong once names tests that exist.

use std::path::Path;

#[test]
fn every_value_that_was_wrong_once_has_its_test() {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let list = std::fs::read_to_string(tests.join("regressions.md")).expect("the list");
    let rows = list.lines().filter(|line| line.starts_with("| ")).skip(1);
    let mut count = 0;
    for row in rows {
        let names: Vec<&str> = row
            .rsplit('|')
            .nth(1)
            .unwrap_or_default()
            .split('`')
            .collect();
        let (file, test) = match names[..] {
            [_, file, _] => (file, None),
            [_, file, _, test, _] => (file, Some(test)),
            _ => panic!("{row}: `FILE` or `FILE` `TEST`"),
        };
        let bytes =
            std::fs::read(tests.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
        let text = String::from_utf8_lossy(&bytes);
        let exists = |test: &str| {
            ["fn ", "def "]
                .iter()
                .any(|start| text.contains(&format!("{start}{test}(")))
        };
        assert!(test.is_none_or(exists), "{file} has no {test:?}");
        count += 1;
    }
    assert!(count > 30, "{count} rows");
}
