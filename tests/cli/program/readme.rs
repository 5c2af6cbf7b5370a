//! Sessions in the README and the manual: the program prints every line that they show.

use super::{TestFolder, ran};
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

/// Added when pictures are verified: the sessions give no size, and `.ci/run` verifies full ones.
const SMALL: &str = " --size 64x36";

const README: &str = include_str!("../../../README.md");
const MANUAL: &str = include_str!("../../../docs/manual.md");

/// Maximum number of words in the README; anything longer belongs in the manual.
const MOST_WORDS: usize = 1500;

#[test]
fn the_readme_is_short() {
    let words = README.split_whitespace().count();
    assert!(words <= MOST_WORDS, "{words} words");
}

#[test]
fn sessions_print_what_they_show() {
    let shown: usize = [README, MANUAL].into_iter().map(sessions_of).sum();
    assert!(shown > 10, "{shown} lines");
}

/// Runs the sessions of a text, and returns the number of lines they show.
fn sessions_of(text: &str) -> usize {
    let folder = TestFolder::new();
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    symlink(scenes, folder.path().join("scenes")).unwrap();
    let (mut inside, mut shown) = (false, 0);
    let mut printed: Vec<String> = Vec::new();
    for line in text.lines() {
        if line.starts_with("```") {
            inside = line == "```console";
        } else if let Some(command) = line.strip_prefix("$ ").filter(|_| inside) {
            let arguments = command
                .strip_prefix("cargo run --release -- ")
                .or(command.strip_prefix("phalanx "))
                .unwrap_or_else(|| panic!("not the program: {command}"));
            let size = if arguments.starts_with("verify") { SMALL } else { "" };
            let output = folder.run(&format!("{arguments}{size}")).stdout;
            printed = output.lines().map(str::to_owned).rev().collect();
        } else if inside && line != "..." {
            // Lines may be omitted, but keep the program's order.
            let is_printed = std::iter::from_fn(|| printed.pop()).any(|other| other == line);
            assert!(is_printed, "the program does not print {line:?}");
            shown += 1;
        }
    }
    shown
}

/// Checks that no output is outside the sessions, and that the program accepts the options of every
/// other command shown.
#[test]
fn commands_are_known_and_outputs_are_sessions() {
    let binary = Path::new(env!("CARGO_BIN_EXE_phalanx"));
    let folder = binary.parent().expect("a folder").display();
    let path = std::env::var("PATH").unwrap_or_default();
    let (mut fence, mut commands) = (None, 0);
    for line in README.lines().chain(MANUAL.lines()) {
        if let Some(language) = line.strip_prefix("```") {
            fence = match fence {
                Some(_) => None,
                None => Some(language),
            };
            let known = ["", "c", "console", "rust", "sh", "text", "toml"].contains(&language);
            assert!(known && fence != Some(""), "a fence of {language:?}");
        }
        let program = line.strip_prefix("cargo run --release -- ");
        let program = program.or(line.strip_prefix("phalanx "));
        if let Some(arguments) = program.filter(|_| fence == Some("sh")) {
            let mut shell = Command::new("sh");
            shell.args(["-c", &format!("phalanx {arguments} --help")]);
            let known = ran(shell.env("PATH", format!("{folder}:{path}")));
            assert_eq!(known.code, Some(0), "{line}: {}", known.stderr);
            commands += 1;
        }
    }
    assert!(commands > 5, "{commands} commands");
}
