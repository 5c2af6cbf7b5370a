//! Films bit by bit, so that -0 is not 0 and equal NaNs are equal.

use phalanx_scene::film::{Film, Tile};

/// All compared values of a pixel, as bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelBits {
    /// Primitive, distance and barycentric weights, if hits were recorded.
    pub hit: Option<HitBits>,
    /// Radiance.
    pub radiance: [u32; 3],
    /// A hash of its AOVs; 0 without any.
    pub layers: u64,
}

/// A primary hit as bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HitBits {
    /// Primitive, or [`NO_HIT`](phalanx_scene::film::NO_HIT).
    pub prim_id: u32,
    /// t, u and v.
    pub tuv: [u32; 3],
}

impl PixelBits {
    /// Pixel `i` of a film.
    pub fn of(film: &Film, i: usize) -> PixelBits {
        let hit = film.hits.as_ref().map(|hits| HitBits {
            prim_id: hits.prim_id[i],
            tuv: [&hits.t, &hits.u, &hits.v].map(|column| column[i].to_bits()),
        });
        PixelBits {
            hit,
            radiance: [0, 1, 2].map(|c| film.planes[c][i].to_bits()),
            layers: film.aov_planes.iter().fold(0, |hash, layer| {
                (hash ^ u64::from(layer[i].to_bits()) ^ 1 << 32).wrapping_mul(0x0100_0000_01b3)
            }),
        }
    }
}

/// Compares two films of one size: the first pixel that differs, and the number of such pixels.
pub fn differing_pixels(a: &Film, b: &Film) -> Option<(usize, usize)> {
    let mut differing =
        (0..a.planes[0].len()).filter(|&i| PixelBits::of(a, i) != PixelBits::of(b, i));
    let first = differing.next()?;
    Some((first, 1 + differing.count()))
}

/// Two 64-bit FNV-1a hashes of each pixel over little-endian bits: those of its primary hit
/// (prim_id, t, u, v), and those of its radiance. A row of the picture is one string, with 16
/// hexadecimal digits per pixel.
pub fn pixel_hashes(film: &Film) -> [Vec<String>; 2] {
    let width = film.width as usize;
    let rows = |hash: fn(PixelBits) -> u64| {
        let digits = |i: usize| format!("{:016x}", hash(PixelBits::of(film, i)));
        let row = |y: usize| (y * width..(y + 1) * width).map(digits).collect();
        (0..film.height as usize).map(row).collect()
    };
    [rows(hit_hash), rows(|pixel| fnv1a(&pixel.radiance))]
}

fn hit_hash(pixel: PixelBits) -> u64 {
    let words = pixel
        .hit
        .map(|hit| [hit.prim_id, hit.tuv[0], hit.tuv[1], hit.tuv[2]]);
    fnv1a(&words.unwrap_or_default())
}

/// Adds a plane's little-endian bytes.
pub fn extend_with_plane(bytes: &mut Vec<u8>, plane: &[f32]) {
    let end = bytes.len();
    bytes.resize(end + 4 * plane.len(), 0);
    let words = bytes[end..].as_chunks_mut::<4>().0.iter_mut();
    for (word, value) in words.zip(plane) {
        *word = value.to_le_bytes();
    }
}

/// Copies the part of a tile that lies in a window onto the window's film. The bytes are those of
/// the tile's planes ([`extend_with_plane`]), row by row.
pub fn put_tile_bytes(film: &mut Film, window: Tile, tile: Tile, bytes: &[u8]) {
    let part = tile.within(window);
    let plane_bytes = 4 * tile.pixels() as usize;
    let planes = film.planes_mut().into_iter();
    for (plane, bytes) in planes.zip(bytes.chunks_exact(plane_bytes)) {
        let words = bytes.as_chunks::<4>().0;
        for y in part.y..part.y + part.height {
            let from = ((y - tile.y) * tile.width + part.x - tile.x) as usize;
            let to = (y - window.y) as usize * window.width as usize + (part.x - window.x) as usize;
            let width = part.width as usize;
            let pixels = plane[to..to + width].iter_mut();
            for (pixel, word) in pixels.zip(&words[from..from + width]) {
                *pixel = f32::from_le_bytes(*word);
            }
        }
    }
}

/// FNV-1a, 64 bits, over the little-endian bytes (<http://www.isthe.com/chongo/tech/comp/fnv/>).
fn fnv1a(words: &[u32]) -> u64 {
    let bytes = words.iter().flat_map(|w| w.to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_fnv1a() {
        // Published values: of no bytes, and of the bytes "foob" and "ar\0\0" by continuation.
        assert_eq!(fnv1a(&[]), 0xcbf2_9ce4_8422_2325);
        assert_eq!(
            fnv1a(&[u32::from_le_bytes(*b"foob")]),
            0xdd12_0e79_0c25_12af
        );
    }
}
