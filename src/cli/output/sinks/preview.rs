//! `--preview`: the unfinished picture in the terminal, two pixels per character.

use crate::cli::output::error::CliError;
use phalanx::image::Picture;
use std::fmt::Write as _;
use std::io::{self, IsTerminal, Write};
use terminal_size::{Height, Width, terminal_size_of};

/// Character for the upper half of a cell; the lower half is the background.
const UPPER_HALF: char = '▀';

/// Draws pictures in the terminal, each replacing the previous one.
#[derive(Default)]
pub struct Preview {
    /// Lines of the last drawing.
    lines: usize,
}

impl Preview {
    /// Fails if stderr is not a terminal.
    pub fn check() -> Result<(), CliError> {
        if io::stderr().is_terminal() {
            return Ok(());
        }
        Err(CliError::Usage(
            "--preview needs a terminal on stderr; use --snapshot FILE.png to write a file at intervals instead".to_owned(),
        ))
    }

    /// Longest side, in pixels, of a picture that fits the terminal at its current size.
    pub fn side() -> u32 {
        let (columns, rows) = size();
        u32::min(columns.into(), 2 * u32::from(rows.saturating_sub(2)))
    }

    /// Draws a picture, reduced to fit, with a status line below. A closed stderr is not an error.
    pub fn draw(&mut self, picture: &Picture, status: &str) {
        let mut text = String::new();
        if self.lines > 0 {
            // Moves up to the first line of the last drawing.
            let _ = write!(text, "\x1b[{}A\r", self.lines);
        }
        let drawn = lines(&thinned(picture, Preview::side()));
        for line in &drawn {
            text.push_str(line);
            text.push_str("\x1b[0m\x1b[K\n");
        }
        let _ = writeln!(text, "{status}\x1b[K");
        self.lines = drawn.len() + 1;
        let _ = io::stderr().lock().write_all(text.as_bytes());
    }
}

/// The picture reduced to at most `side` pixels, by keeping every n-th pixel.
fn thinned(picture: &Picture, side: u32) -> Picture {
    let longest = picture.width.max(picture.height);
    let step = longest.div_ceil(side.max(1)).max(1);
    let (width, height) = (picture.width.div_ceil(step), picture.height.div_ceil(step));
    let mut rgb = Vec::new();
    for y in (0..picture.height).step_by(step as usize) {
        for x in (0..picture.width).step_by(step as usize) {
            let index = 3 * (y as usize * picture.width as usize + x as usize);
            rgb.extend_from_slice(&picture.rgb[index..index + 3]);
        }
    }
    Picture { width, height, rgb }
}

/// Columns and rows of the terminal.
fn size() -> (u16, u16) {
    match terminal_size_of(io::stderr()) {
        Some((Width(columns), Height(rows))) => (columns.max(2), rows.max(4)),
        None => (80, 24),
    }
}

/// Lines of the picture, with two rows of pixels each, in 24-bit colours.
fn lines(picture: &Picture) -> Vec<String> {
    let pitch = 3 * picture.width as usize;
    let rows: Vec<&[u8]> = picture.rgb.chunks(pitch.max(1)).collect();
    let black = vec![0; pitch];
    rows.chunks(2)
        .map(|pair| {
            let (upper, lower) = (pair[0], pair.get(1).copied().unwrap_or(&black));
            let mut line = String::new();
            for (up, down) in upper.chunks_exact(3).zip(lower.chunks_exact(3)) {
                let _ = write!(
                    line,
                    "\x1b[38;2;{};{};{};48;2;{};{};{}m{UPPER_HALF}",
                    up[0], up[1], up[2], down[0], down[1], down[2]
                );
            }
            line
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_large_is_thinned() {
        let picture = Picture {
            width: 5,
            height: 3,
            rgb: (0..45).collect(),
        };
        assert_eq!(thinned(&picture, 5), picture);
        let small = thinned(&picture, 3);
        assert_eq!((small.width, small.height), (3, 2));
        assert_eq!(small.rgb[..6], [0, 1, 2, 6, 7, 8]);
        assert_eq!(small.rgb[9..12], [30, 31, 32]);
    }

    #[test]
    fn a_character_shows_two_pixels() {
        let picture = Picture {
            width: 2,
            height: 3,
            rgb: (0..18).collect(),
        };
        let drawn = lines(&picture);
        assert_eq!(drawn.len(), 2);
        assert_eq!(
            drawn[0],
            "\x1b[38;2;0;1;2;48;2;6;7;8m▀\x1b[38;2;3;4;5;48;2;9;10;11m▀"
        );
        // An odd last row has black below it.
        assert_eq!(
            drawn[1],
            "\x1b[38;2;12;13;14;48;2;0;0;0m▀\x1b[38;2;15;16;17;48;2;0;0;0m▀"
        );
    }
}
