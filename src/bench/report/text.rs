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

/// A share as a signed percentage: -0.148 is `-14.8 %`.
pub(super) fn percent(share: f64) -> String {
    // A number that rounds to zero has no sign.
    let tenths = (share * 1000.0).round() / 10.0;
    if tenths == 0.0 {
        return "0.0 %".to_owned();
    }
    format!("{tenths:+.1} %")
}

/// A rate with as many decimals as it is worth: three significant digits.
pub(super) fn rate(mrays: f64) -> String {
    match mrays {
        r if r >= 100.0 => format!("{r:.0}"),
        r if r >= 10.0 => format!("{r:.1}"),
        r => format!("{r:.2}"),
    }
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
    fn numbers_as_text() {
        assert_eq!(percent(-0.1484), "-14.8 %");
        assert_eq!(percent(0.0321), "+3.2 %");
        assert_eq!(percent(-0.0001), "0.0 %");
        assert_eq!(
            [rate(123.4), rate(12.34), rate(1.234)],
            ["123", "12.3", "1.23"]
        );
        assert_eq!(counted(1, "row") + " " + &counted(0, "row"), "1 row 0 rows");
    }
}
