//! The README's sessions: every line that one shows is a line that the program prints.

use super::TestFolder;
use std::os::unix::fs::symlink;
use std::path::Path;

/// Added where pictures are verified: the lines name no size, and `.ci/run` verifies whole ones.
const SMALL: &str = " --size 64x36";

#[test]
fn sessions_print_what_they_show() {
    let readme = include_str!("../../../README.md");
    let folder = TestFolder::new();
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    symlink(scenes, folder.path().join("scenes")).unwrap();
    let (mut inside, mut shown) = (false, 0);
    let mut printed: Vec<String> = Vec::new();
    for line in readme.lines() {
        if line.starts_with("```") {
            inside = line == "```console";
        } else if let Some(command) = line.strip_prefix("$ ").filter(|_| inside) {
            let arguments = command
                .strip_prefix("cargo run --release -- ")
                .or(command.strip_prefix("phalanx "))
                .unwrap_or_else(|| panic!("not the program: {command}"));
            let size = if arguments.starts_with("verify") {
                SMALL
            } else {
                ""
            };
            let output = folder.run(&format!("{arguments}{size}")).stdout;
            printed = output.lines().map(str::to_owned).rev().collect();
        } else if inside && line != "..." {
            // Lines may be left out, and stand in the program's order.
            let found = std::iter::from_fn(|| printed.pop()).any(|other| other == line);
            assert!(found, "the program does not print {line:?}");
            shown += 1;
        }
    }
    assert!(shown > 10, "{shown} lines");
}
