//! Values of textures at eight hits, bilinear between texel centres, colours decoded from sRGB
//! first; and colours of the vertices, by the barycentric weights.
//!
//! Texel positions follow from any finite texture coordinates, however large. Coordinates beyond
//! ±[`WHOLE`] count as integers, as single precision has almost no fractions there. So do values
//! that overflow on the way.

use super::surface_point::corner_columns;
use glam::Vec3;
use phalanx_scene::sampling::{ROUND_MAGIC, linear_of_srgb, share_of_byte};
use phalanx_scene::{MapTarget, NO_TEXTURE, Scene, Texture, TextureMap, Wrap};
use phalanx_trace::packet::HitPacket;
use phalanx_trace::simd::{F32x8, LANES, LaneMask, Lanes, Mask8, Vec3x8};

/// The colour without effect.
const WHITE: Vec3x8 = Vec3x8::new(F32x8::ONE, F32x8::ONE, F32x8::ONE);

/// 2²²: from here on a number counts as an integer. Below it, adding [`ROUND_MAGIC`] rounds.
const WHOLE: f32 = 4_194_304.0;

/// The factor of a material's colour at eight hits on triangles: the colour of its texture times
/// that of the vertices.
pub fn tint(scene: &Scene, material: u32, hits: &HitPacket) -> Vec3x8 {
    let texture = texture_color(scene, material, hits);
    if scene.triangles.colors.is_empty() {
        texture
    } else {
        texture.mul_elementwise(vertex_color(scene, hits))
    }
}

/// The interpolated colours of the vertices; 1 where a triangle has none.
fn vertex_color(scene: &Scene, hits: &HitPacket) -> Vec3x8 {
    let corners = hits.prim_id.to_array().map(|id| {
        let prim = scene.resolve(id).prim;
        scene
            .triangles
            .corner_colors(scene.prims[prim as usize].index())
    });
    let given = lanes_with(&corners);
    if !given.any() {
        return WHITE;
    }
    let [a, b, c] = corner_columns(corners.map(|colors| colors.unwrap_or([Vec3::ONE; 3])));
    let (beta, gamma) = (hits.u, hits.v);
    let alpha = (F32x8::ONE - beta) - gamma;
    let color = (a.scale(alpha) + b.scale(beta)) + c.scale(gamma);
    Vec3x8::select(given, color, WHITE)
}

/// The colour of a material's texture; 1 where the material has no texture or the triangle has no
/// texture coordinates.
fn texture_color(scene: &Scene, material: u32, hits: &HitPacket) -> Vec3x8 {
    let texture = scene.materials.texture[material as usize];
    if texture == NO_TEXTURE {
        return WHITE;
    }
    let texture = &scene.textures[texture as usize];
    TexturePosition::of(scene, 0, hits).map_or(WHITE, |position| {
        let color = sample(texture, linear_of_srgb(), &position);
        Vec3x8::select(position.given, color, WHITE)
    })
}

/// The lanes that have a value.
pub(super) fn lanes_with<T>(values: &[Option<T>; LANES]) -> Mask8 {
    let bit = |(k, value): (usize, &Option<T>)| u32::from(value.is_some()) << k;
    Mask8::from_bits(values.iter().enumerate().map(bit).sum())
}

/// The values of a map's picture, and the lanes whose triangles have texture coordinates; `None` if
/// no lane has them.
pub(super) fn map_value(
    scene: &Scene,
    map: &TextureMap,
    hits: &HitPacket,
) -> Option<(Mask8, Vec3x8)> {
    let position = TexturePosition::of(scene, map.uv_layer, hits)?;
    let decoded = match map.target {
        MapTarget::Emission | MapTarget::Specular => linear_of_srgb(),
        _ => share_of_byte(),
    };
    let texture = &scene.textures[map.texture as usize];
    Some((position.given, sample(texture, decoded, &position)))
}

/// Texture coordinates of eight hits, in the lanes that have them.
struct TexturePosition {
    given: Mask8,
    u: F32x8,
    v: F32x8,
}

impl TexturePosition {
    /// Interpolates a layer of the coordinates at hits on triangles; `None` if no lane has them.
    fn of(scene: &Scene, layer: u32, hits: &HitPacket) -> Option<TexturePosition> {
        let corners = hits.prim_id.to_array().map(|id| {
            let prim = scene.prims[scene.resolve(id).prim as usize];
            scene.triangles.corner_uvs(prim.index(), layer)
        });
        let given = lanes_with(&corners);
        if !given.any() {
            return None;
        }
        let (beta, gamma) = (hits.u, hits.v);
        let alpha = (F32x8::ONE - beta) - gamma;
        let place = |axis: usize| {
            let corner_value = |corner: usize| {
                F32x8::new(corners.map(|uvs| uvs.map_or(0.0, |uvs| uvs[corner][axis])))
            };
            (corner_value(0) * alpha + corner_value(1) * beta) + corner_value(2) * gamma
        };
        Some(TexturePosition {
            given,
            u: place(0),
            v: place(1),
        })
    }
}

/// Interpolates between the values of the four texels around a point: a + (b − a)·t along the rows,
/// then between the rows.
fn sample(texture: &Texture, value: &[f32; 256], position: &TexturePosition) -> Vec3x8 {
    let across =
        TexelPair::of(position.u, texture.wrap[0], texture.width).filtered(texture.nearest);
    let down = TexelPair::of(position.v, texture.wrap[1], texture.height).filtered(texture.nearest);
    let fetch = |columns: &[u32; LANES], rows: &[u32; LANES]| {
        let texels: [[u8; 3]; LANES] = std::array::from_fn(|k| {
            let row = rows[k] as usize * texture.width as usize;
            texture.texels[row + columns[k] as usize]
        });
        let channel = |c: usize| F32x8::new(texels.map(|texel| value[usize::from(texel[c])]));
        Vec3x8::new(channel(0), channel(1), channel(2))
    };
    let along = |rows: &[u32; LANES]| {
        let (left, right) = (fetch(&across.lower, rows), fetch(&across.upper, rows));
        left + (right - left).scale(across.weight)
    };
    let (upper, lower) = (along(&down.lower), along(&down.upper));
    upper + (lower - upper).scale(down.weight)
}

/// The two texels around a coordinate in one direction, and its relative position between them.
struct TexelPair {
    lower: [u32; LANES],
    upper: [u32; LANES],
    weight: F32x8,
}

impl TexelPair {
    fn of(place: F32x8, wrap: Wrap, size: u32) -> TexelPair {
        let two = F32x8::splat(2.0);
        let folded = match wrap {
            Wrap::Repeat => fraction(place),
            Wrap::Clamp => place.max(F32x8::ZERO).min(F32x8::ONE),
            Wrap::Mirror => {
                let there = fraction(place * F32x8::splat(0.5)) * two;
                there.gt(F32x8::ONE).select(two - there, there)
            }
        };
        // Half a texel to the right, so that texel k begins at its own centre and ends at the next
        // one's.
        let x = folded * F32x8::splat(size as f32) + F32x8::splat(0.5);
        let cell = floor(x);
        let (before, after) = match wrap {
            Wrap::Repeat => (size - 1, 0),
            Wrap::Clamp | Wrap::Mirror => (0, size - 1),
        };
        let upper = cell.to_array().map(|c| c as u32);
        TexelPair {
            lower: upper.map(|k| if k == 0 { before } else { k.min(size) - 1 }),
            upper: upper.map(|k| if k >= size { after } else { k }),
            weight: x - cell,
        }
    }

    /// The same, or the nearer texel twice, so that blending both gives its value.
    fn filtered(mut self, nearest: bool) -> TexelPair {
        if nearest {
            for (k, weight) in self.weight.to_array().into_iter().enumerate() {
                let nearer = [self.lower[k], self.upper[k]][usize::from(weight >= 0.5)];
                (self.lower[k], self.upper[k]) = (nearer, nearer);
            }
        }
        self
    }
}

/// Fractional part, in \[0, 1\]: the distance to the next smaller whole number. 0 for numbers that
/// count as whole, and for NaN.
fn fraction(x: F32x8) -> F32x8 {
    let fine = x.abs().lt(F32x8::splat(WHOLE));
    fine.select(x - floor(x), F32x8::ZERO)
}

/// The next smaller whole number, for |x| < [`WHOLE`].
fn floor(x: F32x8) -> F32x8 {
    let magic = F32x8::splat(ROUND_MAGIC);
    let nearest = (x + magic) - magic;
    nearest.gt(x).select(nearest - F32x8::ONE, nearest)
}
