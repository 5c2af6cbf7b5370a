//! Names and sizes, as given on a command line.

use phalanx::standard::{CATALOGUE, StandardError, find, parse_spec};

fn refused(text: &str) -> String {
    parse_spec(text).map(|s| s.size).unwrap_err().to_string()
}

#[test]
fn a_spec_is_a_name_with_or_without_a_size() {
    let tree = parse_spec("standard:tree").unwrap();
    assert_eq!((tree.scene.name, tree.size), ("tree", 11));
    let tree = parse_spec("standard:tree:3").unwrap();
    assert_eq!((tree.scene.name, tree.size), ("tree", 3));
}

#[test]
fn what_is_wrong_with_a_spec_is_said() {
    assert_eq!(
        refused("standard:ball"),
        "no standard scene is called `ball`; did you mean `balls`?"
    );
    assert_eq!(
        refused("tree"),
        "`tree` is not of the form standard:NAME[:SIZE]"
    );
    for size in ["", "x", "-1", "1.5", "3:4", "99999999999999999999"] {
        let error = parse_spec(&format!("standard:tree:{size}")).map(|s| s.size);
        assert!(
            matches!(
                error,
                Err(StandardError::SizeNotANumber { name: "tree", .. })
            ),
            "{size}: {error:?}"
        );
    }
    assert_eq!(
        refused("standard:tree:5000000000"),
        "tree comes in sizes 1 to 22, not 5000000000"
    );
    assert!(refused("standard:tree:0").ends_with("not 0"));
}

#[test]
fn names_are_unique_and_defaults_in_range() {
    for entry in CATALOGUE {
        assert!(
            std::ptr::eq(find(entry.name).unwrap(), entry),
            "{}",
            entry.name
        );
        assert!(entry.sizes.contains(&entry.default_size), "{}", entry.name);
        let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        assert!(entry.name.chars().all(plain), "{}", entry.name);
    }
}
