//! Light from infinitely far away, by direction: what surrounds the scene.

use crate::column::{AnyColumn, Column};
use crate::sampling::turns;
use crate::up_axis::UpAxis;
use glam::{DVec3, Vec3};
use half::f16;
use std::sync::Arc;

/// Maximum width and height of an environment's picture, in texels.
pub const MAX_ENVIRONMENT_SIDE: u32 = 16_384;

/// Surroundings of a scene: the radiance of rays that leave it.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Radiance by direction.
    pub light: EnvironmentLight,
    /// Factor of that radiance.
    pub scale: f32,
    /// True if camera rays see it, too; else they have [`Scene::background`](super::Scene).
    pub is_background: bool,
    up: UpAxis,
    turn: f64,
    /// Unit vectors to the right, to the zenith, and to the front: see [`UpAxis::frame`].
    frame: [Vec3; 3],
}

/// Radiance by direction.
#[derive(Clone, Debug, PartialEq)]
pub enum EnvironmentLight {
    /// Changes evenly from one colour straight below to another straight above. With two equal
    /// colours, it is the same from everywhere.
    Gradient {
        /// Radiance from straight below.
        nadir: Vec3,
        /// Radiance from straight above.
        zenith: Vec3,
    },
    /// A picture, which clones of the light share: it may be large.
    Map(Arc<EnvironmentMap>),
}

/// A picture of all directions, in equirectangular projection: its upper edge is the zenith, its
/// middle the direction to the right, and three quarters of its width the front, as in three.js,
/// and in Blender for the z axis.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentMap {
    /// Texels in a row, 1 to [`MAX_ENVIRONMENT_SIDE`].
    pub width: u32,
    /// Rows, 1 to [`MAX_ENVIRONMENT_SIDE`].
    pub height: u32,
    /// `width` × `height` texels, the uppermost row first.
    pub texels: EnvironmentTexels,
}

/// Linear radiance, not negative and finite, as its file has it.
#[derive(Clone, Debug, PartialEq)]
pub enum EnvironmentTexels {
    /// Mantissas of red, green and blue, and their exponent ("Real Pixels", G. Ward, Graphics Gems
    /// II, 1991): m · 2^(e − 136).
    Rgbe(Column<[u8; 4]>),
    /// Bits of halfs.
    Half(Column<[u16; 3]>),
    /// Floats.
    Float(Column<[f32; 3]>),
}

impl Environment {
    /// An environment whose zenith is this axis, turned by degrees about it, counter-clockwise as
    /// seen from above. It is the background.
    pub fn new(light: EnvironmentLight, up: UpAxis, turn: f64) -> Environment {
        Environment {
            light,
            scale: 1.0,
            is_background: true,
            up,
            turn,
            frame: turned_frame(up, turn),
        }
    }

    /// Places the environment anew: see [`Environment::new`].
    pub fn place(&mut self, up: UpAxis, turn: f64) {
        (self.up, self.turn) = (up, turn);
        self.frame = turned_frame(up, turn);
    }

    /// The axis of the zenith, and the turn about it in degrees.
    pub fn placement(&self) -> (UpAxis, f64) {
        (self.up, self.turn)
    }

    /// Radiance along a unit direction: nadir + (zenith − nadir)·(½ d·up + ½), or that of a map.
    #[inline]
    pub fn radiance(&self, dir: Vec3) -> Vec3 {
        let [right, up, front] = self.frame;
        let radiance = match &self.light {
            &EnvironmentLight::Gradient { nadir, zenith } => {
                let height = dir.dot(up) * 0.5 + 0.5;
                nadir + (zenith - nadir) * height
            }
            EnvironmentLight::Map(map) => {
                map.radiance(Vec3::new(dir.dot(right), dir.dot(up), dir.dot(front)))
            }
        };
        radiance * self.scale
    }

    /// Returns true if all numbers beside texels are finite, radiance is not negative, and a map
    /// has the texels of its size.
    pub fn is_valid(&self) -> bool {
        let is_lit = match &self.light {
            &EnvironmentLight::Gradient { nadir, zenith } => is_light(nadir) && is_light(zenith),
            EnvironmentLight::Map(map) => {
                let side = 1..=MAX_ENVIRONMENT_SIDE;
                let has_size = side.contains(&map.width) && side.contains(&map.height);
                has_size && map.texels.rows() == map.width as usize * map.height as usize
            }
        };
        is_lit && self.scale.is_finite() && self.scale >= 0.0 && self.turn.is_finite()
    }

    /// Number of the first texel that is negative, or not finite.
    pub fn first_invalid_texel(&self) -> Option<usize> {
        match &self.light {
            EnvironmentLight::Gradient { .. } => None,
            EnvironmentLight::Map(map) => {
                (0..map.texels.rows()).find(|&k| !is_light(map.texels.get(k)))
            }
        }
    }
}

fn is_light(color: Vec3) -> bool {
    color.is_finite() && color.min_element() >= 0.0
}

impl EnvironmentLight {
    /// The texels of a map in memory.
    pub fn texel_bytes(&self) -> &[u8] {
        match self {
            EnvironmentLight::Gradient { .. } => &[],
            EnvironmentLight::Map(map) => map.texels.column().bytes(),
        }
    }
}

/// The axes of a frame that is turned about its second one. Quarters of a circle are exact.
fn turned_frame(up: UpAxis, turn: f64) -> [Vec3; 3] {
    let [right, zenith, front] = up.frame();
    let quarters = libm::round(turn / 90.0);
    let rest = (turn - 90.0 * quarters).to_radians();
    let (sin, cos) = (libm::sin(rest), libm::cos(rest));
    let (sin, cos) = match quarters.rem_euclid(4.0) as u8 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    };
    let axes: [DVec3; 3] = [right * cos - front * sin, zenith, right * sin + front * cos];
    axes.map(|axis| axis.as_vec3())
}

impl EnvironmentMap {
    /// Radiance along a direction in the frame of the environment: bilinear between the centres of
    /// texels. The picture goes on beyond its sides, and beyond a pole on the opposite side.
    fn radiance(&self, dir: Vec3) -> Vec3 {
        let away = (dir.x * dir.x + dir.z * dir.z).sqrt();
        let u = turns(dir.z, dir.x) + 0.5;
        let v = turns(away, dir.y) * 2.0;
        let (x, y) = (u * self.width as f32 + 0.5, v * self.height as f32 + 0.5);
        // One more than the left column and the upper row of the four texels: never negative.
        let (column, row) = (x as u32, y as u32);
        let along = |row: u32| {
            let [a, b] = [column + self.width - 1, column].map(|column| self.texel(column, row));
            a + (b - a) * (x - column as f32)
        };
        let [above, below] = [row, row + 1].map(along);
        above + (below - above) * (y - row as f32)
    }

    /// The texel of a column, as far as twice the width, and of a row from 1, with one more above
    /// and below.
    fn texel(&self, column: u32, row: u32) -> Vec3 {
        let is_beyond = row == 0 || row > self.height;
        let column = column + if is_beyond { self.width / 2 } else { 0 };
        let row = row.clamp(1, self.height) - 1;
        let place = row as usize * self.width as usize + (column % self.width) as usize;
        self.texels.get(place)
    }
}

/// 2^(e − 127), a power of two of single precision.
fn power(exponent: u8) -> f32 {
    f32::from_bits(u32::from(exponent) << 23)
}

/// Exponents, with their biases, of the unit of mantissas and of one over it, together.
const POWERS_OF_MANTISSAS: u32 = 136 + 127;

/// Exponent of infinity in single precision.
const INFINITE_POWER: u32 = 255;

/// 2⁻⁹, which makes a mantissa a share of its exponent's power.
const MANTISSA: f32 = 1.0 / 512.0;

impl EnvironmentTexels {
    /// Radiance of a texel.
    #[inline]
    pub fn get(&self, k: usize) -> Vec3 {
        let rgb = match self {
            EnvironmentTexels::Rgbe(texels) => {
                let [r, g, b, exponent] = texels[k];
                let power = power(exponent);
                [r, g, b].map(|mantissa| f32::from(mantissa) * MANTISSA * power)
            }
            EnvironmentTexels::Half(texels) => texels[k].map(|bits| f16::from_bits(bits).to_f32()),
            EnvironmentTexels::Float(texels) => texels[k],
        };
        rgb.into()
    }

    /// Number of texels.
    pub fn rows(&self) -> usize {
        self.column().rows()
    }

    /// The column of the texels.
    pub fn column(&self) -> &dyn AnyColumn {
        match self {
            EnvironmentTexels::Rgbe(texels) => texels,
            EnvironmentTexels::Half(texels) => texels,
            EnvironmentTexels::Float(texels) => texels,
        }
    }

    /// The same column, to be mapped or given room.
    pub fn column_mut(&mut self) -> &mut dyn AnyColumn {
        match self {
            EnvironmentTexels::Rgbe(texels) => texels,
            EnvironmentTexels::Half(texels) => texels,
            EnvironmentTexels::Float(texels) => texels,
        }
    }

    /// Adds texels up to the first that the format cannot hold exactly. Returns true if there is
    /// none.
    pub fn extend(&mut self, mut rows: impl Iterator<Item = [f32; 3]>) -> bool {
        match self {
            EnvironmentTexels::Rgbe(texels) => {
                let texels = texels.make_mut();
                rows.all(|rgb| rgbe(rgb).map(|texel| texels.push(texel)).is_some())
            }
            EnvironmentTexels::Half(texels) => {
                let texels = texels.make_mut();
                rows.all(|rgb| {
                    let halfs = rgb.map(f16::from_f32);
                    texels.push(halfs.map(f16::to_bits));
                    halfs.map(f16::to_f32) == rgb
                })
            }
            EnvironmentTexels::Float(texels) => {
                texels.make_mut().extend(rows);
                true
            }
        }
    }
}

/// Mantissas and exponent that are exactly this colour, if there are any.
fn rgbe(rgb: [f32; 3]) -> Option<[u8; 4]> {
    let [r, g, b] = rgb;
    let largest = r.max(g).max(b);
    if largest == 0.0 {
        return Some([0; 4]);
    }
    // Plus one for the power of two above the largest, and one for RGBE's bias of 128.
    let exponent = (largest.to_bits() >> 23) + 2;
    // Reciprocal of the mantissas' unit, a power of two; tiny numbers have none.
    let of_unit = POWERS_OF_MANTISSAS.checked_sub(exponent)?;
    let per_unit = f32::from_bits(of_unit.min(INFINITE_POWER) << 23);
    let (r, g, b) = (r * per_unit, g * per_unit, b * per_unit);
    let texel = [r as u8, g as u8, b as u8, exponent as u8];
    let is_exact = f32::from(texel[0]) == r && f32::from(texel[1]) == g && f32::from(texel[2]) == b;
    (is_exact && exponent <= 255).then_some(texel)
}
