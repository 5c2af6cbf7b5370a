//! The records by name, and the reading of operands.

use super::lexer::is_numeric;
use super::reader::NffReader;
use crate::diagnostics::{Span, quoted};
use crate::text::command::{CommandRow, TextToken, command};
use crate::text::number::{coordinate, number};
use glam::{DVec3, Vec3};

/// A kind of record.
type RecordKind = CommandRow<fn(&mut NffReader<'_>, &NffRecord<'_>)>;

const RECORDS: [RecordKind; 9] = [
    command("s", "x y z radius", |r, s| r.sphere(s)),
    command("p", "corners, then x y z of each", |r, s| r.polygon(s)),
    command("pp", "corners, then x y z nx ny nz of each", |r, s| {
        r.patch(s)
    }),
    command("c", "base(x y z radius) apex(x y z radius)", |r, s| {
        r.cone(s)
    }),
    command("f", "r g b kd ks shine t ior", |r, s| r.fill(s)),
    command("l", "x y z [r g b]", |r, s| r.light(s)),
    command("b", "r g b", |r, s| r.background(s)),
    command("v", "from at up angle hither resolution", |r, s| r.view(s)),
    // Not part of Haines' format, but of some readers and the files made for them.
    command("tess", "level", |r, s| r.tess(s)),
];

/// A record's kind and the span of its name.
pub(super) struct NffRecord<'a> {
    kind: &'static RecordKind,
    name: TextToken<'a>,
}

impl NffRecord<'_> {
    /// Span of the name.
    pub(super) fn span(&self) -> Span {
        self.name.span()
    }
}

fn find(name: &str) -> Option<&'static RecordKind> {
    // Most tokens are numbers.
    if !name.starts_with(|c: char| c.is_ascii_lowercase()) {
        return None;
    }
    RECORDS.iter().find(|kind| kind.name == name)
}

impl<'a> NffReader<'a> {
    /// Runs the next record; false at the end of the file.
    pub(super) fn record(&mut self) -> bool {
        let Some(name) = self.tokens.next() else {
            return false;
        };
        match find(name.text) {
            Some(kind) => {
                let record = NffRecord { kind, name };
                (kind.run)(self, &record);
                self.refuse_surplus(&record);
            }
            None => {
                self.report.error_with_help(
                    name.span(),
                    format!("unknown record {}", quoted(name.text)),
                    "NFF knows `v`, `b`, `l`, `f`, `s`, `c`, `p` and `pp`",
                );
                self.skip_to_record();
            }
        }
        true
    }

    /// Refuses a number after a record's last operand, as it belongs to nothing.
    fn refuse_surplus(&mut self, record: &NffRecord<'_>) {
        let Some(surplus) = self.tokens.peek().filter(is_numeric) else {
            return;
        };
        let RecordKind { name, operands, .. } = record.kind;
        self.report.error(
            surplus.span(),
            format!(
                "surplus operand {}: `{name}` takes `{operands}`",
                quoted(surplus.text)
            ),
        );
        self.skip_to_record();
    }

    /// Passes over everything up to the next record.
    pub(super) fn skip_to_record(&mut self) {
        while self.operand().is_some() {}
    }

    /// Returns true if the next token is no operand: the file ends here, or another record begins.
    pub(super) fn at_record(&self) -> bool {
        let next = self.tokens.peek();
        next.is_none_or(|token| find(token.text).is_some())
    }

    /// The next operand, or none at the end of the file or where another record begins.
    pub(super) fn operand(&mut self) -> Option<TextToken<'a>> {
        let mut ahead = self.tokens.clone();
        let token = ahead.next().filter(|token| find(token.text).is_none())?;
        self.tokens = ahead;
        Some(token)
    }

    /// The next `N` operands as finite numbers, or an error for each fault.
    pub(super) fn numbers<const N: usize>(&mut self, record: &NffRecord<'_>) -> Option<[f32; N]> {
        self.operands(record, number)
    }

    fn operands<T: Copy + Default, const N: usize>(
        &mut self,
        record: &NffRecord<'_>,
        parse: fn(&str) -> Result<T, String>,
    ) -> Option<[T; N]> {
        let mut values = [T::default(); N];
        let mut good = true;
        for (k, value) in values.iter_mut().enumerate() {
            let Some(token) = self.operand() else {
                self.breaks_off(record, k, N);
                return None;
            };
            match parse(token.text) {
                Ok(number) => *value = number,
                Err(message) => {
                    self.report.error(token.span(), message);
                    good = false;
                }
            }
        }
        good.then_some(values)
    }

    /// The next `N` operands, which begin with a position. As [`NffReader::numbers`], but in double
    /// precision if the scene is moved.
    pub(super) fn coordinates<const N: usize>(
        &mut self,
        record: &NffRecord<'_>,
    ) -> Option<[f64; N]> {
        self.operands(record, coordinate(self.origin))
    }

    /// The next three operands as a position in the scene.
    pub(super) fn position(&mut self, record: &NffRecord<'_>) -> Option<Vec3> {
        let [x, y, z] = self.coordinates(record)?;
        Some(self.to_scene([x, y, z]))
    }

    /// Position in the scene of a position in the file.
    pub(super) fn to_scene(&self, position: [f64; 3]) -> Vec3 {
        (DVec3::from_array(position) - self.origin).as_vec3()
    }

    /// The next three operands as a vector.
    pub(super) fn vector(&mut self, record: &NffRecord<'_>) -> Option<Vec3> {
        self.numbers(record).map(Vec3::from_array)
    }

    /// Adds an error: a record, or a part of one, has fewer operands than it needs.
    pub(super) fn breaks_off(&mut self, record: &NffRecord<'_>, count: usize, needed: usize) {
        let RecordKind { name, operands, .. } = record.kind;
        self.report.error(
            record.span(),
            format!("`{name}` (`{operands}`) breaks off: {count} of {needed} numbers are there"),
        );
    }

    /// Passes over a record that only some readers know and that has no effect here.
    fn tess(&mut self, record: &NffRecord<'_>) {
        if self.numbers::<1>(record).is_some() {
            self.report
                .warning(record.span(), "`tess` is not of NFF: it is passed over");
        }
    }
}
