//! Names of triangles, from the statements of a file that change them.

use crate::diagnostics::Span;
use phalanx_scene::{NO_NAME, NameTable};

/// Changes of a name, ascending: the first triangle that has it, and its number.
pub(crate) type NameChanges = Vec<(usize, u32)>;

/// Bytes that a name and its run take beyond the file's text.
pub(crate) const NAME_BYTES: u64 = 128;

/// Notes a change that begins at a row. A change that no row has seen is replaced.
pub(crate) fn change<T>(changes: &mut Vec<(usize, T)>, first: usize, state: T) {
    match changes.last_mut() {
        Some(last) if last.0 == first => last.1 = state,
        _ => changes.push((first, state)),
    }
}

/// Names the triangles of a scene of nothing else by the changes of their objects, which are spans
/// of `bytes`, and of their materials.
pub(crate) fn name(
    names: &mut NameTable,
    (bytes, objects): (&[u8], Vec<(usize, Span)>),
    materials: &NameChanges,
    triangles: usize,
) {
    let objects = objects.into_iter();
    let objects = objects.map(|(first, name)| (first, names.intern(&bytes[name.range()])));
    let objects: NameChanges = objects.collect();
    let changes = objects.iter().chain(materials);
    let mut starts: Vec<usize> = changes.map(|change| change.0).chain([triangles]).collect();
    starts.sort_unstable();
    starts.dedup();
    let name_of = |changes: &NameChanges, row: usize| {
        let after = changes.partition_point(|change| change.0 <= row);
        after.checked_sub(1).map_or(NO_NAME, |last| changes[last].1)
    };
    for run in starts.windows(2) {
        let [first, end] = [run[0], run[1]].map(|row| row.min(triangles) as u32);
        let [object, material] = [&objects, materials].map(|changes| name_of(changes, run[0]));
        names.name_run(first..end, object, Some(material));
    }
}
