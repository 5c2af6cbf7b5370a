//! Structural similarity (Wang, Bovik, Sheikh, Simoncelli 2004) of one channel, row by row: means,
//! variances and covariance in a Gaussian window of 11x11 pixels, sigma 1.5, at all positions
//! within the picture.

use super::super::read::SampleKind;
use super::on_screen::on_screen;
use std::collections::VecDeque;

/// Side of the window.
const SIDE: usize = 11;
/// Standard deviation of the window's weights, in pixels.
const SIGMA: f64 = 1.5;
/// Constants of the paper, squared: 0.01 and 0.03 of the range of samples, which is 1.
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// Sums up the similarity of a channel.
pub(super) struct SsimChannel {
    kind: [SampleKind; 2],
    weights: [f64; SIDE],
    /// The last rows.
    rows: VecDeque<WindowRow>,
    sum: f64,
    windows: u64,
}

/// A row of the window.
struct WindowRow {
    /// Samples of both pictures.
    bits: [Vec<u32>; 2],
    /// Weighted sums along the row of a, b, a², b² and ab; made when they are needed.
    sums: Option<Vec<[f64; 5]>>,
}

impl SsimChannel {
    pub(super) fn new(kind: [SampleKind; 2]) -> SsimChannel {
        let bell: [f64; SIDE] = std::array::from_fn(|k| {
            let x = (k as f64 - (SIDE / 2) as f64) / SIGMA;
            libm::exp(-0.5 * x * x)
        });
        let all: f64 = bell.iter().sum();
        SsimChannel {
            kind,
            weights: bell.map(|weight| weight / all),
            rows: VecDeque::new(),
            sum: 0.0,
            windows: 0,
        }
    }

    /// Adds the next row.
    pub(super) fn push(&mut self, a: &[u32], b: &[u32]) {
        let windows = (a.len() + 1).saturating_sub(SIDE);
        if windows == 0 {
            return;
        }
        if self.rows.len() == SIDE {
            self.rows.pop_front();
        }
        self.rows.push_back(WindowRow {
            bits: [a.to_vec(), b.to_vec()],
            sums: None,
        });
        if self.rows.len() < SIDE {
            return;
        }
        self.windows += windows as u64;
        let equal =
            self.kind[0] == self.kind[1] && self.rows.iter().all(|row| row.bits[0] == row.bits[1]);
        self.sum += if equal { windows as f64 } else { self.windows_sum() };
    }

    /// Mean of all windows; `None` for a picture smaller than one.
    pub(super) fn mean(&self) -> Option<f64> {
        (self.windows > 0).then(|| self.sum / self.windows as f64)
    }

    /// Sum over the windows whose lowest row is the last one.
    fn windows_sum(&mut self) -> f64 {
        for row in &mut self.rows {
            if row.sums.is_none() {
                row.sums = Some(row_sums(&row.bits, self.kind, &self.weights));
            }
        }
        let rows: Vec<&[[f64; 5]]> = self.rows.iter().filter_map(|r| r.sums.as_deref()).collect();
        let windows = rows.first().map_or(0, |row| row.len());
        let mut sum = 0.0;
        for x in 0..windows {
            let mut means = [0.0; 5];
            for (row, weight) in rows.iter().zip(self.weights) {
                for (mean, value) in means.iter_mut().zip(row[x]) {
                    *mean += weight * value;
                }
            }
            sum += similarity(means);
        }
        sum
    }
}

fn row_sums(bits: &[Vec<u32>; 2], kind: [SampleKind; 2], weights: &[f64; SIDE]) -> Vec<[f64; 5]> {
    let samples = bits[0].iter().zip(&bits[1]);
    let products: Vec<[f64; 5]> = samples
        .map(|(&p, &q)| {
            let (a, b) = (on_screen(kind[0], p), on_screen(kind[1], q));
            [a, b, a * a, b * b, a * b]
        })
        .collect();
    let sums = products.windows(SIDE).map(|window| {
        let mut sums = [0.0; 5];
        for (values, weight) in window.iter().zip(weights) {
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += weight * value;
            }
        }
        sums
    });
    sums.collect()
}

/// Similarity in a window, by its means of a, b, a², b² and ab.
fn similarity([a, b, aa, bb, ab]: [f64; 5]) -> f64 {
    let (variance_a, variance_b, covariance) = (aa - a * a, bb - b * b, ab - a * b);
    let numerator = (2.0 * a * b + C1) * (2.0 * covariance + C2);
    numerator / ((a * a + b * b + C1) * (variance_a + variance_b + C2))
}
