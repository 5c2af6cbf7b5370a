//! The default lights, and the sky that mirrors reflect.

use super::framing::middle_and_half;
use glam::{DVec3, Vec3};
use phalanx_scene::{Bounds, Environment, EnvironmentLight, Scene, UpAxis, View, VisibleVertices};

/// Colour of the key light.
const KEY_LIGHT_COLOR: Vec3 = Vec3::new(1.0, 0.97, 0.92);

/// Colour of the fill light: dim enough for shadows to show, bright enough for the forms in them.
const FILL_LIGHT_COLOR: Vec3 = Vec3::new(0.17, 0.19, 0.225);

/// Default lights of a scene, if it has them: they stand beside its camera, wherever that goes.
#[derive(Clone, Copy, Debug)]
pub struct DefaultLights {
    /// Bounds of everything visible; `None` if the scene's lights are its own.
    bounds: Option<Bounds>,
}

impl DefaultLights {
    /// The lights of a scene, found by this many threads (0: one per CPU).
    pub fn of(scene: &Scene, threads: usize) -> DefaultLights {
        let bounds = || VisibleVertices::of(scene, threads).bounds(scene);
        DefaultLights {
            bounds: scene.defaulted.light.then(bounds),
        }
    }

    /// Moves the scene's camera, and these lights with it.
    pub fn move_camera(&self, scene: &mut Scene, view: View) {
        scene.view = scene.representable_view(&view);
        if let Some(bounds) = self.bounds {
            place(scene, bounds);
        }
    }
}

/// Replaces the lights of a scene with these bounds by a key light above and to the left of its
/// camera, and a fill light.
pub(super) fn place(scene: &mut Scene, bounds: Bounds) {
    let (middle, half) = middle_and_half(bounds);
    let View { eye, center, .. } = scene.view;
    let is_inside = eye.cmpgt(bounds.lo).all() && eye.cmplt(bounds.hi).all();
    let target = if is_inside { center.as_dvec3() } else { middle };
    let from = eye.as_dvec3() - target;
    let back = from.normalize_or(DVec3::Z);
    let up = scene.view.up.as_dvec3().normalize_or(DVec3::Y);
    let right = up.cross(back).normalize_or(DVec3::X);
    let shoulder = up * 0.85 - right * 0.7;
    let position = if is_inside {
        // Walls may be all around: the light stays close to the camera.
        eye.as_dvec3() + shoulder * from.length() * 0.1
    } else {
        // As far from the middle as the camera, so that the shadow side shows the shape.
        let reach = from.length().max(2.0 * half.length());
        target + (back * 0.75 + shoulder).normalize() * reach * 1.5
    };
    scene.lights = Default::default();
    (scene.lights).add_point(position.as_vec3(), KEY_LIGHT_COLOR, Vec3::X);
    // From below the other shoulder, where the key light's shadows fall.
    let fill = (back * 0.55 + right * 0.7 - up * 0.35).normalize();
    scene.lights.add_fill(fill.as_vec3(), FILL_LIGHT_COLOR);
}

/// Radiance that mirrors see above a mesh without surroundings: that of a bright room.
const ZENITH: Vec3 = Vec3::new(0.62, 0.68, 0.76);
/// Radiance that they see below.
const NADIR: Vec3 = Vec3::new(0.05, 0.045, 0.04);

/// Light of a sky, dark below and bright above.
pub const SKY: EnvironmentLight = EnvironmentLight::Gradient {
    nadir: NADIR,
    zenith: ZENITH,
};

/// Factor of an environment's light beside the lights of a scene. The default sky has no units.
pub fn environment_scale(light: &EnvironmentLight, scene: &Scene) -> f32 {
    if *light == SKY { 1.0 } else { scene.light_scale }
}

/// The surroundings of a scene whose file has none; `None` if nothing reflects them.
pub(super) fn sky(scene: &Scene, up: UpAxis) -> Option<Environment> {
    has_mirrors(scene).then(|| {
        let mut sky = Environment::new(SKY, up, 0.0);
        sky.is_background = false;
        sky
    })
}

/// Returns true if rays bounce off or go through a surface.
fn has_mirrors(scene: &Scene) -> bool {
    let m = &scene.materials;
    let bounces = |k: usize| m.may_mirror(k) || m.kt.get(k) != Vec3::ZERO;
    (0..m.len()).any(bounces)
}
