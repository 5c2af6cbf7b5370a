//! Light of a hit that is independent of lamps: ambient light and emission.

use super::coverage::WaveCoverage;
use super::hit_grouping::HitGroups;
use super::ray_batch::RadianceX8;
use phalanx_trace::simd::{F32x8, LANES, LaneMask};

/// Initialises every hit's sum to Ka + Ke, weighted by its coverage.
pub(super) fn add_ambient_and_emission(
    groups: &HitGroups,
    coverage: WaveCoverage,
    radiance: &mut [RadianceX8],
) {
    for (k, at) in groups.surfaces.iter().enumerate() {
        let own = groups.material(k).own();
        let own = coverage.of(at).map_or(own, |share| own.scale(share));
        let own = [own.x, own.y, own.z].map(F32x8::to_array);
        if let Some(packet) = at.whole_packet() {
            radiance[packet] = RadianceX8(own);
            continue;
        }
        for lane in at.active.lanes() {
            let ray = at.ray[lane] as usize;
            radiance[ray / LANES].set(ray % LANES, own.map(|c| c[lane]));
        }
    }
}
