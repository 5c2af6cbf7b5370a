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
    for (k, surface) in groups.surfaces.iter().enumerate() {
        let emitted = groups.material(k).own();
        let emitted = coverage
            .of(surface)
            .map_or(emitted, |share| emitted.scale(share));
        let emitted = [emitted.x, emitted.y, emitted.z].map(F32x8::to_array);
        if let Some(packet) = surface.whole_packet() {
            radiance[packet] = RadianceX8(emitted);
            continue;
        }
        for lane in surface.active.lanes() {
            let ray = surface.ray[lane] as usize;
            radiance[ray / LANES].set(ray % LANES, emitted.map(|c| c[lane]));
        }
    }
}
