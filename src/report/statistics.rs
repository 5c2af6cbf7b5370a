//! Medians and their uncertainty, and means of ratios. The numbers are the same on every machine:
//! no clock, no library's random numbers, no mathematics of the system.

use super::Estimate;

/// Resamples of a bootstrap.
const RESAMPLES: usize = 1000;

/// The share of resamples below an interval.
const TAIL: f64 = 0.025;

/// Difference between two runs, as a share, from causes that all rounds of one run have in common:
/// the addresses of its memory, the speed of the cores at that time. Runs on a shared virtual
/// machine were up to 2 % off in all rows at once, whatever their rounds said
/// (perf/notes/noise.md).
const BETWEEN_RUNS: f64 = 0.025;

impl Estimate {
    /// The rate of work that is done in pieces, repeatedly, in rounds. `rounds[r][k]` is the
    /// seconds that piece k took in round r when it was fastest. `work` is the sum of all pieces.
    /// All fields are zero where there are no rounds.
    ///
    /// A piece counts with its fastest visit. Other load on a machine can only slow it, by a share
    /// that changes from one millisecond to the next and from one run to another. The fastest of
    /// several visits is the time of the work itself (Chen and Revels, "Robust benchmarking in
    /// noisy environments", 2016; they take whole runs of a benchmark, which here last too long to
    /// be undisturbed).
    ///
    /// The quietness of each round is random, so rounds are drawn with replacement (Efron's
    /// bootstrap). Median and deviation are those of the rates of many draws. The interval is where
    /// the median of another run would be, 9 times in 10. It starts from the 2.5th percentile,
    /// mirrored at the median, since a draw cannot be quieter than all rounds but another run can.
    /// It is 2.5 % wider at both ends, for the differences that all rounds of a run have in common.
    /// From one round, nothing is known of chance.
    #[inline]
    pub fn of_fastest(rounds: &[Vec<f64>], work: f64) -> Estimate {
        if rounds.is_empty() {
            return Estimate::default();
        }
        let mut fastest = Vec::new();
        let mut draw = Draw(seed(rounds));
        let rates = (0..RESAMPLES).map(|_| work / draw.pass(rounds, &mut fastest));
        let mut rates: Vec<f64> = rates.collect();
        rates.sort_unstable_by(f64::total_cmp);
        let low = rates[(TAIL * rates.len() as f64) as usize];
        let middle = median(&mut rates);
        let mut deviations: Vec<f64> = rates.iter().map(|rate| (rate - middle).abs()).collect();
        Estimate {
            median: middle,
            mad: median(&mut deviations),
            low: low * (1.0 - BETWEEN_RUNS),
            high: middle * (middle / low) * (1.0 + BETWEEN_RUNS),
        }
    }
}

/// The middle value, or the mean of the two middle ones; 0 for an empty slice. Sorts.
#[inline]
pub fn median(samples: &mut [f64]) -> f64 {
    samples.sort_unstable_by(f64::total_cmp);
    let half = samples.len() / 2;
    match samples.len() {
        0 => 0.0,
        count if count.is_multiple_of(2) => (samples[half - 1] + samples[half]) / 2.0,
        _ => samples[half],
    }
}

/// The geometric mean of positive numbers; `None` if there are none, or one is not positive.
pub fn geometric_mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0u32);
    for value in values {
        if !(value > 0.0 && value.is_finite()) {
            return None;
        }
        sum += libm::log(value);
        count += 1;
    }
    (count > 0).then(|| libm::exp(sum / f64::from(count)))
}

/// Random numbers by SplitMix64 (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number
/// Generators", 2014).
pub(super) struct Draw(pub u64);

impl Draw {
    /// 64 random bits.
    #[inline]
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A random index below `count`, which is not 0.
    #[inline]
    pub fn below(&mut self, count: usize) -> usize {
        ((u128::from(self.bits()) * count as u128) >> 64) as usize
    }

    /// Seconds of a pass, each piece as fast as in the fastest of as many rounds as there are,
    /// drawn with replacement.
    #[inline]
    fn pass(&mut self, rounds: &[Vec<f64>], fastest: &mut Vec<f64>) -> f64 {
        fastest.clone_from(&rounds[self.below(rounds.len())]);
        for _ in 1..rounds.len() {
            let round = &rounds[self.below(rounds.len())];
            for (fastest, &seconds) in fastest.iter_mut().zip(round) {
                *fastest = fastest.min(seconds);
            }
        }
        fastest.iter().sum()
    }
}

/// A seed from the rounds themselves, so that the same rounds always have the same interval.
#[inline]
fn seed(rounds: &[Vec<f64>]) -> u64 {
    let fold = |hash: u64, seconds: &f64| Draw(hash ^ seconds.to_bits()).bits();
    rounds.iter().flatten().fold(rounds.len() as u64, fold)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_of_known_samples() {
        assert_eq!(median(&mut []), 0.0);
        assert_eq!(median(&mut [3.0]), 3.0);
        assert_eq!(median(&mut [9.0, 1.0, 5.0]), 5.0);
        assert_eq!(median(&mut [4.0, 1.0, 8.0, 2.0]), 3.0);
    }

    #[test]
    fn geometric_means() {
        let mean = geometric_mean([1.0, 4.0, 16.0]).unwrap();
        assert!((mean - 4.0).abs() < 1e-12);
        assert_eq!(geometric_mean([]), None);
        assert_eq!(geometric_mean([2.0, 0.0]), None);
        assert_eq!(geometric_mean([2.0, f64::NAN]), None);
    }

    #[test]
    fn every_piece_counts_with_its_fastest_round() {
        let none = Estimate::of_fastest(&[], 10.0);
        assert_eq!(none, Estimate::default());
        let one = Estimate::of_fastest(&[vec![1.0, 3.0]], 10.0);
        assert_eq!((one.median, one.mad), (2.5, 0.0));
        // Each piece is disturbed in one round of many: no round is quiet, and their sum is.
        let round = |r: usize| -> Vec<f64> {
            let piece = |k: usize| if k == r { 9.0 } else { 1.0 };
            (0..12).map(piece).collect()
        };
        let rounds: Vec<Vec<f64>> = (0..12).map(round).collect();
        let quiet = Estimate::of_fastest(&rounds, 12.0);
        assert_eq!((quiet.median, quiet.mad), (1.0, 0.0));
        assert_eq!(quiet, Estimate::of_fastest(&rounds, 12.0));
    }

    /// Disturbed moments of a tenth of a run or of seven tenths of it: the medians of two runs are
    /// near each other, and the interval of one holds that of the other.
    #[test]
    fn runs_agree_and_know_how_well() {
        let mut draw = Draw(7);
        let mut run = || {
            let disturbed = 0.1 + 0.6 * draw.unit();
            let common = libm::exp(0.005 * draw.normal());
            let mut round = || -> Vec<f64> {
                let mut piece = || {
                    if draw.unit() < disturbed {
                        common * (1.1 + 0.8 * draw.unit())
                    } else {
                        common * (1.0 + 0.02 * draw.unit())
                    }
                };
                (0..64).map(|_| piece()).collect()
            };
            let rounds: Vec<Vec<f64>> = (0..12).map(|_| round()).collect();
            Estimate::of_fastest(&rounds, 64.0)
        };
        let runs: Vec<Estimate> = (0..40).map(|_| run()).collect();
        let pairs: Vec<_> = runs
            .iter()
            .enumerate()
            .flat_map(|(k, a)| runs[..k].iter().map(move |b| (a, b)))
            .collect();
        let share = |count: usize| count as f64 / pairs.len() as f64;
        let near = pairs
            .iter()
            .filter(|(a, b)| (a.median / b.median - 1.0).abs() < 0.05);
        let held = pairs
            .iter()
            .filter(|(a, b)| a.low <= b.median && b.median <= a.high);
        let (near, held) = (share(near.count()), share(held.count()));
        assert!(near > 0.95 && held > 0.95, "near {near}, held {held}");
    }
}
