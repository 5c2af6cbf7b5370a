//! Statements that a file has once, view and background, and its lights.

use super::lexer::is_numeric;
use super::reader::{NffLight, NffReader};
use super::records::NffRecord;
use crate::diagnostics::quoted;
use crate::text::command::TextToken;
use crate::text::number::{count, number};
use glam::Vec3;
use phalanx_scene::{View, check_image_size};

/// The parts of a `v` record, in the order in which missing ones are reported.
const PARTS: [&str; 6] = ["from", "at", "up", "angle", "resolution", "hither"];
/// Number of parts required for a picture: `hither` is for scan converters.
const NEEDED: usize = 5;

/// A `v` record as far as it has been read.
#[derive(Default)]
struct ViewRecord {
    there: [bool; PARTS.len()],
    from: Vec3,
    at: Vec3,
    up: Vec3,
    /// Degrees from the centre of the first pixel row to that of the last.
    angle: f64,
    resolution: [u32; 2],
}

impl NffReader<'_> {
    /// Reads the view. The keywords of the block may come in any order; it ends at any other word.
    pub(super) fn view(&mut self, record: &NffRecord<'_>) {
        if self.seen.view {
            let message = "a second `v`: the last one takes the picture";
            self.report.warning(record.span(), message);
        }
        self.seen.view = true;
        let mut parts = ViewRecord::default();
        let mut good = true;
        while let Some(keyword) = self.tokens.peek()
            && let Some(part) = PARTS.iter().position(|&part| part == keyword.text)
        {
            self.tokens.next();
            if std::mem::replace(&mut parts.there[part], true) {
                let message = format!("a second `{}` in this `v`", keyword.text);
                self.report.error(keyword.span(), message);
                good = false;
            }
            good &= self.part(record, &mut parts, part).is_some();
        }
        if let Some(missing) = (0..NEEDED).find(|&k| !parts.there[k])
            && good
        {
            let message = format!("this `v` has no `{}`", PARTS[missing]);
            self.report.error(record.span(), message);
        } else if good {
            self.set_view(record, &parts);
        }
    }

    /// Reads a part's operands; `None` after an error.
    fn part(&mut self, record: &NffRecord<'_>, parts: &mut ViewRecord, part: usize) -> Option<()> {
        match part {
            0 => parts.from = self.position(record)?,
            1 => parts.at = self.position(record)?,
            2 => parts.up = self.vector(record)?,
            3 => parts.angle = self.angle(record)?,
            4 => parts.resolution = self.resolution(record)?,
            _ => drop(self.numbers::<1>(record)?),
        }
        Some(())
    }

    fn angle(&mut self, record: &NffRecord<'_>) -> Option<f64> {
        let Some(token) = self.operand() else {
            self.breaks_off(record, 0, 1);
            return None;
        };
        // Read in double precision: it is not a coordinate, and the vertical angle computed from it
        // is rounded once.
        let checked = number(token.text).and_then(|_| {
            let angle = token.text.parse::<f64>();
            let range = |angle: &f64| *angle > 0.0 && *angle < 180.0;
            angle.ok().filter(range).ok_or_else(|| {
                let angle = quoted(token.text);
                format!("the angle must lie between 0 and 180 degrees, not at {angle}")
            })
        });
        self.emit_error(token, checked)
    }

    fn resolution(&mut self, record: &NffRecord<'_>) -> Option<[u32; 2]> {
        let first = self.tokens.peek();
        let mut sides = [None; 2];
        for (k, side) in sides.iter_mut().enumerate() {
            let Some(token) = self.operand() else {
                self.breaks_off(record, k, 2);
                return None;
            };
            *side = self.emit_error(token, count(token.text));
        }
        let (width, height) = (sides[0]?, sides[1]?);
        let checked = check_image_size(width, height).map_err(|error| error.to_string());
        self.emit_error(first?, checked)?;
        // The check accepts only sides that fit.
        Some([width as u32, height as u32])
    }

    /// A value, or an error at the token it was made from.
    fn emit_error<T>(&mut self, token: TextToken<'_>, value: Result<T, String>) -> Option<T> {
        match value {
            Ok(value) => Some(value),
            Err(message) => {
                self.report.error(token.span(), message);
                None
            }
        }
    }

    fn set_view(&mut self, record: &NffRecord<'_>, parts: &ViewRecord) {
        let [width, height] = parts.resolution;
        (self.scene.width, self.scene.height) = (width, height);
        self.scene.view = View {
            eye: parts.from,
            center: parts.at,
            up: parts.up,
            fovy: whole_angle(parts.angle, height) as f32,
            ortho: None,
        };
        if let Err(error) = self.scene.view.basis() {
            self.report.error(record.span(), error.to_string());
        }
    }

    pub(super) fn background(&mut self, record: &NffRecord<'_>) {
        if self.seen.background {
            let message = "a second `b`: the last one is the background";
            self.report.warning(record.span(), message);
        }
        self.seen.background = true;
        if let Some(rgb) = self.vector(record) {
            self.scene.background = rgb;
        }
    }

    pub(super) fn light(&mut self, record: &NffRecord<'_>) {
        let position = self.position(record);
        let colored = self.tokens.peek().as_ref().is_some_and(is_numeric);
        let color = if colored { self.vector(record).map(Some) } else { Some(None) };
        if let (Some(position), Some(color)) = (position, color) {
            self.lights.push(NffLight { position, color });
        }
    }
}

/// The angle of the whole image's height, in degrees, if `angle` spans the centre of the first of
/// `height` pixel rows to that of the last. A single row has no such angle: it gets `angle` itself.
fn whole_angle(angle: f64, height: u32) -> f64 {
    if height < 2 {
        return angle;
    }
    let rows = f64::from(height);
    let half = libm::tan(angle.to_radians() / 2.0) * rows / (rows - 1.0);
    2.0 * libm::atan(half).to_degrees()
}
