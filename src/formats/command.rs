//! The grammar that NFF and `.test` files share: a name, then the operands that a table has for it.

use crate::diagnostics::Span;

/// A run of characters without white space, and its place.
#[derive(Clone, Copy, Debug)]
pub(super) struct TextToken<'a> {
    pub(super) text: &'a str,
    pub(super) offset: usize,
}

impl TextToken<'_> {
    pub(super) fn span(&self) -> Span {
        Span::new(self.offset, self.text.len())
    }
}

/// A row of a format's table of commands: a name, the names of its operands, and its function.
pub(super) struct CommandRow<F> {
    pub(super) name: &'static str,
    pub(super) operands: &'static str,
    pub(super) run: F,
}

pub(super) const fn command<F: Copy>(
    name: &'static str,
    operands: &'static str,
    run: F,
) -> CommandRow<F> {
    CommandRow {
        name,
        operands,
        run,
    }
}
