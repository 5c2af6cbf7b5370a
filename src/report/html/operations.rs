//! Operations per test, counted by hand in the kernels of `src/trace`.
//!
//! An operation is an addition, subtraction, multiplication, division, square root, minimum,
//! maximum or comparison of one lane; selects, sign changes, mask logic and integers do not count.
//! A primitive test is counted up to the point where it ends for most primitives, which is where no
//! lane hits them. The additional operations of a hit, and those that are done once per packet, are
//! omitted. So the counts are lower bounds, and a point of the roofline is rather too low than too
//! high.

use crate::{CountedWork, SceneRecord};
use phalanx_scene::PrimKind;

/// `aabb.rs`, rays that agree on signs: 6 subtractions, 6 products, 3 maxima, 2 minima; then
/// `within`: a minimum and a comparison. Rays that go either way take 6 more minima and maxima.
pub(super) const BOX: f64 = 19.0;

/// `triangle.rs` up to `inside`: 9 subtractions for the corners, 12 operations to shear them, 9 for
/// the edge functions, 2 minima, 2 maxima and 2 comparisons.
pub(super) const TRIANGLE: f64 = 36.0;

/// `sphere.rs` up to `meets`: 3 subtractions, d·d and f·d of 5 each, r², b/a, 6 for the closest
/// point, its square of 5, a subtraction and a comparison.
pub(super) const SPHERE: f64 = 28.0;

/// Operations of a sphere test, but its 3 subtractions are two rotations of 15 each and a shift of
/// 3.
pub(super) const ELLIPSOID: f64 = 58.0;

/// `cone.rs` up to `meets`: the own box of 17 and twice `within` of 2, 9 for the entry, six dot
/// products of 5, 3 for d·d across, 3 for the radii, 6 for the slope, 3 for the cross product, 6
/// for the gap and a comparison.
pub(super) const CONE: f64 = 82.0;

/// `instance.rs`: the transform of the ray, 33, and its interval in the instance's box, 17.
pub(super) const INSTANCE: f64 = 50.0;

/// Operations of the counted work. Primitive tests are not counted by kind, so they are taken to be
/// of the kinds that the scene has, in its proportions.
pub(super) fn operations(work: &CountedWork, scene: Option<&SceneRecord>) -> f64 {
    let per_primitive = scene.and_then(mean_primitive).unwrap_or(TRIANGLE);
    work.box_tests as f64 * BOX + work.prim_tests as f64 * per_primitive
}

/// Mean operations of a test of the scene's primitives; `None` for a scene without any.
fn mean_primitive(scene: &SceneRecord) -> Option<f64> {
    let (mut sum, mut number) = (0.0, 0.0);
    for (kind, count) in &scene.primitives {
        sum += of_kind(kind) * *count as f64;
        number += *count as f64;
    }
    (number > 0.0).then(|| sum / number)
}

/// Operations by the name of a kind, in singular or plural.
fn of_kind(kind: &str) -> f64 {
    let singular = kind.trim_end_matches('s');
    let known = PrimKind::ALL
        .into_iter()
        .find(|kind| kind.name() == singular);
    match known {
        Some(PrimKind::Sphere) => SPHERE,
        Some(PrimKind::Ellipsoid) => ELLIPSOID,
        Some(PrimKind::Triangle) => TRIANGLE,
        Some(PrimKind::Cone) => CONE,
        // The one name in records that is not a primitive's.
        None => INSTANCE,
    }
}
