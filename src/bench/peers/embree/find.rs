//! Search for Embree's library: in the loader's folders, or in a Python's `embreex` wheel.

use std::collections::HashSet;
use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Possible names of the library for the system's loader, the newer version first.
pub(super) fn loader_names() -> &'static [&'static str] {
    if cfg!(windows) {
        &["embree4.dll", "embree3.dll"]
    } else if cfg!(target_os = "macos") {
        &[
            "libembree4.4.dylib",
            "libembree4.dylib",
            "libembree3.3.dylib",
            "libembree3.dylib",
        ]
    } else {
        &[
            "libembree4.so.4",
            "libembree4.so",
            "libembree3.so.3",
            "libembree3.so",
        ]
    }
}

/// The libraries in a folder that the user names: an unpacked wheel, an installation, or the folder
/// of the file itself.
pub(super) fn in_folder(folder: &Path) -> Vec<PathBuf> {
    let below = ["", "lib", "lib64", "bin", "embreex.libs", "embreex/.dylibs"];
    let folders = below.iter().map(|name| folder.join(name));
    folders.flat_map(|folder| libraries(&folder)).collect()
}

/// The libraries in wheels of Pythons that can be found without starting one.
pub(super) fn in_wheels() -> Vec<PathBuf> {
    let packages = prefixes()
        .into_iter()
        .flat_map(|prefix| packages_of(&prefix));
    packages.flat_map(|folder| in_folder(&folder)).collect()
}

/// The libraries in wheels of the first Python of `PATH`. It is started to print the path of its
/// packages, because some Pythons are shell scripts that select another.
pub(super) fn by_asking_python() -> Vec<PathBuf> {
    let program = "import site, sysconfig\n\
        print(sysconfig.get_paths()['platlib'])\n\
        print(site.getusersitepackages())\n\
        print(*site.getsitepackages(), sep='\\n')";
    for python in ["python3", "python"] {
        let mut command = Command::new(python);
        command.args(["-c", program]).stdin(Stdio::null());
        if let Ok(output) = command.output()
            && output.status.success()
        {
            let folders = String::from_utf8_lossy(&output.stdout);
            let libraries = folders.lines().map(|line| in_folder(Path::new(line)));
            return libraries.flatten().collect();
        }
    }
    Vec::new()
}

/// Folders that Pythons are installed under: the prefixes of the virtual environment, of the
/// Pythons in `PATH`, and the user's.
fn prefixes() -> Vec<PathBuf> {
    let variables = ["VIRTUAL_ENV", "CONDA_PREFIX"].into_iter();
    let variables = variables.filter_map(env::var_os);
    let mut prefixes: Vec<PathBuf> = variables.map(PathBuf::from).collect();
    for folder in env::split_paths(&env::var_os("PATH").unwrap_or_default()) {
        for python in ["python3", "python", "python3.exe", "python.exe"] {
            let python = folder.join(python);
            if !python.is_file() {
                continue;
            }
            // A virtual environment's Python is a link: its packages are next to the link, the rest
            // is next to its target.
            for python in [Some(python.clone()), fs::canonicalize(&python).ok()] {
                let prefix = python
                    .as_deref()
                    .and_then(|python| python.ancestors().nth(2));
                prefixes.extend(prefix.map(Path::to_owned));
            }
        }
    }
    prefixes.extend(env::home_dir().map(|home| home.join(".local")));
    let mut seen = HashSet::new();
    prefixes.retain(|prefix| seen.insert(prefix.clone()));
    prefixes
}

/// Folders of packages under one prefix.
fn packages_of(prefix: &Path) -> Vec<PathBuf> {
    let mut folders = vec![prefix.join("Lib/site-packages")];
    for lib in [prefix.join("lib"), prefix.join("local/lib")] {
        for python in names_in(&lib) {
            if python.to_string_lossy().starts_with("python3") {
                let python = lib.join(python);
                folders.extend(["site-packages", "dist-packages"].map(|name| python.join(name)));
            }
        }
    }
    folders
}

/// Files of a folder with the name of Embree's library, with any additions by a wheel; version 4
/// before 3.
fn libraries(folder: &Path) -> Vec<PathBuf> {
    let mut libraries: Vec<(u8, PathBuf)> = Vec::new();
    for name in names_in(folder) {
        let text = name.to_string_lossy();
        let stem = text.strip_prefix("lib").unwrap_or(&text);
        let library = [".so", ".dylib", ".dll"]
            .iter()
            .any(|end| text.contains(end));
        match stem
            .strip_prefix("embree")
            .and_then(|rest| rest.bytes().next())
        {
            Some(version @ (b'3' | b'4')) if library => {
                libraries.push((version, folder.join(&name)))
            }
            _ => {}
        }
    }
    libraries.sort_by(|(a, x), (b, y)| b.cmp(a).then_with(|| x.cmp(y)));
    libraries.into_iter().map(|(_, path)| path).collect()
}

/// Names of the entries of a folder, in order; empty if it cannot be read.
fn names_in(folder: &Path) -> Vec<OsString> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<OsString> = entries.map(|entry| entry.file_name()).collect();
    names.sort();
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wheels_and_installations_are_told_by_their_names() {
        let root = tempfile::tempdir().expect("a folder");
        let packages = root.path().join("lib/python3.11/site-packages");
        let files = [
            "embreex.libs/libembree4-4aef3270.so.4",
            "embreex.libs/libtbb-dcf63f8c.so.12",
            "embreex/__init__.py",
            "embreex/rtcore.cpython-311-x86_64-linux-gnu.so",
        ];
        for file in files {
            let file = packages.join(file);
            fs::create_dir_all(file.parent().expect("a folder")).expect("a folder");
            fs::write(&file, "").expect("a file");
        }
        let libraries: Vec<PathBuf> = packages_of(root.path())
            .iter()
            .flat_map(|folder| in_folder(folder))
            .collect();
        assert_eq!(libraries, [packages.join(files[0])]);
    }

    #[test]
    fn the_newer_version_comes_first() {
        let root = tempfile::tempdir().expect("a folder");
        let names = [
            "libembree3.so.3",
            "libembree4.so",
            "libembree4.so.4",
            "libembree2.so.2",
            "embree.txt",
        ];
        for name in names {
            fs::write(root.path().join(name), "").expect("a file");
        }
        let libraries = in_folder(root.path());
        let libraries: Vec<_> = libraries
            .iter()
            .filter_map(|path| path.file_name())
            .collect();
        assert_eq!(
            libraries,
            ["libembree4.so", "libembree4.so.4", "libembree3.so.3"]
        );
    }
}
