//! Random picks of entries by their weights, in constant time.

/// Walker's alias table, built as Vose does ("A Linear Algorithm for Generating Random Numbers with
/// a Given Distribution", 1991): n slots of equal probability, each shared by two entries.
///
/// Weights and shares are f64, and the table is built in one order by one thread. A pick is integer
/// arithmetic, so that both engines agree. Each slot rounds its shares to some of its 2³² / n
/// numbers.
#[derive(Clone, Debug, Default)]
pub struct AliasTable {
    slots: Vec<AliasSlot>,
    /// Probability of each entry.
    pub pdf: Vec<f64>,
}

/// A slot of the entry of its own number, and of one other.
#[derive(Clone, Copy, Debug)]
struct AliasSlot {
    /// Share of its own entry, in units of 2⁻³².
    own: u32,
    /// Entry that has the rest.
    other: u32,
}

impl AliasTable {
    /// The table of positive weights, fewer than 2³², and their sum, which is finite.
    pub(super) fn of(weights: &[f64], sum: f64) -> AliasTable {
        let pdf: Vec<f64> = weights.iter().map(|weight| weight / sum).collect();
        AliasTable {
            slots: slots(&pdf),
            pdf,
        }
    }

    /// The entry of 32 random bits: the slot is the upper word of bits · n, the lower one tells
    /// its two entries apart. `None` from an empty table.
    pub fn pick(&self, bits: u32) -> Option<usize> {
        let product = u64::from(bits) * self.pdf.len() as u64;
        let index = (product >> 32) as usize;
        let slot = self.slots.get(index)?;
        Some(if (product as u32) < slot.own { index } else { slot.other as usize })
    }
}

/// The slots for entries of these probabilities: those that have too little for their slot are
/// completed by those that have too much. The last ones have just enough, up to rounding.
fn slots(pdf: &[f64]) -> Vec<AliasSlot> {
    let entries = 0..pdf.len() as u32;
    let mut left: Vec<f64> = pdf.iter().map(|p| p * pdf.len() as f64).collect();
    let undivided = |other| AliasSlot { own: 0, other };
    let mut slots = Vec::from_iter(entries.clone().map(undivided));
    let (mut small, mut large): (Vec<u32>, Vec<u32>) =
        entries.partition(|&entry| left[entry as usize] < 1.0);
    while let (Some(entry), Some(&other)) = (small.pop(), large.last()) {
        let share = left[entry as usize];
        let own = (share * 4_294_967_296.0) as u32;
        slots[entry as usize] = AliasSlot { own, other };
        left[other as usize] -= 1.0 - share;
        if left[other as usize] < 1.0 {
            large.pop();
            small.push(other);
        }
    }
    slots
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL_BITS: f64 = 4_294_967_296.0;

    fn table(weights: &[f64]) -> AliasTable {
        AliasTable::of(weights, weights.iter().sum())
    }

    fn rng(seed: u32) -> impl FnMut() -> u32 {
        let mut state = u64::from(seed);
        move || {
            state = (state.wrapping_mul(6_364_136_223_846_793_005)).wrapping_add(1);
            (state >> 32) as u32
        }
    }

    /// The exact probability of each entry, summed over all 2³² bits: within a slot, the lower word
    /// of the product grows by n from one number to the next.
    fn exact(table: &AliasTable) -> Vec<f64> {
        let n = table.pdf.len() as u64;
        let mut picked = vec![0; table.pdf.len()];
        for index in 0..n {
            let [first, end] = [index, index + 1].map(|slot| (slot << 32).div_ceil(n));
            let slot = table.slots[index as usize];
            let lower = first * n - (index << 32);
            let own = u64::from(slot.own).saturating_sub(lower).div_ceil(n);
            let own = own.min(end - first);
            for (bits, entry) in [(first, index as usize), (end - 1, slot.other as usize)] {
                let is_there = if bits == first { own > 0 } else { own < end - first };
                assert!(!is_there || table.pick(bits as u32) == Some(entry));
            }
            picked[index as usize] += own;
            picked[slot.other as usize] += end - first - own;
        }
        assert_eq!(picked.iter().sum::<u64>(), 1 << 32);
        picked.iter().map(|&bits| bits as f64 / ALL_BITS).collect()
    }

    /// Each slot rounds by two of its 2³² / n numbers at most.
    #[test]
    fn picks_have_the_probabilities_of_their_weights() {
        let mut next = rng(7);
        for n in [1usize, 2, 3, 5, 64, 1000] {
            for spread in [1.0, 10.0, 60.0] {
                let exponent = |bits: u32| f64::from(bits) / ALL_BITS * spread;
                let weights: Vec<f64> = (0..n).map(|_| libm::exp(exponent(next()))).collect();
                let table = table(&weights);
                let sum: f64 = weights.iter().sum();
                for (entry, picked) in exact(&table).into_iter().enumerate() {
                    let slots = table
                        .slots
                        .iter()
                        .filter(|slot| slot.other as usize == entry);
                    let bound = 2.0 * (1 + slots.count()) as f64 / ALL_BITS + 1e-12;
                    let pdf = table.pdf[entry];
                    assert!((pdf - weights[entry] / sum).abs() < 1e-15);
                    assert!(
                        (picked - pdf).abs() <= bound,
                        "{n} {spread}: {picked}, {pdf}"
                    );
                }
            }
        }
    }

    #[test]
    fn random_picks_pass_a_test_by_their_squares() {
        let weights: Vec<f64> = (1..=64).map(|k| f64::from(k * k)).collect();
        let (table, mut next) = (table(&weights), rng(3));
        let (trials, mut counts) = (200_000, [0.0; 64]);
        (0..trials).for_each(|_| counts[table.pick(next()).unwrap()] += 1.0);
        let terms = counts.iter().enumerate().map(|(entry, count)| {
            let wanted = table.pdf[entry] * f64::from(trials);
            (count - wanted) * (count - wanted) / wanted
        });
        // 63 degrees of freedom: 103.4 is passed once in a thousand times.
        let chi_squared: f64 = terms.sum();
        assert!((20.0..103.4).contains(&chi_squared), "{chi_squared}");
    }

    #[test]
    fn extreme_weights_neither_vanish_nor_take_a_slot() {
        assert_eq!(AliasTable::default().pick(5), None);
        assert_eq!(table(&[3.0]).pick(u32::MAX), Some(0));
        for weights in [
            [1e30, 1e-30, 1.0],
            [1e-30, 1e-30, 1e30],
            [1e-320, 1e-320, 1e-320],
        ] {
            let table = table(&weights);
            let sum: f64 = (0..3).map(|entry| table.pdf[entry]).sum();
            assert!((sum - 1.0).abs() < 1e-12, "{weights:?}: {sum}");
            for (picked, entry) in exact(&table).iter().zip(0..) {
                assert!((picked - table.pdf[entry]).abs() < 2e-9, "{weights:?}");
            }
        }
        // A great one among a million small ones completes all slots; rounding must not give any
        // of those to a small one.
        let mut weights = vec![1e-20; 1 << 20];
        weights[12_345] = 1.0;
        let picked = exact(&table(&weights));
        assert_eq!(picked[12_345], 1.0);
        // As many great ones as small ones, which make the heaviest sums of rounding errors.
        let weights: Vec<f64> = (0..1 << 20)
            .map(|k| if k % 2 == 0 { 1e-20 } else { 1.1 })
            .collect();
        let picked = exact(&table(&weights));
        assert!(picked.iter().step_by(2).all(|&picked| picked == 0.0));
    }
}
