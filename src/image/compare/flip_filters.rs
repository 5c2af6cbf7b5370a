//! Filters of FLIP, along rows and then across them, and its colour spaces.

use glam::{DMat3, DVec3};
use std::f64::consts::PI;

/// Pixels in a degree of the visual field: a screen of 0.7 m and 3840 pixels, seen from 0.7 m.
const PIXELS_PER_DEGREE: f64 = 67.0;
/// Widths of the eye's sensitivity for lightness, red to green, and blue to yellow, which is a sum
/// of two bells with these heights.
const WIDTHS: [f64; 4] = [0.0047, 0.0053, 0.04, 0.025];
const BLUE_HEIGHTS: [f64; 2] = [34.1, 13.5];
/// Radius of the filters of colours in pixels: three standard deviations of the widest.
pub(super) const COLOR_RADIUS: usize = 10;
/// Radius of the detectors of edges and points in pixels.
const FEATURE_RADIUS: usize = 9;
/// Standard deviation of these detectors in degrees.
const FEATURE_SIGMA: f64 = 0.5 * 0.082;

/// Sums along a row for one pixel: lightness, red to green, and both bells of blue to yellow; then
/// lightness by a bell and by its first and second derivative.
type PixelSums = [f64; 7];

/// A row that has been filtered along itself.
pub(super) struct FlipRow(Vec<PixelSums>);

/// Responses of the detectors at a pixel.
#[derive(Clone, Copy)]
pub(super) struct Features {
    pub(super) edge: f64,
    pub(super) point: f64,
}

/// Weights of the filters, and the matrices between colour spaces.
pub(super) struct FlipFilters {
    bells: [[f64; 2 * COLOR_RADIUS + 1]; 4],
    detectors: [[f64; 2 * FEATURE_RADIUS + 1]; 3],
    to_xyz: DMat3,
    to_rgb: DMat3,
    white: DVec3,
}

impl FlipFilters {
    pub(super) fn new() -> FlipFilters {
        // The primaries of sRGB and its white, IEC 61966-2-1.
        let to_xyz = DMat3::from_cols(
            DVec3::new(0.412_386_56, 0.212_636_82, 0.019_330_62),
            DVec3::new(0.357_591_49, 0.715_182_98, 0.119_197_16),
            DVec3::new(0.180_450_49, 0.072_180_20, 0.950_372_59),
        );
        FlipFilters {
            bells: bells(),
            detectors: detectors(),
            to_xyz,
            to_rgb: to_xyz.inverse(),
            white: to_xyz * DVec3::ONE,
        }
    }

    /// Filters a row of linear colours along itself. Beyond its ends, the end pixels are repeated.
    pub(super) fn along(&self, linear: Vec<DVec3>) -> FlipRow {
        let opponent = |rgb: DVec3| {
            let xyz = self.to_xyz * rgb / self.white;
            let (x, y, z) = (xyz.x, xyz.y, xyz.z);
            DVec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
        };
        let row: Vec<DVec3> = linear.into_iter().map(opponent).collect();
        let last = row.len().saturating_sub(1) as isize;
        let near = |x: usize, k: usize, radius: usize| {
            row[(x as isize + k as isize - radius as isize).clamp(0, last) as usize]
        };
        let sums = (0..row.len()).map(|x| {
            let mut sums = [0.0; 7];
            for k in 0..=2 * COLOR_RADIUS {
                let color = near(x, k, COLOR_RADIUS);
                let values = [color.x, color.y, color.z, color.z];
                for ((sum, value), bell) in sums.iter_mut().zip(values).zip(&self.bells) {
                    *sum += bell[k] * value;
                }
            }
            for k in 0..=2 * FEATURE_RADIUS {
                let lightness = (near(x, k, FEATURE_RADIUS).x + 16.0) / 116.0;
                for (sum, detector) in sums[4..].iter_mut().zip(&self.detectors) {
                    *sum += detector[k] * lightness;
                }
            }
            sums
        });
        FlipRow(sums.collect())
    }

    /// Filters rows across, which gives the colours and features of the middle one.
    pub(super) fn across(&self, rows: &[&FlipRow]) -> Vec<(DVec3, Features)> {
        let width = rows.first().map_or(0, |row| row.0.len());
        let inner = COLOR_RADIUS - FEATURE_RADIUS;
        let pixel = |x: usize| {
            let mut color = [0.0; 4];
            for (k, row) in rows.iter().enumerate() {
                for ((sum, value), bell) in color.iter_mut().zip(row.0[x]).zip(&self.bells) {
                    *sum += bell[k] * value;
                }
            }
            let [mut edge, mut point] = [[0.0; 2]; 2];
            let [bell, first, second] = &self.detectors;
            for (k, row) in rows.iter().skip(inner).take(first.len()).enumerate() {
                let [.., smooth, slope, bend] = row.0[x];
                edge = [edge[0] + bell[k] * slope, edge[1] + first[k] * smooth];
                point = [point[0] + bell[k] * bend, point[1] + second[k] * smooth];
            }
            let length = |[x, y]: [f64; 2]| (x * x + y * y).sqrt();
            let features = Features {
                edge: length(edge),
                point: length(point),
            };
            let [light, red, blue, more_blue] = color;
            let linear = self.to_linear(DVec3::new(light, red, blue + more_blue));
            (self.hunt_lab(linear), features)
        };
        (0..width).map(pixel).collect()
    }

    /// Linear colours in \[0, 1\] of filtered ones.
    fn to_linear(&self, opponent: DVec3) -> DVec3 {
        let y = (opponent.x + 16.0) / 116.0;
        let xyz = DVec3::new(opponent.y / 500.0 + y, y, y - opponent.z / 200.0) * self.white;
        (self.to_rgb * xyz).clamp(DVec3::ZERO, DVec3::ONE)
    }

    /// CIELAB of a linear colour, less colourful where it is dark.
    pub(super) fn hunt_lab(&self, linear: DVec3) -> DVec3 {
        let curve = |share: f64| {
            const JOINT: f64 = 6.0 / 29.0;
            if share > JOINT * JOINT * JOINT {
                libm::cbrt(share)
            } else {
                share / (3.0 * JOINT * JOINT) + 4.0 / 29.0
            }
        };
        let xyz = self.to_xyz * linear / self.white;
        let (x, y, z) = (curve(xyz.x), curve(xyz.y), curve(xyz.z));
        let light = 116.0 * y - 16.0;
        DVec3::new(light, 5.0 * light * (x - y), 2.0 * light * (y - z))
    }
}

/// Weights of the bells along one axis. Those of a filter add up to 1 over both axes.
fn bells() -> [[f64; 2 * COLOR_RADIUS + 1]; 4] {
    let bell = |width: f64| -> [f64; 2 * COLOR_RADIUS + 1] {
        std::array::from_fn(|k| {
            let x = (k as f64 - COLOR_RADIUS as f64) / PIXELS_PER_DEGREE;
            libm::exp(-PI * PI * x * x / width)
        })
    };
    let area = |weights: &[f64]| weights.iter().sum::<f64>() * weights.iter().sum::<f64>();
    let mut bells = WIDTHS.map(bell);
    let heights: [f64; 2] = std::array::from_fn(|k| BLUE_HEIGHTS[k] * (PI / WIDTHS[2 + k]).sqrt());
    let both = heights[0] * area(&bells[2]) + heights[1] * area(&bells[3]);
    let scales = [
        1.0 / area(&bells[0]),
        1.0 / area(&bells[1]),
        heights[0] / both,
        heights[1] / both,
    ];
    for (bell, scale) in bells.iter_mut().zip(scales) {
        bell.iter_mut().for_each(|weight| *weight *= scale.sqrt());
    }
    bells
}

/// Weights of a bell and of its derivatives along one axis. Positive weights add up to 1, negative
/// ones to -1.
fn detectors() -> [[f64; 2 * FEATURE_RADIUS + 1]; 3] {
    let sigma = FEATURE_SIGMA * PIXELS_PER_DEGREE;
    let weights = |height: fn(f64) -> f64| -> [f64; 2 * FEATURE_RADIUS + 1] {
        let all: [f64; 2 * FEATURE_RADIUS + 1] = std::array::from_fn(|k| {
            let x = (k as f64 - FEATURE_RADIUS as f64) / sigma;
            height(x) * libm::exp(-0.5 * x * x)
        });
        let sum = |sign: f64| all.iter().map(|w| (w * sign).max(0.0)).sum::<f64>();
        let (above, below) = (sum(1.0), sum(-1.0));
        all.map(
            |w| {
                if w > 0.0 { w / above } else { w / below.max(f64::MIN_POSITIVE) }
            },
        )
    };
    [weights(|_| 1.0), weights(|x| -x), weights(|x| x * x - 1.0)]
}
