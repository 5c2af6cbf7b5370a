//! Packets of a batch: all, or selected groups of four out of every eight groups, so that two
//! kernels can be timed on similar rays.

use std::ops::Range;

/// Consecutive packets that go to the same kernel: rays of one square of the picture.
const FOUR: usize = 4;

/// Part of a trial to which each of eight groups of four belongs: two groups warm the caches for a
/// kernel, three time one kernel, three the other.
const SHARES: [usize; 8] = [0, 1, 2, 1, 0, 2, 1, 2];

/// A selection of a queue's packets.
#[derive(Clone)]
pub(super) struct BatchSlice {
    pub(super) packets: Range<usize>,
    /// Part, a value of [`SHARES`]; all packets if `None`.
    share: Option<usize>,
}

impl BatchSlice {
    pub(super) fn all(packets: Range<usize>) -> BatchSlice {
        BatchSlice {
            packets,
            share: None,
        }
    }

    /// The parts of a trial: a quarter, and twice three eighths, interleaved.
    pub(super) fn trial(packets: Range<usize>) -> [BatchSlice; 3] {
        [0, 1, 2].map(|part| BatchSlice {
            packets: packets.clone(),
            share: Some(part),
        })
    }

    /// The parts of a trial, each a contiguous range.
    pub(super) fn trial_in_pieces(packets: Range<usize>) -> [BatchSlice; 3] {
        let Range { start, end } = packets;
        let eighth = packets.len() / 16 * 2;
        let [from, middle] = [2, 5].map(|eighths| start + eighths * eighth);
        [start..from, from..middle, middle..end].map(BatchSlice::all)
    }

    /// The packets, in order. All groups of four but the last are complete.
    pub(super) fn each(&self) -> impl Iterator<Item = usize> + Clone + use<> {
        let BatchSlice {
            packets,
            share: part,
        } = self.clone();
        let start = packets.start;
        packets.filter(move |packet| match part {
            None => true,
            Some(part) => SHARES[(packet - start) / FOUR % SHARES.len()] == part,
        })
    }

    /// The packets, in pairs if `pairs` is true: the first of each pair, and whether the next one
    /// belongs to it. Groups of four are complete, so a pair is two consecutive packets.
    pub(super) fn pairs(&self, pairs: bool) -> impl Iterator<Item = (usize, bool)> + use<> {
        let (mut packets, end) = (self.each(), self.packets.end);
        std::iter::from_fn(move || {
            let packet = packets.next()?;
            let is_pair = pairs && packet + 1 < end;
            if is_pair {
                packets.next();
            }
            Some((packet, is_pair))
        })
    }

    pub(super) fn count(&self) -> usize {
        self.each().count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trial_has_all_packets_in_fours() {
        let parts = BatchSlice::trial(3..67);
        assert_eq!(parts.each_ref().map(BatchSlice::count), [16, 24, 24]);
        assert!(parts[0].each().take(5).eq([3, 4, 5, 6, 19]));
        assert!(parts[1].each().take(5).eq([7, 8, 9, 10, 15]));
        assert!(parts[2].each().take(5).eq([11, 12, 13, 14, 23]));
        let pieces = BatchSlice::trial_in_pieces(3..67).map(|part| part.packets);
        assert_eq!(pieces, [3..19, 19..43, 43..67]);
        let mut all: Vec<usize> = parts.iter().flat_map(BatchSlice::each).collect();
        all.sort_unstable();
        assert!(BatchSlice::all(3..67).each().eq(all));
    }
}
