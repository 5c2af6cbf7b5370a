//! Visibility of the lights at the hits of samples, and agreement about it among neighbours.

use super::super::sobol::seeds;

/// Number of samples that must agree about a light before their result is reused.
pub const MIN_AGREEING: usize = 6;

/// The counters of [`agreed_lights`] are made for this number.
const _: () = assert!(MIN_AGREEING == 6);

/// Number of hits of a sample that are stored: the camera ray's, its mirror ray's, its refracted
/// ray's.
pub const MAX_HITS: usize = 3;

/// Lights that would contribute at a hit, and those of them that are visible, as far as queried or
/// reused: one bit for each of the first 32 lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LightVisibility {
    /// Path of the sample to this hit, see [`path_id`].
    pub path_id: u32,
    /// Lights that would contribute.
    pub queried: u32,
    /// Those of the queried lights that are visible.
    pub visible: u32,
}

impl LightVisibility {
    /// The bit of a light; 0 for lights beyond the first 32.
    #[inline]
    pub fn bit(light: usize) -> u32 {
        1u32.checked_shl(light as u32).unwrap_or(0)
    }
}

/// Identifier of the path to a hit on a primitive. It follows from that of the hit before and the
/// kind of ray from there, which is given by the index among [`MAX_HITS`].
#[inline]
pub fn path_id(before: u32, hit: usize, prim_id: u32) -> u32 {
    let [mixed] = seeds([before.wrapping_add(hit as u32)], [prim_id]);
    mixed
}

/// The lights about which enough of the neighbours agree that came to a hit along the same path,
/// and those of them that are visible.
pub(super) fn agreed_lights<'v>(
    neighbours: impl Iterator<Item = &'v LightVisibility>,
    path_id: u32,
) -> (u32, u32) {
    // Counters of the queries of each light: bits 1, 2 and 4. A count of six or more is latched
    // in `enough`.
    let [mut ones, mut twos, mut fours, mut enough] = [0u32; 4];
    let [mut yes, mut no] = [0u32; 2];
    for theirs in neighbours {
        if theirs.path_id != path_id {
            continue;
        }
        yes |= theirs.queried & theirs.visible;
        no |= theirs.queried & !theirs.visible;
        let carry = ones & theirs.queried;
        fours |= twos & carry;
        twos ^= carry;
        ones ^= theirs.queried;
        // Six: four, and two more.
        enough |= fours & twos;
    }
    let known = enough & !(yes & no);
    (known, known & yes)
}
