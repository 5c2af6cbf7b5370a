//! The picture while it is made: linear radiance in planes, and the primary hits where they are asked for.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// `prim_id` of a pixel whose primary ray hit nothing.
pub const NO_HIT: u32 = crate::packet::NO_PRIM;

/// Linear, unclamped RGB radiance of every pixel, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Red, green and blue planes, each of width · height values.
    pub planes: [Vec<f32>; 3],
    /// Primary hits, if the render recorded them.
    pub hits: Option<Hits>,
}

/// Primary hits of every pixel, in the film's order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hits {
    /// Primitive, or [`NO_HIT`].
    pub prim_id: Vec<u32>,
    /// Distance along the unit direction; 0 where nothing was hit.
    pub t: Vec<f32>,
    /// Barycentric weight of the second corner (triangles), else 0.
    pub u: Vec<f32>,
    /// Barycentric weight of the third corner (triangles), else 0.
    pub v: Vec<f32>,
}

impl Film {
    /// Radiance of the pixel in column `x`, row `y`.
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 3] {
        let i = y as usize * self.width as usize + x as usize;
        [self.planes[0][i], self.planes[1][i], self.planes[2][i]]
    }
}

/// A film that workers fill at the same time. No two tiles share a pixel, so the order of the (relaxed) stores does
/// not matter; joining the workers makes them visible.
pub struct SharedFilm {
    width: u32,
    height: u32,
    /// Red, green, blue; then t, u, v if hits are recorded.
    planes: Vec<Vec<AtomicU32>>,
    prim_id: Vec<AtomicU32>,
}

impl SharedFilm {
    /// A black film.
    pub fn new(width: u32, height: u32, record_hits: bool) -> SharedFilm {
        let pixels = width as usize * height as usize;
        let plane = |fill: u32| {
            let mut plane = Vec::new();
            plane.resize_with(pixels, || AtomicU32::new(fill));
            plane
        };
        SharedFilm {
            width,
            height,
            planes: (0..if record_hits { 6 } else { 3 })
                .map(|_| plane(0))
                .collect(),
            prim_id: if record_hits {
                plane(NO_HIT)
            } else {
                Vec::new()
            },
        }
    }

    /// Whether the film keeps hits.
    pub fn records_hits(&self) -> bool {
        !self.prim_id.is_empty()
    }

    /// Stores a pixel's radiance.
    pub fn set(&self, x: u32, y: u32, rgb: [f32; 3]) {
        self.store(0, x, y, rgb);
    }

    /// Stores a pixel's primary hit as (t, u, v) and primitive, if the film keeps hits.
    pub fn set_hit(&self, x: u32, y: u32, tuv: [f32; 3], prim_id: u32) {
        if self.records_hits() {
            self.store(3, x, y, tuv);
            self.prim_id[self.index(x, y)].store(prim_id, Relaxed);
        }
    }

    fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }

    fn store(&self, first_plane: usize, x: u32, y: u32, values: [f32; 3]) {
        let i = self.index(x, y);
        for (plane, value) in self.planes[first_plane..].iter().zip(values) {
            plane[i].store(value.to_bits(), Relaxed);
        }
    }

    /// The finished film.
    pub fn finish(self) -> Film {
        let floats = |plane: Vec<AtomicU32>| -> Vec<f32> {
            plane
                .into_iter()
                .map(|v| f32::from_bits(v.into_inner()))
                .collect()
        };
        let prim_id: Vec<u32> = self
            .prim_id
            .into_iter()
            .map(AtomicU32::into_inner)
            .collect();
        let mut planes = self.planes.into_iter().map(floats);
        let mut next = || planes.next().unwrap_or_default();
        let colors = [next(), next(), next()];
        let (t, u, v) = (next(), next(), next());
        Film {
            width: self.width,
            height: self.height,
            planes: colors,
            hits: (!prim_id.is_empty()).then_some(Hits { prim_id, t, u, v }),
        }
    }
}
