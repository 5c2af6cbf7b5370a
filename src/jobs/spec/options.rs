//! Options as words of a command line, from the JSON of their structs.

use phalanx_files::shell_word;
use serde::Serialize;
use serde_json::Value;

/// Order of options in commands and messages; all others come last.
const ORDER: &str = "format camera camera_name ortho up light background material two_sided terminator \
    origin size region aov max_depth min_weight spp filter aa threshold aperture focus integrator \
    ao_distance transfer quantize bits exposure";

/// Default values, which commands omit.
const DEFAULTS: [(&str, &str); 4] = [
    ("origin", "auto"),
    ("filter", "box"),
    ("aa", "uniform"),
    ("integrator", "whitted"),
];

/// Text for an option that is not given.
const NOT_GIVEN: &str = "not given";

/// Fields of a struct of options by name, including those of nested structs.
pub(crate) fn fields(part: &impl Serialize) -> Vec<(String, Value)> {
    let mut found = Vec::new();
    collect(serde_json::to_value(part).unwrap_or_default(), &mut found);
    let place = |name: &str| ORDER.split(' ').position(|known| known == name);
    found.sort_by_key(|(name, _)| place(name).unwrap_or(usize::MAX));
    found
}

fn collect(part: Value, found: &mut Vec<(String, Value)>) {
    let Value::Object(fields) = part else {
        return;
    };
    for (name, value) in fields {
        if value.is_object() {
            collect(value, found)
        } else {
            found.push((name, value))
        }
    }
}

/// All text values, each with the name of its field.
pub(crate) fn texts(part: &impl Serialize) -> Vec<(String, String)> {
    let parts = |value| match value {
        Value::Array(parts) => parts,
        value => vec![value],
    };
    let fields = fields(part).into_iter();
    let fields = fields.flat_map(|(name, value)| {
        let parts = parts(value).into_iter();
        parts.filter_map(move |part| Some((name.clone(), part.as_str()?.to_owned())))
    });
    fields.collect()
}

/// The option of a field.
pub(crate) fn option_name(field: &str) -> String {
    format!("--{}", field.replace('_', "-"))
}

/// The value of an option for messages. Different values have different texts.
pub(crate) fn option_text(field: &str, value: &Value) -> String {
    match value {
        Value::Null | Value::Bool(false) => NOT_GIVEN.to_owned(),
        Value::Array(parts) if parts.is_empty() => NOT_GIVEN.to_owned(),
        Value::Array(parts) => {
            let parts: Vec<String> = parts.iter().map(|part| option_text(field, part)).collect();
            parts.join(match field {
                "size" => "x",
                "aov" => ",",
                _ => " ",
            })
        }
        Value::String(text) => text.clone(),
        Value::Number(number) => match (number.as_u64(), number.as_f64()) {
            (Some(whole), _) => whole.to_string(),
            (None, Some(number)) if field == "exposure" => (number as f32).to_string(),
            // For very small and very large numbers `Debug` prints fewer digits than `Display`, and
            // loses no bits.
            (None, number) => format!("{:?}", number.unwrap_or_default() as f32),
        },
        other => other.to_string(),
    }
}

/// Words of a command line that give these options, but for defaults.
pub(super) fn words(part: &impl Serialize) -> Vec<String> {
    let mut words = Vec::new();
    for (field, value) in fields(part) {
        let (option, text) = (option_name(&field), option_text(&field, &value));
        if text == NOT_GIVEN || DEFAULTS.contains(&(&field, &text)) {
            continue;
        }
        let has_parts = ["camera", "region", "light", "allow_path"].contains(&field.as_str());
        let values = match value {
            Value::Array(parts) if has_parts => parts,
            value => vec![value],
        };
        let values = values.iter().map(|value| option_text(&field, value));
        match field.as_str() {
            "two_sided" => words.push(option),
            "ortho" if text == "fit" => words.push(option),
            // Their values may begin with a minus sign.
            "camera_name" | "ortho" | "up" | "exposure" => words.push(format!("{option}={text}")),
            "light" => words.extend(values.flat_map(|light| [option.clone(), light])),
            "allow_path" => words.extend(values.map(|path| format!("{option}={path}"))),
            "size" | "aov" => words.extend([option, text]),
            _ => words.extend([option].into_iter().chain(values)),
        }
    }
    words
}

/// A command line of these words, as shells read it.
pub(super) fn command_line(words: &[String]) -> String {
    let words: Vec<String> = words.iter().map(shell_word).collect();
    words.join(" ")
}
