//! Tables that scroll in a box of their own, so that the page never scrolls sideways.

use crate::report_table::ReportTable;
use maud::{Markup, Render, html};

/// A cell of text.
pub(super) fn cell(text: impl AsRef<str>) -> Markup {
    html! { (text.as_ref()) }
}

impl<C: Render> ReportTable<C> {
    /// The table with its title as caption and its note; nothing where there are no rows. Numbers
    /// are aligned right, text left.
    pub(super) fn page(&self) -> Markup {
        let align = |column| (column < self.texts).then_some("t");
        html! {
            @if !self.rows.is_empty() {
                div.scroll role="region" tabindex="0" aria-label=(self.title) {
                    table {
                        caption { (self.title) }
                        thead { tr {
                            @for (i, name) in self.head.iter().enumerate() {
                                th scope="col" class=[align(i)] { (name) }
                            }
                        } }
                        tbody {
                            @for row in &self.rows { tr {
                                @for (i, cell) in row.iter().enumerate() {
                                    @if i == 0 {
                                        th scope="row" { (cell) }
                                    } @else {
                                        td class=[align(i)] { (cell) }
                                    }
                                }
                            } }
                        }
                    }
                }
                @if !self.note.is_empty() { p.note { (self.note) } }
            }
        }
    }

    /// The table behind a line to click on; nothing where there are no rows.
    pub(super) fn folded(&self) -> Markup {
        if self.rows.is_empty() {
            html! {}
        } else {
            folded(&self.title, self.page())
        }
    }
}

/// Something long behind a line to click on.
pub(super) fn folded(title: &str, inside: Markup) -> Markup {
    html! { details { summary { (title) } (inside) } }
}
