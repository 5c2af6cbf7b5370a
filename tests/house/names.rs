//! Names: each type has a unique one, and abandoned names stay unused.

use crate::source::{SourceFile, everything, places, sources};
use std::collections::BTreeMap;

/// Types that may be defined more than once, with the number of definitions and the reason.
const TWICE: [(&str, usize, &str); 2] = [
    (
        "Native",
        2,
        "one alias under two cfgs: sixteen lanes or eight",
    ),
    (
        "Bvh",
        2,
        "of the build's level and of the machine's: programs exchange one for the other",
    ),
];

/// Old names, one per line: a `type` is defined nowhere, a `word` appears nowhere in code, a `file`
/// is not a module of `src`, a `local` is no variable: a preposition or a participle hides what the
/// value is.
const OLD: &str = include_str!("old_names.txt");

/// Names of the types that `code` defines. Associated types belong to their traits and do not
/// count.
fn types_defined(code: &str) -> Vec<&str> {
    let mut names = Vec::new();
    // One flag for each open brace: it belongs to an `impl` or a trait.
    let (mut open, mut start) = (Vec::<bool>::new(), 0);
    for (offset, c) in code.char_indices() {
        if !matches!(c, '{' | '}' | ';') {
            continue;
        }
        let head = &code[start..offset];
        start = offset + 1;
        let associated = open.last().copied().unwrap_or_default();
        let words: Vec<&str> = head.split_whitespace().collect();
        for pair in words.windows(2) {
            let kind = ["struct", "enum", "union", "trait"].contains(&pair[0]);
            if kind || (pair[0] == "type" && !associated) {
                let part = |c: char| c.is_alphanumeric() || c == '_';
                let name = &pair[1][..pair[1].find(|c| !part(c)).unwrap_or(pair[1].len())];
                if name.starts_with(char::is_uppercase) {
                    names.push(name);
                }
            }
        }
        match c {
            '{' => open.push(words.iter().any(|w| *w == "trait" || w.starts_with("impl"))),
            '}' => drop(open.pop()),
            _ => {}
        }
    }
    names
}

#[test]
fn definitions_are_found() {
    let code = "pub struct A<T>(T); impl X for A { type Output = B; fn f() { type C = u8; } } \
                pub(crate) enum D { E } trait F { type G; } mod m { union H { a: u8 } }";
    assert_eq!(types_defined(code), ["A", "C", "D", "F", "H"]);
}

#[test]
fn no_two_types_share_a_name() {
    let all = everything();
    let mut places: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for source in &all {
        for name in types_defined(&source.code) {
            places.entry(name).or_default().push(&source.path);
        }
    }
    for (name, count, why) in TWICE {
        let definitions = places.remove(name).unwrap_or_default();
        assert_eq!(definitions.len(), count, "{name} ({why}): {definitions:?}");
    }
    let twice: Vec<String> = places
        .iter()
        .filter(|(_, paths)| paths.len() > 1)
        .map(|(name, paths)| format!("{name}: {}", paths.join(", ")))
        .collect();
    assert!(twice.is_empty(), "{}", twice.join("\n"));
}

/// Old names of one kind.
fn old(kind: &str) -> Vec<&'static str> {
    let rows = OLD.lines().filter_map(|line| line.strip_prefix(kind));
    let names: Vec<&str> = rows.map(str::trim).collect();
    assert!(names.len() > 5, "only {} of {kind}", names.len());
    names
}

#[test]
fn old_type_names_stay_unused() {
    let (types, words) = (old("type "), old("word "));
    let mut wrong = Vec::new();
    for source in &everything() {
        let defined = types_defined(&source.code);
        for name in types.iter().filter(|name| defined.contains(name)) {
            wrong.push(format!("{} defines {name}", source.path));
        }
        for name in words.iter().filter(|name| source.text.contains(**name)) {
            for line in source.lines_with(name) {
                wrong.push(format!("{}:{line}: {name}", source.path));
            }
            for line in mentions(source, name) {
                wrong.push(format!("{}:{line}: {name} in a comment", source.path));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Lines on which a comment names `name` as code: in backticks, or in an example.
fn mentions(source: &SourceFile, name: &str) -> Vec<usize> {
    let mut lines = Vec::new();
    let mut example = false;
    for (line, number) in source.text.lines().zip(1..) {
        let line = line.trim_start();
        if !line.starts_with("//") {
            example = false;
            continue;
        }
        if line.contains("```") {
            example = !example;
            continue;
        }
        let mut spans = line.split('`').skip(1).step_by(2);
        let quoted = spans.any(|span| !places(span, name).is_empty());
        if quoted || (example && !places(line, name).is_empty()) {
            lines.push(number);
        }
    }
    lines
}

#[test]
fn old_file_names_stay_unused() {
    let files = old("file ");
    let mut wrong = Vec::new();
    for source in &sources() {
        let module = source.path.trim_end_matches(".rs");
        let module = module.strip_suffix("/mod").unwrap_or(module);
        let module = format!("/{module}");
        for name in &files {
            if module.ends_with(&format!("/{name}")) {
                wrong.push(format!("src/{}: {name}", source.path));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Lines on which `name` stands for a value: not behind a dot or in a path, where it is an item or
/// a field, nor before a colon, where it may be a field (a parameter is seen where it is used).
fn variable_lines(code: &str, name: &str) -> Vec<usize> {
    let is_variable = |offset: &usize| {
        let (before, after) = (code[..*offset].trim_end(), &code[offset + name.len()..]);
        let is_item = before.ends_with(['.', '\'', '$']) && !before.ends_with("..");
        let is_function = before.ends_with("fn") || after.starts_with(['(', '!']);
        !(is_item || is_function || before.ends_with("::") || after.starts_with(':'))
    };
    let line = |offset: usize| code[..offset].matches('\n').count() + 1;
    let positions = places(code, name).into_iter().filter(is_variable);
    positions.map(line).collect()
}

#[test]
fn variables_are_told_from_fields_and_functions() {
    let code = "fn said(a: X) { a.said + said() + X::said }\nstruct A { said: u8 }\n\
                fn f(b: A, said: u8) {\nA { said }; }\nfn g() {\nlet (a, mut said) = h();\n\
                0..said }";
    assert_eq!(variable_lines(code, "said"), [4, 6, 7]);
}

#[test]
fn locals_are_nouns() {
    let names = old("local ");
    let mut wrong = Vec::new();
    for source in &everything() {
        for name in &names {
            let quoted = format!("`{name}`");
            let comments =
                source.text.lines().zip(1..).filter(|(line, _)| {
                    line.trim_start().starts_with("//") && line.contains(&quoted)
                });
            let lines = variable_lines(&source.code, name).into_iter();
            for line in lines.chain(comments.map(|(_, line)| line)) {
                wrong.push(format!("{}:{line}: {name}", source.path));
            }
        }
    }
    assert!(
        wrong.is_empty(),
        "{} of them:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}
