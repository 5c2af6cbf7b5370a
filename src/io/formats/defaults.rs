//! The last step of every reader: it applies the user's overrides, adds what the file lacks, and
//! checks that the scene can be traced.

use super::diagnostics::{DiagnosticSink, Span};
use super::framing::{PictureShape, framing, middle_and_half, parallel_height};
use super::loaded::Loaded;
use super::options::{AddedLight, Options, OrthoHeight};
use super::origin::{self, Origin, ReadStop};
use super::up_axis::UpAxis;
use super::visible_vertices::VisibleVertices;
use glam::{DVec3, Vec3};
use phalanx_scene::{Bounds, MadeUpParts, SINGLE_SIDED, Scene, SceneError, Sky, View};

/// Parts of a scene that a file does not give, so that defaults are needed.
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

impl MissingParts {
    /// The format gives every part itself.
    pub(super) const NOTHING: MissingParts = MissingParts {
        view: false,
        lights: false,
        background: false,
        up: UpAxis::Y,
        up_unsaid: false,
    };
}

/// Background behind a mesh without surroundings: dark enough for its lit side, light enough for
/// its shadow.
const BACKGROUND: Vec3 = Vec3::new(0.095, 0.11, 0.135);

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
        files: Vec::new(),
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
    scene.made_up = MadeUpParts {
        view: missing.view,
        light: missing.lights,
    };
    if missing.background {
        scene.background = BACKGROUND;
    }
    apply_overrides(scene, options);
    let up = options.up.unwrap_or(missing.up);
    let MadeUpParts { view, light } = scene.made_up;
    if view || light {
        let visible = VisibleVertices::of(scene, options.threads);
        let bounds = visible.bounds(scene);
        if view {
            make_up_view(scene, &visible, bounds, up, options);
            let assumed_y = options.up.is_none() && missing.up_unsaid && missing.up == UpAxis::Y;
            let options_of = match assumed_y {
                true => ", y up (see --camera, --up)",
                false => " (see --camera)",
            };
            let used = "the file has no camera: one that frames everything is used";
            notes.push(format!("{used}{options_of}"));
        }
        if light {
            make_up_light(scene, bounds);
            notes.push(
                "the file has no light: a point light over the camera's shoulder is used (see --light)"
                    .into(),
            );
        }
    }
    apply_projection(scene, options.ortho, options);
    if missing.background && options.background.is_none() {
        notes.extend(make_up_sky(scene, up));
    }
    notes.extend(note_on_up(scene, options));
    if view && options.up.is_none() && missing.up != UpAxis::Y {
        notes.push("the model is taken as Z-up, as is the custom in its format (see --up)".into());
    }
}

/// Radiance that mirrors see above a mesh without surroundings: that of a bright room.
const ZENITH: Vec3 = Vec3::new(0.62, 0.68, 0.76);
/// Radiance that they see below.
const NADIR: Vec3 = Vec3::new(0.05, 0.045, 0.04);

/// Gives mirrors something to see before an even background. Returns a note if there are any.
fn make_up_sky(scene: &mut Scene, up: UpAxis) -> Option<String> {
    let m = &scene.materials;
    let bounces = |k: usize| m.ks.get(k) != Vec3::ZERO || m.kt.get(k) != Vec3::ZERO;
    if !(0..m.len()).any(bounces) {
        return None;
    }
    let [_, up, _] = up.frame();
    scene.sky = Some(Sky {
        up: up.as_vec3(),
        nadir: NADIR,
        zenith: ZENITH,
    });
    let note = "the file has no surroundings: mirrors see a sky, dark below and bright above (see --background)";
    Some(note.into())
}

/// Makes the camera's rays parallel, if the user wants that. Without a given height, a made-up
/// camera still shows everything, and any other shows what lies as far away as the point that it
/// looks at in the same size as before.
fn apply_projection(scene: &mut Scene, ortho: Option<OrthoHeight>, options: &Options) {
    let Some(height) = ortho else {
        return;
    };
    let height = match height {
        OrthoHeight::Given(height) => height * f64::from(scene.scale),
        OrthoHeight::Fitting if scene.made_up.view => {
            let shape = picture_shape(scene, UpAxis::of(&scene.view).unwrap_or_default(), options);
            let visible = VisibleVertices::of(scene, options.threads);
            let bounds = visible.bounds(scene);
            parallel_height(scene, &visible, &scene.view, bounds, shape)
        }
        OrthoHeight::Fitting => {
            let distance = scene
                .view
                .eye
                .as_dvec3()
                .distance(scene.view.center.as_dvec3());
            let half_angle = f64::from(scene.view.fovy).to_radians() / 2.0;
            2.0 * distance * libm::tan(half_angle)
        }
    };
    scene.view.ortho = Some(height as f32);
}

/// The picture that a camera is made up for.
fn picture_shape(scene: &Scene, up: UpAxis, options: &Options) -> PictureShape {
    PictureShape {
        aspect: aspect(options.size.unwrap_or((scene.width, scene.height))),
        up,
        turntable: options.turntable,
    }
}

fn make_up_view(
    scene: &mut Scene,
    visible: &VisibleVertices,
    bounds: Bounds,
    up: UpAxis,
    options: &Options,
) {
    let shape = picture_shape(scene, up, options);
    scene.view = framing(scene, visible, bounds, shape);
}

/// Turns a sky that was made with this axis up to the axis of the view that was made up since.
fn turn_sky(scene: &mut Scene, from: Option<UpAxis>) {
    let from = from.map(|axis| axis.frame()[1].as_vec3());
    if let Some(sky) = scene.sky.as_mut().filter(|sky| Some(sky.up) == from) {
        sky.up = scene.view.up;
    }
}

fn make_up_light(scene: &mut Scene, bounds: Bounds) {
    let position = key_light(&scene.view, bounds);
    scene.lights = Default::default();
    scene.lights.add_point(position, KEY_LIGHT_COLOR, Vec3::X);
}

fn aspect((width, height): (u32, u32)) -> f64 {
    f64::from(width) / f64::from(height)
}

/// A note where the axis that points up was given and does nothing.
fn note_on_up(scene: &Scene, options: &Options) -> Option<String> {
    // A sky has an axis of its own.
    if options.up.is_none() || scene.made_up.view || scene.sky.is_some() {
        return None;
    }
    let reason = match options.view.is_some() {
        true => "--camera says what is up",
        false => "the scene has its camera",
    };
    Some(format!("{reason}: --up changes nothing"))
}

/// Replaces parts of a finished scene by those that the user gives, and makes those that were made
/// up once more, if they depend on them. Positions are in the file's units. Returns notes on
/// options that mean nothing here.
///
/// # Errors
/// [`SceneError`] if the result cannot be traced; the scene must not be used then.
pub fn override_scene(scene: &mut Scene, options: &Options) -> Result<Vec<String>, SceneError> {
    let parallel = scene.view.ortho.is_some();
    apply_overrides(scene, options);
    let MadeUpParts { view, light } = scene.made_up;
    let up = UpAxis::of(&scene.view);
    let size = (scene.width, scene.height);
    let stored = aspect(size) == aspect(options.size.unwrap_or(size))
        && options.up.is_none_or(|asked| up == Some(asked))
        && !options.turntable;
    let (view, light) = (
        view && !stored,
        light && (options.view.is_some() || !stored),
    );
    let mut ortho = options.ortho;
    if view || light {
        let visible = VisibleVertices::of(scene, options.threads);
        let bounds = visible.bounds(scene);
        if view {
            make_up_view(
                scene,
                &visible,
                bounds,
                options.up.or(up).unwrap_or_default(),
                options,
            );
            turn_sky(scene, up);
            ortho = ortho.or(parallel.then_some(OrthoHeight::Fitting));
        }
        if light {
            make_up_light(scene, bounds);
        }
    }
    apply_projection(scene, ortho, options);
    // The scene was rescaled into the comfortable range when it was made. Parts given now cannot
    // change its scale any more.
    let given = options.view.is_some() || !options.lights.is_empty() || view;
    if given && !scene.is_in_safe_range() {
        return Err(SceneError::TooFar(scene.safe_extent()));
    }
    scene.validate_settings()?;
    Ok(note_on_up(scene, options).into_iter().collect())
}

fn apply_overrides(scene: &mut Scene, options: &Options) {
    if let Some(view) = &options.view {
        scene.view = scene.view_of(view);
        scene.made_up.view = false;
    }
    if !options.lights.is_empty() {
        scene.lights = Default::default();
        scene.made_up.light = false;
        for light in &options.lights {
            add_light(scene, light);
        }
    }
    if let Some(color) = options.background {
        scene.background = color;
        scene.sky = None;
    }
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

/// A light above and to the left of the camera, as far from the middle as the camera, so that the
/// shadow side shows the shape.
fn key_light(view: &View, bounds: Bounds) -> Vec3 {
    let (center, half) = middle_and_half(bounds);
    let from = view.eye.as_dvec3() - center;
    let reach = from.length().max(2.0 * half.length());
    let back = from.normalize_or(DVec3::Z);
    let up = view.up.as_dvec3().normalize_or(DVec3::Y);
    let right = up.cross(back).normalize_or(DVec3::X);
    let position = center + (back * 0.75 - right * 0.7 + up * 0.85).normalize() * reach * 1.5;
    position.as_vec3()
}
