//! Pending requests of all pages. The page that has had the least of the tracer's time is served
//! next.

use super::painting::ShownPicture;
use super::protocol::{FrameRequest, KeepRequest, PixelRequest, Shot};
use phalanx::frame::Control;
use serde_json::Value;
use std::collections::{HashMap, VecDeque};
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Most pages, and most requests of each that wait.
const MAX_PAGES: usize = 16;
const MAX_WAITING: usize = 16;

/// Most frames of a moving camera that wait: older ones are not worth their time.
const MAX_MOVING: usize = 4;

/// Time without a request after which a page is taken to be gone; if another wants its place, less.
const GONE: Duration = Duration::from_secs(600);
const GONE_FOR_ANOTHER: Duration = Duration::from_secs(5);

/// Time after its last request for which a page is taken to be about to ask again.
const ACTIVE: Duration = Duration::from_secs(1);

/// A request that takes the tracer's time.
#[derive(Clone, Copy, Debug)]
pub(super) enum Task {
    Frame(FrameRequest),
    Pixel(PixelRequest),
    Command(KeepRequest),
    Exposure(KeepRequest),
    Save(KeepRequest),
}

impl Task {
    /// The picture that it is about, and its samples.
    pub(super) fn shot(&self) -> (&Shot, u32) {
        match self {
            Task::Frame(request) => (&request.shot, request.samples),
            Task::Pixel(request) => (&request.shot, 1),
            Task::Command(request) | Task::Exposure(request) | Task::Save(request) => {
                (&request.shot, request.samples)
            }
        }
    }

    /// The task, unless its picture cannot be rendered.
    pub(super) fn checked(self) -> Result<Task, String> {
        let (shot, samples) = self.shot();
        shot.check(samples)?;
        match self {
            Task::Pixel(PixelRequest { x, y, .. }) if x >= shot.size.0 || y >= shot.size.1 => {
                Err(format!("pixel {x},{y} is outside the picture"))
            }
            task => Ok(task),
        }
    }
}

/// An answer to it.
pub(super) enum PageAnswer {
    Frame(ShownPicture),
    Json(Value),
    /// Name and contents. One thread encodes them, because each that did would keep some memory.
    File(String, Vec<u8>),
    /// The page has asked for something else since, or has the best frame already.
    Nothing,
    Refused(String),
}

/// A task whose turn it is.
pub(super) struct Turn {
    pub(super) page: String,
    id: u64,
    pub(super) task: Task,
    /// Stops the work if nobody waits for it any more.
    pub(super) control: Arc<Control>,
    /// True if no other page has asked for anything lately.
    pub(super) is_alone: bool,
}

/// The queue of all pages.
#[derive(Default)]
pub(super) struct Queue {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    pages: HashMap<String, PageQueue>,
    running: Option<(u64, Arc<Control>)>,
    last: u64,
    /// Time that the page which was served last had spent.
    clock: f64,
}

#[derive(Default)]
struct PageQueue {
    waiting: VecDeque<WaitingTask>,
    /// Seconds of the tracer's time.
    spent: f64,
    /// Time of its last request.
    seen: Option<Instant>,
}

struct WaitingTask {
    id: u64,
    task: Task,
    answer: Sender<PageAnswer>,
}

impl Queue {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Notes that a page is there. Returns false if there are too many.
    pub(super) fn greet(&self, page: &str) -> bool {
        self.state().greet(page)
    }

    /// Adds a task. A frame takes the place of those that the page waits for, except that frames of
    /// a moving camera follow each other. `None` if too much waits.
    pub(super) fn submit(&self, page: &str, task: Task) -> Option<(u64, Receiver<PageAnswer>)> {
        let mut state = self.state();
        if !state.greet(page) {
            return None;
        }
        let (id, clock) = (state.last + 1, state.clock);
        let queue = state.pages.get_mut(page)?;
        if queue.waiting.is_empty() {
            // Time in which a page asked for nothing is not saved up.
            queue.spent = queue.spent.max(clock);
        }
        let useless = match task {
            Task::Frame(request) => queue.supersede(request.moving),
            _ => VecDeque::new(),
        };
        let (answer, receiver) = channel();
        let has_room = queue.waiting.len() < MAX_WAITING;
        if has_room {
            queue.waiting.push_back(WaitingTask { id, task, answer });
        }
        state.last = id;
        for cancelled in useless {
            let _ = cancelled.answer.send(PageAnswer::Nothing);
            state.stop(cancelled.id);
        }
        drop(state);
        self.changed.notify_all();
        has_room.then_some((id, receiver))
    }

    /// Takes a task back whose answer nobody waits for.
    pub(super) fn withdraw(&self, page: &str, id: u64) {
        let mut state = self.state();
        if let Some(of_page) = state.pages.get_mut(page) {
            of_page.waiting.retain(|waiting| waiting.id != id);
        }
        state.stop(id);
    }

    /// Forgets a page and all that it waits for.
    pub(super) fn leave(&self, page: &str) {
        let mut state = self.state();
        let gone = state.pages.remove(page);
        for waiting in gone.into_iter().flat_map(|page| page.waiting) {
            state.stop(waiting.id);
        }
        drop(state);
        self.changed.notify_all();
    }

    /// Returns true for a page that has not left.
    pub(super) fn knows(&self, page: &str) -> bool {
        self.state().pages.contains_key(page)
    }

    /// The next task; `None` if there has been none for a while. It stays in the queue until it is
    /// answered.
    pub(super) fn next(&self) -> Option<Turn> {
        let mut state = self.state();
        for _ in 0..2 {
            if let Some(turn) = state.turn() {
                return Some(turn);
            }
            let waited = self.changed.wait_timeout(state, GONE_FOR_ANOTHER);
            (state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        }
        state.pages.retain(|_, page| !page.is_gone(GONE));
        None
    }

    /// Ends a turn that took this time. Without an answer, the task gets another turn.
    pub(super) fn end(&self, turn: &Turn, time: Duration, answer: Option<PageAnswer>) {
        let mut state = self.state();
        state.running = None;
        let Some(page) = state.pages.get_mut(&turn.page) else {
            return;
        };
        page.spent += time.as_secs_f64();
        let (Some(answer), Some(place)) = (answer, page.place(turn.id)) else {
            return;
        };
        if let Some(waiting) = page.waiting.remove(place) {
            // A reader that is gone needs no answer.
            let _ = waiting.answer.send(answer);
        }
    }
}

impl PageQueue {
    fn is_gone(&self, after: Duration) -> bool {
        self.seen.is_none_or(|seen| seen.elapsed() > after)
    }

    fn is_active(&self) -> bool {
        !self.waiting.is_empty() || !self.is_gone(ACTIVE)
    }

    fn place(&self, id: u64) -> Option<usize> {
        self.waiting.iter().position(|waiting| waiting.id == id)
    }

    /// The task to serve first: the oldest of the urgent ones, or else of all.
    fn first(&self) -> Option<&WaitingTask> {
        let urgent = self.waiting.iter().find(|waiting| waiting.is_urgent());
        urgent.or(self.waiting.front())
    }

    /// Takes out the frames that a new one makes useless.
    fn supersede(&mut self, moving: bool) -> VecDeque<WaitingTask> {
        let moved = self.waiting.iter().filter(|waiting| waiting.is_moving());
        let mut spare =
            if moving { moved.count().saturating_sub(MAX_MOVING - 1) } else { usize::MAX };
        let useless = |waiting: &WaitingTask| match waiting.task {
            Task::Frame(request) if request.moving => {
                let is_spare = spare > 0;
                spare = spare.saturating_sub(1);
                is_spare
            }
            Task::Frame(_) => true,
            _ => false,
        };
        let (useless, useful) = self.waiting.drain(..).partition(useless);
        self.waiting = useful;
        useless
    }
}

impl WaitingTask {
    fn is_moving(&self) -> bool {
        matches!(self.task, Task::Frame(request) if request.moving)
    }

    /// Returns true for what takes little time, or must not wait for what takes more.
    fn is_urgent(&self) -> bool {
        self.is_moving() || !matches!(self.task, Task::Frame(_) | Task::Save(_))
    }
}

impl State {
    fn greet(&mut self, page: &str) -> bool {
        if !self.pages.contains_key(page) && self.pages.len() >= MAX_PAGES {
            let stays = |page: &PageQueue| !page.is_gone(GONE_FOR_ANOTHER);
            self.pages
                .retain(|_, page| stays(page) || !page.waiting.is_empty());
            if self.pages.len() >= MAX_PAGES {
                return false;
            }
        }
        let known = self.pages.entry(page.to_owned()).or_default();
        known.seen = Some(Instant::now());
        true
    }

    /// Stops the work on a task, if it is the one that is worked on.
    fn stop(&self, id: u64) {
        if let Some((_, control)) = self.running.as_ref().filter(|(running, _)| *running == id) {
            control.stop.store(true, Relaxed);
        }
    }

    fn turn(&mut self) -> Option<Turn> {
        let waiting = |(_, page): &(_, &PageQueue)| !page.waiting.is_empty();
        let pages = self.pages.iter().filter(waiting);
        let (page, of_page) = pages.min_by(|(_, a), (_, b)| a.spent.total_cmp(&b.spent))?;
        let WaitingTask { id, task, .. } = *of_page.first()?;
        let turn = Turn {
            page: page.clone(),
            id,
            task,
            control: Arc::default(),
            is_alone: self.pages.values().filter(|page| page.is_active()).count() == 1,
        };
        self.clock = of_page.spent;
        self.running = Some((id, Arc::clone(&turn.control)));
        Some(turn)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{from_value, json};

    const A: &str = "a";
    const B: &str = "b";

    fn shot() -> Value {
        let view = json!({ "eye": [0, 0, 5], "center": [0, 0, 0], "up": [0, 1, 0], "fovy": 40 });
        json!({
            "view": view, "size": [8, 8], "x": 1, "y": 1, "samples": 4,
            "pixels": 64, "have": 0, "jpeg": false,
        })
    }

    fn frame(moving: bool) -> Task {
        let mut request = shot();
        request["moving"] = json!(moving);
        Task::Frame(from_value(request).unwrap())
    }

    #[test]
    fn the_page_with_the_least_time_is_next() {
        let queue = Queue::default();
        let second = Duration::from_secs(1);
        let _a = queue.submit(A, frame(false));
        let turn = queue.next().unwrap();
        assert!(turn.is_alone && turn.page == A);
        queue.end(&turn, second * 11 / 2, None);
        let _b = queue.submit(B, frame(false));
        let mut pages = Vec::new();
        for _ in 0..8 {
            let turn = queue.next().unwrap();
            assert!(!turn.is_alone);
            queue.end(&turn, second, None);
            pages.push(turn.page);
        }
        assert_eq!(pages.concat(), "bbbbbbab");
        // A page that comes back has no time in credit, and none in debt.
        queue.leave(B);
        let turn = queue.next().unwrap();
        queue.end(&turn, 100 * second, Some(PageAnswer::Nothing));
        let _b = queue.submit(B, frame(false));
        let _a = queue.submit(A, frame(false));
        let turn = queue.next().unwrap();
        queue.end(&turn, second, None);
        assert_eq!(turn.page, B);
        assert!(queue.state().pages[B].spent >= 6.5);
    }

    #[test]
    fn a_frame_takes_the_place_of_those_before() {
        let queue = Queue::default();
        let (_, still) = queue.submit(A, frame(false)).unwrap();
        let turn = queue.next().unwrap();
        let moving: Vec<_> = (0..6)
            .map(|_| queue.submit(A, frame(true)).unwrap().1)
            .collect();
        assert!(matches!(still.try_recv(), Ok(PageAnswer::Nothing)));
        assert!(turn.control.stop.load(Relaxed));
        queue.end(&turn, Duration::ZERO, None);
        for (k, answer) in moving.iter().enumerate() {
            assert_eq!(answer.try_recv().is_ok(), k < 2, "{k}");
        }
        // Urgent tasks go first, saves last.
        let _save = queue.submit(A, Task::Save(from_value(shot()).unwrap()));
        let _pixel = queue.submit(A, Task::Pixel(from_value(shot()).unwrap()));
        let kinds = (0..6).map(|_| {
            let turn = queue.next().unwrap();
            queue.end(&turn, Duration::ZERO, Some(PageAnswer::Nothing));
            match turn.task {
                Task::Frame(_) => 'f',
                Task::Pixel(_) => 'p',
                Task::Command(_) | Task::Exposure(_) => 'c',
                Task::Save(_) => 's',
            }
        });
        assert_eq!(kinds.collect::<String>(), "ffffps");
        // Nobody waits for a page that is gone, or for more than it may ask.
        let (id, answer) = queue.submit(A, frame(false)).unwrap();
        let turn = queue.next().unwrap();
        queue.withdraw(A, id);
        assert!(turn.control.stop.load(Relaxed) && answer.recv().is_err());
        let saves = (0..20).map(|_| queue.submit(A, Task::Save(from_value(shot()).unwrap())));
        assert_eq!(saves.flatten().count(), MAX_WAITING);
        let pages = (0..20).filter(|k| queue.greet(&k.to_string()));
        assert_eq!(pages.count(), MAX_PAGES - 1);
    }
}
