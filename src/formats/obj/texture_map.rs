//! Textures that a material names: options, and a file name.

use super::cursor::Cursor;
use crate::diagnostics::Span;
use crate::texture::TextureSampler;
use glam::Vec2;
use phalanx_scene::Wrap;

/// A texture that a material names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MtlTexture {
    /// The file's name, perhaps with a comment behind it.
    pub(super) name: Span,
    pub(super) sampler: TextureSampler,
    pub(super) transform: UvTransform,
    /// True for a mask that is the picture's alpha, regardless of its colours.
    pub(super) matte: bool,
    /// Channel of a number: 0, 1 or 2 for red, green or blue.
    pub(super) channel: u32,
    /// Factor of a relief: `-bm`.
    pub(super) bump: f32,
}

/// The options `-s` and `-o`: u' = s · u + o, with v from the bottom of the picture upward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UvTransform {
    pub(super) scale: Vec2,
    pub(super) offset: Vec2,
}

impl UvTransform {
    pub(super) const IDENTITY: UvTransform = UvTransform {
        scale: Vec2::ONE,
        offset: Vec2::ZERO,
    };

    /// The UV at which the texture is sampled, for a UV of the scene, whose v points downward.
    /// (0, 0) instead of numbers that are not finite.
    pub(super) fn apply(&self, [u, v]: [f32; 2]) -> Vec2 {
        let up = Vec2::new(u, 1.0 - v) * self.scale + self.offset;
        let uv = Vec2::new(up.x, 1.0 - up.y);
        if uv.is_finite() { uv } else { Vec2::ZERO }
    }

    /// The numbers' bits, which can be compared and hashed.
    pub(super) fn bits(&self) -> [u32; 4] {
        [self.scale.x, self.scale.y, self.offset.x, self.offset.y].map(f32::to_bits)
    }
}

/// Options with a fixed number of operands, of which none is shown.
const OPTIONS: [(&[u8], usize); 8] = [
    (b"-blendu", 1),
    (b"-blendv", 1),
    (b"-boost", 1),
    (b"-cc", 1),
    (b"-mm", 2),
    (b"-texres", 1),
    (b"-type", 1),
    (b"-colorspace", 1),
];

/// A file name after options; `None` if there is no name. `leave_out` gets the options that are not
/// shown.
pub(super) fn read(
    cursor: &mut Cursor,
    mut leave_out: impl FnMut(&Cursor, Span),
) -> Option<MtlTexture> {
    let mut map = MtlTexture {
        name: Span::START,
        sampler: TextureSampler::default(),
        transform: UvTransform::IDENTITY,
        matte: false,
        channel: 0,
        bump: 1.0,
    };
    loop {
        cursor.skip_blanks();
        let start = *cursor;
        let option = cursor.word();
        let text = start.bytes(option);
        let is = |name: &[u8]| text.eq_ignore_ascii_case(name);
        if is(b"-clamp") {
            let on = cursor.word();
            let on = start.bytes(on).eq_ignore_ascii_case(b"on");
            map.sampler.wrap = [if on { Wrap::Clamp } else { Wrap::Repeat }; 2];
        } else if is(b"-imfchan") {
            let channel = cursor.word();
            match start.bytes(channel) {
                b"m" | b"M" => map.matte = true,
                b"l" | b"L" | b"r" | b"R" => {}
                b"g" | b"G" => map.channel = 1,
                b"b" | b"B" => map.channel = 2,
                _ => leave_out(&start, option),
            }
        } else if is(b"-s") {
            map.transform.scale = vector(cursor, Vec2::ONE);
        } else if is(b"-o") {
            map.transform.offset = vector(cursor, Vec2::ZERO);
        } else if is(b"-bm") {
            let factor = cursor.float().ok().filter(|factor| factor.is_finite());
            map.bump = factor.unwrap_or(1.0);
        } else if is(b"-t") {
            vector(cursor, Vec2::ZERO);
            leave_out(&start, option);
        } else if let Some((_, operands)) = OPTIONS.iter().find(|(name, _)| is(name)) {
            (0..*operands).for_each(|_| _ = cursor.word());
            leave_out(&start, option);
        } else {
            *cursor = start;
            break;
        }
    }
    map.name = cursor.rest_of_line();
    (!super::name::without_comment(cursor.bytes(map.name)).is_empty()).then_some(map)
}

/// Up to three finite numbers, of which two are used. The last word of a statement is its file
/// name, even if it is a number.
fn vector(cursor: &mut Cursor, default: Vec2) -> Vec2 {
    let mut out = default.extend(0.0);
    for k in 0..3 {
        let mut ahead = *cursor;
        match ahead.float() {
            Ok(number) if !ahead.at_statement_end() => {
                *cursor = ahead;
                if number.is_finite() {
                    out[k] = number;
                }
            }
            _ => break,
        }
    }
    out.truncate()
}

/// Passes an option and its operands, if there is one here.
pub(super) fn skip_option(cursor: &mut Cursor, option: &[u8], operands: usize) {
    let mut ahead = *cursor;
    let word = ahead.word();
    if ahead.bytes(word).eq_ignore_ascii_case(option) {
        (0..operands).for_each(|_| _ = ahead.word());
        *cursor = ahead;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The name, the map, and the options that are omitted.
    fn of(line: &str) -> Option<(&str, MtlTexture, Vec<&str>)> {
        let mut cursor = Cursor {
            text: line.as_bytes(),
            at: 0,
        };
        let mut left_out = Vec::new();
        let map = read(&mut cursor, |_, option| {
            left_out.push(&line[option.range()])
        })?;
        Some((&line[map.name.range()], map, left_out))
    }

    #[test]
    fn a_name_follows_the_options() {
        for (line, name) in [
            (" wood.png", "wood.png"),
            ("\ttwo words.png \t\r\n", "two words.png"),
            ("-s 1 2 3 -o .5 -bm 0.2 -mm 0 1 -blendu on 2.png", "2.png"),
            ("-s 1 1 7", "7"),
            ("-S 2 a.png # tex", "a.png # tex"),
            ("-dark.png", "-dark.png"),
        ] {
            assert_eq!(of(line).map(|m| m.0), Some(name), "{line}");
        }
        for none in ["", "  \n", "-s 1", "# tex", "-clamp on"] {
            assert!(of(none).is_none_or(|m| m.0 == "1"), "{none}");
        }
    }

    #[test]
    fn options_are_read_or_named() {
        let (_, map, left_out) =
            of("-s 2 3 1 -O 0.5 -clamp ON -t 1 1 1 -imfchan m -cc on a.png").unwrap();
        let (scale, offset) = (map.transform.scale, map.transform.offset);
        assert_eq!((scale, offset), (Vec2::new(2.0, 3.0), Vec2::new(0.5, 0.0)));
        assert_eq!((map.sampler.wrap, map.matte), ([Wrap::Clamp; 2], true));
        assert_eq!(left_out, ["-t", "-cc"]);
        let (_, map, _) = of("-s nan 2 -clamp off a.png").unwrap();
        assert_eq!(
            (map.transform.scale, map.sampler.wrap),
            (Vec2::new(1.0, 2.0), [Wrap::Repeat; 2])
        );
    }

    #[test]
    fn v_is_scaled_and_moved_from_the_bottom_upward() {
        let transform = UvTransform {
            scale: Vec2::new(2.0, 4.0),
            offset: Vec2::new(0.5, 0.25),
        };
        // The lower left corner is (0, 1) in the scene.
        assert_eq!(transform.apply([0.0, 1.0]), Vec2::new(0.5, 0.75));
        assert_eq!(transform.apply([1.0, 0.0]), Vec2::new(2.5, -3.25));
        let endless = UvTransform {
            scale: Vec2::splat(3e38),
            ..transform
        };
        assert_eq!(endless.apply([3e38, 1.0]), Vec2::ZERO);
    }
}
