//! Reconstruction filters, importance-sampled (Ernst, Stamminger and Greiner, "Filter Importance
//! Sampling", 2006), so that each pixel has its own samples and no tile needs its neighbours.
//!
//! Offsets are drawn with a density proportional to the filter's size. A sample's weight is the
//! filter's value there over that density. For a box and a tent the weight is always 1. Mitchell's
//! filter has negative lobes, whose samples have negative weights.

use crate::fork_safe_once::ForkSafeOnce;

/// A reconstruction filter, the same along both axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// Equal weight over all of the pixel's square.
    #[default]
    Box,
    /// Linear fall from the pixel's centre to those of its neighbours.
    Tent,
    /// Mitchell and Netravali's cubic with B = C = 1/3, two pixels to each side: sharper, and with
    /// a little overshoot ("Reconstruction Filters in Computer Graphics", 1988).
    Mitchell,
}

impl Filter {
    /// All filters, by name.
    pub const ALL: [(&'static str, Filter); 3] = [
        ("box", Filter::Box),
        ("tent", Filter::Tent),
        ("mitchell", Filter::Mitchell),
    ];

    /// The filter's name.
    #[inline]
    pub fn name(self) -> &'static str {
        match self {
            Filter::Box => "box",
            Filter::Tent => "tent",
            Filter::Mitchell => "mitchell",
        }
    }

    /// An offset from the pixel's centre in pixels, for `u` in \[0, 1), and the weight of the
    /// sample there.
    #[inline(always)]
    pub(super) fn draw(self, u: f32) -> (f32, f32) {
        match self {
            Filter::Box => (u - 0.5, 1.0),
            // The inverse of the tent's integral, on either side of its middle.
            Filter::Tent => {
                if u < 0.5 {
                    ((2.0 * u).sqrt() - 1.0, 1.0)
                } else {
                    (1.0 - (2.0 - 2.0 * u).sqrt(), 1.0)
                }
            }
            Filter::Mitchell => draw_mitchell(u),
        }
    }
}

/// Steps from the centre to the end of Mitchell's filter. A step is drawn in proportion to the
/// filter's size there, by trapezoids. With only the value at its middle, the step in which the
/// filter crosses zero would hardly ever be drawn, and would then have a large weight.
const TABLE_STEPS: usize = 128;

/// Radius of the filter.
const FILTER_RADIUS: f64 = 2.0;

struct FilterTable {
    /// Share of the filter's size before each step, and all of it at the end: 0 to 1.
    before: [f32; TABLE_STEPS + 1],
    /// One over the density of offsets in each step, on one side.
    over: [f32; TABLE_STEPS],
}

static MITCHELL: ForkSafeOnce<FilterTable> = ForkSafeOnce::new();

fn mitchell_table() -> FilterTable {
    let width = FILTER_RADIUS / TABLE_STEPS as f64;
    let size_at = |steps: f64| mitchell(steps * width).abs();
    let sizes: [f64; TABLE_STEPS] = std::array::from_fn(|k| {
        let k = k as f64;
        (size_at(k) + 2.0 * size_at(k + 0.5) + size_at(k + 1.0)) * 0.25 * width
    });
    let all: f64 = sizes.iter().sum();
    let mut before = [1.0; TABLE_STEPS + 1];
    let mut sum = 0.0;
    for (k, size) in sizes.iter().enumerate() {
        before[k] = (sum / all) as f32;
        sum += size;
    }
    // Both sides are drawn equally often.
    let over = sizes.map(|size| (2.0 * width * all / size) as f32);
    FilterTable { before, over }
}

fn draw_mitchell(u: f32) -> (f32, f32) {
    let table = MITCHELL.get_or_init(mitchell_table);
    let side = 2.0 * u - 1.0;
    let size = side.abs();
    // There is always a step at or before: `before[0]` is 0.
    let step = (table.before.partition_point(|&b| b <= size) - 1).min(TABLE_STEPS - 1);
    let (from, to) = (table.before[step], table.before[step + 1]);
    let within = (size - from) / (to - from);
    let away = (step as f32 + within) * (FILTER_RADIUS as f32 / TABLE_STEPS as f32);
    let weight = mitchell_f32(away) * table.over[step];
    (if side < 0.0 { -away } else { away }, weight)
}

/// Mitchell's filter, by distance from its centre; its integral over both sides is 1.
fn mitchell(x: f64) -> f64 {
    let sixfold = if x < 1.0 {
        (7.0 * x - 12.0) * x * x + 16.0 / 3.0
    } else {
        // The zeros of this part: a single one where the negative lobe begins, and a double one at
        // its end.
        -7.0 / 3.0 * (x - 8.0 / 7.0) * (x - 2.0) * (x - 2.0)
    };
    sixfold / 6.0
}

/// Mitchell's filter in f32, in one order for both engines.
fn mitchell_f32(x: f32) -> f32 {
    let sixfold = if x < 1.0 {
        (7.0 * x - 12.0) * x * x + 16.0 / 3.0
    } else {
        -7.0 / 3.0 * (x - 8.0 / 7.0) * (x - 2.0) * (x - 2.0)
    };
    sixfold / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The filters' values, by offset.
    fn value(filter: Filter, x: f64) -> f64 {
        match filter {
            Filter::Box => f64::from(u8::from(x.abs() <= 0.5)),
            Filter::Tent => (1.0 - x.abs()).max(0.0),
            Filter::Mitchell if x.abs() < 2.0 => mitchell(x.abs()),
            Filter::Mitchell => 0.0,
        }
    }

    /// Checks that the mean of the samples' weights times a function of their offset is the
    /// filter's integral of that function.
    #[test]
    fn samples_are_the_filters_integral() {
        let count = 1 << 20;
        for (name, filter) in Filter::ALL {
            for frequency in 0..4 {
                let wave = |x: f64| libm::cos(f64::from(frequency) * x);
                let mean = (0..count).map(|k| {
                    let (offset, weight) = filter.draw((k as f32 + 0.5) / count as f32);
                    f64::from(weight) * wave(f64::from(offset)) / f64::from(count)
                });
                let mean: f64 = mean.sum();
                let steps = 100_000;
                let width = 4.0 / f64::from(steps);
                let want = (0..steps).map(|k| {
                    let x = (f64::from(k) + 0.5) * width - 2.0;
                    value(filter, x) * wave(x) * width
                });
                let want: f64 = want.sum();
                // Both sides are sums of rectangles, with f32 within them.
                assert!(
                    (mean - want).abs() < 2e-5,
                    "{name}, {frequency}: {mean} {want}"
                );
            }
        }
    }

    #[test]
    fn offsets_stay_within_reach_and_weights_are_few() {
        for (filter, reach) in [
            (Filter::Box, 0.5),
            (Filter::Tent, 1.0),
            (Filter::Mitchell, 2.0),
        ] {
            let (mut last, mut negative) = (f32::NEG_INFINITY, 0);
            for k in 0..1 << 14 {
                let (offset, weight) = filter.draw(k as f32 / (1 << 14) as f32);
                assert!(offset.abs() <= reach && offset >= last, "{filter:?} {k}");
                assert!(weight.abs() < 3.0, "{filter:?} {k} {weight}");
                negative += u32::from(weight < 0.0);
                last = offset;
            }
            assert_eq!(negative > 0, filter == Filter::Mitchell);
        }
    }
}
