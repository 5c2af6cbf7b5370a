//! Who may import whom, which file owns which crate, and what may not stand in the sources at all.
//!
//! Read from the text of `src`: comments and string literals are blanked out first, then every path that starts with
//! `crate::` (or, in the binary, `phalanx::`) is looked up in the table.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// A room, what it may import, and why no more.
struct Row {
    room: &'static str,
    may: &'static [&'static str],
    why: &'static str,
}

const fn row(room: &'static str, may: &'static [&'static str], why: &'static str) -> Row {
    Row { room, may, why }
}

const TABLE: [Row; 16] = [
    row("scene", &[], "what is traced does not depend on how"),
    row("lanes", &[], "numbers know nothing of rays"),
    row("sampling", &[], "a definition both engines share"),
    row("formats", &["scene"], "bytes become a scene, no more"),
    row(
        "standard",
        &["scene"],
        "a generator is a reader without a file",
    ),
    row("bvh", &["scene"], "a tree of boxes, whoever walks it"),
    row(
        "camera",
        &["scene", "lanes"],
        "rays of a view, scalar and eight-wide",
    ),
    row(
        "packet",
        &["lanes"],
        "columns of lanes, whatever they are for",
    ),
    row(
        "trace",
        &["bvh", "scene", "packet", "lanes"],
        "finds hits; what they look like is not its business",
    ),
    row(
        "shade",
        &["scene", "packet", "lanes", "sampling"],
        "emits queues and never traces: data goes forward only",
    ),
    row(
        "render",
        &[
            "scene", "camera", "bvh", "packet", "trace", "shade", "lanes",
        ],
        "the one place where the stages meet; reads no files, knows no oracle",
    ),
    row(
        "oracle",
        &["scene", "camera", "sampling"],
        "a proof must not share what it proves",
    ),
    row(
        "frame",
        &["scene", "camera", "bvh", "render", "oracle", "trace"],
        "chooses an engine and runs it",
    ),
    row(
        "image",
        &["scene", "render"],
        "writes films by the scene's tone",
    ),
    row("isa", &[], "asks the processor"),
    row("cli", &[], "sees the library from outside, as phalanx::"),
];

/// Crates that only some rooms (or files) may name.
const OWNERS: [(&str, &[&str], &str); 4] = [
    (
        "wide",
        &["lanes/types.rs"],
        "the vector crate can be exchanged in one file",
    ),
    (
        "obvhs",
        &["bvh/", "peers/"],
        "builders can be exchanged in one room",
    ),
    (
        "image",
        &["image.rs", "image/"],
        "encoders can be exchanged in one room",
    ),
    (
        "core_affinity",
        &["render/workers.rs"],
        "threads are pinned in one place",
    ),
];

/// What breaks the same bits on every machine, and what to use instead.
const BANNED: [(&str, &str); 11] = [
    ("mul_add", "fuses or not by build: write a * b + c"),
    (".recip(", "an approximation in vector crates: divide"),
    ("recip_sqrt", "an approximation: divide by the root"),
    ("powf", "the system's libm: sampling::pow"),
    ("powi", "order of products not specified: write them out"),
    (".sin(", "the system's libm: libm::sin in f64"),
    (".cos(", "the system's libm: libm::cos in f64"),
    (".tan(", "the system's libm: libm::tan in f64"),
    (".sin_cos(", "the system's libm: libm::sincos in f64"),
    (
        "lerp",
        "fuses or not by build for SIMD-backed types: write it out",
    ),
    ("algebraic_", "may be reassociated"),
];

/// Files that may hold `unsafe`.
const UNSAFE_FILES: [&str; 0] = [];

/// Files of the crate's root, which belong to no room.
const ROOTS: [&str; 2] = ["lib.rs", "main.rs"];

struct Source {
    /// Relative to `src`, with forward slashes.
    path: String,
    /// The text without comments and literals, of the same lines.
    code: String,
}

impl Source {
    /// The first component of the path, without its ending.
    fn room(&self) -> &str {
        let first = self.path.split('/').next().unwrap_or_default();
        first.strip_suffix(".rs").unwrap_or(first)
    }

    fn is_root(&self) -> bool {
        ROOTS.contains(&self.path.as_str())
    }

    /// Lines (from 1) on which `word` stands with no identifier character around it.
    fn lines_with(&self, word: &str) -> Vec<usize> {
        let numbered = self.code.lines().zip(1..);
        let found = numbered.filter(|(line, _)| !places(line, word).is_empty());
        found.map(|(_, number)| number).collect()
    }
}

/// Byte places of `word` in `text` where it is not part of a longer identifier.
fn places(text: &str, word: &str) -> Vec<usize> {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    let starts_inside = |c: Option<char>| word.starts_with(part) && c.is_some_and(part);
    let goes_on =
        |c: Option<char>| word.ends_with(part) && !word.ends_with('_') && c.is_some_and(part);
    let found = text.match_indices(word).filter(|&(at, _)| {
        let before = text[..at].chars().next_back();
        let after = text[at + word.len()..].chars().next();
        !starts_inside(before) && !goes_on(after)
    });
    found.map(|(at, _)| at).collect()
}

/// Blanks comments, string and character literals; line breaks stay.
fn code_of(text: &str) -> String {
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
        // A literal keeps its place, so that what stands around it does not grow together.
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
    let found = (from..rest.len()).find(|&k| end(&rest[k..]));
    found.map_or(rest.len(), |k| k + with)
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

fn sources() -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    let mut folders = vec![root.clone()];
    while let Some(folder) = folders.pop() {
        let entries = fs::read_dir(&folder).expect("a readable folder");
        let mut paths: Vec<PathBuf> = entries.map(|e| e.expect("an entry").path()).collect();
        paths.sort();
        for path in paths {
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let name = path.strip_prefix(&root).expect("below src");
            let name = name.to_string_lossy().replace('\\', "/");
            assert!(name.ends_with(".rs"), "{name} is no Rust source");
            let text = fs::read_to_string(&path).expect("UTF-8");
            let code = code_of(&text);
            found.push(Source { path: name, code });
        }
    }
    assert!(found.len() > 20, "only {} sources found", found.len());
    found
}

/// The rooms that follow `root::` in `code`, also within braces: `crate::{bvh::Bvh, scene::{A, B}}`.
fn imported(code: &str, root: &str) -> BTreeSet<String> {
    let compact: String = code.split_whitespace().collect::<Vec<_>>().join(" ");
    let compact = compact.replace(" ::", "::").replace(":: ", "::");
    let mut rooms = BTreeSet::new();
    for at in places(&compact, root) {
        let Some(rest) = compact[at + root.len()..].strip_prefix("::") else {
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
    for (at, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth > 0 => depth -= 1,
            ',' | '}' if depth == 0 => {
                words.extend(first_word(&list[start..at]));
                start = at + 1;
                if c == '}' {
                    break;
                }
            }
            _ => {}
        }
    }
    words
}

#[test]
fn rooms_import_what_the_table_allows() {
    let mut wrong = Vec::new();
    for source in sources().iter().filter(|s| !s.is_root()) {
        let room = source.room();
        let Some(row) = TABLE.iter().find(|row| row.room == room) else {
            wrong.push(format!("{}: no room of the table", source.path));
            continue;
        };
        for other in imported(&source.code, "crate") {
            let known = TABLE.iter().any(|row| row.room == other);
            let binary = room == "cli" && (other == "cli" || !known);
            if other != room && !row.may.contains(&other.as_str()) && !binary {
                let why = row.why;
                wrong.push(format!("{}: {room} imports {other} ({why})", source.path));
            }
        }
        let outside = !imported(&source.code, "phalanx").is_empty();
        if outside && room != "cli" {
            wrong.push(format!("{}: names its own crate", source.path));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A room above another's cannot be reached through `super` either.
#[test]
fn super_stays_within_its_room() {
    for source in sources().iter().filter(|s| !s.is_root()) {
        let room_depth = source.path.matches('/').count();
        let inner = source.code.contains("mod tests {");
        let module = source.path.ends_with("mod.rs");
        let levels = room_depth - usize::from(module) + usize::from(inner);
        let up = "super::".repeat(levels + 1);
        assert!(
            !source.code.contains(&up),
            "{} climbs out of its room",
            source.path
        );
    }
}

#[test]
fn crates_have_one_owner() {
    let mut wrong = Vec::new();
    for source in &sources() {
        for (name, owners, why) in OWNERS {
            let owned = owners.iter().any(|owner| source.path.starts_with(owner));
            let used = imported_crate(&source.code, name);
            if used && !owned {
                wrong.push(format!("{} names {name}: {why}", source.path));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Whether the code names the crate `name`: as the first part of a path, unless a room of that name is imported.
fn imported_crate(code: &str, name: &str) -> bool {
    let room = ["crate", "phalanx"]
        .iter()
        .any(|root| imported(code, root).contains(name));
    let first = |at: usize| match code[..at].trim_end().strip_suffix("::") {
        Some(path) => path.ends_with([' ', ';', '{', '(', ',']),
        None => true,
    };
    let goes_on = |at: usize| {
        let rest = code[at + name.len()..].trim_start();
        rest.starts_with("::")
            || ["use", "crate"]
                .iter()
                .any(|w| code[..at].trim_end().ends_with(w))
    };
    !room
        && places(code, name)
            .into_iter()
            .any(|at| first(at) && goes_on(at))
}

#[test]
fn nothing_that_differs_between_machines() {
    let mut wrong = Vec::new();
    for source in &sources() {
        for (word, instead) in BANNED {
            for line in source.lines_with(word) {
                wrong.push(format!("{}:{line}: {word}: {instead}", source.path));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn unsafe_stands_in_the_files_named_for_it() {
    for source in &sources() {
        let lines = source.lines_with("unsafe");
        let named = UNSAFE_FILES.contains(&source.path.as_str());
        assert!(
            named || lines.is_empty(),
            "{}: unsafe on {lines:?}",
            source.path
        );
        assert!(
            !named || !lines.is_empty(),
            "{} is named for nothing",
            source.path
        );
    }
}

#[test]
fn the_table_reads_paths_as_the_compiler_does() {
    let code = code_of(
        "use crate::{bvh::Bvh, scene::{self, Prim}};\n// crate::shade\nlet s = \"crate::trace\";\n\
         /* crate::oracle /* nested */ crate::camera */ r#\"crate::frame\"# + '\"' + crate :: lanes::F;",
    );
    let found = imported(&code, "crate");
    let found: Vec<&str> = found.iter().map(String::as_str).collect();
    assert_eq!(found, ["bvh", "lanes", "scene"]);
    assert_eq!(places("unsafe_code unsafe", "unsafe"), [12]);
    assert!(imported_crate("use wide::{f32x8};", "wide"));
    assert!(!imported_crate("self.wide(3); crate::wide::x", "wide"));
    assert!(imported_crate("let c = image::open(p);", "image"));
    assert!(!imported_crate("use crate::image::write;", "image"));
}
