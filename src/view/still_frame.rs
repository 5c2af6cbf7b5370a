//! A page's picture at rest, which gets better in slices of time.

use super::painting::ShownPicture;
use super::protocol::{FrameInfo, Shot};
use super::viewed_scene::ViewedScene;
use phalanx::film::Film;
use phalanx::frame::{Control, FrameError, RefinedFrame, Settings};
use phalanx::render::RayCounts;
use serde_json::Value;
use std::mem::take;
use std::time::{Duration, Instant};

/// Interval between refined pictures: sending each sample would cost more than tracing it.
const BATCH: Duration = Duration::from_millis(120);

/// A picture at rest.
pub(super) struct StillFrame {
    pub(super) shot: Shot,
    pub(super) served: Instant,
    settings: Settings,
    frame: RefinedFrame,
    /// Samples and film that the page has got last.
    shown: Option<(u32, Film)>,
    /// Seconds of a tile.
    tile: f64,
    /// Work since the page has got a picture.
    wall: Duration,
    tracing: Duration,
    rays: RayCounts,
}

impl StillFrame {
    /// A picture without samples.
    pub(super) fn new(shot: Shot, settings: Settings) -> StillFrame {
        StillFrame {
            shot,
            served: Instant::now(),
            frame: RefinedFrame::new(settings.clone()),
            settings,
            shown: None,
            // Unknown: the first step is a tile for each thread.
            tile: f64::INFINITY,
            wall: Duration::ZERO,
            tracing: Duration::ZERO,
            rays: RayCounts::default(),
        }
    }

    /// Adds samples until it is `ready`, or until the time is over. Returns false then.
    pub(super) fn refine(
        &mut self,
        scene: &ViewedScene,
        control: &Control,
        time: Duration,
        ready: impl Fn(&StillFrame) -> bool,
    ) -> Result<bool, FrameError> {
        let start = Instant::now();
        self.served = start;
        while !ready(self) {
            let left = time.saturating_sub(start.elapsed());
            if left.is_zero() {
                return Ok(false);
            }
            let most = (left.as_secs_f64() / self.tile.max(1e-6)) as usize;
            let most = most.max(1) * self.settings.threads.max(1);
            let begun = Instant::now();
            let traced = self.frame.refine(&scene.scene, &scene.bvh, control, most);
            self.wall += begun.elapsed();
            let traced = traced?;
            self.tracing += traced.tracing;
            self.rays.add(&traced.stats.rays);
            let tiles = traced.tile_seconds.len().max(1) as f64;
            self.tile = traced.tile_seconds.iter().sum::<f64>() / tiles;
        }
        Ok(true)
    }

    /// Returns true if there is a picture for a page that has one with `have` samples, and wants
    /// `most`.
    pub(super) fn has_news(&self, have: u32, most: u32) -> bool {
        let samples = self.frame.samples();
        let is_due = self.wall >= BATCH || samples >= most || samples <= 2;
        samples > have && self.frame.is_even() && is_due
    }

    /// The film with this number of samples, if it is there.
    pub(super) fn film(&self, samples: u32) -> Option<&Film> {
        match &self.shown {
            Some((shown, film)) if *shown == samples => Some(film),
            _ if self.frame.samples() == samples && self.frame.is_even() => Some(self.frame.film()),
            _ => None,
        }
    }

    /// Returns true if the picture cannot have this number of samples any more.
    pub(super) fn is_beyond(&self, samples: u32) -> bool {
        self.film(samples).is_none() && self.frame.samples() >= samples
    }

    /// The picture for the page.
    pub(super) fn show(&mut self, scene: &ViewedScene) -> ShownPicture {
        let film = self.frame.film();
        let picture = scene.radiance(film);
        let mut info = FrameInfo {
            samples: self.frame.samples(),
            rays: Value::from_iter(take(&mut self.rays).by_kind()),
            ..scene.info(&self.settings)
        };
        info.set_times(
            (take(&mut self.wall), take(&mut self.tracing)),
            self.settings.threads,
        );
        self.shown = Some((info.samples, film.clone()));
        ShownPicture { picture, info }
    }
}
