//! Keys by which rows of several records belong together.

use crate::report::RateRow;
use std::collections::BTreeMap;

/// Scene, kind of rays, engine and threads of a rate.
pub(super) type RateKey<'a> = (&'a str, &'a str, &'a str, u32);

/// A rate's key, and its kernel or mode.
pub(super) type KernelKey<'a> = (RateKey<'a>, &'a str);

/// The key of a row.
pub(super) fn kernel_key(row: &RateRow) -> KernelKey<'_> {
    let rate = (&*row.scene, &*row.rays, &*row.engine, row.threads);
    (rate, &row.kernel)
}

/// A record's rows by their keys.
pub(super) fn by_kernel(rows: &[RateRow]) -> BTreeMap<KernelKey<'_>, &RateRow> {
    let usable = rows.iter().filter(|row| has_rate(row));
    usable.map(|row| (kernel_key(row), row)).collect()
}

/// Returns true if a row was measured.
pub(super) fn has_rate(row: &RateRow) -> bool {
    row.mrays_per_s.median > 0.0
}
