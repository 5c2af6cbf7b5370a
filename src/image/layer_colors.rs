//! Layers of a film as colours, to be looked at.

use super::false_color::false_colors;
use phalanx_scene::film::{Aov, Film, NO_ID};

/// Colour where a layer has no value.
const NOTHING: [u8; 3] = [24, 26, 30];

/// Red, green and blue of each pixel of a layer: distances and costs in the colours of
/// [`false_color`](fn@crate::false_color), integers each in one of their own, and vectors from −1
/// to 1 as bytes. With the first comes the value of the last colour.
///
/// ```
/// # mod phalanx { pub use {phalanx_image as image, phalanx_scene::film}; }
/// use phalanx::film::{Aov, Aovs, Film};
/// use phalanx::image::layer_colors;
///
/// let film = Film::new(2, 1, false).with_aovs(Aovs::default().with(Aov::Depth));
/// let (rgb, scale) = layer_colors(&film, Aov::Depth);
/// assert_eq!((rgb.len(), scale), (6, Some(1.0)));
/// ```
pub fn layer_colors(film: &Film, aov: Aov) -> (Vec<u8>, Option<f32>) {
    let planes = film.layer(aov);
    match planes {
        [x, y, z, ..] => {
            let byte = |c: f32| ((0.5 * c + 0.5) * 255.0).round() as u8;
            let vectors = x.iter().zip(y).zip(z).map(|((x, y), z)| [*x, *y, *z]);
            let colors = vectors.map(
                |vector| {
                    if vector == [0.0; 3] { NOTHING } else { vector.map(byte) }
                },
            );
            (colors.flatten().collect(), None)
        }
        [ids, ..] if aov.channels()[0].1 => {
            let ids = ids.iter().map(|id| id.to_bits());
            (ids.flat_map(id_color).collect(), None)
        }
        [values, ..] => {
            let (mut rgb, scale) = false_colors(values);
            for (pixel, value) in rgb.as_chunks_mut().0.iter_mut().zip(values) {
                if value.is_infinite() {
                    *pixel = NOTHING;
                }
            }
            (rgb, Some(scale))
        }
        [] => (Vec::new(), None),
    }
}

/// A colour for a number; those of neighbours differ. The constants are those of MurmurHash3's last
/// step.
fn id_color(id: u32) -> [u8; 3] {
    if id == NO_ID {
        return NOTHING;
    }
    let mixed = (id ^ id >> 16).wrapping_mul(0x85eb_ca6b);
    let mixed = (mixed ^ mixed >> 13).wrapping_mul(0xc2b2_ae35);
    let [r, g, b, _] = (mixed ^ mixed >> 16).to_le_bytes();
    [r, g, b].map(|c| 64 + c / 4 * 3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use phalanx_scene::film::Aovs;

    /// The colours of a layer of two pixels with these values in its channels.
    fn colors(aov: Aov, values: [f32; 2]) -> (Vec<u8>, Option<f32>) {
        let mut film = Film::new(2, 1, false).with_aovs(Aovs::default().with(aov));
        film.aov_planes
            .iter_mut()
            .for_each(|plane| *plane = values.to_vec());
        layer_colors(&film, aov)
    }

    #[test]
    fn each_kind_of_layer_has_its_colours() {
        let (rgb, scale) = colors(Aov::Depth, [f32::INFINITY, 3.0]);
        assert_eq!((&rgb[..3], scale), (&NOTHING[..], Some(5.0)));
        assert_ne!(rgb[3..], NOTHING);
        assert_eq!(
            colors(Aov::Ns, [0.0, 1.0]),
            ([&NOTHING[..], &[255; 3]].concat(), None)
        );
        let (rgb, _) = colors(Aov::Primitive, [f32::from_bits(NO_ID), f32::from_bits(1)]);
        assert_eq!(rgb[..3], NOTHING);
        let (other, _) = colors(Aov::Primitive, [f32::from_bits(2), f32::from_bits(1)]);
        assert!(rgb[3..] == other[3..] && other[..3] != other[3..]);
    }
}
