//! The command line: messages, exit codes, and the files that appear or do not.
#![cfg(unix)]

mod bench;
mod caches;
mod compare;
mod copied_commands;
mod defaults;
mod environments;
mod exposure;
mod formats;
mod guide;
mod headers;
mod inputs;
mod jobs;
mod light_list;
mod made_up;
mod memory;
mod names;
mod origin;
mod pictures;
mod places;
mod plans;
mod readme;
mod refusals;
mod same_bytes;
mod scenes;
mod sequences;
mod signals;
mod standard;
mod streams;
mod view;
mod view_requests;
mod words;

use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// A scene of two spheres and a reflective, half transparent triangle, with both kinds of light.
const SCENE: &str = "\
size 40 24
camera 0 0 5 0 0 0 0 1 0 45
directional 1 1 1 0.5 0.5 0.5
point 3 3 3 0.5 0.4 0.3
diffuse 0.6 0.3 0.2
specular 0.3 0.3 0.3
sphere -1 0 0 1
sphere 1 0.5 0 0.7
maxverts 3
vertex -3 -1 -3
vertex 3 -1 -3
vertex 0 -1 3
transmission 0.5 0.5 0.5
ior 1.5
tri 0 2 1
";

/// A separate folder to run in.
struct TestFolder(TempDir);

/// Results of a run.
struct Ran {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

impl TestFolder {
    /// A folder that contains the scene as `a.test`.
    fn new() -> TestFolder {
        let room = TestFolder(tempfile::tempdir().unwrap());
        room.write("a.test", SCENE);
        room
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path().join(name), text).unwrap();
    }

    /// Sorted names of the folder's contents, except the scene.
    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.path()).unwrap();
        let names = entries.map(|e| e.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<_> = names.filter(|name| name != "a.test").collect();
        names.sort();
        names
    }

    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_phalanx"));
        command
            .current_dir(self.path())
            .args(line.split_whitespace());
        command
    }

    fn run(&self, line: &str) -> Ran {
        ran(&mut self.command(line))
    }

    /// Runs in an address space of 400 MB.
    fn run_in_400_mb(&self, line: &str) -> Ran {
        let binary = env!("CARGO_BIN_EXE_phalanx");
        let mut command = Command::new("sh");
        command.args(["-c", "ulimit -v 400000; exec \"$@\"", "sh", binary]);
        ran(command
            .current_dir(self.path())
            .args(line.split_whitespace()))
    }

    /// Runs a command that must succeed, and returns its stdout.
    fn ok(&self, line: &str) -> String {
        let ran = self.run(line);
        assert_eq!(ran.code, Some(0), "{line}: {}", ran.stderr);
        ran.stdout
    }

    /// Runs a script in the folder, with an sbatch that does nothing.
    fn carry_out(&self, script: &str) {
        let mut shell = Command::new("bash");
        let script = format!("sbatch() {{ :; }}\n{script}");
        let ran = ran(shell.current_dir(self.path()).args(["-ec", &script]));
        assert_eq!(ran.code, Some(0), "{script}: {}", ran.stderr);
    }

    fn json(&self, line: &str) -> Value {
        serde_json::from_str(&self.ok(line)).unwrap()
    }

    /// Runs a command that must fail with `code`, print every part on stderr and nothing on stdout,
    /// and leave no new file.
    fn refused(&self, line: &str, code: i32, parts: &[&str]) {
        let before = self.names();
        let ran = self.run(line);
        assert_eq!(ran.code, Some(code), "{line}: {}", ran.stderr);
        for part in parts {
            assert!(
                ran.stderr.contains(part),
                "{line}: {part:?} in\n{}",
                ran.stderr
            );
        }
        assert!(!ran.stderr.contains("panicked"), "{line}: {}", ran.stderr);
        assert_eq!(ran.stdout, "", "{line}");
        assert_eq!(self.names(), before, "{line}");
    }
}

fn ran(command: &mut Command) -> Ran {
    let output = command.output().unwrap();
    Ran {
        code: output.status.code(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}
