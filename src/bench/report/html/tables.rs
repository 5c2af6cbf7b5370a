//! Tables that scroll in a box of their own, so that the page never scrolls sideways.

use maud::{Markup, html};

/// A table with a caption. Numbers are aligned right, cells of the first `texts` columns left.
pub(super) struct HtmlTable {
    pub(super) caption: String,
    pub(super) head: Vec<String>,
    /// Number of columns that hold words.
    pub(super) texts: usize,
    pub(super) rows: Vec<Vec<Markup>>,
}

/// A cell of text.
pub(super) fn cell(text: impl AsRef<str>) -> Markup {
    html! { (text.as_ref()) }
}

impl HtmlTable {
    /// The table; nothing where it has no rows.
    pub(super) fn markup(&self) -> Markup {
        if self.rows.is_empty() {
            return html! {};
        }
        html! {
            div.scroll role="region" tabindex="0" aria-label=(self.caption) {
                table {
                    caption { (self.caption) }
                    thead { tr {
                        @for (i, name) in self.head.iter().enumerate() {
                            th scope="col" class=[(i < self.texts).then_some("t")] { (name) }
                        }
                    } }
                    tbody {
                        @for row in &self.rows { (self.row(row)) }
                    }
                }
            }
        }
    }

    fn row(&self, row: &[Markup]) -> Markup {
        html! { tr {
            @for (i, cell) in row.iter().enumerate() {
                @if i == 0 {
                    th scope="row" { (cell) }
                } @else if i < self.texts {
                    td.t { (cell) }
                } @else {
                    td { (cell) }
                }
            }
        } }
    }

    /// The table behind a line to click on.
    pub(super) fn folded(&self) -> Markup {
        folded(&self.caption, self.markup())
    }
}

/// Something long behind a line to click on.
pub(super) fn folded(title: &str, inside: Markup) -> Markup {
    html! { details { summary { (title) } (inside) } }
}
