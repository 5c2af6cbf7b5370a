//! Options as words of a command line and of messages.

use phalanx_files::shell_word;
use serde::Serialize;
use serde_json::Value;

/// An option with its values. One without values is not given.
#[derive(Debug, PartialEq)]
pub(crate) struct OptionRow {
    /// Name of the field that holds the option.
    pub(crate) field: &'static str,
    values: Vec<String>,
    form: OptionForm,
}

/// How a command gives an option.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum OptionForm {
    /// The option, then its values.
    Words,
    /// The option, then its values as one word, with this between them.
    List(&'static str),
    /// The option before each value.
    Repeated,
    /// `--option=value` for each value, which may begin with a minus sign.
    Attached,
    /// The option alone.
    Flag,
}

impl OptionRow {
    /// The row of a field, whose values are those of its JSON.
    pub(super) fn new(field: &'static str, form: OptionForm, value: &impl Serialize) -> OptionRow {
        let mut values = match serde_json::to_value(value).unwrap_or_default() {
            Value::Null | Value::Bool(false) => Vec::new(),
            Value::Array(parts) => parts.iter().map(value_text).collect(),
            value => vec![value_text(&value)],
        };
        if let (OptionForm::List(between), false) = (form, values.is_empty()) {
            values = vec![values.join(between)];
        }
        OptionRow {
            field,
            values,
            form,
        }
    }

    /// The option as commands have it.
    pub(crate) fn option(&self) -> String {
        format!("--{}", self.field.replace('_', "-"))
    }

    /// The values, each with the name of the field.
    pub(crate) fn texts(&self) -> impl Iterator<Item = (&'static str, String)> {
        self.values.iter().map(|value| (self.field, value.clone()))
    }

    pub(super) fn is_given(&self) -> bool {
        !self.values.is_empty()
    }

    /// The values for messages. Different values have different texts.
    pub(crate) fn text(&self) -> String {
        if self.is_given() { self.values.join(" ") } else { "not given".to_owned() }
    }

    fn words(&self) -> Vec<String> {
        let (option, values) = (self.option(), self.values.iter());
        match self.form {
            _ if self.values.is_empty() => Vec::new(),
            OptionForm::Repeated => values.flat_map(|v| [option.clone(), v.clone()]).collect(),
            OptionForm::Attached => values.map(|value| format!("{option}={value}")).collect(),
            OptionForm::Flag => vec![option],
            _ => [&[option], &self.values[..]].concat(),
        }
    }
}

fn value_text(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        // For very small and very large numbers `Debug` prints fewer digits than `Display`, and
        // loses no bits.
        Value::Number(number) if number.is_f64() => {
            format!("{:?}", number.as_f64().unwrap_or_default() as f32)
        }
        value => value.to_string(),
    }
}

/// Words of a command line that give these options.
pub(super) fn words(rows: &[OptionRow]) -> Vec<String> {
    rows.iter().flat_map(OptionRow::words).collect()
}

/// A command line of these words, as shells read it.
pub(super) fn command_line(words: &[String]) -> String {
    let words: Vec<String> = words.iter().map(shell_word).collect();
    words.join(" ")
}

/// A value that a command has to name.
pub(super) fn unless_default<T: Default + PartialEq>(value: Option<T>) -> Option<T> {
    value.filter(|value| *value != T::default())
}
