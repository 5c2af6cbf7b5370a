//! The last step of every reader: it applies the user's overrides, adds what the file lacks, and
//! checks that the scene can be traced.

use super::camera_choice;
use super::diagnostics::{DiagnosticSink, Span};
use super::framing::{PictureShape, framing, middle_and_half, parallel_height};
use super::loaded::Loaded;
use super::options::{AddedLight, Options};
use super::origin::{self, Origin, ReadStop};
use super::visible_vertices::VisibleVertices;
use glam::{DVec3, Vec3};
use phalanx_scene::{
    Bounds, DefaultedParts, OrthoHeight, SINGLE_SIDED, Scene, SceneError, Sky, UpAxis, View,
};

/// Parts of a scene that a file does not give, so that defaults are needed. By default, it gives
/// all of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct MissingParts {
    /// True if the file has no camera. The default frames everything.
    pub(super) view: bool,
    /// True if the file has no light. The default is a key light beside the camera.
    pub(super) lights: bool,
    /// True if the file has no background. The default is a quiet one.
    pub(super) background: bool,
    /// The axis that points up where nobody says so.
    pub(super) up: UpAxis,
    /// True if the format does not say what is up.
    pub(super) up_unsaid: bool,
}

/// Background behind a mesh without surroundings: dark enough for its lit side, light enough for
/// its shadow.
const BACKGROUND: Vec3 = Vec3::new(0.095, 0.11, 0.135);

/// Colour of the key light.
const KEY_LIGHT_COLOR: Vec3 = Vec3::new(1.0, 0.97, 0.92);

/// Colour of the fill light: dim enough for shadows to show, bright enough for the forms in them.
const FILL_LIGHT_COLOR: Vec3 = Vec3::new(0.17, 0.19, 0.225);

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
        scene.add_missing_tangents();
        scene.defaulted = DefaultedParts {
            view: missing.view,
            light: missing.lights,
            bare: missing.view && missing.lights && missing.background,
            sky: missing.background,
            up: missing.up,
            ..scene.defaulted
        };
        if missing.background {
            scene.background = BACKGROUND;
        }
        let decided = decide(&mut scene, options);
        decided.map_err(|error| ReadStop::Options(error.to_string()))?;
        notes = notes_on(&scene, missing, options);
        // Checked once in the file's units, and once as it will be traced: a scene that holds both
        // 1e30 and 1e-30 units cannot be brought into f32's comfortable range as a whole.
        let told = |error: SceneError| format!("the scene cannot be traced: {error}");
        if let Err(error) = scene.validate() {
            report.error(Span::START, told(error));
        } else {
            let unit = scene.scale;
            scene.rescale_to_f32_range();
            if scene.scale != unit
                && let Err(error) = scene.validate()
            {
                if options.view.is_some() || !options.lights.is_empty() {
                    let reason = format!("--camera or --light is too far away: {error}");
                    return Err(ReadStop::Options(reason));
                }
                let help =
                    "its largest and smallest parts may lie too far apart for single precision";
                report.error_with_help(Span::START, told(error), help);
            }
        }
    }
    let warnings = report.finish()?;
    Ok(Loaded {
        scene,
        files: Vec::new(),
        warnings,
        notes,
    })
}

/// Notes on what was made up, and on options that do nothing.
fn notes_on(scene: &Scene, missing: &MissingParts, options: &Options) -> Vec<String> {
    let mut notes: Vec<String> = Vec::new();
    let DefaultedParts {
        view, light, sky, ..
    } = scene.defaulted;
    if view {
        let assumed_y = options.up.is_none() && missing.up_unsaid && missing.up == UpAxis::Y;
        let up = if assumed_y { ", y up (see --camera, --up)" } else { " (see --camera)" };
        let used = "the file has no camera: one that frames everything is used";
        notes.push(format!("{used}{up}"));
    }
    if light {
        let fill = if scene.defaulted.bare { " and a fill light are" } else { " is" };
        notes.push(format!(
            "the file has no light: a point light over the camera's shoulder{fill} used (see --light)"
        ));
    }
    if sky && scene.sky.is_some() {
        notes.push(
            "the file has no surroundings: mirrors see a sky, dark below and bright above (see --background)"
                .into(),
        );
    }
    notes.extend(camera_choice::note(scene, options));
    notes.extend(note_on_up(scene, options));
    if view && options.up.is_none() && missing.up != UpAxis::Y {
        notes.push("the model is taken as Z-up, as is the custom in its format (see --up)".into());
    }
    notes
}

/// Radiance that mirrors see above a mesh without surroundings: that of a bright room.
const ZENITH: Vec3 = Vec3::new(0.62, 0.68, 0.76);
/// Radiance that they see below.
const NADIR: Vec3 = Vec3::new(0.05, 0.045, 0.04);

/// Applies the options, and makes what is made up: the one place for all that depends on the
/// picture. Parts that it made for another picture are made again, from [`Scene::defaulted`], so
/// that a cache gives the picture of its file; looking at millions of vertices takes time.
fn decide(scene: &mut Scene, options: &Options) -> Result<(), SceneError> {
    let before = scene.defaulted;
    camera_choice::choose(scene, options)?;
    apply_overrides(scene, options);
    let DefaultedParts {
        view,
        light,
        sky,
        up,
        ortho,
        ortho_size,
        ..
    } = scene.defaulted;
    let (width, height) = options.size.unwrap_or((scene.width, scene.height));
    let aspect = f64::from(width) / f64::from(height);
    // Other scenes are the same for every picture.
    let picture = if view || ortho_size.is_some() {
        (aspect, options.turntable)
    } else {
        (1.0, false)
    };
    scene.defaulted.made_for = Some(picture);
    let is_placed = options.view.is_some() || options.camera.is_some();
    if scene.defaulted == before && !is_placed {
        return Ok(());
    }
    let mut fitting = None;
    if view || light {
        let visible = VisibleVertices::of(scene, options.threads);
        let bounds = visible.bounds(scene);
        if view {
            let turntable = options.turntable;
            let shape = PictureShape {
                aspect,
                up,
                turntable,
            };
            scene.view = framing(scene, &visible, bounds, shape);
            if ortho == Some(OrthoHeight::Fitting) {
                fitting = Some(parallel_height(scene, &visible, &scene.view, bounds, shape));
            }
        }
        if light {
            DefaultLights { bounds }.place(scene);
        }
    }
    let visible_height = match (ortho, ortho_size) {
        (Some(OrthoHeight::Given(height)), _) => Some(height * f64::from(scene.scale)),
        (_, Some([width, height])) => Some(height.max(width / aspect) * f64::from(scene.scale)),
        (Some(OrthoHeight::Fitting), None) => fitting.or(Some(seen_height(&scene.view))),
        (None, None) => scene.view.ortho.map(f64::from),
    };
    scene.view.ortho = visible_height.map(|height| height as f32);
    if sky {
        scene.sky = has_mirrors(scene).then_some(Sky {
            up: up.frame()[1].as_vec3(),
            nadir: NADIR,
            zenith: ZENITH,
        });
    }
    Ok(())
}

/// Visible height of a perspective, as far away as the point that it looks at.
fn seen_height(view: &View) -> f64 {
    let distance = view.eye.as_dvec3().distance(view.center.as_dvec3());
    2.0 * distance * libm::tan(f64::from(view.fovy).to_radians() / 2.0)
}

/// Returns true if rays bounce off or go through a surface.
fn has_mirrors(scene: &Scene) -> bool {
    let m = &scene.materials;
    let bounces = |k: usize| m.may_mirror(k) || m.kt.get(k) != Vec3::ZERO;
    (0..m.len()).any(bounces)
}

/// Lights of a scene whose file has none. They stand beside its camera, wherever that goes.
#[derive(Clone, Copy, Debug)]
pub struct DefaultLights {
    /// Bounds of everything visible.
    bounds: Bounds,
}

impl DefaultLights {
    /// The lights of a scene, found by this many threads (0: one per CPU); `None` if its lights are
    /// its own.
    pub fn of(scene: &Scene, threads: usize) -> Option<DefaultLights> {
        let bounds = || VisibleVertices::of(scene, threads).bounds(scene);
        let lights = || DefaultLights { bounds: bounds() };
        scene.defaulted.light.then(lights)
    }

    /// Gives the scene a key light above and to the left of its camera, and if it is a bare mesh a
    /// fill light.
    pub fn place(&self, scene: &mut Scene) {
        let (center, half) = middle_and_half(self.bounds);
        let from = scene.view.eye.as_dvec3() - center;
        let back = from.normalize_or(DVec3::Z);
        let up = scene.view.up.as_dvec3().normalize_or(DVec3::Y);
        let right = up.cross(back).normalize_or(DVec3::X);
        // As far from the middle as the camera, so that the shadow side shows the shape.
        let reach = from.length().max(2.0 * half.length());
        let key = (back * 0.75 - right * 0.7 + up * 0.85).normalize();
        let position = (center + key * reach * 1.5).as_vec3();
        scene.lights = Default::default();
        scene.lights.add_point(position, KEY_LIGHT_COLOR, Vec3::X);
        if scene.defaulted.bare {
            // From below the other shoulder, where the key light's shadows fall.
            let fill = (back * 0.55 + right * 0.7 - up * 0.35).normalize();
            scene.lights.add_fill(fill.as_vec3(), FILL_LIGHT_COLOR);
        }
    }
}

/// A note if `--up` was given and has no effect.
fn note_on_up(scene: &Scene, options: &Options) -> Option<String> {
    // A sky has an axis of its own.
    if options.up.is_none() || scene.defaulted.view || scene.sky.is_some() {
        return None;
    }
    let reason = if options.view.is_some() {
        "with --camera"
    } else {
        "on a scene that has a camera"
    };
    Some(format!("--up has no effect {reason}"))
}

/// Replaces parts of a finished scene by those that the user gives, and makes those that are made
/// up once more. Positions are in the file's units. Returns notes on options that have no effect.
///
/// # Errors
/// [`SceneError`] if the result cannot be traced; the scene must not be used then.
pub fn override_scene(scene: &mut Scene, options: &Options) -> Result<Vec<String>, SceneError> {
    decide(scene, options)?;
    // The scene was rescaled into the comfortable range when it was made. Parts that are placed now
    // cannot change its scale any more.
    let DefaultedParts { view, light, .. } = scene.defaulted;
    let moved = options.view.is_some() || options.camera.is_some() || !options.lights.is_empty();
    if (moved || view || light) && !scene.is_in_safe_range() {
        return Err(SceneError::TooFar(scene.safe_extent()));
    }
    scene.validate_settings()?;
    let notes = camera_choice::note(scene, options).into_iter();
    Ok(notes.chain(note_on_up(scene, options)).collect())
}

fn apply_overrides(scene: &mut Scene, options: &Options) {
    if let Some(view) = &options.view {
        scene.view = scene.view_of(view);
        scene.defaulted.view = false;
        scene.defaulted.ortho_size = None;
    }
    scene.defaulted.up = options.up.unwrap_or(scene.defaulted.up);
    scene.defaulted.ortho = options.ortho.or(scene.defaulted.ortho);
    if !options.lights.is_empty() {
        scene.lights = Default::default();
        scene.defaulted.light = false;
        scene.defaulted.bare = false;
        for light in &options.lights {
            add_light(scene, light);
        }
    }
    if let Some(color) = options.background {
        scene.background = color;
        scene.defaulted.sky = false;
        scene.sky = None;
    }
    scene.smooth_shadows = options.smooth_shadows.unwrap_or(scene.smooth_shadows);
    if options.two_sided && scene.has_unseen_backs() {
        let flags = scene.materials.flags.make_mut();
        flags.iter_mut().for_each(|flags| *flags &= !SINGLE_SIDED);
    }
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
