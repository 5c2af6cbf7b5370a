//! A picture that gets better sample by sample, and tile by tile, as long as there is time.

use super::settings::Settings;
use super::{FrameError, render_packets};
use crate::tile_sums::TileSums;
use crate::{Aovs, Control, Film, RenderedTiles, SharedFilm, Tile, tiles};
use phalanx_scene::Scene;
use phalanx_scene::sampling::Sampling;
use phalanx_trace::bvh::Bvh;

/// A picture of the packet engine that gets sample after sample. With N samples a pixel, it is bit
/// for bit the picture of [`render`](super::render) with N uniform samples.
///
/// ```
/// # mod phalanx { pub use {phalanx_render::frame, phalanx_scene::*, phalanx_trace::bvh::*}; }
/// use phalanx::frame::{Control, RefinedFrame, Settings};
/// use phalanx::{Bvh, Scene};
///
/// let mut scene = Scene::new();
/// scene.add_spheres(&[[0.0; 3]], &[1.0])?;
/// let (bvh, control) = (Bvh::build(&scene), Control::default());
/// let mut frame = RefinedFrame::new(Settings { width: 40, height: 30, ..Settings::of(&scene) });
/// while frame.samples() < 4 {
///     frame.refine(&scene, &bvh, &control, usize::MAX)?;
/// }
/// assert_eq!(frame.film().planes[0].len(), 40 * 30);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct RefinedFrame {
    settings: Settings,
    film: Film,
    sums: TileSums,
    tiles: Vec<Tile>,
    /// Samples of every pixel, and the tiles that have another one already.
    samples: u32,
    done: usize,
    /// True while some of the next tiles may have it as well, after an interruption.
    is_torn: bool,
}

impl RefinedFrame {
    /// A picture without samples. It has no AOVs and no hits, and the number of samples, a
    /// criterion for them, and a region in the settings are ignored.
    pub fn new(settings: Settings) -> RefinedFrame {
        let settings = Settings {
            region: None,
            aovs: Aovs::default(),
            record_hits: false,
            ..settings
        };
        let (size, side) = ((settings.width, settings.height), settings.tile_side());
        RefinedFrame {
            film: Film::new(size.0, size.1, false),
            sums: TileSums::new(size, side),
            tiles: tiles(settings.window(), side),
            samples: 0,
            done: 0,
            is_torn: false,
            settings,
        }
    }

    /// Samples that every pixel has.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// The picture. While [`RefinedFrame::samples`] is about to grow, some of its tiles have
    /// another sample already: see [`RefinedFrame::is_even`].
    pub fn film(&self) -> &Film {
        &self.film
    }

    /// Returns true if all pixels have the same number of samples.
    pub fn is_even(&self) -> bool {
        self.done == 0 && !self.is_torn
    }

    /// Adds a sample to the pixels of the next tiles, at most `most` of them. A single sample goes
    /// through the pixel's centre, and counts no more once there is a second: two are traced then.
    ///
    /// # Errors
    /// Those of [`render`](super::render); after an interruption, the picture can go on.
    pub fn refine(
        &mut self,
        scene: &Scene,
        bvh: &Bvh,
        control: &Control,
        most: usize,
    ) -> Result<RenderedTiles, FrameError> {
        let next = self.samples + 1;
        self.settings.sampling = Sampling {
            spp: next,
            adaptive: None,
            ..self.settings.sampling
        };
        let (window, side) = (self.settings.window(), self.settings.tile_side());
        let end = self.done.saturating_add(most).min(self.tiles.len());
        let shared = SharedFilm::of(&mut self.film, window, side);
        self.is_torn = true;
        let traced = render_packets(
            scene,
            bvh,
            &self.settings,
            control,
            &self.tiles[self.done..end],
            &shared,
            Some(&self.sums),
        )?;
        (self.done, self.is_torn) = (end, false);
        if self.done == self.tiles.len() {
            (self.samples, self.done) = (next, 0);
        }
        Ok(traced)
    }
}
