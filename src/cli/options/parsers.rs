//! Parsers for options with named values.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// A parser for the names in a table of names and values.
pub fn name_parser<T: Copy + Send + Sync>(
    table: &'static [(&'static str, T)],
) -> impl TypedValueParser<Value = T> {
    let names = table.iter().map(|(name, _)| *name);
    let value = |name: &str| table.iter().find(|row| row.0 == name).map(|row| row.1);
    PossibleValuesParser::new(names).try_map(move |name| value(&name).ok_or("an unknown name"))
}

/// A parser for the names in a table of names, help texts and values.
pub fn described_name_parser<T: Copy + Send + Sync>(
    table: &'static [(&'static str, &'static str, T)],
) -> impl TypedValueParser<Value = T> {
    let names = table.iter();
    let names = names.map(|(name, help, _)| PossibleValue::new(*name).help(*help));
    let value = |name: &str| table.iter().find(|row| row.0 == name).map(|row| row.2);
    PossibleValuesParser::new(names).try_map(move |name| value(&name).ok_or("an unknown name"))
}
