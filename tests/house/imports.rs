//! Paths to other files of the same crate, read from a file's code.

/// A path as written, with `use` trees expanded: `crate::bvh::Bvh` has three segments.
#[derive(Debug, PartialEq)]
pub struct ImportPath {
    pub segments: Vec<String>,
    /// Name under which a `use` imports it; empty outside of `use`.
    pub alias: String,
    /// Re-exported by a `pub use`.
    pub public: bool,
}

/// Words, and other characters one by one, with `::` as one.
fn tokens(code: &str) -> Vec<&str> {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    let mut tokens = Vec::new();
    let mut rest = code.trim_start();
    while let Some(first) = rest.chars().next() {
        let length = match first {
            _ if part(first) => rest.find(|c| !part(c)).unwrap_or(rest.len()),
            ':' if rest.starts_with("::") => 2,
            _ => first.len_utf8(),
        };
        tokens.push(&rest[..length]);
        rest = rest[length..].trim_start();
    }
    tokens
}

fn is_word(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// Blanks the bodies of inline test modules: tests may import anything.
fn without_tests(tokens: &[&str]) -> Vec<String> {
    let mut kept_tokens = Vec::new();
    let mut i = 0;
    while i < tokens.len() {
        let test = tokens[i..].starts_with(&["#", "[", "cfg", "(", "test", ")", "]", "mod"]);
        if test && tokens.get(i + 9) == Some(&"{") {
            let mut depth = 0;
            i += 9;
            while i < tokens.len() {
                depth += i32::from(tokens[i] == "{") - i32::from(tokens[i] == "}");
                i += 1;
                if depth == 0 {
                    break;
                }
            }
            continue;
        }
        kept_tokens.push(tokens[i].to_owned());
        i += 1;
    }
    kept_tokens
}

/// The paths in a file's code, except in inline test modules.
pub fn import_paths(code: &str) -> Vec<ImportPath> {
    let tokens = without_tests(&tokens(code));
    let tokens: Vec<&str> = tokens.iter().map(String::as_str).collect();
    let mut paths = Vec::new();
    let mut i = 0;
    while i < tokens.len() {
        if tokens[i] == "use" {
            let before = &tokens[..i];
            let public = before.ends_with(&["pub"])
                || before.ends_with(&["pub", "(", "crate", ")"])
                || before.ends_with(&["pub", "(", "super", ")"]);
            i = tree(&tokens, i + 1, &[], public, &mut paths);
            continue;
        }
        let starts = is_word(tokens[i])
            && tokens.get(i + 1) == Some(&"::")
            && (i == 0 || !["::", "."].contains(&tokens[i - 1]));
        if starts {
            let mut segments = vec![tokens[i].to_owned()];
            while tokens.get(i + 1) == Some(&"::") && tokens.get(i + 2).is_some_and(|t| is_word(t))
            {
                segments.push(tokens[i + 2].to_owned());
                i += 2;
            }
            paths.push(ImportPath {
                segments,
                alias: String::new(),
                public: false,
            });
        }
        i += 1;
    }
    paths
}

/// Expands a `use` tree that begins at token `i` below `prefix`; returns the token after it.
fn tree(
    tokens: &[&str],
    mut i: usize,
    prefix: &[String],
    public: bool,
    paths: &mut Vec<ImportPath>,
) -> usize {
    let mut segments = prefix.to_vec();
    while let Some(&token) = tokens.get(i) {
        match token {
            "::" => i += 1,
            "{" => {
                i += 1;
                while i < tokens.len() && tokens[i] != "}" {
                    i = tree(tokens, i, &segments, public, paths);
                    i += usize::from(tokens.get(i) == Some(&","));
                }
                return i + 1;
            }
            "self" if !prefix.is_empty() && segments.len() == prefix.len() => i += 1,
            _ if is_word(token) || token == "*" => {
                segments.push(token.to_owned());
                i += 1;
            }
            _ => break,
        }
        if tokens.get(i) == Some(&"as") {
            break;
        }
    }
    let mut alias = segments.last().cloned().unwrap_or_default();
    if tokens.get(i) == Some(&"as") {
        alias = tokens.get(i + 1).copied().unwrap_or_default().to_owned();
        i += 2;
    }
    paths.push(ImportPath {
        segments,
        alias,
        public,
    });
    i
}

#[test]
fn paths_are_expanded() {
    let code = "pub use a::{b, c::{self, d as e}}; use super::x::*; fn f() { crate::g::h(1).k() } \
                #[cfg(test)] mod tests { use crate::no; } self::m::N";
    let paths = import_paths(code);
    let rows = paths
        .iter()
        .map(|p| (p.segments.join("/"), p.alias.as_str(), p.public));
    let rows: Vec<_> = rows.collect();
    let row = |path: &str, alias, public| (path.to_owned(), alias, public);
    let expected = [
        row("a/b", "b", true),
        row("a/c", "c", true),
        row("a/c/d", "e", true),
        row("super/x/*", "*", false),
        row("crate/g/h", "", false),
        row("self/m/N", "", false),
    ];
    assert_eq!(rows, expected);
}
