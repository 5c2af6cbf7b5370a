//! The grammar that NFF and `.test` files share: a name, then the operands that a table has for it.

use crate::diagnostics::Span;

/// A run of characters without white space, and its place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TextToken<'a> {
    pub(crate) text: &'a str,
    pub(crate) offset: usize,
}

impl TextToken<'_> {
    pub(crate) fn span(&self) -> Span {
        Span::new(self.offset, self.text.len())
    }
}

/// A row of a format's table of commands: a name, the names of its operands, and its function.
pub(crate) struct CommandRow<F> {
    pub(crate) name: &'static str,
    pub(crate) operands: &'static str,
    pub(crate) run: F,
}

pub(crate) const fn command<F: Copy>(
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
