//! Colours of binary STL: fifteen bits in the word at the end of each facet, in one of two
//! dialects.
//!
//! | dialect | known by | bit 15 | bits 0 to 4, 5 to 9, 10 to 14 |
//! |---|---|---|---|
//! | Materialise Magics | `COLOR=` and four bytes in the header: the colour of the rest | clear: the facet has a colour of its own | red, green, blue |
//! | VisCAM, SolidView | no other word than 0 without bit 15 | set: the facet has a colour | blue, green, red |
//!
//! The word is unused by the standard, and some programs leave arbitrary values in it.

use crate::memory::{MemoryLedger, OverLimit};
use crate::mesh::vertex_colors::{
    COLOR_BYTES, COLOR_ROW_BYTES, ColorOwners, MeshColors, linear_of_byte, linear_of_share,
};
use glam::Vec3;
use phalanx_scene::NO_INDEX;

/// Bit that tells facets with a colour from others.
const FLAG: u16 = 1 << 15;
/// Number of colours.
const COLORS: usize = FLAG as usize;

/// Bytes of the number of a facet's colour, while the mesh is made.
const NUMBER_BYTES: u64 = 4;

/// Colours of facets with these words; none unless the file clearly uses them. Facets without one
/// are `bare`. The error is for a message: there is no memory for them.
pub(super) fn read(
    header: &[u8],
    words: impl ExactSizeIterator<Item = u16> + Clone,
    bare: Option<Vec3>,
    memory: &MemoryLedger,
) -> Result<MeshColors, OverLimit> {
    let coloured = words.clone().any(|word| word != 0);
    let object = object_color(header);
    let plain = || words.clone().all(|word| word == 0 || word & FLAG != 0);
    if object.is_none() && !(coloured && plain()) {
        return Ok(MeshColors::default());
    }
    let facets = words.len() as u64;
    let needed = facets * (COLOR_ROW_BYTES + NUMBER_BYTES) + COLORS as u64 * COLOR_BYTES;
    memory.take(needed, "for the colours of the file's facets")?;
    let mut colors = MeshColors::default();
    let mut numbers = vec![NO_INDEX; COLORS];
    let mut row = |rgb: Vec3| {
        colors.rgb.push(rgb);
        colors.rgb.len() as u32 - 1
    };
    let others = object.or(bare).map_or(NO_INDEX, &mut row);
    let is_colored = |word: u16| match object {
        // If all words are 0, the header's colour is that of all facets.
        Some(_) => coloured && word & FLAG == 0,
        None => word & FLAG != 0,
    };
    let of_facet = |word: u16| {
        if !is_colored(word) {
            return others;
        }
        let number = &mut numbers[usize::from(word & !FLAG)];
        if *number == NO_INDEX {
            let [low, middle, high] = [0, 5, 10].map(|bit| channel(word >> bit));
            *number = row(match object {
                Some(_) => Vec3::new(low, middle, high),
                None => Vec3::new(high, middle, low),
            });
        }
        *number
    };
    let owners = words.map(of_facet).collect();
    colors.owners = ColorOwners::Triangles(owners);
    Ok(colors)
}

/// The linear value of the lowest five bits.
fn channel(bits: u16) -> f32 {
    linear_of_share(f32::from(bits & 31) / 31.0)
}

/// The colour that a header names for all facets without one of their own. Opacity is not used.
fn object_color(header: &[u8]) -> Option<Vec3> {
    let name = b"COLOR=";
    let position = memchr::memmem::find(header, name)?;
    let &[r, g, b, _] = header[position + name.len()..].first_chunk()?;
    Some([r, g, b].map(linear_of_byte).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(header: &[u8], words: &[u16]) -> Option<Vec<Option<[f32; 3]>>> {
        let words = words.iter().copied();
        let colors = read(header, words, None, &MemoryLedger::of(None)).expect("memory");
        let ColorOwners::Triangles(numbers) = &colors.owners else {
            assert!(colors.rgb.is_empty());
            return None;
        };
        let color = |&number: &u32| {
            let is_colored = number != NO_INDEX;
            is_colored.then(|| colors.rgb.get(number as usize).to_array())
        };
        Some(numbers.iter().map(color).collect())
    }

    const RED: Option<[f32; 3]> = Some([1.0, 0.0, 0.0]);
    const GREEN: Option<[f32; 3]> = Some([0.0, 1.0, 0.0]);
    const BLUE: Option<[f32; 3]> = Some([0.0, 0.0, 1.0]);

    #[test]
    fn viscam_marks_facets_with_a_colour() {
        let words = [0x801f, 0x83e0, 0xfc00, 0, 0x801f];
        let expected = vec![BLUE, GREEN, RED, None, BLUE];
        assert_eq!(of(b"", &words), Some(expected));
        let grey = of(b"", &[0x8000 | 16 << 10 | 16 << 5 | 16]).unwrap()[0].unwrap();
        assert!((grey[0] - 0.2289).abs() < 1e-3, "{grey:?}");
    }

    #[test]
    fn magics_marks_facets_without_one() {
        let header = b"x COLOR=\x00\xff\x00\xff,MATERIAL=";
        let words = [0x001f, 0x7c00, 0x8000, 0xffff];
        assert_eq!(of(header, &words), Some(vec![RED, BLUE, GREEN, GREEN]));
        let black = Some([0.0; 3]);
        assert_eq!(of(header, &[0x8000, 0]), Some(vec![GREEN, black]));
        assert_eq!(of(header, &[0, 0]), Some(vec![GREEN; 2]));
    }

    #[test]
    fn words_that_mean_something_else_colour_nothing() {
        for words in [
            &[][..],
            &[0, 0],
            &[1, 2, 3],
            &[0x8001, 0x0001],
            &[7, 0xffff],
        ] {
            assert_eq!(of(b"solid", words), None, "{words:?}");
        }
        // Cut off by the end of the header.
        assert_eq!(of(b"COLOR=abc", &[1]), None);
    }

    #[test]
    fn colours_count() {
        let words = std::iter::repeat_n(0xffff, 1_000_000);
        let refused = read(
            b"",
            words.clone(),
            None,
            &MemoryLedger::of(Some(16_000_000)),
        );
        assert!(refused.is_err_and(|message| message.what.contains("colours")));
        assert!(read(b"", words, None, &MemoryLedger::of(Some(17_000_000))).is_ok());
    }
}
