//! Rays through partly transparent surfaces: hit after hit, in the order of (t, prim_id).

use super::intersect::{OracleHit, OracleRay};
use super::search::SceneSearch;
use glam::Vec3;
use phalanx_scene::MIN_SURFACE_SHARE;
use std::vec;

/// Number of hits that are searched for one by one. Rays with more hits find the rest in one
/// search, so that n surfaces in one place do not take n searches.
const SINGLE_STEPS: u32 = 8;

/// A ray on its way from hit to hit.
struct OracleHitWalk<'a> {
    search: &'a SceneSearch<'a>,
    ray: &'a OracleRay,
    /// The last hit.
    after: Option<OracleHit>,
    steps: u32,
    /// All hits after the last, once they are known.
    rest: Option<vec::IntoIter<OracleHit>>,
}

impl<'a> OracleHitWalk<'a> {
    /// A walk over the hits after `after`, or over all hits if that is `None`.
    fn new(
        search: &'a SceneSearch<'a>,
        ray: &'a OracleRay,
        after: Option<OracleHit>,
    ) -> OracleHitWalk<'a> {
        OracleHitWalk {
            search,
            ray,
            after,
            steps: 0,
            rest: None,
        }
    }
}

impl Iterator for OracleHitWalk<'_> {
    type Item = OracleHit;

    fn next(&mut self) -> Option<OracleHit> {
        if let Some(rest) = &mut self.rest {
            return rest.next();
        }
        self.steps += 1;
        let hit = match self.after {
            None => self.search.closest(self.ray),
            Some(after) if self.steps <= SINGLE_STEPS => {
                self.search.closest_after(self.ray, &after)
            }
            Some(after) => {
                let rest = self.search.all_after::<false>(self.ray, &after).into_iter();
                return self.rest.insert(rest).next();
            }
        };
        self.after = hit.or(self.after);
        hit
    }
}

impl SceneSearch<'_> {
    /// The closest hit with any coverage after the hit `passed` by (t, prim_id), or of all hits if
    /// that is `None`. Skips surfaces without coverage and invisible backs.
    pub(super) fn closest_there(
        &self,
        ray: &OracleRay,
        passed: Option<OracleHit>,
    ) -> Option<OracleHit> {
        self.next_there(&mut OracleHitWalk::new(self, ray, passed), passed)
    }

    /// The next hit of a walk with any coverage, after the hit `passed`.
    fn next_there(&self, walk: &mut OracleHitWalk, passed: Option<OracleHit>) -> Option<OracleHit> {
        let dir = walk.ray.dir;
        walk.find(|&hit| {
            let is_passed = |passed| self.scene.is_same_surface(passed, hit);
            !(self.has_coverage || self.has_unseen_backs)
                || !passed.is_some_and(is_passed) && self.seen_coverage(dir, hit) != 0.0
        })
    }

    fn seen_coverage(&self, dir: Vec3, hit: OracleHit) -> f32 {
        self.scene.seen_coverage(dir, hit).unwrap_or_else(|| {
            self.unseen_backs.set(self.unseen_backs.get() + 1);
            0.0
        })
    }

    /// The surfaces that end a ray from a hit on, and the part of it that ends on each.
    pub(super) fn shares_along(
        &self,
        ray: &OracleRay,
        first: Option<OracleHit>,
        opaque: bool,
    ) -> Vec<(u32, f32)> {
        let (mut open, mut next) = (1.0f32, first);
        let mut walk = OracleHitWalk::new(self, ray, first);
        let mut shares = Vec::new();
        while let Some(hit) = next {
            let coverage =
                if opaque || !self.has_coverage { 1.0 } else { self.scene.coverage(hit) };
            shares.push((hit.prim_id, open * coverage));
            open *= 1.0 - coverage;
            if open < MIN_SURFACE_SHARE {
                break;
            }
            next = self.next_there(&mut walk, Some(hit));
        }
        shares
    }

    /// Share of a lamp's light that passes all surfaces before `tmax`: V.
    pub(super) fn visibility(&self, ray: &OracleRay, tmax: f32) -> Vec3 {
        if !self.occluded(ray, tmax) {
            return Vec3::ONE;
        }
        if self.has_clear_shadows {
            self.visibility_past(ray, tmax, |_| false)
        } else {
            Vec3::ZERO
        }
    }

    /// V without the hits that `spares` takes.
    pub(super) fn visibility_past(
        &self,
        ray: &OracleRay,
        tmax: f32,
        mut spares: impl FnMut(&OracleHit) -> bool,
    ) -> Vec3 {
        let mut product = Vec3::ONE;
        let mut counted: Option<OracleHit> = None;
        for hit in OracleHitWalk::new(self, ray, None).take_while(|hit| hit.t < tmax) {
            let is_counted = |counted| self.scene.is_same_surface(counted, hit);
            if !spares(&hit) && !counted.is_some_and(is_counted) {
                product = self.scene.pass_light(product, hit);
                counted = Some(hit);
            }
            if product == Vec3::ZERO {
                break;
            }
        }
        product
    }
}
