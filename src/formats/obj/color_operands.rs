//! Colours in the text: three numbers behind a position, or ZBrush's comments.

use super::chunk::ObjReader;
use crate::diagnostics::{ParseError, Span};
use crate::mesh::faces::VERTEX;
use crate::mesh::vertex_colors::{COLOR_BYTES, note_opacity};

impl ObjReader<'_> {
    /// Reads the numbers after a position: a weight, or a colour and perhaps its opacity.
    pub(super) fn weight_or_color(&mut self) -> Result<(), ParseError> {
        let start = self.cursor.at;
        let mut numbers = [0.0, 0.0, 0.0, 1.0];
        let mut count = 0;
        while !self.cursor.at_statement_end() {
            let number = self.cursor.float()?;
            if let Some(slot) = numbers.get_mut(count) {
                *slot = number;
            }
            count += 1;
        }
        match count {
            1 => {}
            2 => self.note_surplus(start),
            _ => self.add_color(numbers, start),
        }
        Ok(())
    }

    fn add_color(&mut self, [r, g, b, alpha]: [f32; 4], start: usize) {
        if !self.share.take(COLOR_BYTES) {
            return;
        }
        let vertex = self.chunk.counts()[VERTEX] - 1;
        let (rgb, span) = ([r, g, b], Span::between(start, self.cursor.at));
        note_opacity(alpha, span, &mut self.chunk.remarks);
        if !rgb.iter().all(|channel| channel.is_finite()) {
            self.chunk.remarks.warn(
                span,
                "this colour is not finite: white is used instead",
                "colours are not finite, this one first: white is used instead",
            );
        }
        self.chunk.colors.add(vertex, rgb);
    }

    /// Reads ZBrush's `#MRGB` and the colours after it, each of which is a mask, red, green and
    /// blue in hexadecimal digits.
    #[cold]
    pub(super) fn painted_colors(&mut self) {
        let rest = &self.cursor.text[self.cursor.at + b"#MRGB".len()..];
        let digits = rest.trim_ascii_start();
        let digit = |offset: usize| {
            let digit = digits.get(offset).map(|&digit| char::from(digit));
            digit.and_then(|digit| digit.to_digit(16))
        };
        let byte = |offset: usize| Some((digit(offset)? << 4 | digit(offset + 1)?) as u8);
        let color = |offset: usize| Some([byte(offset + 2)?, byte(offset + 4)?, byte(offset + 6)?]);
        let colors = (0..).step_by(8).map_while(color);
        for color in colors {
            if self.share.take(COLOR_BYTES) {
                self.chunk.colors.painted.push(color);
            }
        }
    }
}
