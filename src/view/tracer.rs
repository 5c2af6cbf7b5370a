//! The one thread that has the scene, and traces for all pages in turn.

use super::pace::Pace;
use super::protocol::{FrameRequest, KeepRequest, Shot};
use super::queue::{PageAnswer, Queue, Task, Turn};
use super::still_frame::StillFrame;
use super::viewed_scene::ViewedScene;
use phalanx::frame::{FrameError, Settings};
use std::cmp::Reverse;
use std::collections::HashMap;
use std::time::{Duration, Instant};

/// Time that a page's picture may take from the others at a time, and from nobody.
const SLICE: Duration = Duration::from_millis(40);
const LONG_SLICE: Duration = Duration::from_millis(400);

/// Side in pixels of the tiles of frames that would have fewer than this for each thread.
const SMALL_TILE: u32 = 16;
const TILES_PER_THREAD: u64 = 6;

/// The tracer.
pub(super) struct PageTracer<'q> {
    scene: ViewedScene,
    queue: &'q Queue,
    pages: HashMap<String, PageWork>,
}

/// Things that a page's next frames go on from.
#[derive(Default)]
struct PageWork {
    pace: Pace,
    still: Option<StillFrame>,
}

impl<'q> PageTracer<'q> {
    pub(super) fn new(scene: ViewedScene, queue: &'q Queue) -> PageTracer<'q> {
        PageTracer {
            scene,
            queue,
            pages: HashMap::new(),
        }
    }

    /// Serves the pages until the process ends.
    pub(super) fn run(&mut self) -> ! {
        let queue = self.queue;
        loop {
            if let Some(turn) = queue.next() {
                let start = Instant::now();
                let mut work = self.pages.remove(&turn.page).unwrap_or_default();
                let answer = self.serve(&turn, &mut work);
                self.pages.insert(turn.page.clone(), work);
                queue.end(&turn, start.elapsed(), answer.unwrap_or_else(refused));
            }
            // Pages that are gone need nothing any more.
            self.pages.retain(|page, _| queue.knows(page));
            self.free_pictures();
        }
    }

    /// Frees the pictures of the pages that were served longest ago, until the others fit.
    fn free_pictures(&mut self) {
        let stills = self.pages.values_mut().map(|work| &mut work.still);
        let mut stills: Vec<_> = stills.collect();
        stills.sort_by_key(|still| Reverse(still.as_ref().map(|still| still.served)));
        let mut left = self.scene.most_pixels;
        for still in stills {
            let pixels = still.as_ref().map_or(0, |still| still.shot.pixels());
            match left.checked_sub(pixels) {
                Some(rest) => left = rest,
                None => *still = None,
            }
        }
    }

    /// Works on a task. No answer yet is `Ok(None)`.
    fn serve(
        &mut self,
        turn: &Turn,
        work: &mut PageWork,
    ) -> Result<Option<PageAnswer>, FrameError> {
        let (shot, _) = turn.task.shot();
        let most = self.scene.most_pixels;
        if shot.pixels() > most {
            let reason = format!("a picture of more than {most} pixels needs more memory");
            return Ok(Some(PageAnswer::Refused(reason)));
        }
        if let Err(reason) = self.scene.look(shot) {
            return Ok(Some(PageAnswer::Refused(reason)));
        }
        match &turn.task {
            Task::Frame(request) if request.moving => self.moving(turn, work, request).map(Some),
            Task::Frame(request) => self.still(turn, work, request),
            Task::Pixel(request) => self.scene.pixel(request).map(PageAnswer::Json).map(Some),
            Task::Command(request) => self.scene.command(request).map(Some),
            Task::Exposure(request) => self.scene.exposure(request, &turn.control).map(Some),
            Task::Save(request) => self.save(turn, work, request),
        }
    }

    /// One frame as fast as possible.
    fn moving(
        &self,
        turn: &Turn,
        work: &mut PageWork,
        request: &FrameRequest,
    ) -> Result<PageAnswer, FrameError> {
        let Shot { size, mode, .. } = request.shot;
        let at_rest = self.scene.settings(mode, size);
        let frame = with_small_tiles(work.pace.next(&at_rest, request.pixels));
        let start = Instant::now();
        let mut shown = self.scene.paint(mode, &frame, &turn.control)?;
        work.pace.record(&frame, start.elapsed());
        shown.info.moving = true;
        Ok(PageAnswer::Frame(shown))
    }

    /// The next better picture at rest.
    fn still(
        &self,
        turn: &Turn,
        work: &mut PageWork,
        request: &FrameRequest,
    ) -> Result<Option<PageAnswer>, FrameError> {
        let FrameRequest { shot, have, .. } = *request;
        let is_refined = shot.mode.is_refined();
        let most = if is_refined { request.samples } else { 1 };
        if have >= most {
            return Ok(Some(PageAnswer::Nothing));
        }
        if !is_refined {
            let settings = self.scene.settings(shot.mode, shot.size);
            let shown = self.scene.paint(shot.mode, &settings, &turn.control)?;
            return Ok(Some(PageAnswer::Frame(shown)));
        }
        let is_better = |still: &StillFrame| still.has_news(have, most);
        let still = self.refined(turn, work, &shot, is_better)?;
        Ok(still.map(|still| PageAnswer::Frame(still.show(&self.scene))))
    }

    /// A page's picture at rest, once it is `ready`.
    fn refined<'w>(
        &self,
        turn: &Turn,
        work: &'w mut PageWork,
        shot: &Shot,
        ready: impl Fn(&StillFrame) -> bool,
    ) -> Result<Option<&'w mut StillFrame>, FrameError> {
        let of_before = work
            .still
            .take()
            .filter(|still| still.shot.has_film_of(shot));
        let still = work.still.insert(of_before.unwrap_or_else(|| {
            let settings = self.scene.settings(shot.mode, shot.size);
            StillFrame::new(*shot, with_small_tiles(settings))
        }));
        let slice = if turn.is_alone { LONG_SLICE } else { SLICE };
        let is_ready = still.refine(&self.scene, &turn.control, slice, ready)?;
        Ok(is_ready.then_some(still))
    }

    /// A file, of the picture that is there if it has the samples that are wanted.
    fn save(
        &self,
        turn: &Turn,
        work: &mut PageWork,
        request: &KeepRequest,
    ) -> Result<Option<PageAnswer>, FrameError> {
        let KeepRequest { shot, samples, .. } = request;
        let mut film = None;
        if shot.mode.is_refined() {
            // Samples cannot be taken away.
            work.still.take_if(|still| still.is_beyond(*samples));
            let is_there = |still: &StillFrame| still.film(*samples).is_some();
            match self.refined(turn, work, shot, is_there)? {
                Some(still) => film = still.film(*samples),
                None => return Ok(None),
            }
        }
        self.scene.file(request, film, &turn.control).map(Some)
    }
}

/// The answer of work that gave nothing.
fn refused(error: FrameError) -> Option<PageAnswer> {
    Some(match error {
        FrameError::Interrupted(_) => PageAnswer::Nothing,
        error => PageAnswer::Refused(error.to_string()),
    })
}

/// Settings with tiles small enough for all threads to get some.
fn with_small_tiles(settings: Settings) -> Settings {
    let tiles = settings.pixels() / u64::from(settings.tile.pow(2));
    let tile = if tiles < TILES_PER_THREAD * settings.threads as u64 {
        settings.tile.min(SMALL_TILE)
    } else {
        settings.tile
    };
    Settings { tile, ..settings }
}
