//! Results of tracing a set of rays, kept for comparison: a rate counts only if the results are
//! right.

use phalanx_report::QueryKind;
use phalanx_trace::packet::{HitPacket, NO_PRIM};
use phalanx_trace::simd::{LANES, LaneMask, LaneU32, Mask8};

/// The answer to a set of rays, packet by packet.
pub enum Answer {
    /// The closest hit of each ray.
    Closest(Vec<HitPacket>),
    /// Occluded lanes of each packet, as bits.
    Occluded(Vec<u8>),
}

/// Relative difference in distance within which two hits on different primitives count as the same
/// position. Peers number coincident surfaces in another order, and round differently.
pub const MAX_DISTANCE_ERROR: f32 = 1e-4;

/// Maximum share of rays with different results, for a peer's rates to count: 0.01 %.
pub const MAX_DIFFERING_SHARE: f64 = 1e-4;

impl Answer {
    /// Storage for the results of a query on some packets, initialised to no hit.
    pub fn with_capacity(query: QueryKind, packets: usize) -> Answer {
        match query {
            QueryKind::Closest => Answer::Closest(vec![HitPacket::miss(); packets]),
            QueryKind::Occluded => Answer::Occluded(vec![0; packets]),
        }
    }

    /// Number of hits among the first `rays` rays.
    pub fn hits(&self, rays: usize) -> usize {
        let hit = |packet| match self {
            Answer::Closest(hits) => hit_lanes(&hits[packet]).bits(),
            Answer::Occluded(blocked) => u32::from(blocked[packet]),
        };
        let packets = 0..rays.div_ceil(LANES);
        let counts = packets.map(|k| (live(k, rays).bits() & hit(k)).count_ones() as usize);
        counts.sum()
    }

    /// CRC-32 over the results of the first `rays` rays. For each ray these are its `prim_id` and
    /// the bits of `t`, `u` and `v`, little-endian; where nothing is hit, all but the first are
    /// zeros. For occlusion it is one byte per ray, 1 where it is occluded.
    pub fn checksum(&self, rays: usize) -> u32 {
        let mut crc = crc32fast::Hasher::new();
        for packet in 0..rays.div_ceil(LANES) {
            for lane in live(packet, rays).lanes() {
                match self {
                    Answer::Closest(hits) => {
                        let words = bits(&hits[packet], lane);
                        words.iter().for_each(|w| crc.update(&w.to_le_bytes()));
                    }
                    Answer::Occluded(blocked) => crc.update(&[blocked[packet] >> lane & 1]),
                }
            }
        }
        crc.finalize()
    }

    /// The first ray whose results differ in any bit.
    pub fn first_difference(
        &self,
        other: &Answer,
        rays: impl IntoIterator<Item = usize>,
    ) -> Option<usize> {
        let same = |a: &HitPacket, b: &HitPacket, lane| bits(a, lane) == bits(b, lane);
        rays.into_iter().find(|&ray| self.differs(other, ray, same))
    }

    /// Share of `rays` rays for which a peer has another result: only one of the two hits, or they
    /// hit different primitives at different positions ([`MAX_DISTANCE_ERROR`]).
    pub fn share_of_differences(&self, peer: &Answer, rays: usize) -> f64 {
        let differs = |ray: &usize| self.differs(peer, *ray, same_position);
        (0..rays).filter(differs).count() as f64 / rays.max(1) as f64
    }

    /// Tests if a ray has different results in two answers. `same` compares two closest hits.
    fn differs(
        &self,
        other: &Answer,
        ray: usize,
        same: impl Fn(&HitPacket, &HitPacket, usize) -> bool,
    ) -> bool {
        let (packet, lane) = (ray / LANES, ray % LANES);
        match (self, other) {
            (Answer::Closest(a), Answer::Closest(b)) => !same(&a[packet], &b[packet], lane),
            (Answer::Occluded(a), Answer::Occluded(b)) => (a[packet] ^ b[packet]) >> lane & 1 == 1,
            _ => true,
        }
    }

    /// The result of a ray as text.
    pub fn describe(&self, ray: usize) -> String {
        let (packet, lane) = (ray / LANES, ray % LANES);
        match self {
            Answer::Closest(hits) => match bits(&hits[packet], lane) {
                [NO_PRIM, ..] => "nothing".to_owned(),
                [prim_id, t, ..] => format!("primitive {prim_id} at t = {}", f32::from_bits(t)),
            },
            Answer::Occluded(blocked) if blocked[packet] >> lane & 1 == 1 => "occluded".to_owned(),
            Answer::Occluded(_) => "not occluded".to_owned(),
        }
    }
}

/// Lanes of a packet that carry one of the first `rays` rays.
fn live(packet: usize, rays: usize) -> Mask8 {
    Mask8::first(rays - packet * LANES)
}

fn hit_lanes(hit: &HitPacket) -> Mask8 {
    !hit.prim_id.eq(phalanx_trace::simd::U32x8::splat(NO_PRIM))
}

fn bits(hit: &HitPacket, lane: usize) -> [u32; 4] {
    match hit.prim_id.lane(lane) {
        NO_PRIM => [NO_PRIM, 0, 0, 0],
        prim_id => {
            let [t, u, v] = [hit.t, hit.u, hit.v].map(|x| x.lane(lane).to_bits());
            [prim_id, t, u, v]
        }
    }
}

fn same_position(a: &HitPacket, b: &HitPacket, lane: usize) -> bool {
    let (id, other) = (a.prim_id.lane(lane), b.prim_id.lane(lane));
    if id == other {
        return true;
    }
    let (t, s) = (a.t.lane(lane), b.t.lane(lane));
    id != NO_PRIM && other != NO_PRIM && (t - s).abs() <= MAX_DISTANCE_ERROR * t.abs().max(s.abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use phalanx_trace::simd::{F32x8, Lanes, U32x8};

    fn answer(ids: [u32; 8], t: [f32; 8]) -> Answer {
        Answer::Closest(vec![HitPacket {
            t: F32x8::new(t),
            u: F32x8::ZERO,
            v: F32x8::ZERO,
            prim_id: U32x8::new(ids),
        }])
    }

    const IDS: [u32; 8] = [3, 1, NO_PRIM, 4, 4, 2, 9, 9];
    const T: [f32; 8] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];

    #[test]
    fn an_id_or_a_bit_of_t_is_a_difference_and_changes_the_checksum() {
        let right = answer(IDS, T);
        assert_eq!((right.hits(8), right.hits(3)), (7, 2));
        let mut ids = IDS;
        ids[3] = 5;
        let mut t = T;
        t[5] = f32::from_bits(t[5].to_bits() + 1);
        for (wrong, ray) in [(answer(ids, T), 3), (answer(IDS, t), 5)] {
            assert_eq!(right.first_difference(&wrong, 0..8), Some(ray));
            assert_eq!(right.first_difference(&wrong, 0..ray), None);
            assert_ne!(right.checksum(8), wrong.checksum(8));
            assert_eq!(right.checksum(ray), wrong.checksum(ray));
        }
        // The value of t is irrelevant where nothing was hit.
        t = T;
        t[2] = 99.0;
        assert_eq!(right.first_difference(&answer(IDS, t), 0..8), None);
        assert_eq!(right.checksum(8), answer(IDS, t).checksum(8));
    }

    #[test]
    fn peers_may_number_and_round_otherwise_but_not_miss() {
        let right = answer(IDS, T);
        let mut t = T;
        t[0] *= 1.00001;
        let mut ids = IDS;
        ids[0] = 77;
        assert_eq!(right.share_of_differences(&answer(ids, t), 8), 0.0);
        t[0] *= 1.01;
        assert_eq!(right.share_of_differences(&answer(ids, t), 8), 0.125);
        ids[0] = NO_PRIM;
        ids[2] = 0;
        assert_eq!(right.share_of_differences(&answer(ids, t), 8), 0.25);
    }

    #[test]
    fn occlusion_is_compared_in_the_lanes_that_carry_rays() {
        let [a, b] = [0b0000_0101, 0b1000_0101].map(|bits| Answer::Occluded(vec![bits]));
        assert_eq!((a.hits(8), b.hits(8), b.hits(7)), (2, 3, 2));
        assert_eq!(a.first_difference(&b, 0..7), None);
        assert_eq!(a.first_difference(&b, 0..8), Some(7));
        assert_eq!(a.checksum(7), b.checksum(7));
        assert_ne!(a.checksum(8), b.checksum(8));
        assert_eq!(a.describe(0), "occluded");
        assert_eq!(a.describe(1), "not occluded");
    }
}
