//! File names in messages.

use std::path::Path;

/// A path for a message, with control characters escaped: one in a name must not end the message's
/// line, nor look like another message.
pub fn shown_path(path: impl AsRef<Path>) -> String {
    shown_text(&path.as_ref().to_string_lossy())
}

/// A text for one line of a message, with control characters escaped.
pub fn shown_text(text: &str) -> String {
    escaped(text, char::is_control)
}

/// A text with the characters of a kind escaped.
pub fn escaped(text: &str, of_kind: impl Fn(char) -> bool) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        match of_kind(c) {
            true => shown.extend(c.escape_default()),
            false => shown.push(c),
        }
    }
    shown
}

/// A text in a line of a message, between backticks.
pub fn quoted_text(text: &str) -> String {
    format!("`{}`", shown_text(text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_on_their_line() {
        let name = Path::new("ä b/we\nird\t\u{1b}.png");
        assert_eq!(shown_path(name), "ä b/we\\nird\\t\\u{1b}.png");
        assert_eq!(quoted_text("a\nb"), "`a\\nb`");
    }
}
