//! The text of the sources without comments and literals, and the paths in it.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Files of `src` that are not Rust sources.
const OTHERS: [&str; 1] = ["report/html/style.css"];

/// The Python package, except its extension, the page of `phalanx view`, and what C has.
const PACKAGES: [&str; 9] = [
    "capi/README.md",
    "capi/include/",
    "capi/install.sh",
    "capi/package/",
    "view/page/",
    "python/phalanx/",
    "python/pyproject.toml",
    "python/README.md",
    "python/LICENSE-",
];

/// One Rust file.
pub struct SourceFile {
    /// Path relative to `src`, with forward slashes; relative to the repository, if it comes from
    /// [`everything`].
    pub path: String,
    /// The original text.
    pub text: String,
    /// The text without comments and literals, with the same lines.
    pub code: String,
}

impl SourceFile {
    /// Returns true if the file is in a module, for instance `trace/simd`.
    pub fn is_in(&self, room: &str) -> bool {
        let rest = self.path.strip_prefix(room);
        rest.is_some_and(|rest| rest.starts_with('/'))
    }

    /// Lines (from 1) on which `word` appears as a whole identifier.
    pub fn lines_with(&self, word: &str) -> Vec<usize> {
        let line = |offset: usize| 1 + self.code[..offset].matches('\n').count();
        let mut lines: Vec<usize> = places(&self.code, word).into_iter().map(line).collect();
        lines.dedup();
        lines
    }
}

/// Byte positions of `word` in `text` where it is not part of a longer identifier.
pub fn places(text: &str, word: &str) -> Vec<usize> {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    let starts_inside = |c: Option<char>| word.starts_with(part) && c.is_some_and(part);
    let goes_on =
        |c: Option<char>| word.ends_with(part) && !word.ends_with('_') && c.is_some_and(part);
    let positions = text.match_indices(word).filter(|&(position, _)| {
        let before = text[..position].chars().next_back();
        let after = text[position + word.len()..].chars().next();
        !starts_inside(before) && !goes_on(after)
    });
    positions.map(|(position, _)| position).collect()
}

/// Blanks comments, string and character literals; keeps line breaks.
pub fn code_of(text: &str) -> String {
    let chars: Vec<char> = text.chars().collect();
    let mut out = String::with_capacity(text.len());
    let mut i = 0;
    while i < chars.len() {
        let rest = &chars[i..];
        let length = match rest {
            ['/', '/', ..] => until(rest, 2, |r| r[0] == '\n', 0),
            ['/', '*', ..] => block_comment(rest),
            ['r', '"', ..] | ['r', '#', '"' | '#', ..] if !in_word(&chars, i) => raw_string(rest),
            ['"', ..] => string(rest),
            ['\'', '\\', ..] => until(rest, 3, |r| r[0] == '\'', 1),
            ['\'', _, '\'', ..] => 3,
            _ => {
                out.push(rest[0]);
                i += 1;
                continue;
            }
        };
        // A literal keeps its width, so that its neighbours stay separate.
        out.push(' ');
        out.extend(rest[..length].iter().filter(|&&c| c == '\n'));
        i += length;
    }
    out
}

fn in_word(chars: &[char], i: usize) -> bool {
    i > 0 && (chars[i - 1].is_alphanumeric() || chars[i - 1] == '_')
}

fn until(rest: &[char], from: usize, end: impl Fn(&[char]) -> bool, with: usize) -> usize {
    let end = (from..rest.len()).find(|&k| end(&rest[k..]));
    end.map_or(rest.len(), |k| k + with)
}

fn block_comment(rest: &[char]) -> usize {
    let (mut depth, mut k) = (0, 0);
    while k < rest.len() {
        match rest[k..] {
            ['/', '*', ..] => (depth, k) = (depth + 1, k + 2),
            ['*', '/', ..] => (depth, k) = (depth - 1, k + 2),
            _ => k += 1,
        }
        if depth == 0 {
            break;
        }
    }
    k
}

fn string(rest: &[char]) -> usize {
    let mut k = 1;
    while k < rest.len() && rest[k] != '"' {
        k += if rest[k] == '\\' { 2 } else { 1 };
    }
    (k + 1).min(rest.len())
}

fn raw_string(rest: &[char]) -> usize {
    let hashes = rest[1..].iter().take_while(|&&c| c == '#').count();
    if rest.get(1 + hashes) != Some(&'"') {
        // A raw identifier.
        return 2;
    }
    let end =
        |r: &[char]| r[0] == '"' && r.len() > hashes && r[1..=hashes].iter().all(|&c| c == '#');
    until(rest, 2 + hashes, end, 1 + hashes)
}

/// The files of `src`.
pub fn sources() -> Vec<SourceFile> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let files = files_below(&root, &root);
    assert!(files.len() > 20, "only {} sources found", files.len());
    let rust = |path: &str| path.ends_with(".rs");
    let package = |path: &str| PACKAGES.iter().any(|folder| path.starts_with(folder));
    let other =
        |path: &str| OTHERS.contains(&path) || package(path) || path.ends_with("/Cargo.toml");
    for path in &files {
        assert!(rust(path) || other(path), "{path} is no Rust source");
    }
    let sources = files.into_iter().filter(|path| rust(path));
    sources.map(|path| read(&root, path)).collect()
}

/// Every Rust file of the repository: program, tests, benches, examples and build script.
pub fn everything() -> Vec<SourceFile> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut paths = vec!["build.rs".to_owned()];
    for folder in ["src", "tests", "benches", "examples"] {
        paths.extend(files_below(&root.join(folder), root));
    }
    let sources = paths.into_iter().filter(|path| path.ends_with(".rs"));
    sources.map(|path| read(root, path)).collect()
}

fn read(root: &Path, path: String) -> SourceFile {
    let text = fs::read_to_string(root.join(&path)).expect("UTF-8");
    let code = code_of(&text);
    SourceFile { path, text, code }
}

/// Paths of all files below `folder`, relative to `root`; none if there is no such folder.
fn files_below(folder: &Path, root: &Path) -> Vec<String> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut paths: Vec<PathBuf> = entries.map(|e| e.expect("an entry").path()).collect();
    paths.sort();
    let mut names = Vec::new();
    for path in paths {
        if path.is_dir() {
            names.extend(files_below(&path, root))
        } else {
            let name = path.strip_prefix(root).expect("below the root");
            names.push(name.to_string_lossy().replace('\\', "/"));
        }
    }
    names
}

/// The modules that follow `root::` in `code`, also within braces: `crate::{bvh::Bvh, scene::{A,
/// B}}`.
pub fn imported(code: &str, root: &str) -> BTreeSet<String> {
    let compact: String = code.split_whitespace().collect::<Vec<_>>().join(" ");
    let compact = compact.replace(" ::", "::").replace(":: ", "::");
    let mut rooms = BTreeSet::new();
    for position in places(&compact, root) {
        let Some(rest) = compact[position + root.len()..].strip_prefix("::") else {
            continue;
        };
        match rest.strip_prefix('{') {
            Some(list) => rooms.extend(firsts_of_list(list)),
            None => rooms.extend(first_word(rest)),
        }
    }
    rooms
}

fn first_word(text: &str) -> Option<String> {
    let part = |c: char| c.is_alphanumeric() || c == '_' || c == '*';
    let word: String = text.trim_start().chars().take_while(|&c| part(c)).collect();
    (!word.is_empty()).then_some(word)
}

/// The first word of each entry of a braced list, up to its closing brace.
fn firsts_of_list(list: &str) -> Vec<String> {
    let (mut words, mut depth, mut start) = (Vec::new(), 0, 0);
    for (offset, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth > 0 => depth -= 1,
            ',' | '}' if depth == 0 => {
                words.extend(first_word(&list[start..offset]));
                start = offset + 1;
                if c == '}' {
                    break;
                }
            }
            _ => {}
        }
    }
    words
}

/// Returns true if the code names the crate `name`: as the first part of a path, unless a module of
/// that name is imported.
pub fn imported_crate(code: &str, name: &str) -> bool {
    let is_room = || {
        ["crate", "phalanx"]
            .iter()
            .any(|root| imported(code, root).contains(name))
    };
    let first = |offset: usize| match code[..offset].trim_end().strip_suffix("::") {
        Some(path) => path.ends_with([' ', ';', '{', '(', ',']),
        None => true,
    };
    let goes_on = |offset: usize| {
        let rest = code[offset + name.len()..].trim_start();
        rest.starts_with("::")
            || ["use", "crate"]
                .iter()
                .any(|w| code[..offset].trim_end().ends_with(w))
    };
    places(code, name)
        .into_iter()
        .any(|offset| first(offset) && goes_on(offset))
        && !is_room()
}
