//! Light of a hit that is independent of lamps: ambient light and emission.

use super::coverage::WaveCoverage;
use super::hit_grouping::HitGroups;
use super::ray_batch::RadianceX8;
use crate::shade::{CurrentMaterial, ShadeMaterial};
use phalanx_scene::Scene;
use phalanx_trace::simd::{LANES, LaneMask};

/// Initialises every hit's sum to Ka + Ke, or to Ka times the surface's colour + Ke, weighted by
/// its coverage.
pub(super) fn add_ambient_and_emission(
    scene: &Scene,
    groups: &HitGroups,
    coverage: WaveCoverage,
    radiance: &mut [RadianceX8],
) {
    let mut materials = CurrentMaterial::new(scene);
    for (k, at) in groups.surfaces.iter().enumerate() {
        let ShadeMaterial { ka, ke, .. } = materials.row(at.material);
        let own = (ka + ke).to_array();
        let share = coverage.of(at);
        if let (None, None, Some(packet)) = (groups.tints.get(k), share, at.whole_packet()) {
            radiance[packet] = RadianceX8(own.map(|c| [c; LANES]));
            continue;
        }
        for lane in at.active.lanes() {
            let own = match groups.tints.get(k) {
                Some(t) => {
                    let t = glam::Vec3::new(t.x.lane(lane), t.y.lane(lane), t.z.lane(lane));
                    (ka * t + ke).to_array()
                }
                None => own,
            };
            let own = share.map_or(own, |share| own.map(|c| c * share.lane(lane)));
            let ray = at.ray[lane] as usize;
            radiance[ray / LANES].set(ray % LANES, own);
        }
    }
}
