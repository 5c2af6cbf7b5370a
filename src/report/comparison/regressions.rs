//! Selection of the changes that are regressions.

use super::{ComparedRate, GroupChange, RecordComparison};

/// Times that a suspect is measured again before it counts.
pub const RETAKES: usize = 2;

/// Kernels and rates that fell beyond the threshold of a comparison.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Regressions {
    /// Kernels, as a whole, on one kind of rays or in one scene.
    pub groups: Vec<GroupChange>,
    /// Single rates, as measured the last time.
    pub rates: Vec<ComparedRate>,
}

impl Regressions {
    /// Returns true if nothing is slower.
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty() && self.rates.is_empty()
    }
}

impl RecordComparison {
    /// The rates that look slower, and did so in each of the retakes: the first record compared
    /// with suspects that were measured again. They are to be measured again, [`RETAKES`] times in
    /// all.
    pub fn suspects(&self, retakes: &[RecordComparison]) -> Vec<&ComparedRate> {
        let stays = |rate: &&ComparedRate| {
            let mut retakes = retakes.iter();
            retakes.all(|retake| retake.suspect(rate).is_some())
        };
        self.slow_rates.iter().filter(stays).collect()
    }

    /// The regressions of a run, whose [suspects](RecordComparison::suspects) were measured again
    /// for the retakes.
    ///
    /// A suite has some thousand rows. Each has noise that the rounds of one run do not show: its
    /// memory lies elsewhere in every run, and another load on the machine may last for all of its
    /// rounds. An interval taken alone would raise a false alarm in every run. So:
    ///
    /// - A **group** of rates decides by itself, as every comparison of two records shows it
    ///   ([`GroupChange`]): the noise of its rates averages out.
    /// - A single **rate** counts only if it was slower in the run and in [`RETAKES`] retakes. With
    ///   fewer retakes no rate counts: a neighbour that slows one rate in a hundred slows ten of a
    ///   thousand, and one of ten a second time in every tenth suite.
    ///
    /// `simulation.rs` simulates this. Anything at all is reported of a thousand unchanged rates in
    /// fewer than one suite of a hundred. A kernel slower by 15 %, on one kind of rays or in one
    /// scene, is missed in fewer than two of a hundred.
    pub fn regressions(&self, retakes: &[RecordComparison]) -> Regressions {
        let slower = self.groups.iter().filter(|group| group.change.by < 0.0);
        let last = retakes.last().filter(|_| retakes.len() >= RETAKES);
        let rates = last.map_or(Vec::new(), |last| {
            let suspects = self.suspects(retakes).into_iter();
            suspects
                .filter_map(|rate| last.suspect(rate).cloned())
                .collect()
        });
        Regressions {
            groups: slower.cloned().collect(),
            rates,
        }
    }

    /// The same rate as another comparison's, if it looks slower here.
    fn suspect(&self, rate: &ComparedRate) -> Option<&ComparedRate> {
        let mut suspects = self.slow_rates.iter();
        suspects.find(|suspect| suspect.key() == rate.key())
    }
}
