//! The last step of every reader: it applies the user's overrides, adds what the file lacks, and
//! checks that the scene can be traced.

use super::diagnostics::{DiagnosticSink, Span};
use super::loaded::Loaded;
use super::options::{AddedLight, Options};
use super::origin::{self, Origin, ReadStop};
use super::workers;
use glam::{DVec3, Vec3};
use phalanx_scene::{Bounds, Scene, SceneError, View};

/// Parts of a scene that a file does not give, so that defaults are needed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct MissingParts {
    /// True if the file has no camera. The default frames everything.
    pub(super) view: bool,
    /// True if the file has no light. The default is a key light beside the camera.
    pub(super) lights: bool,
    /// True if the file has no background. The default is a quiet one.
    pub(super) background: bool,
}

impl MissingParts {
    /// The format gives every part itself.
    pub(super) const NOTHING: MissingParts = MissingParts {
        view: false,
        lights: false,
        background: false,
    };
}

/// Background behind a mesh without surroundings: dark enough for its lit side, light enough for
/// its shadow.
const BACKGROUND: Vec3 = Vec3::new(0.095, 0.11, 0.135);

/// Field of view of the framing camera: a short telephoto, so that near parts are not blown up.
const FRAMING_FOVY: f32 = 32.0;
/// Direction from the middle toward the framing camera: a little from the right, a little from
/// above.
const THREE_QUARTER: DVec3 = DVec3::new(0.45, 0.32, 1.0);
/// Room around the framed box.
const MARGIN: f64 = 1.06;
/// Colour of the key light.
const KEY_LIGHT_COLOR: Vec3 = Vec3::new(1.0, 0.97, 0.92);

/// Applies the options, adds what is missing, and checks the scene.
pub(super) fn finish_scene(
    mut scene: Scene,
    missing: &MissingParts,
    options: &Options,
    mut report: DiagnosticSink,
) -> Result<Loaded, ReadStop> {
    // Done even if something is wrong: rounding alone may put a camera on the point it looks at.
    if options.origin == Origin::Auto
        && scene.meshes.is_empty()
        && let Some(far) = origin::of_scene(&scene)
    {
        return Err(ReadStop::Far(far));
    }
    scene.origin = options.origin.position().into();
    let mut notes = Vec::new();
    if report.is_clean() {
        add_defaults(&mut scene, missing, options, &mut notes);
        // Checked once in the file's units, and once as it will be traced: a scene that holds both
        // 1e30 and 1e-30 units cannot be brought into f32's comfortable range as a whole.
        let told = |error: SceneError| format!("the scene cannot be traced: {error}");
        if let Err(error) = scene.validate() {
            report.error(Span::START, told(error));
        } else {
            let unit = scene.scale;
            scene.rescale_to_f32_range();
            let fitted = match scene.scale == unit {
                true => Ok(()),
                false => scene.validate(),
            };
            if let Err(error) = fitted {
                let help =
                    "its largest and smallest parts may lie too far apart for single precision";
                report.error_with_help(Span::START, told(error), help);
            }
        }
    }
    let warnings = report.finish()?;
    Ok(Loaded {
        scene,
        warnings,
        notes,
    })
}

fn add_defaults(
    scene: &mut Scene,
    missing: &MissingParts,
    options: &Options,
    notes: &mut Vec<String>,
) {
    let bounds = match (missing.view && options.view.is_none()) || missing.lights {
        true => bounds_of(scene, options),
        false => Bounds::EMPTY,
    };
    if missing.view && options.view.is_none() {
        scene.view = framing(bounds, scene.width as f64 / scene.height as f64);
        notes.push(
            "the file has no camera: one that frames everything is used (see --camera)".into(),
        );
    }
    if missing.background {
        scene.background = BACKGROUND;
    }
    apply_overrides(scene, options);
    if options.lights.is_empty() && missing.lights {
        let position = key_light(&scene.view, bounds);
        scene.lights.add_point(position, KEY_LIGHT_COLOR, Vec3::X);
        notes.push(
            "the file has no light: a point light over the camera's shoulder is used (see --light)"
                .into(),
        );
    }
}

/// Replaces parts of a finished scene by those that the user gives. Positions are in the file's
/// units.
///
/// # Errors
/// [`SceneError`] if the result cannot be traced; the scene must not be used then.
pub fn override_scene(scene: &mut Scene, options: &Options) -> Result<(), SceneError> {
    apply_overrides(scene, options);
    // The scene was rescaled into the comfortable range when it was made. Parts given now cannot
    // change its scale any more.
    let given = options.view.is_some() || !options.lights.is_empty();
    if given && !scene.is_in_safe_range() {
        return Err(SceneError::TooFar(scene.safe_extent()));
    }
    scene.validate_settings()
}

fn apply_overrides(scene: &mut Scene, options: &Options) {
    if let Some(view) = &options.view {
        scene.view = scene.view_of(view);
    }
    if !options.lights.is_empty() {
        scene.lights = Default::default();
        for light in &options.lights {
            add_light(scene, light);
        }
    }
    if let Some(color) = options.background {
        scene.background = color;
    }
}

/// Bounds of everything visible. A scene of nothing but triangles may have millions, so several
/// threads compute them.
fn bounds_of(scene: &Scene, options: &Options) -> Bounds {
    let t = &scene.triangles;
    if t.len() != scene.prim_count() || !scene.meshes.is_empty() {
        return scene.bounds();
    }
    let threads = workers::thread_count(options.threads);
    let of = |rows: &[[u32; 3]]| {
        let mut bounds = [(f32::INFINITY, f32::NEG_INFINITY); 3];
        for row in rows {
            for (column, (lo, hi)) in t.vertices.parts().into_iter().zip(&mut bounds) {
                // Comparisons, not f32::min: no coordinate is NaN here, and they take a third of
                // the instructions.
                let [a, b, c] = row.map(|corner| column[corner as usize]);
                let less = |a: f32, b: f32| if a < b { a } else { b };
                let more = |a: f32, b: f32| if a > b { a } else { b };
                *lo = less(less(less(a, b), c), *lo);
                *hi = more(more(more(a, b), c), *hi);
            }
        }
        let [x, y, z] = bounds;
        Bounds::new(Vec3::new(x.0, y.0, z.0), Vec3::new(x.1, y.1, z.1))
    };
    let blocks = t.corners.chunks(1 << 16).collect();
    let bounds = workers::map(threads, blocks, of);
    bounds.into_iter().fold(Bounds::EMPTY, Bounds::union)
}

fn add_light(scene: &mut Scene, light: &AddedLight) {
    match *light {
        AddedLight::Point { position, color } => {
            let position = scene.scene_position(position);
            scene.lights.add_point(position, color, Vec3::X);
        }
        AddedLight::Directional { toward, color } => {
            let unit = toward.as_dvec3().normalize_or(DVec3::Y);
            scene.lights.add_directional(unit.as_vec3(), color);
        }
    }
}

/// A camera in front of a box, a little to the right and above, at the smallest distance from which
/// all eight corners are in view.
fn framing(bounds: Bounds, aspect: f64) -> View {
    let (lo, hi) = corners_or_unit(bounds);
    let center = (lo + hi) / 2.0;
    let back = THREE_QUARTER.normalize();
    let right = DVec3::Y.cross(back).normalize();
    let up = back.cross(right);
    let tangent = libm::tan(f64::from(FRAMING_FOVY).to_radians() / 2.0) / MARGIN;
    let half = (hi - lo) / 2.0;
    let mut distance = half.length() * 1e-3;
    for k in 0..8 {
        let sign = |bit: u32| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
        let corner = half * DVec3::new(sign(0), sign(1), sign(2));
        let wide = (corner.dot(right).abs() / aspect).max(corner.dot(up).abs());
        distance = distance.max(corner.dot(back) + wide / tangent);
    }
    View {
        eye: (center + back * distance).as_vec3(),
        center: center.as_vec3(),
        up: Vec3::Y,
        fovy: FRAMING_FOVY,
        ortho: None,
    }
}

/// A light above and to the left of the camera, as far from the middle as the camera, so that the
/// shadow side shows the shape.
fn key_light(view: &View, bounds: Bounds) -> Vec3 {
    let (lo, hi) = corners_or_unit(bounds);
    let center = (lo + hi) / 2.0;
    let from = view.eye.as_dvec3() - center;
    let reach = from.length().max((hi - lo).length());
    let back = from.normalize_or(DVec3::Z);
    let up = view.up.as_dvec3().normalize_or(DVec3::Y);
    let right = up.cross(back).normalize_or(DVec3::X);
    let position = center + (back * 0.75 - right * 0.7 + up * 0.85).normalize() * reach * 1.5;
    position.as_vec3()
}

/// The corners of the box, or of a unit box where there is none or it is a point.
fn corners_or_unit(bounds: Bounds) -> (DVec3, DVec3) {
    let (lo, hi) = (bounds.lo.as_dvec3(), bounds.hi.as_dvec3());
    if bounds.is_empty() {
        return (DVec3::splat(-1.0), DVec3::ONE);
    }
    // Rounding to f32 must leave a distance between the camera and what it looks at.
    let least = lo.abs().max(hi.abs()).max_element().max(1e-30) * 1e-5;
    match (hi - lo).max_element() < least {
        true => (lo - least, hi + least),
        false => (lo, hi),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_of_many_triangles_are_those_of_the_scene() {
        let mut scene = Scene::default();
        for k in 0..200_000 {
            let position = |j: u32| Vec3::new((k * j) as f32, (k % 77) as f32 - 3.0, -(j as f32));
            scene.add_triangle([position(1), position(2), position(3)], None, 0);
        }
        // A vertex that no triangle uses does not count.
        scene.triangles.vertices.push(Vec3::splat(1e9));
        let options = Options {
            threads: 3,
            ..Options::default()
        };
        let (bounds, expected) = (bounds_of(&scene, &options), scene.bounds());
        assert_eq!((bounds.lo, bounds.hi), (expected.lo, expected.hi));
    }

    #[test]
    fn every_corner_of_the_box_is_in_the_frame() {
        for (lo, hi, aspect) in [
            (Vec3::splat(-1.0), Vec3::ONE, 4.0 / 3.0),
            (Vec3::new(5.0, 0.0, -9.0), Vec3::new(900.0, 0.1, -8.0), 1.0),
            (Vec3::splat(1e7), Vec3::splat(1e7 + 8.0), 0.5),
            (Vec3::splat(3e-12), Vec3::splat(4e-12), 2.0),
            (Vec3::ONE, Vec3::ONE, 1.0),
        ] {
            let view = framing(Bounds::new(lo, hi), aspect);
            let basis = view.basis().expect("a camera");
            let tangent = libm::tan(f64::from(view.fovy).to_radians() / 2.0);
            for k in 0..8 {
                let pick = |axis: usize| {
                    if k >> axis & 1 == 0 {
                        lo[axis]
                    } else {
                        hi[axis]
                    }
                };
                let corner = Vec3::new(pick(0), pick(1), pick(2));
                let to = corner.as_dvec3() - view.eye.as_dvec3();
                let depth = -to.dot(basis.w.as_dvec3());
                assert!(depth > 0.0, "{corner} behind {view:?}");
                let across = to.dot(basis.u.as_dvec3()).abs() / aspect;
                let along = to.dot(basis.v.as_dvec3()).abs();
                assert!(
                    across.max(along) <= depth * tangent,
                    "{corner} outside {view:?}"
                );
            }
        }
    }
}
