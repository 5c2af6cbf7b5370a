//! Local origin of a scene that lies far from the origin of its file's coordinates.
//!
//! A file is first read in its own coordinates. If its geometry turns out to lie far away, the file
//! is read again. This time readers subtract an origin near the geometry, in double precision,
//! before they round. So scenes that are not far away keep every bit, at the cost of examining some
//! of their triangles.
//!
//! | symbol | meaning |
//! |---|---|
//! | h | largest half extent of the geometry along an axis |
//! | c | largest magnitude of the geometry's coordinates along one axis |
//! | g | largest power of two ≤ h, at least one unit in the last place of the largest coordinate |
//!
//! An axis is moved if c > [`MAX_OFFSET_RATIO`] · h, to the multiple of g that is nearest to the
//! middle of the geometry. Then c − 2h ≤ |x| ≤ c for all coordinates x, so that origin and x lie
//! within a factor of 2 of each other, and both are single-precision numbers if x is one. Their
//! difference is exact (Sterbenz). Axes that are not moved stay exact, too. Scenes with a ground
//! that reaches to the origin have a large h, and are not moved.

use crate::diagnostics::{Diagnostic, DiagnosticSink, Span};
use crate::memory::OverLimit;
use glam::DVec3;
use phalanx_scene::{Bounds, Scene, Vec3s};

/// Ratio of coordinates to the geometry's half extent from which on it counts as far away. Rounding
/// moves positions by up to 2⁻²⁵ of a coordinate. If no axis is moved, it therefore moves nothing
/// by more than 16 · 2⁻²⁵ ≈ 5·10⁻⁷ of the half extent: a thousandth of a pixel in a picture of 2000
/// pixels. Moved or not, 99.9 % of the pixels of a box over a floor are the same at 16; at 30 fewer
/// are where samples are rounded down. Scenes that are modelled where they are used, with a corner
/// or the eye at the origin, stay below 8.
const MAX_OFFSET_RATIO: f64 = 16.0;

/// Most readings of a file; the first is in its own coordinates. Coordinates that were rounded to
/// single precision give a position to 2⁻²⁴. So a second origin may be needed for a small thing
/// very far away. A third is never needed, as double precision ends there.
pub(super) const MAX_READINGS: usize = 3;

/// Origin of a scene that is read from a file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Origin {
    /// Near the geometry, if that lies far from the file's origin; else the file's origin.
    #[default]
    Auto,
    /// The file's origin.
    File,
    /// A position in the file's coordinates. The file's origin is used instead if the file's
    /// coordinates are single precision and cannot be moved there without rounding them.
    At([f64; 3]),
}

impl Origin {
    /// The origin that a reader subtracts; `None` if it keeps the file's coordinates.
    pub(super) fn offset(self) -> Option<DVec3> {
        match self {
            Origin::At(position) if position != [0.0; 3] => Some(position.into()),
            _ => None,
        }
    }

    /// The origin that a reader subtracts.
    pub(super) fn position(self) -> DVec3 {
        self.offset().unwrap_or(DVec3::ZERO)
    }
}

/// The reason why a reading ends without a scene.
#[derive(Debug)]
pub(super) enum ReadStop {
    /// Something is wrong with the file.
    Wrong(Vec<Diagnostic>),
    /// The geometry is far away: the file must be read again, from this origin.
    Far(DVec3),
    /// Coordinates are single precision, and the move would change them.
    Inexact,
}

impl ReadStop {
    /// Stops because of the errors of a report, which has some.
    pub(super) fn of(report: DiagnosticSink) -> ReadStop {
        ReadStop::Wrong(report.into_errors())
    }

    /// The errors, in tests of files that are read once.
    #[cfg(test)]
    pub(super) fn diagnostics(self) -> Vec<Diagnostic> {
        match self {
            ReadStop::Wrong(diagnostics) => diagnostics,
            ReadStop::Far(_) | ReadStop::Inexact => Vec::new(),
        }
    }
}

impl From<Vec<Diagnostic>> for ReadStop {
    fn from(diagnostics: Vec<Diagnostic>) -> ReadStop {
        ReadStop::Wrong(diagnostics)
    }
}

impl From<OverLimit> for Vec<Diagnostic> {
    fn from(refusal: OverLimit) -> Vec<Diagnostic> {
        DiagnosticSink::binary().refuse(Span::START, refusal.to_string())
    }
}

impl From<OverLimit> for ReadStop {
    fn from(refusal: OverLimit) -> ReadStop {
        ReadStop::Wrong(refusal.into())
    }
}

/// Number of triangles between two checks whether the rest matters.
const BLOCK: usize = 64;

/// Returns true if nothing that is added to geometry within these bounds can make it far away. As
/// they grow to a half extent H, c grows by at most 2H. So nothing is far away in the end if c ≤
/// ([`MAX_OFFSET_RATIO`] − 2) · h now, as h ≤ H.
fn is_near(bounds: Bounds) -> bool {
    let (lo, hi) = (bounds.lo.as_dvec3(), bounds.hi.as_dvec3());
    let half = ((hi - lo) / 2.0).max_element();
    lo.abs().max(hi.abs()).max_element() <= (MAX_OFFSET_RATIO - 2.0) * half
}

/// The origin of geometry within these corners, if that is far away.
fn far(lo: DVec3, hi: DVec3) -> Option<DVec3> {
    let half = ((hi - lo) / 2.0).max_element();
    let magnitude = lo.abs().max(hi.abs());
    let largest = magnitude.max_element();
    let finite = half >= 0.0 && largest.is_finite();
    if !finite || largest <= MAX_OFFSET_RATIO * half {
        return None;
    }
    let unit = power_below(half).max(power_below(largest) * f64::from(f32::EPSILON));
    let center = (lo + hi) / 2.0;
    let multiple = |axis: usize| {
        if magnitude[axis] > MAX_OFFSET_RATIO * half {
            libm::rint(center[axis] / unit) * unit
        } else {
            0.0
        }
    };
    let origin = DVec3::new(multiple(0), multiple(1), multiple(2));
    (origin != DVec3::ZERO && origin.is_finite()).then_some(origin)
}

/// The largest power of two that is not larger than `x`; 0 for 0.
fn power_below(x: f64) -> f64 {
    let (mantissa, exponent) = libm::frexp(x);
    if mantissa == 0.0 { 0.0 } else { libm::scalbn(0.5, exponent) }
}

/// The origin of triangles of these vertices, if they are far away. Ends early if they are not.
pub(super) fn of_triangles(vertices: &Vec3s, corners: &[[u32; 3]]) -> Option<DVec3> {
    let mut bounds = Bounds::EMPTY;
    for rows in corners.chunks(BLOCK) {
        for row in rows {
            let [a, b, c] = row.map(|corner| vertices.get(corner as usize));
            bounds = bounds.union(Bounds::new(a.min(b).min(c), a.max(b).max(c)));
        }
        if is_near(bounds) {
            return None;
        }
    }
    of_bounds(bounds)
}

/// The origin of a scene's visible geometry, if that is far away, in the file's units. Ends early
/// if it is not.
pub(super) fn of_scene(scene: &Scene) -> Option<DVec3> {
    let unit = f64::from(scene.scale);
    if !scene.meshes.is_empty() {
        return of_bounds(scene.bounds()).map(|origin| origin / unit);
    }
    let mut bounds = Bounds::EMPTY;
    let count = scene.prim_count() as u32;
    for first in (0..count).step_by(BLOCK) {
        let block = first..count.min(first + BLOCK as u32);
        let boxes = block.map(|id| scene.prim_bounds(id));
        bounds = boxes.fold(bounds, Bounds::union);
        if is_near(bounds) {
            return None;
        }
    }
    of_bounds(bounds).map(|origin| origin / unit)
}

/// The origin of geometry within a box, if that is far away.
pub(super) fn of_bounds(bounds: Bounds) -> Option<DVec3> {
    far(bounds.lo.as_dvec3(), bounds.hi.as_dvec3())
}

/// Moves single-precision vertices to an origin, unless that rounds any that triangles use.
pub(super) fn move_exactly(
    vertices: &mut Vec3s,
    corners: &[[u32; 3]],
    axes: [bool; 3],
    origin: DVec3,
) -> Result<(), ReadStop> {
    for (axis, column) in vertices.parts_mut().into_iter().enumerate() {
        let origin = origin[axis];
        if !axes[axis] || origin == 0.0 {
            continue;
        }
        let is_exact = |&corner: &u32| is_exact(column[corner as usize], origin);
        if !corners.as_flattened().iter().all(is_exact) {
            return Err(ReadStop::Inexact);
        }
        for c in column.iter_mut() {
            *c = (f64::from(*c) - origin) as f32;
        }
    }
    Ok(())
}

/// Returns true if a single-precision coordinate stays one after the move.
pub(super) fn is_exact(c: f32, origin: f64) -> bool {
    let moved = (f64::from(c) - origin) as f32;
    f64::from(moved) + origin == f64::from(c)
}

/// Note for the user about a scene far away that was not moved.
pub(super) const KEPT_NOTE: &str = "the scene keeps the origin of its file: its coordinates are single precision, and moving \
     them would round them";

/// Note for the user about a scene that was moved.
pub fn note(scene: &Scene) -> Option<String> {
    let words = "the scene lies far from the origin of its coordinates: it is";
    let help = "options and reports still use the file's coordinates (see --origin)";
    let origin = scene.describe_origin()?;
    Some(format!("{words} moved to a local origin: {origin}; {help}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn origin_of(lo: [f64; 3], hi: [f64; 3]) -> Option<[f64; 3]> {
        far(lo.into(), hi.into()).map(|origin| origin.to_array())
    }

    #[test]
    fn only_axes_on_which_the_geometry_is_far_away_move() {
        assert_eq!(origin_of([-10.0, 0.0, -10.0], [10.0, 3.0, 10.0]), None);
        assert_eq!(origin_of([0.0; 3], [0.0; 3]), None);
        let utm = origin_of(
            [499_990.0, 0.0, -4_012_355.0],
            [500_010.0, 3.0, -4_012_335.0],
        );
        assert_eq!(utm, Some([500_000.0, 0.0, -4_012_344.0]));
        // The other axes' extent counts: a floor in which the third coordinate is constant is not
        // far away.
        assert_eq!(origin_of([-10.0, 5.0, -10.0], [10.0, 5.0, 10.0]), None);
        // A ground that reaches to the origin.
        assert_eq!(
            origin_of([0.0, 0.0, 0.0], [500_010.0, 3.0, 500_010.0]),
            None
        );
        // A point, which is all that single precision leaves of something small.
        assert_eq!(
            origin_of([1e9, 0.0, 0.0], [1e9, 0.0, 0.0]),
            Some([1e9, 0.0, 0.0])
        );
        assert_eq!(origin_of([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), None);
    }

    #[test]
    fn an_early_end_changes_no_answer() {
        let mut seed = 1u32;
        let mut unit = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / (1 << 24) as f32
        };
        let mut moved = 0;
        for _ in 0..300 {
            let mut scene = Scene::default();
            let offset = Vec3::new(unit(), unit(), unit()) * 25.0;
            for _ in 0..1 + (unit() * 300.0) as usize {
                let corners = [(); 3].map(|()| offset + Vec3::new(unit(), unit(), unit()) * 2.0);
                scene.add_triangle(corners, None, 0);
            }
            let expected = of_bounds(scene.bounds());
            let triangles = &scene.triangles;
            assert_eq!(
                of_triangles(&triangles.vertices, &triangles.corners),
                expected
            );
            assert_eq!(of_scene(&scene), expected);
            moved += usize::from(expected.is_some());
        }
        assert!((30..270).contains(&moved), "{moved} of 300 are far away");
    }

    #[test]
    fn differences_of_single_precision_are_exact_at_the_chosen_origin() {
        let mut seed = 7u32;
        let mut unit = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24) * 2.0 - 1.0
        };
        for _ in 0..2000 {
            let middle = DVec3::new(unit(), unit(), unit()) * libm::exp2(unit() * 30.0);
            let half = libm::exp2(unit() * 20.0);
            let positions: Vec<Vec3> = (0..8)
                .map(|_| (middle + DVec3::new(unit(), unit(), unit()) * half).as_vec3())
                .collect();
            let bounds = positions
                .iter()
                .fold(Bounds::EMPTY, |b, p| b.union(Bounds::new(*p, *p)));
            let Some(origin) = of_bounds(bounds) else {
                continue;
            };
            for position in positions {
                let exact = (0..3).all(|k| is_exact(position[k], origin[k]));
                assert!(exact, "{position} − {origin}");
            }
        }
    }

    #[test]
    fn vertices_that_would_be_rounded_are_not_moved() {
        let mut vertices = Vec3s::default();
        for x in [500_000.25, 500_001.0, 500_000.0, 0.1] {
            vertices.push(Vec3::new(x, 1.0, 2.0));
        }
        let before = vertices.clone();
        let near = DVec3::new(500_000.0, 0.0, 0.0);
        let all = [true; 3];
        // 0.1 cannot be moved there, but only the second triangle uses it.
        let moved = move_exactly(&mut vertices, &[[0, 1, 3]], all, near);
        assert!(matches!(moved, Err(ReadStop::Inexact)));
        assert_eq!(vertices, before);
        move_exactly(&mut vertices, &[[0, 1, 2]], all, near).unwrap();
        assert_eq!(vertices.x[..3], [0.25, 1.0, 0.0]);
        assert_eq!((vertices.y[0], vertices.z[0]), (1.0, 2.0));
        assert!(!is_exact(1e-30, 500_000.0));
    }
}
