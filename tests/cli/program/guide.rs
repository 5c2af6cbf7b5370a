//! Output for shells and for readers of manuals.

use super::TestFolder;
use std::fs;
use std::process::{Command, Stdio};

const COMMANDS: [&str; 13] = [
    "render",
    "verify",
    "plan",
    "submit",
    "merge",
    "compare",
    "info",
    "scenes",
    "generate",
    "build",
    "bench",
    "completions",
    "man",
];

/// The long options of a command, by its help.
fn options(room: &TestFolder, command: &str) -> Vec<String> {
    let help = room.ok(&format!("{command} --help"));
    let words = help.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-'));
    let mut options: Vec<String> = words
        .filter(|word| word.starts_with("--") && word.len() > 3)
        .map(str::to_owned)
        .collect();
    options.sort();
    options.dedup();
    options
}

#[test]
fn completions_know_every_command_and_option() {
    let room = TestFolder::new();
    let options = options(&room, "render");
    assert!(options.len() > 25, "{options:?}");
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = room.ok(&format!("completions {shell}"));
        for command in COMMANDS {
            assert!(script.contains(command), "{shell}: {command}");
        }
        if shell == "bash" {
            for option in &options {
                assert!(script.contains(option.as_str()), "{option}");
            }
            room.write("script", &script);
            let check = Command::new("bash")
                .args(["-n", "script"])
                .current_dir(room.path())
                .stderr(Stdio::inherit())
                .status();
            assert!(check.is_ok_and(|status| status.success()));
        }
    }
    room.refused("completions tcl", 2, &["bash", "zsh"]);
}

#[test]
fn there_is_a_page_for_every_command() {
    let room = TestFolder::new();
    let main = room.ok("man");
    assert!(main.contains(".TH phalanx 1"), "{main}");
    fs::create_dir(room.path().join("pages")).unwrap();
    room.ok("man --dir pages");
    let pages = fs::read_dir(room.path().join("pages")).unwrap().count();
    assert_eq!(pages, 1 + COMMANDS.len());
    for command in COMMANDS {
        assert!(main.contains(&format!("phalanx\\-{command}")), "{command}");
        let page = fs::read_to_string(room.path().join(format!("pages/phalanx-{command}.1")));
        assert!(page.unwrap().contains(".SH SYNOPSIS"), "{command}");
    }
    let render = fs::read_to_string(room.path().join("pages/phalanx-render.1")).unwrap();
    for option in options(&room, "render") {
        assert!(render.contains(&option.replace('-', "\\-")), "{option}");
    }
    room.refused("man --dir no/where", 1, &["no/where"]);
}
