//! The steps from a scene as its file gives it to one that can be rendered: overrides, default
//! parts, and validation.

use super::camera_choice;
use super::framing::{PictureShape, framing, parallel_height};
use super::lights;
use super::overrides::{AddedLight, Overrides};
use glam::{DVec3, Vec3};
use phalanx_scene::{
    Environment, OrthoHeight, SINGLE_SIDED, Scene, SceneError, UpAxis, View, VisibleVertices,
};

/// The reason why a scene cannot be traced.
#[derive(Debug)]
pub struct UnfitScene {
    /// The fault.
    pub message: String,
    /// A probable cause, if there is one.
    pub help: Option<&'static str>,
    /// True if an override is to blame, and not the file.
    pub is_override: bool,
}

/// Background behind a mesh without surroundings: dark enough for its lit side, light enough for
/// its shadow.
const BACKGROUND: Vec3 = Vec3::new(0.095, 0.11, 0.135);

/// Finishes a scene as a reader returns it: applies the overrides, adds default parts for those
/// that [`Scene::defaulted`] names, and brings it into the range of single precision. Uses up to
/// `threads` threads, 0 for one per CPU. `up_is_assumed` is true if the format does not say which
/// axis points up. Returns notes on default parts, and on overrides that have no effect.
///
/// # Errors
/// [`UnfitScene`]; the scene must not be used then.
pub fn finish_scene(
    scene: &mut Scene,
    up_is_assumed: bool,
    overrides: &Overrides,
    threads: usize,
) -> Result<Vec<String>, UnfitScene> {
    scene.view = scene.representable_view(&scene.view);
    for k in 0..scene.cameras.len() {
        scene.cameras[k].view = scene.representable_view(&scene.cameras[k].view);
    }
    if scene.defaulted.sky {
        scene.background = BACKGROUND;
    }
    let unfit = |message: String, is_override: bool| UnfitScene {
        message,
        help: None,
        is_override,
    };
    apply(scene, overrides, threads).map_err(|error| unfit(error.to_string(), true))?;
    let notes = notes_on(scene, up_is_assumed, overrides);
    // Checked once in the file's units, and once as it will be traced: a scene that holds both
    // 1e30 and 1e-30 units cannot be brought into f32's comfortable range as a whole.
    let of_file = |error| unfit(format!("the scene cannot be traced: {error}"), false);
    scene.validate().map_err(of_file)?;
    let unit = scene.scale;
    scene.rescale_to_f32_range();
    if scene.scale != unit
        && let Err(error) = scene.validate()
    {
        if overrides.view.is_some() || !overrides.lights.is_empty() {
            let message = format!("--camera or --light is too far away: {error}");
            return Err(unfit(message, true));
        }
        let help = "its largest and smallest parts may lie too far apart for single precision";
        return Err(UnfitScene {
            help: Some(help),
            ..of_file(error)
        });
    }
    Ok(notes)
}

/// Notes on default parts, and on overrides that have no effect.
fn notes_on(scene: &Scene, up_is_assumed: bool, overrides: &Overrides) -> Vec<String> {
    let mut notes: Vec<String> = Vec::new();
    let defaulted = &scene.defaulted;
    let is_up_given = overrides.up.is_some();
    if defaulted.view {
        let assumed_y = !is_up_given && up_is_assumed && defaulted.up == UpAxis::Y;
        let up = if assumed_y { ", y up (see --camera, --up)" } else { " (see --camera)" };
        let used = "the file has no camera: one that frames everything is used";
        notes.push(format!("{used}{up}"));
    }
    if defaulted.light && !overrides.headlight {
        notes.push(
            "the file has no light: a point light over the camera's shoulder and a fill light are used (see --light)"
                .into(),
        );
    }
    if defaulted.sky && scene.environment.is_some() {
        notes.push(
            "the file has no surroundings: mirrors see a sky, dark below and bright above (see --background)"
                .into(),
        );
    }
    notes.extend(notes_without_effect(scene, overrides));
    if defaulted.view && !is_up_given && defaulted.up != UpAxis::Y {
        notes.push("the model is taken as Z-up, as is the custom in its format (see --up)".into());
    }
    notes
}

/// Note for users of renderers whose environment lights everything.
const ENVIRONMENT_NOTE: &str = "the environment shows behind the scene, in mirrors and through glass; it lights no matt surface";

/// Notes on the choice of a camera and on the environment, and on options that have no effect.
fn notes_without_effect(
    scene: &Scene,
    overrides: &Overrides,
) -> impl Iterator<Item = String> + use<> {
    let on_camera = camera_choice::note(scene, overrides);
    let on_turn = overrides.environment_turn.is_some() && scene.environment.is_none();
    let on_turn = on_turn.then(|| "--environment-turn has no effect without an environment".into());
    let on_light = overrides.environment.is_some();
    let on_light = on_light.then(|| ENVIRONMENT_NOTE.to_owned());
    let others = [on_camera, note_on_up(scene, overrides), on_turn, on_light];
    others.into_iter().flatten()
}

/// Applies the overrides, and makes the default parts: the one place for all that depends on the
/// picture. Parts that were made for another picture are made again, from [`Scene::defaulted`], so
/// that a cache gives the picture of its file. Parts that were made for this one are kept, because
/// millions of vertices take time.
fn apply(scene: &mut Scene, overrides: &Overrides, threads: usize) -> Result<(), SceneError> {
    let before = scene.defaulted;
    camera_choice::choose(scene, overrides)?;
    apply_overrides(scene, overrides);
    let defaulted = scene.defaulted;
    let (width, height) = overrides.size.unwrap_or((scene.width, scene.height));
    let aspect = f64::from(width) / f64::from(height);
    // Other scenes are the same for every picture.
    let picture = if defaulted.view || defaulted.ortho_size.is_some() {
        (aspect, overrides.turntable)
    } else {
        (1.0, false)
    };
    scene.defaulted.made_for = Some(picture);
    let is_placed = overrides.view.is_some() || overrides.camera.is_some();
    if scene.defaulted == before && !is_placed {
        return Ok(());
    }
    let mut fitting = None;
    if defaulted.view || defaulted.light {
        let visible = VisibleVertices::of(scene, threads);
        let bounds = visible.bounds(scene);
        if defaulted.view {
            let shape = PictureShape {
                aspect,
                up: defaulted.up,
                turntable: overrides.turntable,
            };
            scene.view = scene.representable_view(&framing(scene, &visible, bounds, shape));
            if defaulted.ortho == Some(OrthoHeight::Fitting) {
                fitting = Some(parallel_height(scene, &visible, &scene.view, bounds, shape));
            }
        }
        if defaulted.light {
            lights::place(scene, bounds);
        }
    }
    let visible_height = match (defaulted.ortho, defaulted.ortho_size) {
        (Some(OrthoHeight::Given(height)), _) => Some(height * f64::from(scene.scale)),
        (_, Some([width, height])) => Some(height.max(width / aspect) * f64::from(scene.scale)),
        (Some(OrthoHeight::Fitting), None) => fitting.or(Some(seen_height(&scene.view))),
        (None, None) => scene.view.ortho.map(f64::from),
    };
    scene.view.ortho = visible_height.map(|height| height as f32);
    if defaulted.sky {
        scene.environment = lights::sky(scene, defaulted.up);
    }
    Ok(())
}

/// Visible height of a perspective, as far away as the point that it looks at.
fn seen_height(view: &View) -> f64 {
    let distance = view.eye.as_dvec3().distance(view.center.as_dvec3());
    2.0 * distance * libm::tan(f64::from(view.fovy).to_radians() / 2.0)
}

/// A note if `--up` was given and has no effect.
fn note_on_up(scene: &Scene, overrides: &Overrides) -> Option<String> {
    // An environment has an axis of its own.
    if overrides.up.is_none() || scene.defaulted.view || scene.environment.is_some() {
        return None;
    }
    let reason = if overrides.view.is_some() {
        "with --camera"
    } else {
        "on a scene that has a camera"
    };
    Some(format!("--up has no effect {reason}"))
}

/// Applies overrides to a finished scene, and makes its default parts again if they depend on
/// them. Positions are in the file's units. Uses up to `threads` threads, 0 for one per CPU.
/// Returns notes on overrides that have no effect.
///
/// # Errors
/// [`SceneError`] if the result cannot be traced; the scene must not be used then.
pub fn override_scene(
    scene: &mut Scene,
    overrides: &Overrides,
    threads: usize,
) -> Result<Vec<String>, SceneError> {
    apply(scene, overrides, threads)?;
    // The scene was rescaled into the comfortable range when it was made. Parts that are placed now
    // cannot change its scale any more.
    let moved =
        overrides.view.is_some() || overrides.camera.is_some() || !overrides.lights.is_empty();
    if (moved || scene.defaulted.view || scene.defaulted.light) && !scene.is_in_safe_range() {
        return Err(SceneError::TooFar(scene.safe_extent()));
    }
    scene.validate_settings()?;
    Ok(notes_without_effect(scene, overrides).collect())
}

fn apply_overrides(scene: &mut Scene, overrides: &Overrides) {
    if let Some(view) = &overrides.view {
        scene.view = scene.view_of(view);
        scene.defaulted.view = false;
        scene.defaulted.ortho_size = None;
    }
    scene.defaulted.up = overrides.up.unwrap_or(scene.defaulted.up);
    scene.defaulted.ortho = overrides.ortho.or(scene.defaulted.ortho);
    scene.defaulted.light |= overrides.headlight;
    if overrides.headlight || !overrides.lights.is_empty() {
        // Only the file's lamps have units.
        scene.set_light_scale(1.0);
    }
    if !overrides.lights.is_empty() {
        scene.lights = Default::default();
        scene.defaulted.light = false;
        for light in &overrides.lights {
            add_light(scene, light);
        }
    }
    if let Some(color) = overrides.background {
        scene.background = color;
        // A sky that was made up is only for want of a background.
        if std::mem::take(&mut scene.defaulted.sky) {
            scene.environment = None;
        } else if let Some(environment) = &mut scene.environment {
            environment.is_background = false;
        }
    }
    if let Some(light) = &overrides.environment {
        scene.defaulted.sky = false;
        let mut environment = Environment::new(light.clone(), scene.defaulted.up, 0.0);
        environment.is_background = overrides.background.is_none();
        scene.environment = Some(environment);
    }
    place_environment(scene, overrides);
    scene.smooth_shadows = overrides.smooth_shadows.unwrap_or(scene.smooth_shadows);
    if overrides.two_sided && scene.has_unseen_backs() {
        let flags = scene.materials.flags.make_mut();
        flags.iter_mut().for_each(|flags| *flags &= !SINGLE_SIDED);
    }
}

/// Places an environment by the up axis and the turn that are given, and scales it with the other
/// lights.
fn place_environment(scene: &mut Scene, overrides: &Overrides) {
    let Some(mut environment) = scene.environment.take() else {
        return;
    };
    let (up, turn) = environment.placement();
    let turn = overrides.environment_turn.unwrap_or(turn);
    environment.place(overrides.up.unwrap_or(up), turn);
    environment.scale = lights::environment_scale(&environment.light, scene);
    scene.environment = Some(environment);
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
