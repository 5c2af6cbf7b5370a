//! Commands that change what later primitives and lights capture.

use super::commands::Statement;
use super::reader::TestReader;
use super::transform::{MOST_SAVED, rotation, rounded};
use glam::{DAffine3, DVec3, Vec3};
use phalanx_scene::Material;

impl TestReader<'_> {
    pub(super) fn translate(&mut self, statement: &Statement<'_>) {
        if let Some(offset) = self.coordinates(statement) {
            let offset = DVec3::from_array(offset);
            self.transform(statement, DAffine3::from_translation(offset));
        }
    }

    pub(super) fn rotate(&mut self, statement: &Statement<'_>) {
        let Some([x, y, z, degrees]) = self.coordinates(statement) else {
            return;
        };
        match rotation(DVec3::new(x, y, z), degrees) {
            Some(turn) => self.transform(statement, turn),
            None => self.refuse(statement, 0, "the axis of a rotation must not be zero"),
        }
    }

    pub(super) fn scale(&mut self, statement: &Statement<'_>) {
        let Some(factors) = self.coordinates::<3>(statement) else {
            return;
        };
        match factors.iter().position(|&factor| factor as f32 == 0.0) {
            Some(zero) => self.report.error_with_help(
                statement.operand_place(zero),
                "a scale of zero flattens everything it applies to",
                "use 1 to leave an axis as it is",
            ),
            None => {
                let factors = DVec3::from_array(factors);
                self.transform(statement, DAffine3::from_scale(factors));
            }
        }
    }

    fn transform(&mut self, statement: &Statement<'_>, step: DAffine3) {
        if !self.transforms.apply(step) {
            self.report.error(
                statement.span(),
                "the transform grows beyond what numbers can hold",
            );
        }
    }

    pub(super) fn push_transform(&mut self, statement: &Statement<'_>) {
        self.nothing(statement);
        if !self.transforms.push(statement.span()) {
            self.report.error_with_help(
                statement.span(),
                format!("more than {MOST_SAVED} `pushTransform` without their `popTransform`"),
                "close each `pushTransform` with a `popTransform`",
            );
        }
    }

    pub(super) fn pop_transform(&mut self, statement: &Statement<'_>) {
        self.nothing(statement);
        if !self.transforms.pop() {
            self.report.error(
                statement.span(),
                "`popTransform` without a `pushTransform` to return to",
            );
        }
    }

    /// Sets a colour of the surfaces that follow.
    pub(super) fn color(
        &mut self,
        statement: &Statement<'_>,
        column: fn(&mut Material) -> &mut Vec3,
    ) {
        if let Some(rgb) = self.numbers(statement) {
            *column(&mut self.surface) = Vec3::from_array(rgb);
        }
    }

    pub(super) fn shininess(&mut self, statement: &Statement<'_>) {
        match self.numbers(statement) {
            Some([exponent]) if exponent >= 0.0 => self.surface.shininess = exponent,
            Some(_) => self.refuse(statement, 0, "the shininess must not be negative"),
            None => {}
        }
    }

    pub(super) fn gloss(&mut self, statement: &Statement<'_>) {
        match self.numbers(statement) {
            Some([exponent]) if exponent >= 0.0 => self.surface.gloss = exponent,
            Some(_) => self.report.error_with_help(
                statement.operand_place(0),
                "the gloss must not be negative",
                "the larger it is, the sharper the mirror; 0 is a perfect one",
            ),
            None => {}
        }
    }

    pub(super) fn ior(&mut self, statement: &Statement<'_>) {
        match self.numbers(statement) {
            Some([index]) if index > 0.0 => self.surface.ior = index,
            Some(_) => self.refuse(statement, 0, "the index of refraction must be positive"),
            None => {}
        }
    }

    /// A transformed position in f32, or an error.
    pub(super) fn in_range(&mut self, statement: &Statement<'_>, position: DVec3) -> Option<Vec3> {
        let position = rounded(position);
        if position.is_none() {
            self.out_of_range(statement);
        }
        position
    }

    pub(super) fn out_of_range(&mut self, statement: &Statement<'_>) {
        self.report.error_with_help(
            statement.span(),
            "the current transform takes this beyond the range of single precision",
            "it reaches from about 1e-45 to 3e38",
        );
    }
}
