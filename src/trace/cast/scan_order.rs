//! Rays of a picture in scan order, as most programs generate them, traced in blocks of pixels that
//! are coherent in both directions.
//!
//! Answers do not depend on the order of rays, so this only affects speed.

use super::RayBatch;

/// Rows of pixels in a band, the part of a picture that a worker takes at once.
const BAND_ROWS: usize = 8;

/// Columns of a block: with the rows of a band, it has the rays of a beam.
const BLOCK_COLUMNS: usize = 64;

/// Columns and rows of a packet.
const PACKET: (usize, usize) = (4, 2);

/// Range of picture widths that are recognised.
const WIDTHS: (usize, usize) = (32, 1 << 15);

/// The order in which rays of a picture are traced.
pub(super) struct ScanOrder {
    /// Indices of a band's rays, block by block and packet by packet.
    places: Vec<u32>,
    width: usize,
}

impl ScanOrder {
    /// The order for rays in scan order; `None` for all others.
    pub(super) fn of(rays: &RayBatch) -> Option<ScanOrder> {
        let width = width(rays)?;
        Some(ScanOrder {
            places: places(width, BAND_ROWS),
            width,
        })
    }

    /// Rays of a band.
    pub(super) fn band(&self) -> usize {
        BAND_ROWS * self.width
    }

    /// Indices of a band's rays, in tracing order. The last band of a picture may be smaller, and
    /// is traced in the given order.
    pub(super) fn places(&self, rays: usize) -> Option<&[u32]> {
        (rays == self.places.len()).then_some(&self.places)
    }
}

fn places(width: usize, rows: usize) -> Vec<u32> {
    let (columns_each, rows_each) = PACKET;
    let mut places = Vec::with_capacity(width * rows);
    for left in (0..width).step_by(BLOCK_COLUMNS) {
        let right = (left + BLOCK_COLUMNS).min(width);
        for top in (0..rows).step_by(rows_each) {
            for column in (left..right).step_by(columns_each) {
                for row in top..(top + rows_each).min(rows) {
                    let run = column..(column + columns_each).min(right);
                    places.extend(run.map(|column| (row * width + column) as u32));
                }
            }
        }
    }
    places
}

/// The number of rays after which a second row of pixels begins: steps between rays are equal
/// within a row, and differ from its end to the start of the next row.
fn width(rays: &RayBatch) -> Option<usize> {
    let count = rays.len();
    let (least, greatest) = WIDTHS;
    if count < 2 * least {
        return None;
    }
    // A parallel camera moves the rays' origins, any other camera rotates them.
    let turns = rays.ray(0).direction != rays.ray(1).direction;
    let place = |k: usize| {
        let ray = rays.ray(k);
        if turns { ray.direction } else { ray.origin }
    };
    let between = |from: usize, to: usize| difference(place(to), place(from));
    let mut step = between(0, 1);
    let end = (1..greatest.min(count / 2)).find(|&k| {
        let next = between(k, k + 1);
        let alike = length(difference(next, step)) <= length(step);
        step = next;
        // NaN compares unequal.
        !alike
    })?;
    let width = end + 1;
    // Rows start below each other, closer together than their length.
    let row = length(between(0, end));
    let beneath = |k: usize| {
        let down = length(between((k - 1) * width, k * width));
        down > 0.0 && down < 0.25 * row
    };
    let rows = count / width;
    (width >= least && rows >= 2 && [1, rows / 2, rows - 1].into_iter().all(beneath))
        .then_some(width)
}

fn difference(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

fn length([x, y, z]: [f32; 3]) -> f32 {
    (x * x + y * y + z * z).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cast::{Ray, RayBuffer};

    /// Rays of a camera, with directions of unit length and pixels that are not square.
    fn picture(width: usize, rows: usize) -> RayBuffer {
        let ray = |k: usize| {
            let (x, y) = ((k % width) as f32, (k / width) as f32);
            let (x, y) = (x / width as f32 - 0.5, y / rows as f32 - 0.5);
            let scale = 1.0 / length([x, y, 1.0]);
            Ray::new([1.0, 2.0, 3.0], [x, y, 1.0].map(|c| c * scale))
        };
        (0..width * rows).map(ray).collect()
    }

    fn width_of(rays: &RayBuffer) -> Option<usize> {
        width(&RayBatch::from(&rays.columns()))
    }

    #[test]
    fn pictures_are_found_and_nothing_else() {
        for (width, rows) in [(32, 24), (33, 100), (640, 480), (1001, 50)] {
            assert_eq!(width_of(&picture(width, rows)), Some(width));
        }
        assert_eq!(width_of(&picture(16, 100)), None);
        assert_eq!(width_of(&RayBuffer::default()), None);
        let same: RayBuffer = (0..999).map(|_| Ray::new([0.0; 3], [1.0; 3])).collect();
        assert_eq!(width_of(&same), None);
        let none: RayBuffer = (0..999)
            .map(|_| Ray::new([f32::NAN; 3], [f32::NAN; 3]))
            .collect();
        assert_eq!(width_of(&none), None);
        let parallel =
            |k: usize| Ray::new([(k % 80) as f32, (k / 80) as f32, 9.0], [0.0, 0.0, -1.0]);
        assert_eq!(width_of(&(0..4000).map(parallel).collect()), Some(80));
        let line = |k: usize| Ray::new([k as f32, 0.0, 9.0], [0.0, 0.0, -1.0]);
        assert_eq!(width_of(&(0..4000).map(line).collect()), None);
    }

    #[test]
    fn each_place_comes_once() {
        for (width, rows) in [(64, 8), (33, 8), (1001, 8), (5, 7)] {
            let mut places = places(width, rows);
            places.sort_unstable();
            assert!(places.into_iter().eq(0..(width * rows) as u32));
        }
    }

    #[test]
    fn packets_are_blocks_of_pixels() {
        assert_eq!(places(64, 8)[..8], [0, 1, 2, 3, 64, 65, 66, 67]);
    }
}
