//! What of the changes is a regression.

use super::{Changes, GroupChange, RowChange, RowKey};

/// Rows that a group must have to decide by itself: with fewer it is hardly more than one of them.
const ROWS_TO_DECIDE: usize = 4;

/// A rate that fell beyond the threshold.
#[derive(Clone, Debug, PartialEq)]
pub enum Regression {
    /// A kernel on one kind of rays over all scenes, or in one scene over all kinds of rays.
    Group(GroupChange),
    /// One row, as measured the second time.
    Row(RowChange),
}

impl Changes {
    /// The rows that look slower than by the threshold (such as 0.08): to be measured again.
    pub fn suspects(&self, threshold: f64) -> Vec<RowKey> {
        let suspect = |row: &&RowChange| row.change.slower_than(threshold);
        let found = self.rows.iter().filter(suspect);
        found.map(|row| row.key.clone()).collect()
    }

    /// What fell beyond the threshold, `again` being the same baseline against a second measurement of the
    /// [suspects](Changes::suspects).
    ///
    /// A suite has some thousand rows, and each has noise that the rounds of one run do not show: its memory lies
    /// elsewhere in every run, and a neighbour on the machine may stay for all of its rounds. A 95 % interval taken
    /// alone would cry wolf in every run. So:
    ///
    /// - *Slower* is what lies beyond the threshold with its whole interval.
    /// - A **group** (one kernel and one kind of rays over all scenes, or one scene over all kinds; of four rows or more,
    ///   all in units of the oracle's rates) decides by itself. There are some hundred of them; what rows scatter by
    ///   averages out and is in the interval.
    /// - A **row** counts only if it was slower twice: in the run, and when measured again afterwards. Chance seldom
    ///   strikes the same row twice; without a second measurement no row counts.
    ///
    /// The tests in `noise.rs` simulate this: anything at all is reported of a thousand unchanged rows in fewer than one
    /// suite of a hundred, and a kernel slower by 15 %, on one kind of rays or in one scene, is missed in fewer than one
    /// of a hundred. What slows one row alone must be gross to be seen: that a thousand rows raise no false alarm
    /// and one of them tells of 15 % cannot both be had with seven noisy samples.
    pub fn regressions(&self, again: Option<&Changes>, threshold: f64) -> Vec<Regression> {
        let decides = |group: &&GroupChange| {
            group.normalised && group.rows >= ROWS_TO_DECIDE && group.change.slower_than(threshold)
        };
        let groups = self.groups.iter().filter(decides).cloned();
        let again = again.map_or(&[][..], |changes| &changes.rows);
        let slower = |key: &RowKey| {
            let mut rows = again.iter().filter(|row| row.key == *key);
            rows.find(|row| row.change.slower_than(threshold)).cloned()
        };
        let rows = self
            .suspects(threshold)
            .into_iter()
            .filter_map(|key| slower(&key));
        let found = groups.map(Regression::Group);
        found.chain(rows.map(Regression::Row)).collect()
    }
}
