//! Selection of the changes that are regressions.

use super::changes::{Changes, GroupChange, RowChange, RowKey};

/// Minimum number of rows with which a group decides by itself: with fewer it is hardly more than
/// one of them.
pub(super) const ROWS_TO_DECIDE: usize = 4;

/// Times that a suspect is measured again before it counts.
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
        let rows = self.rows.iter();
        let suspects = rows.filter(|row| row.change.slower_than(threshold));
        let keys = suspects.map(|row| row.key.clone());
        keys.filter(stays).collect()
    }

    /// The regressions beyond the threshold, `again` being the same baseline against each retake of
    /// the [suspects](Changes::suspects).
    ///
    /// A suite has some thousand rows. Each has noise that the rounds of one run do not show: its
    /// memory lies elsewhere in every run, and another load on the machine may last for all of its
    /// rounds. A 95 % interval taken alone would raise a false alarm in every run. So:
    ///
    /// - A change is *slower* if its whole interval lies beyond the threshold.
    /// - A **group** decides by itself. It is one kernel and one kind of rays over all scenes, or
    ///   one scene over all kinds. It has four rows or more, all in units of the oracle's rates.
    ///   There are some hundred of them; the scatter of the rows averages out and is in the
    ///   interval.
    /// - A **row** counts only if it was slower in the run and in [`RETAKES`] retakes. With fewer
    ///   retakes no row counts: a neighbour that slows one row in a hundred slows ten of a
    ///   thousand, and one of ten a second time in every tenth suite.
    ///
    /// The tests in `noise.rs` simulate this. Anything at all is reported of a thousand unchanged
    /// rows in fewer than one suite of a hundred. A kernel slower by 15 %, on one kind of rays or
    /// in one scene, is missed in fewer than one of a hundred. A slowdown of one row alone must be
    /// large to be found: on a noisy machine, it is impossible both that a thousand rows raise no
    /// false alarm and that one of them reveals 15 %.
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
