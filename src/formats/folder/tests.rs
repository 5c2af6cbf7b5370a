//! Names that are found, and names that must not be.

use super::*;
use std::fs::{create_dir_all, write};

/// A scene file's folder with pictures, beside another folder and a file that are not its own.
fn tree() -> (tempfile::TempDir, PathBuf, Folder) {
    let outer = tempfile::tempdir().unwrap();
    let scene = outer.path().join("scene");
    for folder in ["scene/mtl/img", "scene/maps", "textures"] {
        create_dir_all(outer.path().join(folder)).unwrap();
    }
    for file in [
        "secret",
        "textures/bark.png",
        "scene/maps/wood.png",
        "scene/beside.png",
        "scene/mtl/a.mtl",
        "scene/mtl/img/tile.png",
        "scene/mtl/beside.png",
        "scene/Upper.PNG",
    ] {
        write(outer.path().join(file), file).unwrap();
    }
    let folder = Folder::of(&scene.join("a.obj"));
    (outer, scene, folder)
}

fn text(folder: &Folder, file: &Found) -> String {
    String::from_utf8(folder.read(file).unwrap()).unwrap()
}

#[test]
fn only_files_of_the_folder_are_read() {
    let (outer, scene, folder) = tree();
    let wood = folder.find("maps/wood.png").unwrap();
    assert_eq!(text(&folder, &wood), "scene/maps/wood.png");
    for same in [
        ".\\maps\\wood.png",
        "maps//wood.png",
        "mtl/../maps/wood.png",
        " \"maps/wood.png\" ",
    ] {
        assert_eq!(folder.find(same), Ok(wood.clone()), "{same}");
    }
    let absolute = outer.path().join("secret");
    for outside in [
        "../secret",
        "maps/../../secret",
        "",
        "maps",
        "absent",
        "..",
        "/",
        absolute.to_str().unwrap(),
    ] {
        assert!(folder.find(outside).is_err(), "{outside}");
    }
    let error = folder.find("../secret").unwrap_err();
    assert!(
        error.contains("not in the scene file's folder") && error.contains("--allow-path"),
        "{error}"
    );
    // The message does not say that there is such a file.
    assert_eq!(folder.find("../none"), Err(error));
    let _ = scene;
}

#[cfg(unix)]
#[test]
fn links_open_nothing() {
    use std::os::unix::fs::symlink;
    let (outer, scene, folder) = tree();
    symlink(outer.path().join("secret"), scene.join("link")).unwrap();
    symlink(outer.path().join("textures"), scene.join("linked")).unwrap();
    symlink(outer.path().join("textures"), outer.path().join("other")).unwrap();
    for outside in [
        "link",
        "linked/bark.png",
        "LINK",
        "linked/BARK.png",
        "c:/link",
    ] {
        let error = folder.find(outside).unwrap_err();
        assert!(
            error.contains("leads out") || error.contains("No such") || error.contains("not in"),
            "{error}"
        );
    }
    // A file that a link leads to may be read once its folder has been opened, by the folder's own
    // path or by the path of the link.
    let folder = folder.with_opened(&[outer.path().join("other")]);
    for inside in [
        "linked/bark.png",
        "../textures/bark.png",
        "../other/bark.png",
    ] {
        assert!(folder.find(inside).is_ok(), "{inside}");
    }
    assert!(folder.find("link").unwrap_err().contains("leads out"));
}

#[test]
fn names_are_relative_to_the_file_that_has_them_then_to_the_scene() {
    let (_outer, _, folder) = tree();
    let mtl = folder.find("mtl/a.mtl").unwrap();
    for (name, expected) in [
        ("img/tile.png", "scene/mtl/img/tile.png"),
        ("beside.png", "scene/mtl/beside.png"),
        ("../beside.png", "scene/beside.png"),
        ("maps/wood.png", "scene/maps/wood.png"),
        ("../maps/wood.png", "scene/maps/wood.png"),
    ] {
        let named = folder.find_for(Some(&mtl), name).unwrap();
        assert_eq!(
            (text(&folder, &named.file).as_str(), named.instead),
            (expected, None),
            "{name}"
        );
    }
}

#[test]
fn paths_of_other_machines_are_cut_to_their_last_component() {
    let (_outer, scene, folder) = tree();
    let mtl = folder.find("mtl/a.mtl").unwrap();
    let expected = scene.canonicalize().unwrap().join("maps/wood.png");
    assert!(
        folder.find(expected.to_str().unwrap()).is_ok(),
        "an absolute path of the folder itself"
    );
    for name in [
        "C:\\Users\\bob\\beside.png",
        "c:beside.png",
        "/home/bob/beside.png",
        "\\\\srv\\share\\beside.png",
        "\"D:\\with blanks\\beside.png\"",
        "file:///C:/a/beside.png",
    ] {
        let named = folder.find_for(Some(&mtl), name).unwrap();
        assert_eq!(
            (text(&folder, &named.file).as_str(), named.instead),
            ("scene/mtl/beside.png", None),
            "{name}"
        );
    }
    let named = folder.find_for(None, "none/there/beside.png").unwrap();
    assert_eq!(
        named.instead.as_deref(),
        Some("beside.png"),
        "said, since the name was relative"
    );
}

#[test]
fn letters_of_the_other_case_are_searched_for_if_one_file_has_them() {
    let (_outer, scene, folder) = tree();
    if scene.join("upper.png").exists() {
        return println!("skipped: this file system does not tell case");
    }
    let lone = |name: &str| folder.find_for(None, name).map(|named| named.instead);
    assert_eq!(lone("upper.png"), Ok(Some("Upper.PNG".into())));
    assert_eq!(lone("MAPS/Wood.png"), Ok(Some("wood.png".into())));
    write(scene.join("UPPER.png"), "").unwrap();
    assert!(lone("upper.png").is_err(), "two are like it");
    assert!(lone("../SECRET").is_err());
}

#[test]
fn an_opened_folder_opens_nothing_else() {
    let (outer, _, folder) = tree();
    let folder = folder.with_opened(&[outer.path().join("textures"), outer.path().join("absent")]);
    for name in ["../textures/bark.png", "bark.png", "C:\\x\\bark.png"] {
        let named = folder.find_for(None, name).unwrap();
        assert_eq!(text(&folder, &named.file), "textures/bark.png", "{name}");
    }
    for outside in [
        "../secret",
        "../textures/../secret",
        "../textures",
        "../absent/x",
    ] {
        assert!(folder.find(outside).is_err(), "{outside}");
    }
}

#[test]
fn searches_end() {
    let (_outer, _, folder) = tree();
    for k in 0..MAX_SEARCHES {
        assert!(folder.find(&format!("none{k}")).is_err());
    }
    assert!(folder.find("beside.png").is_ok());
    assert!(
        folder.find("upper.png").is_err(),
        "not searched for any more"
    );
}

#[test]
fn blanks_and_quotes_may_be_part_of_a_name() {
    let (_outer, scene, folder) = tree();
    for name in [
        " beside.png",
        "two  blanks.png ",
        "'quoted.png'",
        " maps/wood.png",
    ] {
        create_dir_all(scene.join(name).parent().unwrap()).unwrap();
        write(scene.join(name), name).unwrap();
        let file = folder.find(name).unwrap();
        assert_eq!(text(&folder, &file), name);
    }
    // Without such a file they stand around the name.
    let file = folder.find("  beside.png ").unwrap();
    assert_eq!(text(&folder, &file), "scene/beside.png");
    assert!(folder.find(" ../secret").is_err());
    assert!(folder.find(" /etc/passwd").is_err());
}

#[test]
fn addresses_are_not_fetched() {
    let (_outer, _scene, folder) = tree();
    for name in ["http://a/b.png", "HTTPS://a/b.png", "s3+x://a/b.png"] {
        assert_eq!(folder.find(name).unwrap_err(), REMOTE);
    }
    for name in ["file:///a/b.png", "C://a/b.png", "a b://c.png", "://c.png"] {
        assert_ne!(folder.find(name).unwrap_err(), REMOTE, "{name}");
    }
    // One that has been saved next to the scene is found.
    assert!(folder.find("https://example.com/wood/beside.png").is_ok());
}
