//! Text tables: labelled rows, and the numbers in them.

use phalanx::files::shown_text;

/// Labelled rows, with the labels in a separate column.
pub fn lines(rows: &[(&str, String)]) -> String {
    let width = rows
        .iter()
        .fold(12, |width, (label, _)| label.len().max(width));
    let row = |(label, value): &(&str, String)| format!("{label:<width$} {}\n", shown_text(value));
    rows.iter().map(row).collect()
}

/// Rows in columns, one line each: the first column left-aligned, the others right-aligned.
pub fn aligned(rows: &[Vec<String>]) -> Vec<String> {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let line = |row: &Vec<String>| {
        let mut line = String::new();
        for (cell, &width) in row.iter().zip(&widths) {
            line.push_str(&if line.is_empty() {
                format!("{cell:<width$}")
            } else {
                format!("  {cell:>width$}")
            });
        }
        line
    };
    rows.iter().map(line).collect()
}

/// 1234567 as 1,234,567.
pub fn grouped(number: u64) -> String {
    phalanx::report::grouped(&number.to_string(), ',')
}

/// Bytes in the unit that gives one to four digits before the decimal point.
pub fn bytes(number: u64) -> String {
    let mut amount = number as f64 / 1024.0;
    let mut unit = "KiB";
    for larger in ["MiB", "GiB"] {
        if amount >= 1024.0 {
            (amount, unit) = (amount / 1024.0, larger);
        }
    }
    format!("{amount:.1} {unit}")
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

    #[test]
    fn bytes_get_a_fitting_unit() {
        let cases = [
            (512, "0.5 KiB"),
            (3 << 20, "3.0 MiB"),
            (5 << 40, "5120.0 GiB"),
        ];
        for (number, text) in cases {
            assert_eq!(bytes(number), text);
        }
    }
}
