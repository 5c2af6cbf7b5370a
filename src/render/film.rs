//! The picture while it is made: linear radiance in planes, and the primary hits where they are asked for.

/// `prim_id` of a pixel whose primary ray hit nothing.
pub const NO_HIT: u32 = u32::MAX;

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
