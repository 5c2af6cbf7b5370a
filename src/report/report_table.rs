//! Tables, to be printed for a terminal or as Markdown, or shown on a page.

use super::text::{markdown, wrapped};

/// A table with its title.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportTable<C = String> {
    /// Title, which says what the rows are.
    pub title: String,
    /// Names of the columns.
    pub head: Vec<String>,
    /// Number of columns of text, which are flush left.
    pub texts: usize,
    /// Number of columns that name a row: every block of a wide table begins with them.
    pub names: usize,
    /// Columns that stay in one block with the column before them.
    pub joined: Vec<usize>,
    /// Cells.
    pub rows: Vec<Vec<C>>,
    /// Explanation, in a line below.
    pub note: String,
}

impl<C> ReportTable<C> {
    /// A table without rows. Names of columns are written as `scene | rays | kernel`; the first
    /// `texts` are columns of text, which name the rows.
    pub fn new(title: impl Into<String>, head: &str, texts: usize) -> ReportTable<C> {
        ReportTable {
            title: title.into(),
            head: head.split(" | ").map(str::to_owned).collect(),
            texts,
            names: texts,
            joined: Vec::new(),
            rows: Vec::new(),
            note: String::new(),
        }
    }

    /// The same table with these rows.
    pub fn with(self, rows: impl IntoIterator<Item = Vec<C>>) -> ReportTable<C> {
        ReportTable {
            rows: rows.into_iter().collect(),
            ..self
        }
    }
}

impl ReportTable {
    /// The columns under their heads, in blocks below each other where they are wider than `width`.
    pub fn fitted(&self, width: usize) -> String {
        let widths: Vec<usize> = (0..self.head.len())
            .map(|column| 2 + column_width(self.lines(), column))
            .collect();
        let always: usize = widths.iter().take(self.names).sum();
        let mut blocks: Vec<Vec<usize>> = Vec::new();
        let mut used = 0;
        for column in self.names..widths.len() {
            let followers = (column + 1..).take_while(|next| self.joined.contains(next));
            let needed = widths[column] + followers.map(|next| widths[next]).sum::<usize>();
            let may_begin = !self.joined.contains(&column);
            if blocks.is_empty() || may_begin && used + needed > width {
                blocks.push((0..self.names).collect());
                used = always;
            }
            used += widths[column];
            if let Some(block) = blocks.last_mut() {
                block.push(column);
            }
        }
        let blocks = blocks.iter().map(|columns| self.block(columns));
        blocks.collect::<Vec<_>>().join("\n")
    }

    /// Columns under their heads.
    fn block(&self, columns: &[usize]) -> String {
        let cells = |line: &Vec<String>| columns.iter().map(|&i| line[i].clone()).collect();
        let rows: Vec<Vec<String>> = self.lines().map(cells).collect();
        let texts = columns.iter().filter(|&&i| i < self.texts).count();
        let lines = aligned(&rows, texts).into_iter();
        lines
            .map(|line| format!("  {}\n", line.trim_end()))
            .collect()
    }

    fn lines(&self) -> impl Iterator<Item = &Vec<String>> {
        std::iter::once(&self.head).chain(&self.rows)
    }

    /// The table with title and note for a terminal of `width` columns.
    pub fn text(&self, width: usize) -> String {
        let title = wrapped(&self.title, "", width);
        title + &self.fitted(width) + &wrapped(&self.note, "  ", width)
    }

    /// Head and rows as Markdown, each cell as `escape` returns it.
    pub fn markdown_rows(&self, escape: fn(&str) -> String) -> String {
        let line = |cells: &Vec<String>| {
            let cells: Vec<String> = cells.iter().map(|cell| escape(cell)).collect();
            format!("| {} |\n", cells.join(" | "))
        };
        let rule = |column| if column < self.texts { "---|" } else { "---:|" };
        let rules: String = (0..self.head.len()).map(rule).collect();
        let rows: String = self.rows.iter().map(line).collect();
        format!("{}|{rules}\n{rows}", line(&self.head))
    }

    /// The table with title and note as Markdown.
    pub fn markdown(&self) -> String {
        let mut text = format!("\n{}:\n\n", markdown(&self.title));
        text += &self.markdown_rows(markdown);
        if !self.note.is_empty() {
            text += &format!("\n{}\n", markdown(&self.note));
        }
        text
    }
}

/// Rows in columns, one line each, two blanks between columns: the first `texts` columns flush
/// left, the others flush right.
pub fn aligned(rows: &[Vec<String>], texts: usize) -> Vec<String> {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns)
        .map(|column| column_width(rows.iter(), column))
        .collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).enumerate();
        let padded = cells.map(|(column, (cell, &width))| {
            if column < texts {
                format!("{cell:<width$}")
            } else {
                format!("{cell:>width$}")
            }
        });
        padded.collect::<Vec<_>>().join("  ")
    };
    rows.iter().map(line).collect()
}

/// Width of a column in letters.
fn column_width<'r>(rows: impl Iterator<Item = &'r Vec<String>>, column: usize) -> usize {
    let cells = rows.filter_map(|row| row.get(column));
    cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned() {
        let rows = [["terrain – hügel", "7"], ["a", "12.25"]];
        let rows = rows.map(|row| row.map(str::to_owned).to_vec());
        let table = ReportTable::new("", "scene | rate", 1).with(rows);
        assert_eq!(
            table.fitted(80),
            "  scene             rate\n  terrain – hügel      7\n  a                12.25\n"
        );
    }

    #[test]
    fn columns_that_do_not_fit_go_into_further_blocks() {
        let row = ["a", "11111", "22222"].map(str::to_owned).to_vec();
        let mut table = ReportTable::new("", "x | one | two", 1).with([row]);
        let wide = table.fitted(17);
        assert_eq!(wide, "  x    one    two\n  a  11111  22222\n");
        let narrow = table.fitted(16);
        assert_eq!(narrow, "  x    one\n  a  11111\n\n  x    two\n  a  22222\n");
        table.joined = vec![2];
        assert_eq!(table.fitted(16), wide);
    }
}
