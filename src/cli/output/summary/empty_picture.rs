//! Detection of empty pictures while their bands are written, and the likely reason.

use phalanx::camera::Camera;
use phalanx::image::PictureFile;
use phalanx::render::Film;
use phalanx::scene::{Bounds, Scene};

/// Minimum size, in pixels, of a picture whose single colour is reported. A smaller one may show a
/// detail.
const MIN_PIXELS: usize = 64;

/// The warning of a picture in which nothing can be seen.
pub const EMPTY: &str = "the picture is empty (all pixels have the same colour)";

/// The common colour of all pixels so far, as it is shown, if there is one.
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
    /// Adds the pixels of a band of a file's picture.
    pub fn add(&mut self, file: &PictureFile, band: &Film) {
        let pixels = band.planes[0].len();
        if pixels == 0 || matches!(self, EvenColor::Several) {
            return;
        }
        *self = match (*self, file.even_color(band)) {
            (EvenColor::Nothing, Some(color)) => EvenColor::All(color, pixels),
            (EvenColor::All(color, before), Some(same)) if same == color => {
                EvenColor::All(color, before + pixels)
            }
            _ => EvenColor::Several,
        };
    }

    /// The reason why a picture of this size shows nothing. `None` if it shows something, or if the
    /// scene is empty, of which its reader has warned.
    pub fn explain(self, file: &PictureFile, scene: &Scene, size: (u32, u32)) -> Option<String> {
        let EvenColor::All(color, pixels) = self else {
            return None;
        };
        let background = color == file.shown()(scene.background.to_array());
        let detail = pixels < MIN_PIXELS && outside(scene, scene.bounds(), size).is_none();
        // A part of a picture may well be a part of one surface.
        let part = pixels < size.0 as usize * size.1 as usize && !background && color != [0.0; 3];
        if scene.prim_count() == 0 || detail || part {
            return None;
        }
        let reason = reason(scene, background, color, size);
        Some(format!("{EMPTY}: {reason}"))
    }
}

fn reason(scene: &Scene, background: bool, color: [f32; 3], size: (u32, u32)) -> String {
    let m = &scene.materials;
    let bounds = scene.bounds();
    let clear = |prim: u32| m.opacity[scene.prim_material(prim) as usize] == 0.0;
    if (0..scene.prim_count() as u32).all(clear) {
        return "every surface is fully transparent".into();
    }
    if let Some(place) = outside(scene, bounds, size) {
        return format!("the whole scene is {place} (see --camera)");
    }
    let eye = scene.view.eye;
    let inside = eye.cmpge(bounds.lo).all() && eye.cmple(bounds.hi).all();
    let reason = if background && inside {
        "the camera is inside the scene, but nothing is in view (see --camera)"
    } else if background {
        "nothing is visible, or it has the colour of the background (see --camera, --background, --exposure)"
    } else if color == [1.0; 3] {
        "it is overexposed (see --light, --exposure)"
    } else if color != [0.0; 3] {
        "one surface fills it, or the camera is inside an object (see --camera)"
    } else if scene.lights.is_empty() {
        "the scene has no lights and no emissive surfaces (see --light)"
    } else if inside {
        "the camera is inside the scene, where little or no light reaches (see --camera, --light)"
    } else {
        "little or no light reaches the visible surfaces (see --light, --exposure)"
    };
    reason.into()
}

/// Position of the scene, if its box is completely outside a picture of this size.
fn outside(scene: &Scene, bounds: Bounds, (width, height): (u32, u32)) -> Option<&'static str> {
    let camera = Camera::new(&scene.view, width, height).ok()?;
    // Coordinates to the right, up and ahead of the eye, and the pixel spacing there.
    let corners = bounds.corners().map(|corner| {
        let to = corner - camera.eye;
        let ahead = -to.dot(camera.back);
        let pixel = camera.slope * if camera.parallel { 1.0 } else { ahead };
        [to.dot(camera.right), to.dot(camera.up), ahead, pixel]
    });
    let all = |is_beyond: &dyn Fn([f32; 4]) -> bool| corners.into_iter().all(is_beyond);
    if all(&|[_, _, ahead, _]| ahead <= 0.0) {
        return Some("behind the camera");
    }
    for sign in [1.0, -1.0] {
        if all(&|[right, _, _, pixel]| sign * right > camera.half_width * pixel) {
            return Some("to the side of the picture");
        }
        if all(&|[_, up, _, pixel]| sign * up > camera.half_height * pixel) {
            return Some("above or below the picture");
        }
    }
    None
}
