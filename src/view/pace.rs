//! Size, bounces and kernel of frames while the camera moves, so that they come often enough.

use phalanx::frame::{Kernel, Settings};
use std::time::Duration;

/// Time of a frame in seconds: less than a thirtieth, since it still has to be sent and shown.
const AIM: f64 = 0.026;

/// Slowest frame for which all bounces are traced: 15 a second, with its way to the eye.
const SLOWEST: f64 = 0.055;

/// Fewest pixels of a frame: 320 by 180.
const MIN_PIXELS: f64 = 57_600.0;

/// Weight of the last frame in the mean.
const NEWEST: f64 = 0.4;

/// Share of [`SLOWEST`] below which a frame with more bounces is worth a try.
const ROOM: f64 = 0.9;

/// Least gain of a cut of the bounces that is kept.
const WORTH_IT: f64 = 1.15;

/// Kernels to choose from. Few rays of a dense mesh share nodes, so that single rays are often
/// faster for small frames (`perf/notes/view.md`).
const KERNELS: [Kernel; 2] = [Kernel::Auto, Kernel::Single];

/// Frames from one trial of the other kernel to the next.
const TRIAL: u32 = 40;

/// The pace of a page's camera.
#[derive(Clone, Debug, Default)]
pub(super) struct Pace {
    /// Mean time of a pixel with the present bounces, for each kernel that has been tried.
    times: [Option<f64>; KERNELS.len()],
    pixels: f64,
    cuts: Vec<BounceCut>,
    /// Time of a pixel for which a cut has not been worth it.
    in_vain: f64,
    /// The kernel that was the best when both had been tried.
    best: usize,
    /// Frames with the present bounces.
    frames: u32,
}

/// A cut of the bounces.
#[derive(Clone, Copy, Debug)]
struct BounceCut {
    max_depth: u32,
    /// Time of a pixel before it, and how much more that was than the time after it.
    pixel: f64,
    gain: Option<f64>,
}

impl Pace {
    /// Settings of the next frame, instead of those of the picture at rest. It may have `most`
    /// pixels.
    pub(super) fn next(&mut self, at_rest: &Settings, most: u64) -> Settings {
        if let Some(pixel) = self.pixel() {
            let affordable = AIM / pixel;
            // The size jumps visibly, so small errors are left alone.
            if !(0.75..1.4).contains(&(affordable / self.pixels)) {
                self.pixels = affordable;
            }
            self.change_depth(pixel, at_rest.max_depth);
        }
        self.frames += 1;
        let (width, height) = self.size((at_rest.width, at_rest.height), most);
        Settings {
            width,
            height,
            max_depth: self.depth(at_rest.max_depth),
            kernel: match at_rest.kernel {
                Kernel::Auto => self.kernel(),
                given => given,
            },
            ..at_rest.clone()
        }
    }

    /// Notes the time that a frame took. The first one warms caches up.
    pub(super) fn record(&mut self, frame: &Settings, time: Duration) {
        if self.frames == 1 && self.cuts.is_empty() {
            return;
        }
        let newest = time.as_secs_f64().max(1e-6) / frame.pixels() as f64;
        let kernel = KERNELS.iter().position(|kernel| *kernel == frame.kernel);
        let mean = &mut self.times[kernel.unwrap_or(0)];
        *mean = Some(mean.map_or(newest, |mean| mean + NEWEST * (newest - mean)));
        if let [Some(auto), Some(single)] = self.times {
            self.best = usize::from(single < auto);
        }
        let pixel = self.pixel();
        if let (Some(cut), Some(pixel)) = (self.cuts.last_mut(), pixel) {
            let gain = *cut.gain.get_or_insert(cut.pixel / pixel);
            if gain < WORTH_IT {
                self.in_vain = cut.pixel;
                self.cuts.pop();
            }
        }
    }

    /// Time of a pixel with the best kernel.
    fn pixel(&self) -> Option<f64> {
        self.times.into_iter().flatten().reduce(f64::min)
    }

    /// The best kernel, or now and then the other.
    fn kernel(&self) -> Kernel {
        KERNELS[if self.frames % TRIAL == 3 { 1 - self.best } else { self.best }]
    }

    fn depth(&self, max_depth: u32) -> u32 {
        self.cuts.last().map_or(max_depth, |cut| cut.max_depth)
    }

    /// Cuts the bounces if the smallest frame takes too long with them, or takes a cut back.
    fn change_depth(&mut self, pixel: f64, max_depth: u32) {
        let depth = self.depth(max_depth);
        let gain = self.cuts.last().and_then(|cut| cut.gain);
        if pixel * MIN_PIXELS > SLOWEST && depth > 0 && pixel > 2.0 * self.in_vain {
            self.cuts.push(BounceCut {
                max_depth: depth.min(4) / 2,
                pixel,
                gain: None,
            });
            (self.times, self.frames) = Default::default();
        } else if gain.is_some_and(|gain| pixel * gain * MIN_PIXELS < ROOM * SLOWEST) {
            self.cuts.pop();
            (self.times, self.frames) = Default::default();
        }
    }

    fn size(&self, (width, height): (u32, u32), most: u64) -> (u32, u32) {
        let full = f64::from(width) * f64::from(height);
        let pixels = self.pixels.max(MIN_PIXELS).min(most as f64).min(full);
        let shrink = (pixels.max(1.0) / full).sqrt();
        if shrink > 0.95 {
            return (width, height);
        }
        let side = |full: u32| ((f64::from(full) * shrink).round() as u32).clamp(1, full);
        (side(width), side(height))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phalanx::scene::Scene;

    fn at_rest() -> Settings {
        Settings {
            width: 1280,
            height: 720,
            max_depth: 5,
            ..Settings::of(&Scene::default())
        }
    }

    /// The frame after many on a machine that takes this many seconds for a pixel and a bounce, and
    /// `single` times as many for single rays: its width, height, bounces and kernel.
    fn settle(pace: &mut Pace, pixel: f64, single: f64, most: u64) -> (u32, u32, u32, Kernel) {
        for _ in 0..2 * TRIAL {
            let frame = pace.next(&at_rest(), most);
            let factor = if frame.kernel == Kernel::Single { single } else { 1.0 };
            let each = pixel * factor * (1.0 + f64::from(frame.max_depth));
            let time = frame.pixels() as f64 * each;
            pace.record(&frame, Duration::from_secs_f64(time));
        }
        let Settings {
            width,
            height,
            max_depth,
            kernel,
            ..
        } = pace.next(&at_rest(), most);
        (width, height, max_depth, kernel)
    }

    #[test]
    fn frames_are_as_large_as_there_is_time_for() {
        let all = u64::MAX;
        let settled = |pixel, most| settle(&mut Pace::default(), pixel, 3.0, most);
        assert_eq!(settled(1e-9, all), (1280, 720, 5, Kernel::Auto));
        let (width, height, depth, _) = settled(4e-8, all);
        assert!(width > 320 && width < 640 && depth == 5, "{width} {depth}");
        assert_eq!((f64::from(width) * 9.0 / 16.0).round() as u32, height);
        assert_eq!(settled(1e-9, 57_600), (320, 180, 5, Kernel::Auto));
    }

    #[test]
    fn bounces_go_last_and_come_back_where_the_camera_sees_less() {
        let mut pace = Pace::default();
        let slow = settle(&mut pace, 1e-6, 3.0, u64::MAX);
        assert_eq!(slow, (320, 180, 0, Kernel::Auto));
        assert_eq!(settle(&mut pace, 4e-8, 3.0, u64::MAX).2, 5);
    }

    #[test]
    fn the_faster_kernel_wins() {
        let mut pace = Pace::default();
        assert_eq!(settle(&mut pace, 1e-8, 0.5, u64::MAX).3, Kernel::Single);
        assert_eq!(settle(&mut pace, 1e-8, 2.0, u64::MAX).3, Kernel::Auto);
        let given = Settings {
            kernel: Kernel::Beam8,
            ..at_rest()
        };
        assert_eq!(pace.next(&given, u64::MAX).kernel, Kernel::Beam8);
    }
}
