//! Numbers as colours, with a legend of the scale.

use super::encoder::Picture;
use font8x8::legacy::BASIC_LEGACY;

/// Share of the pixels that the scale covers; larger values have the last colour. A few extreme
/// pixels would otherwise make all others dark.
const COVERED: f64 = 0.995;

/// Side of a letter.
const LETTER: u32 = 8;

/// Height of the legend below the picture: bar, ticks, text.
const LEGEND: u32 = 40;

/// A picture of `values` (row by row from the top left, `width` per row) from dark violet through
/// orange to light yellow (matplotlib's inferno, whose lightness rises evenly), and below it a
/// legend with `title`.
pub fn false_color(values: &[f32], width: u32, title: &str) -> Picture {
    let rows = (values.len() as u32).checked_div(width).unwrap_or(0);
    let (mut rgb, top) = false_colors(values);
    rgb.resize(rgb.len() + (width * LEGEND * 3) as usize, 16);
    let mut picture = Picture {
        width,
        height: rows + LEGEND,
        rgb,
    };
    legend(&mut picture, rows, top, title);
    picture
}

/// Red, green and blue of each value in the colours of [`false_color`], and the value of the last
/// colour.
pub fn false_colors(values: &[f32]) -> (Vec<u8>, f32) {
    let top = scale(values);
    (values.iter().flat_map(|&v| color(v / top)).collect(), top)
}

/// The value of the last colour: a round number that covers nearly all pixels.
fn scale(values: &[f32]) -> f32 {
    let mut sorted: Vec<f32> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f32::total_cmp);
    let rank = (sorted.len() as f64 * COVERED) as usize;
    let covered = sorted.get(rank.min(sorted.len().saturating_sub(1)));
    round_up(covered.copied().unwrap_or(0.0))
}

/// 1, 2 or 5 times a power of ten, at least 1.
fn round_up(value: f32) -> f32 {
    let mut decade = 1.0;
    loop {
        for step in [1.0, 2.0, 5.0] {
            if value <= step * decade || decade >= 1e30 {
                return step * decade;
            }
        }
        decade *= 10.0;
    }
}

fn color(share: f32) -> [u8; 3] {
    let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 1.0 };
    let color = colorous::INFERNO.eval_continuous(share as f64);
    [color.r, color.g, color.b]
}

/// The colours with the values of their ends and quarters, and the title.
fn legend(picture: &mut Picture, top: u32, most: f32, title: &str) {
    let margin = (2 * LETTER).min(picture.width / 8);
    let length = picture.width.saturating_sub(2 * margin).max(1);
    for x in 0..length {
        let rgb = color(x as f32 / length as f32);
        (6..14).for_each(|y| set(picture, margin + x, top + y, rgb));
    }
    let quarters = if length >= 300 { 4 } else { 2 };
    for quarter in 0..=quarters {
        let x = margin + length * quarter / quarters;
        let value = most * quarter as f32 / quarters as f32;
        let more = if quarter == quarters { ">=" } else { "" };
        let label = format!("{more}{}", (value * 100.0).round() / 100.0);
        let half = label.len() as u32 * LETTER / 2;
        let room = picture.width.saturating_sub(2 * half);
        text(picture, x.saturating_sub(half).min(room), top + 17, &label);
    }
    let half = title.len() as u32 * LETTER / 2;
    let middle = (picture.width / 2).saturating_sub(half);
    text(picture, middle, top + 29, title);
}

fn text(picture: &mut Picture, x: u32, y: u32, text: &str) {
    for (k, letter) in text.bytes().enumerate() {
        let Some(rows) = BASIC_LEGACY.get(letter as usize) else {
            continue;
        };
        for (dy, row) in rows.iter().enumerate() {
            for dx in (0..LETTER).filter(|dx| row >> dx & 1 == 1) {
                set(picture, x + k as u32 * LETTER + dx, y + dy as u32, [230; 3]);
            }
        }
    }
}

fn set(picture: &mut Picture, x: u32, y: u32, rgb: [u8; 3]) {
    if x < picture.width && y < picture.height {
        let index = (y as usize * picture.width as usize + x as usize) * 3;
        picture.rgb[index..index + 3].copy_from_slice(&rgb);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_end_in_round_numbers_that_cover_nearly_all() {
        for (value, top) in [
            (0.0, 1.0),
            (1.0, 1.0),
            (1.1, 2.0),
            (3.0, 5.0),
            (51.0, 100.0),
            (150.0, 200.0),
        ] {
            assert_eq!(round_up(value), top);
        }
        let mut values = vec![10.0; 1000];
        values[7] = 1e9;
        assert_eq!(scale(&values), 10.0);
        assert_eq!(scale(&[f32::NAN]), 1.0);
        assert_eq!(scale(&[]), 1.0);
    }

    #[test]
    fn more_is_lighter_and_the_legend_stands_below() {
        let picture = false_color(&[0.0, 5.0, 10.0, 4.0], 2, "nodes");
        assert_eq!((picture.width, picture.height), (2, 2 + LEGEND));
        assert_eq!(picture.rgb.len(), (2 * (2 + LEGEND) * 3) as usize);
        let light = |k: usize| {
            picture.rgb[3 * k..3 * k + 3]
                .iter()
                .map(|&c| u32::from(c))
                .sum::<u32>()
        };
        assert!(light(0) < light(3) && light(3) < light(1) && light(1) < light(2));
        let wide = false_color(&vec![1.0; 400 * 4], 400, "nodes visited");
        let row = |y: u32| &wide.rgb[(y * 400 * 3) as usize..((y + 1) * 400 * 3) as usize];
        // Letters in the legend's last line.
        assert!((4 + 29..4 + 37).any(|y| row(y).contains(&230)));
    }
}
