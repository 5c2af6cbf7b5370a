//! Tables that scroll in a box of their own, so that the page never scrolls sideways.

use maud::{Markup, html};

/// TableRows of cells.
pub(super) type TableRows = Vec<Vec<Markup>>;

/// A cell of text.
pub(super) fn cell(text: impl AsRef<str>) -> Markup {
    html! { (text.as_ref()) }
}

/// A table with a caption; nothing where there are no rows. Numbers are aligned right, cells of the
/// first `texts` columns left.
pub(super) fn table(
    caption: &str,
    head: &[impl AsRef<str>],
    texts: usize,
    rows: TableRows,
) -> Markup {
    let align = |column| (column < texts).then_some("t");
    html! {
        @if !rows.is_empty() {
            div.scroll role="region" tabindex="0" aria-label=(caption) {
                table {
                    caption { (caption) }
                    thead { tr {
                        @for (i, name) in head.iter().enumerate() {
                            th scope="col" class=[align(i)] { (name.as_ref()) }
                        }
                    } }
                    tbody {
                        @for row in rows { tr {
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
        }
    }
}

/// A table behind a line to click on; nothing where there are no rows.
pub(super) fn folded_table(
    caption: &str,
    head: &[impl AsRef<str>],
    texts: usize,
    rows: TableRows,
) -> Markup {
    match rows.is_empty() {
        true => html! {},
        false => folded(caption, table(caption, head, texts, rows)),
    }
}

/// Something long behind a line to click on.
pub(super) fn folded(title: &str, inside: Markup) -> Markup {
    html! { details { summary { (title) } (inside) } }
}
