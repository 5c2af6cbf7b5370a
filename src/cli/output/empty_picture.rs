//! A picture of something that shows nothing: found while its bands are written, and explained.

use phalanx::camera::Camera;
use phalanx::render::Film;
use phalanx::scene::{Bounds, Scene};

/// Fewest pixels of a picture that may be called empty: a detail may well be of one colour.
const MIN_PIXELS: usize = 64;

/// The colour of all pixels so far, while they are of one.
#[derive(Clone, Copy, Debug, Default)]
pub enum EvenColor {
    /// No pixel yet.
    #[default]
    Nothing,
    /// One colour, and the number of pixels.
    All([f32; 3], usize),
    /// Several colours.
    Several,
}

impl EvenColor {
    /// Adds the pixels of a band.
    pub fn add(&mut self, band: &Film) {
        let pixels = band.planes[0].len();
        if pixels == 0 || matches!(self, EvenColor::Several) {
            return;
        }
        let (color, before) = match *self {
            EvenColor::All(color, before) => (color, before),
            _ => (band.pixel(0, 0), 0),
        };
        let mut planes = band.planes.iter().zip(color);
        *self = match planes.all(|(plane, c)| plane.iter().all(|&p| p == c)) {
            true => EvenColor::All(color, before + pixels),
            false => EvenColor::Several,
        };
    }

    /// The reason why a picture of a scene, of this size, is empty: nothing but background, or
    /// black. `None` if it is not, or if the scene is.
    pub fn explain(self, scene: &Scene, size: (u32, u32)) -> Option<String> {
        let EvenColor::All(color, pixels) = self else {
            return None;
        };
        let background = color == scene.background.to_array();
        if pixels < MIN_PIXELS || scene.prim_count() == 0 || !(background || color == [0.0; 3]) {
            return None;
        }
        let reason = reason(scene, background, size);
        Some(format!(
            "the picture is empty, all of it has one colour: {reason}"
        ))
    }
}

fn reason(scene: &Scene, background: bool, size: (u32, u32)) -> String {
    let m = &scene.materials;
    let bounds = scene.bounds();
    let clear = |prim: u32| m.opacity[scene.prim_material(prim) as usize] == 0.0;
    if (0..scene.prim_count() as u32).all(clear) {
        return "every surface is clear, its opacity is 0".into();
    }
    if let Some(place) = outside(scene, bounds, size) {
        return format!("all of the scene lies {place} (see --camera)");
    }
    let eye = scene.view.eye;
    let inside = eye.cmpge(bounds.lo).all() && eye.cmple(bounds.hi).all();
    if background {
        return match inside {
            true => "the camera stands within the scene and looks past all of it (see --camera)".into(),
            false => "nothing of the scene is seen, or it is as dark or bright as the background (see --camera, --background)".into(),
        };
    }
    if scene.lights.is_empty() {
        return "there is no light, and nothing shines by itself (see --light)".into();
    }
    match inside {
        true => "the camera stands within the scene, where no light comes (see --camera, --light)"
            .into(),
        false => "no light reaches what is seen (see --light)".into(),
    }
}

/// Where the scene lies, if its box is wholly outside a picture of this size.
fn outside(scene: &Scene, bounds: Bounds, (width, height): (u32, u32)) -> Option<&'static str> {
    let camera = Camera::new(&scene.view, width, height).ok()?;
    // Right, up and ahead of the eye, and the distance of pixels there.
    let corners = bounds.corners().map(|corner| {
        let to = corner - camera.eye;
        let ahead = -to.dot(camera.back);
        let pixel = camera.slope * if camera.parallel { 1.0 } else { ahead };
        [to.dot(camera.right), to.dot(camera.up), ahead, pixel]
    });
    let all = |beyond: &dyn Fn([f32; 4]) -> bool| corners.into_iter().all(beyond);
    if all(&|[_, _, ahead, _]| ahead <= 0.0) {
        return Some("behind the camera");
    }
    for sign in [1.0, -1.0] {
        if all(&|[right, _, _, pixel]| sign * right > camera.half_width * pixel) {
            return Some("beside the picture");
        }
        if all(&|[_, up, _, pixel]| sign * up > camera.half_height * pixel) {
            return Some("above or below the picture");
        }
    }
    None
}
