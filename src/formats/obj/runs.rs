//! Runs of triangles between the statements that change a state.

use std::ops::Range;

/// The triangles of each change: those up to the next one, of `triangles` in all. Changes are
/// ascending, by the triangle that they begin at.
pub(super) fn ranges<T>(
    changes: &[(usize, T)],
    triangles: usize,
) -> impl Iterator<Item = (Range<usize>, &T)> {
    let ends = changes.iter().skip(1).map(|change| change.0);
    let ends = ends.chain([triangles]);
    let all = changes.iter().zip(ends);
    all.map(|((first, state), end)| (*first..end, state))
}
