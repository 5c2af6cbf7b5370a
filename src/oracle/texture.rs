//! The texture's colour at one hit; explained in `shade`, where it is written for eight.

use super::intersect::{OracleHit, max, min};
use glam::Vec3;
use phalanx_scene::sampling::linear_of_srgb;
use phalanx_scene::{NO_TEXTURE, PrimKind, Scene, Texture, Wrap};

/// The factor of Ka and Kd on a stored primitive.
pub(super) fn texture_color(scene: &Scene, texture: u32, prim: u32, hit: &OracleHit) -> Vec3 {
    let prim = scene.prims[prim as usize];
    if texture == NO_TEXTURE || prim.kind() != PrimKind::Triangle {
        return Vec3::ONE;
    }
    let Some([a, b, c]) = scene.triangles.corner_uvs(prim.index()) else {
        return Vec3::ONE;
    };
    let (beta, gamma) = (hit.u, hit.v);
    let alpha = (1.0 - beta) - gamma;
    let position = (a * alpha + b * beta) + c * gamma;
    sample(&scene.textures[texture as usize], position.x, position.y)
}

fn sample(texture: &Texture, u: f32, v: f32) -> Vec3 {
    let (left, right, tx) = texel_pair(u, texture.wrap[0], texture.width);
    let (above, below, ty) = texel_pair(v, texture.wrap[1], texture.height);
    let texel = |column: u32, row: u32| {
        let index = row as usize * texture.width as usize + column as usize;
        let linear = linear_of_srgb();
        Vec3::from_array(texture.texels[index].map(|byte| linear[usize::from(byte)]))
    };
    let between = |a: Vec3, b: Vec3, t: f32| a + (b - a) * t;
    let along = |row: u32| between(texel(left, row), texel(right, row), tx);
    between(along(above), along(below), ty)
}

/// The two texels around a position, and the fraction of the way from the first to the second.
fn texel_pair(place: f32, wrap: Wrap, size: u32) -> (u32, u32, f32) {
    let folded = match wrap {
        Wrap::Repeat => fraction(place),
        Wrap::Clamp => min(max(place, 0.0), 1.0),
        Wrap::Mirror => {
            let there = fraction(place * 0.5) * 2.0;
            if there > 1.0 { 2.0 - there } else { there }
        }
    };
    let x = folded * size as f32 + 0.5;
    let k = x.floor() as u32;
    let (before, after) = match wrap {
        Wrap::Repeat => (size - 1, 0),
        Wrap::Clamp | Wrap::Mirror => (0, size - 1),
    };
    let lower = if k == 0 { before } else { k.min(size) - 1 };
    let upper = if k >= size { after } else { k };
    (lower, upper, x - x.floor())
}

/// The fractional part. Numbers from 2²² on count as whole, and so does a NaN.
fn fraction(x: f32) -> f32 {
    if x.abs() < 4_194_304.0 {
        x - x.floor()
    } else {
        0.0
    }
}
