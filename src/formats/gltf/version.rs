//! The version of a document, checked before anything else is read: other versions differ in
//! everything.

use crate::diagnostics::quoted;
use serde_json::value::RawValue;
use std::collections::BTreeMap;

/// Error for the format's first version, which is a different format.
pub(super) const FIRST_VERSION: &str = "this is glTF 1.0, and only 2.0 is read here: convert it first, for instance with gltf-pipeline";

/// Lists of the second version that are objects with names in the first one.
const LISTS: [&str; 8] = [
    "accessors",
    "bufferViews",
    "buffers",
    "images",
    "materials",
    "meshes",
    "nodes",
    "scenes",
];

type Members<'a> = BTreeMap<String, &'a RawValue>;

/// Refuses a document of another version, or without one. Text that is not an object passes: its
/// reader gives a better message.
pub(super) fn check(json: &[u8]) -> Result<(), String> {
    let Ok(members) = serde_json::from_slice::<Members>(json) else {
        return Ok(());
    };
    let asset = members.get("asset").map_or("", |asset| asset.get());
    let asset: Members = serde_json::from_slice(asset.as_bytes()).unwrap_or_default();
    let text = |name: &str| {
        let text = asset.get(name)?.get();
        // A version without quotes is taken as written.
        let text = serde_json::from_slice(text.as_bytes()).unwrap_or_else(|_| text.to_owned());
        (text != "null").then_some(text)
    };
    let least = text("minVersion");
    let is = |version: &str, number: &str| {
        let rest = version.trim().strip_prefix(number);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    let is_object = |list: &&str| members.get(*list).is_some_and(|l| l.get().starts_with('{'));
    if let Some(least) = least.as_ref().filter(|least| is(least, "2"))
        && !["2", "2.0"].contains(&least.trim())
    {
        let least = quoted(least);
        return Err(format!(
            "glTF {least} is needed (minVersion), and only 2.0 is read here"
        ));
    }
    match least.or_else(|| text("version")) {
        Some(version) if is(&version, "2") => Ok(()),
        Some(version) if is(&version, "1") => Err(FIRST_VERSION.to_owned()),
        None if LISTS.iter().any(is_object) => Err(FIRST_VERSION.to_owned()),
        Some(version) => {
            let version = quoted(&version);
            Err(format!("glTF {version} is not read here, only 2.0"))
        }
        None => Err("not a glTF file: it has no `asset.version`".to_owned()),
    }
}
