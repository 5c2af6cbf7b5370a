//! Rows of a column that belong to nothing any more, for those that come.

use std::ops::Range;

/// Runs of free rows, ascending, none of which touches another.
#[derive(Clone, Debug, Default)]
pub(in crate::bvh) struct FreeRows(Vec<Range<usize>>);

impl FreeRows {
    /// Takes the first `count` consecutive rows that are free, of a column of `len` rows; those at
    /// its end, where it grows, if there are no others.
    pub(in crate::bvh) fn run(&mut self, count: usize, len: usize) -> Range<usize> {
        let fits = |run: &Range<usize>| run.len() >= count || run.end == len;
        let place = self.0.iter().position(fits).filter(|_| count > 0);
        let Some(place) = place else {
            return len..len + count;
        };
        let run = &mut self.0[place];
        let first = run.start;
        run.start = run.end.min(first + count);
        if run.start == run.end {
            self.0.remove(place);
        }
        first..first + count
    }

    /// Gives rows back.
    pub(in crate::bvh) fn give(&mut self, rows: Range<usize>) {
        if rows.is_empty() {
            return;
        }
        let after = self.0.partition_point(|run| run.start < rows.start);
        self.0.insert(after, rows);
        self.0.dedup_by(|next, run| {
            let touch = run.end == next.start;
            run.end = if touch { next.end } else { run.end };
            touch
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that rows are never given out twice, and that a column in which as much comes as goes
    /// stays as long as it is.
    #[test]
    fn rows_are_used_again() {
        let mut free = FreeRows::default();
        let (mut len, mut taken, mut seed) = (0, Vec::<Range<usize>>::new(), 1u32);
        let mut longest = 0;
        for round in 0..20_000 {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            if taken.len() > 20 {
                free.give(taken.swap_remove(seed as usize >> 8 & 15));
            }
            let count = 1 + (seed as usize >> 16 & 63);
            let run = free.run(count, len);
            len = len.max(run.end);
            let disjoint = |other: &Range<usize>| other.end <= run.start || run.end <= other.start;
            assert!(run.len() == count && taken.iter().all(disjoint));
            taken.push(run);
            if round == 10_000 {
                longest = len;
            }
        }
        assert!(len <= longest + 64, "{longest} rows grew to {len}");
        taken.into_iter().for_each(|rows| free.give(rows));
        assert_eq!(free.run(len, len), 0..len);
    }
}
