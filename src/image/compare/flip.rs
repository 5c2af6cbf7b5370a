//! FLIP (Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild 2020): the difference
//! seen by an observer who flips between two pictures on a screen, 0 to 1, at 67 pixels per degree.
//!
//! Colours are blurred as by the eye and compared in Hunt-adjusted CIELAB; edges and points in only
//! one of the pictures increase the difference. The constants are those of the paper.

use super::super::read::SampleKind;
use super::flip_filters::{COLOR_RADIUS, Features, FlipFilters, FlipRow};
use super::on_screen::linear_on_screen;
use glam::DVec3;
use phalanx_scene::map_on_pool;
use std::collections::VecDeque;

/// Exponent and cut of the difference of colours: values up to 0.4 of the largest take the range up
/// to 0.95.
const COLOR_EXPONENT: f64 = 0.7;
const CUT: f64 = 0.4;
const CUT_VALUE: f64 = 0.95;

/// Samples of red, green and blue in a row of one picture.
pub(super) type RgbRow = [Vec<u32>; 3];

/// Sums up the differences of a layer of colours, row by row.
pub(super) struct FlipSum {
    kind: [[SampleKind; 3]; 2],
    filters: FlipFilters,
    /// Largest difference of colours: of green and blue.
    largest: f64,
    height: usize,
    /// The last rows, of which the first has this number in the picture.
    rows: VecDeque<PairOfRows>,
    first: usize,
    /// The row whose differences come next.
    next: usize,
    sum: f64,
    pixels: u64,
}

/// The same row of both pictures.
struct PairOfRows {
    samples: [RgbRow; 2],
    equal: bool,
    filtered: Option<[FlipRow; 2]>,
}

impl FlipSum {
    pub(super) fn new(kind: [[SampleKind; 3]; 2], height: u32) -> FlipSum {
        let filters = FlipFilters::new();
        let pure = |rgb| filters.hunt_lab(DVec3::from_array(rgb));
        let (green, blue) = (pure([0.0, 1.0, 0.0]), pure([0.0, 0.0, 1.0]));
        FlipSum {
            kind,
            largest: libm::pow(hyab(green, blue), COLOR_EXPONENT),
            filters,
            height: height as usize,
            rows: VecDeque::new(),
            first: 0,
            next: 0,
            sum: 0.0,
            pixels: 0,
        }
    }

    /// Adds the next rows; several dozen at once keep all threads busy.
    pub(super) fn push(&mut self, rows: Vec<[RgbRow; 2]>) {
        for samples in rows {
            self.rows.push_back(PairOfRows {
                equal: self.kind[0] == self.kind[1] && samples[0] == samples[1],
                samples,
                filtered: None,
            });
        }
        self.add_complete();
    }

    /// Mean over all pixels.
    pub(super) fn mean(&self) -> Option<f64> {
        (self.pixels > 0).then(|| self.sum / self.pixels as f64)
    }

    /// Adds rows for which all surrounding rows are present.
    fn add_complete(&mut self) {
        let pushed = self.first + self.rows.len();
        let end = if pushed == self.height { pushed } else { pushed.saturating_sub(COLOR_RADIUS) };
        let differing: Vec<usize> = (self.next..end)
            .filter(|&y| self.around(y).any(|row| !row.equal))
            .collect();
        self.filter_around(&differing);
        let sums = map_on_pool(differing, |y| self.row_sum(y));
        self.sum += sums.iter().sum::<f64>();
        let width = self.rows.front().map_or(0, |row| row.samples[0][0].len());
        self.pixels += (end.saturating_sub(self.next) * width) as u64;
        self.next = self.next.max(end);
        while self.first + COLOR_RADIUS < self.next && self.rows.len() > 1 {
            self.rows.pop_front();
            self.first += 1;
        }
    }

    /// A stored row of the picture. Beyond the picture's edges, the edge rows are repeated.
    fn row(&self, y: isize) -> &PairOfRows {
        let y = y.clamp(0, self.height as isize - 1) as usize;
        &self.rows[y - self.first]
    }

    fn around(&self, y: usize) -> impl Iterator<Item = &PairOfRows> {
        let radius = COLOR_RADIUS as isize;
        (-radius..=radius).map(move |k| self.row(y as isize + k))
    }

    /// Filters the rows around some rows along themselves.
    fn filter_around(&mut self, rows: &[usize]) {
        let mut needed = vec![false; self.rows.len()];
        for &y in rows {
            let top = y.saturating_sub(COLOR_RADIUS).max(self.first) - self.first;
            let end = (y + COLOR_RADIUS + 1).min(self.first + self.rows.len()) - self.first;
            needed[top..end].fill(true);
        }
        let (kind, filters) = (self.kind, &self.filters);
        let all = self.rows.iter_mut().zip(needed);
        let missing = all.filter(|(row, needed)| *needed && row.filtered.is_none());
        map_on_pool(missing, |(row, _)| {
            let filtered = [0, 1].map(|side| {
                let [red, green, blue] = &row.samples[side];
                let pixels = red.iter().zip(green).zip(blue);
                let linear = pixels.map(|((&r, &g), &b)| {
                    let [r_kind, g_kind, b_kind] = kind[side];
                    let (r, g) = (linear_on_screen(r_kind, r), linear_on_screen(g_kind, g));
                    DVec3::new(r, g, linear_on_screen(b_kind, b))
                });
                filters.along(linear.collect())
            });
            row.filtered = Some(filtered);
        });
    }

    /// Sum of the differences of a row.
    fn row_sum(&self, y: usize) -> f64 {
        let side = |side: usize| {
            let rows = self.around(y).filter_map(|row| row.filtered.as_ref());
            let rows: Vec<&FlipRow> = rows.map(|filtered| &filtered[side]).collect();
            self.filters.across(&rows)
        };
        let (first, second) = (side(0), side(1));
        let pixels = first.into_iter().zip(second);
        pixels.map(|(p, q)| self.difference(p, q)).sum()
    }

    fn difference(&self, p: (DVec3, Features), q: (DVec3, Features)) -> f64 {
        let color = libm::pow(hyab(p.0, q.0), COLOR_EXPONENT);
        let cut = CUT * self.largest;
        let color = if color < cut {
            color * CUT_VALUE / cut
        } else {
            CUT_VALUE + (color - cut) / (self.largest - cut) * (1.0 - CUT_VALUE)
        };
        let feature = (p.1.edge - q.1.edge)
            .abs()
            .max((p.1.point - q.1.point).abs());
        let feature = (feature * std::f64::consts::FRAC_1_SQRT_2).sqrt();
        libm::pow(color, 1.0 - feature)
    }
}

/// Distance of colours: along the lightness, plus across it.
fn hyab(p: DVec3, q: DVec3) -> f64 {
    let d = p - q;
    d.x.abs() + (d.y * d.y + d.z * d.z).sqrt()
}
