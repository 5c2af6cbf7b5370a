//! Pictures of heights as normal maps.

use phalanx_scene::{Texture, Wrap};

/// Slope of a step from black to white within two texels. Formats name no unit of heights; this one
/// shows the grain of most pictures, at any resolution.
const STEEPNESS: f32 = 4.0;

/// Brightest texel that counts as empty: black, or next to black in a JPEG. No normal is as dark.
const EMPTY: u8 = 32;

/// Returns true if the picture is bluish, as normals are that point outward. The unused parts of an
/// atlas do not count: they are black or transparent.
pub(super) fn is_normal_map(picture: &Texture) -> bool {
    let (mut sums, mut count) = ([0u64; 3], 0u64);
    for (k, texel) in picture.texels.iter().enumerate() {
        if texel.iter().any(|&c| c > EMPTY) && picture.alpha.get(k) != Some(&0) {
            (0..3).for_each(|channel| sums[channel] += u64::from(texel[channel]));
            count += 1;
        }
    }
    let [r, g, b] = sums.map(|sum| sum as f64 / count.max(1) as f64);
    let is_middle = |mean: f64| (90.0..=165.0).contains(&mean);
    is_middle(r) && is_middle(g) && b > r.max(g) + 50.0
}

/// Normals of heights, the green of each texel: central differences over two texels, encoded as in
/// glTF.
pub(super) fn normals_of_heights(heights: &Texture) -> Vec<[u8; 3]> {
    let (width, height) = (heights.width as usize, heights.height as usize);
    let height_at =
        |column: usize, row: usize| f32::from(heights.texels[row * width + column][1]) / 255.0;
    let [across, down] = heights.wrap;
    let mut normals = Vec::with_capacity(width * height);
    for row in 0..height {
        let [above, below] = neighbours(row, height, down);
        for column in 0..width {
            let [left, right] = neighbours(column, width, across);
            let x = (height_at(left, row) - height_at(right, row)) * STEEPNESS;
            let y = (height_at(column, below) - height_at(column, above)) * STEEPNESS;
            let length = (x * x + y * y + 1.0).sqrt();
            let byte = |c: f32| ((c / length * 0.5 + 0.5) * 255.0).round() as u8;
            normals.push([byte(x), byte(y), byte(1.0)]);
        }
    }
    normals
}

fn neighbours(k: usize, count: usize, wrap: Wrap) -> [usize; 2] {
    match wrap {
        Wrap::Repeat => [(k + count - 1) % count, (k + 1) % count],
        Wrap::Clamp | Wrap::Mirror => [k.saturating_sub(1), (k + 1).min(count - 1)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture of grey heights in rows of `width`.
    fn heights(width: u32, wrap: Wrap, grey: &[u8]) -> Texture {
        Texture {
            width,
            height: grey.len() as u32 / width,
            wrap: [wrap; 2],
            nearest: false,
            texels: grey.iter().map(|&c| [c; 3]).collect(),
            alpha: Default::default(),
        }
    }

    #[test]
    fn slopes_face_away_from_the_heights() {
        const FLAT: [u8; 3] = [128, 128, 255];
        let ramp = normals_of_heights(&heights(4, Wrap::Clamp, &[0, 0, 255, 255]));
        assert_eq!([ramp[0], ramp[3]], [FLAT; 2]);
        let [x, y, z] = ramp[1];
        assert!(x < 10 && y == 128 && z < 170, "{ramp:?}");
        let hill = normals_of_heights(&heights(1, Wrap::Clamp, &[0, 255, 0]));
        assert_eq!(hill[1], FLAT);
        // Above the hill, the slope faces the upper edge, which is positive y.
        assert!(hill[0][1] > 240 && hill[2][1] < 15, "{hill:?}");
        let around = normals_of_heights(&heights(3, Wrap::Repeat, &[255, 0, 0]));
        assert!(around[2][0] < 10, "{around:?}");
    }

    #[test]
    fn normal_maps_are_bluish() {
        let is_normal_map = |texels: &[[u8; 3]], alpha: &[u8]| {
            is_normal_map(&Texture {
                texels: texels.to_vec().into(),
                alpha: alpha.to_vec().into(),
                ..heights(1, Wrap::Clamp, &[0])
            })
        };
        let outward = [128, 128, 255];
        assert!(is_normal_map(&[outward, [90, 160, 230]], &[]));
        for grey in [0, 128, 255] {
            assert!(!is_normal_map(&[[grey; 3]], &[]));
        }
        assert!(!is_normal_map(&[], &[]) && !is_normal_map(&[[10, 20, 200]], &[]));
        // Unused parts of an atlas, four fifths of it.
        let atlas = |unused| [outward, unused, unused, unused, unused];
        assert!(is_normal_map(&atlas([20, 30, 16]), &[]));
        assert!(is_normal_map(&atlas([255; 3]), &[255, 0, 0, 0, 0]));
        // Heights stay heights, however much of them is black or cut out.
        assert!(!is_normal_map(&[[200; 3], [0; 3], [0; 3]], &[]));
        assert!(!is_normal_map(&atlas([255; 3]), &[0, 255, 255, 255, 255]));
    }
}
