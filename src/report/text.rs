//! Names, days and sentences as tables and pages show them.

use crate::Program;

/// A paragraph of at most `width` columns, each line after an indent; empty where there are no
/// words. A word that is longer has a line of its own.
pub fn wrapped(text: &str, indent: &str, width: usize) -> String {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(format!("{indent}{word}")),
        }
    }
    lines.iter().map(|line| format!("{line}\n")).collect()
}

/// The day of a moment such as `2026-11-27T09:00:00Z`.
pub fn day(moment: &str) -> &str {
    moment.split('T').next().unwrap_or_default()
}

/// The first letters of a commit.
pub(super) fn short_commit(commit: &str) -> String {
    commit.chars().take(8).collect()
}

/// The first letters of a program's commit, and whether files differed from it.
pub fn commit(program: &Program) -> Option<String> {
    let short = short_commit(program.git_revision.as_ref()?);
    Some(match program.git_dirty {
        Some(true) => format!("{short}, changed"),
        _ => short,
    })
}

/// A scene's name without the part that all standard scenes share, and only its end where it is
/// longer than `most`.
pub(super) fn short_name(scene: &str, most: usize) -> String {
    shortened(scene.strip_prefix("standard:").unwrap_or(scene), most)
}

/// The end of a text that is too long for its space, since paths differ at their ends.
pub(super) fn shortened(text: &str, most: usize) -> String {
    let length = text.chars().count();
    if length <= most {
        return text.to_owned();
    }
    let room = most.saturating_sub(1);
    let tail: String = text.chars().skip(length - room).collect();
    format!("…{tail}")
}

/// Words with commas, and "and" before the last.
pub(super) fn listed(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [one] => one.clone(),
        [most @ .., last] => format!("{} and {last}", most.join(", ")),
    }
}

/// Text with Markdown's special characters escaped.
pub fn markdown(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\\' | '`' | '*' | '_' | '[' | ']' | '|' | '<' | '>' => out.extend(['\\', c]),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paragraphs_are_wrapped() {
        assert_eq!(wrapped("one two three", "  ", 9), "  one two\n  three\n");
        assert_eq!(wrapped("one two three", "  ", 8), "  one\n  two\n  three\n");
        assert_eq!(wrapped(" ", "  ", 9), "");
        assert_eq!(short_name("standard:terrain:1M", 6), "…in:1M");
    }
}
