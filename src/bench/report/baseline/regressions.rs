//! What of the changes is a regression.

use super::{Changes, GroupChange, RowChange, RowKey};

/// Rows that a group must have to decide by itself: with fewer it is hardly more than one of them.
const ROWS_TO_DECIDE: usize = 4;

/// How often a suspect is measured again before it counts.
pub const RETAKES: usize = 2;

/// A rate that fell beyond the threshold.
#[derive(Clone, Debug, PartialEq)]
pub enum Regression {
    /// A kernel on one kind of rays over all scenes, or in one scene over all kinds of rays.
    Group(GroupChange),
    /// One row, as measured the last time.
    Row(RowChange),
}

impl Changes {
    /// The rows that look slower than by the threshold (such as 0.08), and did so each time they
    /// were measured again (`again`: the same baseline against each retake). They are to be
    /// measured again, [`RETAKES`] times in all.
    pub fn suspects(&self, again: &[Changes], threshold: f64) -> Vec<RowKey> {
        let stays = |key: &RowKey| again.iter().all(|retake| retake.slower(key, threshold));
        let suspects = self
            .rows
            .iter()
            .filter(|row| row.change.slower_than(threshold));
        let keys = suspects.map(|row| row.key.clone());
        keys.filter(stays).collect()
    }

    /// What fell beyond the threshold, `again` being the same baseline against each retake of the
    /// [suspects](Changes::suspects).
    ///
    /// A suite has some thousand rows, and each has noise that the rounds of one run do not show:
    /// its memory lies elsewhere in every run, and a neighbour on the machine may stay for all of
    /// its rounds. A 95 % interval taken alone would cry wolf in every run. So:
    ///
    /// - *Slower* is what lies beyond the threshold with its whole interval.
    /// - A **group** (one kernel and one kind of rays over all scenes, or one scene over all kinds;
    ///   of four rows or more, all in units of the oracle's rates) decides by itself. There are
    ///   some hundred of them; what rows scatter by averages out and is in the interval.
    /// - A **row** counts only if it was slower in the run and in [`RETAKES`] retakes. With fewer
    ///   no row counts: a neighbour that slows one row in a hundred slows ten of a thousand, and
    ///   one of ten a second time in every tenth suite.
    ///
    /// The tests in `noise.rs` simulate this: anything at all is reported of a thousand unchanged
    /// rows in fewer than one suite of a hundred, and a kernel slower by 15 %, on one kind of rays
    /// or in one scene, is missed in fewer than one of a hundred. What slows one row alone must be
    /// gross to be seen: that a thousand rows raise no false alarm and one of them tells of 15 %
    /// cannot both be had on a noisy machine.
    pub fn regressions(&self, again: &[Changes], threshold: f64) -> Vec<Regression> {
        let decides = |group: &&GroupChange| {
            let counts = group.normalised && group.rows >= ROWS_TO_DECIDE;
            counts && group.change.slower_than(threshold)
        };
        let groups = self.groups.iter().filter(decides);
        let mut found: Vec<Regression> = groups.cloned().map(Regression::Group).collect();
        if again.len() >= RETAKES
            && let Some(last) = again.last()
        {
            let suspects = self.suspects(again, threshold);
            let rows = suspects.iter().filter_map(|key| last.row(key));
            found.extend(rows.cloned().map(Regression::Row));
        }
        found
    }

    fn row(&self, key: &RowKey) -> Option<&RowChange> {
        self.rows.iter().find(|row| row.key == *key)
    }

    fn slower(&self, key: &RowKey, threshold: f64) -> bool {
        self.row(key)
            .is_some_and(|row| row.change.slower_than(threshold))
    }
}
