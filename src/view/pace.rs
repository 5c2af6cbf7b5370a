//! Size, bounces and kernel of frames while the camera moves, so that they come often enough.

use phalanx::frame::Kernel;
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
const ROOM: f64 = 0.7;

/// Least gain of a cut of the bounces that is kept.
const WORTH_IT: f64 = 1.15;

/// Kernels to choose from. Few rays of a dense mesh share nodes, so that single rays are often
/// faster for small frames (`perf/notes/view.md`).
const KERNELS: [Kernel; 2] = [Kernel::Auto, Kernel::Single];

/// Frames from one trial of the other kernel to the next.
const TRIAL: u32 = 40;

/// Size, bounces and kernel of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FramePace {
    pub(super) size: (u32, u32),
    pub(super) max_depth: u32,
    pub(super) kernel: Kernel,
}

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
    /// The next frame instead of `whole`, the picture at rest; it may have `most` pixels.
    pub(super) fn next(&mut self, whole: FramePace, most: u64) -> FramePace {
        if let Some(pixel) = self.pixel() {
            let affordable = AIM / pixel;
            // The size jumps visibly, so small errors are left alone.
            if !(0.75..1.4).contains(&(affordable / self.pixels)) {
                self.pixels = affordable;
            }
            self.change_depth(pixel, whole.max_depth);
        }
        self.frames += 1;
        FramePace {
            size: self.size(whole.size, most),
            max_depth: self.depth(whole.max_depth),
            kernel: match whole.kernel {
                Kernel::Auto => self.kernel(),
                given => given,
            },
        }
    }

    /// Notes the time that a frame took. The first one warms caches up.
    pub(super) fn learn(&mut self, frame: FramePace, time: Duration) {
        if self.frames == 1 && self.cuts.is_empty() {
            return;
        }
        let (width, height) = frame.size;
        let newest = time.as_secs_f64().max(1e-6) / (f64::from(width) * f64::from(height));
        let at = KERNELS.iter().position(|kernel| *kernel == frame.kernel);
        let mean = &mut self.times[at.unwrap_or(0)];
        *mean = Some(mean.map_or(newest, |mean| mean + NEWEST * (newest - mean)));
        if let [Some(auto), Some(single)] = self.times {
            self.best = usize::from(single < auto);
        }
        if let (Some(cut), Some(pixel)) = (self.cuts.last().copied(), self.pixel()) {
            let gain = cut.gain.unwrap_or(cut.pixel / pixel);
            self.cuts.pop();
            match gain < WORTH_IT {
                true => self.in_vain = cut.pixel,
                false => self.cuts.push(BounceCut {
                    gain: Some(gain),
                    ..cut
                }),
            }
        }
    }

    /// Time of a pixel with the best kernel.
    fn pixel(&self) -> Option<f64> {
        self.times.into_iter().flatten().reduce(f64::min)
    }

    /// The best kernel, or now and then the other.
    fn kernel(&self) -> Kernel {
        KERNELS[match self.frames % TRIAL == 3 {
            true => 1 - self.best,
            false => self.best,
        }]
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
        let whole = f64::from(width) * f64::from(height);
        let pixels = self.pixels.max(MIN_PIXELS).min(most as f64).min(whole);
        let shrink = (pixels.max(1.0) / whole).sqrt();
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

    const WHOLE: FramePace = FramePace {
        size: (1280, 720),
        max_depth: 5,
        kernel: Kernel::Auto,
    };

    /// The frame after many on a machine that takes this many seconds for a pixel and a bounce, and
    /// `single` times as many for single rays.
    fn settle(pace: &mut Pace, pixel: f64, single: f64, most: u64) -> FramePace {
        for _ in 0..2 * TRIAL {
            let frame = pace.next(WHOLE, most);
            let (width, height) = frame.size;
            let factor = if frame.kernel == Kernel::Single {
                single
            } else {
                1.0
            };
            let each = pixel * factor * (1.0 + f64::from(frame.max_depth));
            let time = f64::from(width) * f64::from(height) * each;
            pace.learn(frame, Duration::from_secs_f64(time));
        }
        pace.next(WHOLE, most)
    }

    #[test]
    fn frames_are_as_large_as_there_is_time_for() {
        let all = u64::MAX;
        let settled = |pixel, most| settle(&mut Pace::default(), pixel, 3.0, most);
        assert_eq!(settled(1e-9, all), WHOLE);
        let FramePace {
            size: (width, height),
            max_depth,
            ..
        } = settled(4e-8, all);
        assert!(
            width > 320 && width < 640 && max_depth == 5,
            "{width} {max_depth}"
        );
        assert_eq!((f64::from(width) * 9.0 / 16.0).round() as u32, height);
        assert_eq!(settled(1e-9, 57_600).size, (320, 180));
    }

    #[test]
    fn bounces_go_last_and_come_back_where_the_camera_sees_less() {
        let mut pace = Pace::default();
        let slow = settle(&mut pace, 1e-6, 3.0, u64::MAX);
        assert_eq!((slow.size, slow.max_depth), ((320, 180), 0));
        assert_eq!(settle(&mut pace, 4e-8, 3.0, u64::MAX).max_depth, 5);
    }

    #[test]
    fn the_faster_kernel_wins() {
        let mut pace = Pace::default();
        let kernel = settle(&mut pace, 1e-8, 0.5, u64::MAX).kernel;
        assert_eq!(kernel, Kernel::Single);
        assert_eq!(settle(&mut pace, 1e-8, 2.0, u64::MAX).kernel, Kernel::Auto);
        let given = FramePace {
            kernel: Kernel::Beam8,
            ..WHOLE
        };
        assert_eq!(pace.next(given, u64::MAX).kernel, Kernel::Beam8);
    }
}
