//! Text tables: labelled rows, and the numbers in them.

use phalanx::files::shown_text;

pub use phalanx::report::{aligned, bytes};

/// Labelled rows, with the labels in a separate column.
pub fn lines(rows: &[(&str, String)]) -> String {
    let width = rows
        .iter()
        .fold(12, |width, (label, _)| label.len().max(width));
    let row = |(label, value): &(&str, String)| format!("{label:<width$} {}\n", shown_text(value));
    rows.iter().map(row).collect()
}

/// 1234567 as 1,234,567.
pub fn grouped(number: u64) -> String {
    phalanx::report::grouped(&number.to_string(), ',')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped_by_thousands() {
        let cases = [
            (0, "0"),
            (999, "999"),
            (1000, "1,000"),
            (1_234_567, "1,234,567"),
        ];
        for (number, text) in cases {
            assert_eq!(grouped(number), text);
        }
    }
}
