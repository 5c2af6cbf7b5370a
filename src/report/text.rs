//! Tables for the terminal.

/// Columns under their heads, two blanks between them: the first `left` flush left, the others
/// flush right.
pub(super) fn aligned(head: &[&str], rows: &[Vec<String>], left: usize) -> String {
    let head = head.iter().map(ToString::to_string).collect();
    let lines: Vec<&Vec<String>> = std::iter::once(&head).chain(rows).collect();
    let width = |column: usize| {
        let cells = lines.iter().filter_map(|line| line.get(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..head.len()).map(width).collect();
    let mut text = String::new();
    for line in lines {
        let cells = line.iter().zip(&widths).enumerate();
        let padded = cells.map(|(column, (cell, &width))| match column < left {
            true => format!("{cell:<width$}"),
            false => format!("{cell:>width$}"),
        });
        let line = padded.collect::<Vec<_>>().join("  ");
        text.push_str("  ");
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}

/// Layout of a table that may be wider than the terminal.
#[derive(Clone, Copy, Debug, Default)]
pub struct ColumnLayout<'c> {
    /// Number of columns that are flush left.
    pub left: usize,
    /// Number of columns that every block of the table begins with.
    pub names: usize,
    /// Columns that stay in one block with the column before them.
    pub joined: &'c [usize],
}

/// Columns under their heads, in blocks below each other where they are wider than `width`.
pub fn fitted_table(
    head: &[&str],
    rows: &[Vec<String>],
    layout: ColumnLayout,
    width: usize,
) -> String {
    let ColumnLayout {
        left,
        names,
        joined,
    } = layout;
    let cells = |column: usize| {
        let below = rows.iter().filter_map(move |row| row.get(column));
        std::iter::once(head[column]).chain(below.map(String::as_str))
    };
    let wide = |column: usize| 2 + cells(column).map(|c| c.chars().count()).max().unwrap_or(0);
    let always: usize = (0..names.min(head.len())).map(wide).sum();
    let mut blocks: Vec<Vec<usize>> = Vec::new();
    let mut used = 0;
    for column in names..head.len() {
        let followers = column + 1..head.len();
        let group = followers.take_while(|next| joined.contains(next));
        let needed = wide(column) + group.map(wide).sum::<usize>();
        let may_begin = !joined.contains(&column);
        if blocks.is_empty() || may_begin && used + needed > width {
            blocks.push((0..names).collect());
            used = always;
        }
        used += wide(column);
        if let Some(block) = blocks.last_mut() {
            block.push(column);
        }
    }
    let block_text = |columns: &Vec<usize>| {
        let head: Vec<&str> = columns.iter().map(|&column| head[column]).collect();
        let pick = |row: &Vec<String>| {
            let cells = columns.iter().map(|&column| row.get(column));
            cells
                .map(|cell| cell.cloned().unwrap_or_default())
                .collect()
        };
        let rows: Vec<Vec<String>> = rows.iter().map(pick).collect();
        aligned(&head, &rows, left)
    };
    let blocks: Vec<String> = blocks.iter().map(block_text).collect();
    blocks.join("\n")
}

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

/// A share as a signed percentage: -0.148 is `-14.8 %`.
pub(super) fn percent(share: f64) -> String {
    // A number that rounds to zero has no sign.
    let tenths = (share * 1000.0).round() / 10.0;
    if tenths == 0.0 {
        return "0.0 %".to_owned();
    }
    format!("{tenths:+.1} %")
}

/// A rate with three significant digits, which is what it is worth.
pub fn rate(mrays: f64) -> String {
    let decimals = match mrays {
        r if r >= 99.95 => 0,
        r if r >= 9.995 => 1,
        _ => 2,
    };
    format!("{mrays:.decimals$}")
}

/// A threshold as it was given: 0.0005 is `0.05 %`.
pub(super) fn threshold(share: f64) -> String {
    let percent = format!("{:.6}", 100.0 * share);
    format!("{} %", percent.trim_end_matches('0').trim_end_matches('.'))
}

/// The day of a moment such as `2026-11-27T09:00:00Z`.
pub(super) fn day(moment: &str) -> &str {
    moment.split('T').next().unwrap_or_default()
}

/// The first letters of a commit.
pub(super) fn short_commit(commit: &str) -> String {
    commit.chars().take(8).collect()
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
    let kept = most.saturating_sub(1);
    let tail: String = text.chars().skip(length - kept).collect();
    format!("…{tail}")
}

/// Text with Markdown's special characters escaped.
pub(super) fn markdown(text: &str) -> String {
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

/// A row of a table in Markdown, its cells as they are.
pub(super) fn markdown_row(cells: &[String]) -> String {
    format!("| {} |\n", cells.join(" | "))
}

/// `3 scenes`, `1 scene`.
pub(super) fn counted(count: usize, noun: &str) -> String {
    match count {
        1 => format!("1 {noun}"),
        _ => format!("{count} {noun}s"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned() {
        let rows = [
            vec!["terrain – hügel".into(), "7".into()],
            vec!["a".into(), "12.25".into()],
        ];
        let text = aligned(&["scene", "rate"], &rows, 1);
        assert_eq!(
            text,
            "  scene             rate\n  terrain – hügel      7\n  a                12.25\n"
        );
    }

    #[test]
    fn columns_that_do_not_fit_go_into_further_blocks() {
        let rows = [vec!["a".into(), "11111".into(), "22222".into()]];
        let head = ["x", "one", "two"];
        let mut layout = ColumnLayout {
            left: 1,
            names: 1,
            joined: &[],
        };
        let wide = fitted_table(&head, &rows, layout, 17);
        assert_eq!(wide, "  x    one    two\n  a  11111  22222\n");
        let narrow = fitted_table(&head, &rows, layout, 16);
        assert_eq!(narrow, "  x    one\n  a  11111\n\n  x    two\n  a  22222\n");
        layout.joined = &[2];
        assert_eq!(fitted_table(&head, &rows, layout, 16), wide);
    }

    #[test]
    fn paragraphs_are_wrapped() {
        assert_eq!(wrapped("one two three", "  ", 9), "  one two\n  three\n");
        assert_eq!(wrapped("one two three", "  ", 8), "  one\n  two\n  three\n");
        assert_eq!(wrapped(" ", "  ", 9), "");
    }

    #[test]
    fn numbers_as_text() {
        assert_eq!(percent(-0.1484), "-14.8 %");
        assert_eq!(percent(0.0321), "+3.2 %");
        assert_eq!(percent(-0.0001), "0.0 %");
        assert_eq!(
            [rate(123.4), rate(99.96), rate(12.34), rate(1.234)],
            ["123", "100", "12.3", "1.23"]
        );
        assert_eq!(threshold(0.0005), "0.05 %");
        assert_eq!(short_name("standard:terrain:1M", 6), "…in:1M");
        assert_eq!(counted(1, "row") + " " + &counted(0, "row"), "1 row 0 rows");
    }
}
