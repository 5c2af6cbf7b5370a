//! File names in messages.

use std::path::Path;

/// Returns true for characters that affect how others are displayed: control characters, line and
/// paragraph separators, and invisible format characters (U+202E reverses a line). These are the
/// general categories Cc, Zl, Zp and Cf of Unicode 16, except Cf's visible number signs.
pub fn steers(c: char) -> bool {
    c.is_control()
        || matches!(
            u32::from(c),
            0xad | 0x61c | 0x180e | 0xfeff | 0x200b..=0x200f | 0x2028..=0x202e | 0x2060..=0x206f
                | 0xfff9..=0xfffb | 0x1bca0..=0x1bca3 | 0x1d173..=0x1d17a | 0xe0000..=0xe007f
        )
}

/// A path for a message, with characters that [steer](steers) the display escaped: a name must not
/// end the message's line, or look like another message or another name.
pub fn shown_path(path: impl AsRef<Path>) -> String {
    shown_text(&path.as_ref().to_string_lossy())
}

/// A text for one line of a message, with characters that [steer](steers) the display escaped.
pub fn shown_text(text: &str) -> String {
    escaped(text, steers)
}

/// A text with the characters of a kind escaped.
pub fn escaped(text: &str, of_kind: impl Fn(char) -> bool) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if of_kind(c) { shown.extend(c.escape_default()) } else { shown.push(c) }
    }
    shown
}

/// A text in a line of a message, between backticks.
pub fn quoted_text(text: &str) -> String {
    format!("`{}`", shown_text(text))
}

/// Characters of a text that [`quoted`] repeats: a line of a file may be megabytes long.
pub const QUOTED_CHARS: usize = 40;

/// The beginning of a text in a form that a message may repeat: short, and without control
/// characters for a terminal.
pub fn quoted(text: &str) -> String {
    quoted_up_to(text, QUOTED_CHARS)
}

/// As [`quoted`], for at most this many characters.
pub fn quoted_up_to(text: &str, most: usize) -> String {
    let end = text.char_indices().nth(most).map(|(end, _)| end);
    let shown = shown_text(&text[..end.unwrap_or(text.len())]);
    let more = if end.is_some() { "…" } else { "" };
    format!("`{shown}{more}`")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_on_their_line() {
        let name = Path::new("ä b/we\nird\t\u{1b}.png");
        assert_eq!(shown_path(name), "ä b/we\\nird\\t\\u{1b}.png");
        assert_eq!(quoted_text("a\nb"), "`a\\nb`");
        let turned = "a\u{202e}gnp.\u{feff}\u{ad}\u{200d}\u{e0041}\u{2028}";
        let shown = "a\\u{202e}gnp.\\u{feff}\\u{ad}\\u{200d}\\u{e0041}\\u{2028}";
        assert_eq!(shown_text(turned), shown);
        assert_eq!(
            shown_text("e\u{301}\u{3000}🙂\u{fe0f}"),
            "e\u{301}\u{3000}🙂\u{fe0f}"
        );
    }
}
