//! Shell completions, manual pages and help.

use super::{TestFolder, ran};
use std::fs;
use std::process::{Command, Stdio};

const COMMANDS: [&str; 14] = [
    "render",
    "verify",
    "plan",
    "submit",
    "view",
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

/// The long options of a command, from its help.
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

/// Stdout of a successful command in a terminal of 80 columns.
fn at_80_columns(room: &TestFolder, line: &str) -> String {
    let ran = ran(room.command(line).env("COLUMNS", "80"));
    assert_eq!(ran.code, Some(0), "{line}: {}", ran.stderr);
    ran.stdout
}

/// Checks that a command's `-h` fits a terminal of 80 columns and 50 lines, one option per line.
#[test]
fn short_help_fits_a_screen() {
    let room = TestFolder::new();
    for command in COMMANDS {
        let help = at_80_columns(&room, &format!("{command} -h"));
        let lines: Vec<&str> = help.lines().collect();
        assert!(
            lines.len() <= 50,
            "{command}: {} lines\n{help}",
            lines.len()
        );
        for line in &lines {
            assert!(line.chars().count() <= 80, "{command}: {line}");
            let continued = line.starts_with("          ") && !line.trim_start().starts_with('-');
            assert!(!continued, "{command}: {line}");
        }
        assert!(help.contains("Example"), "{command}\n{help}");
    }
    let help = at_80_columns(&room, "render -h");
    for heading in [
        "Scene",
        "Camera",
        "Quality",
        "Output",
        "Long renders",
        "Machine",
    ] {
        assert!(
            help.contains(&format!("\n{heading}:\n")),
            "{heading}\n{help}"
        );
    }
}

#[test]
fn a_render_ends_with_three_lines_unless_asked_for_more_or_less() {
    let room = TestFolder::new();
    let three = room.ok("render a.test -o a.png");
    assert_eq!(three.lines().count(), 3, "{three}");
    for (line, part) in three
        .lines()
        .zip(["scene ", "speed ", "written      a.png: 40x24"])
    {
        assert!(
            line.starts_with(part) && line.chars().count() <= 80,
            "{three}"
        );
    }
    let all = room.ok("render a.test -o a.png --verbose");
    assert!(all.lines().count() > 12 && all.contains("\ntree "), "{all}");
    for quiet in ["-q", "--quiet"] {
        let ran = room.run(&format!("{quiet} render a.test -o b.png --threads 999"));
        assert_eq!((ran.code, &*ran.stdout, &*ran.stderr), (Some(0), "", ""));
        let ran = room.run(&format!("render {quiet} none.test -o b.png"));
        assert_eq!((ran.code, &*ran.stdout), (Some(1), ""));
        assert!(ran.stderr.starts_with("error: "), "{}", ran.stderr);
    }
    room.refused("render a.test -q -v", 2, &["cannot be used with"]);
}

#[test]
fn colours_are_where_they_are_asked_for() {
    let room = TestFolder::new();
    room.write("bad.test", "size 4 4\nspere 0 0 0 1\n");
    let stderr = |line: &str, set: &[(&str, &str)]| {
        let mut command = room.command(line);
        for name in ["NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE"] {
            command.env_remove(name);
        }
        ran(command.envs(set.iter().copied())).stderr
    };
    for line in ["render none.test", "render bad.test", "render --no-such"] {
        let colored = |set: &[(&str, &str)]| stderr(line, set).contains('\u{1b}');
        assert!(!colored(&[]), "{line}");
        assert!(colored(&[("CLICOLOR_FORCE", "1")]), "{line}");
        assert!(
            !colored(&[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")]),
            "{line}"
        );
    }
    let help = ran(room.command("render -h").env("CLICOLOR_FORCE", "1")).stdout;
    assert!(help.contains('\u{1b}'), "{help}");
}
