//! The table of commands, and the checks of a statement's operands.

use super::lexer::TestTokens;
use super::reader::TestReader;
use crate::diagnostics::{Span, quoted};
use crate::text::command::{CommandRow, TextToken, command};
use crate::text::number::{coordinate, count, number};

/// A command, with a word for each operand.
type SceneCommand = CommandRow<fn(&mut TestReader<'_>, &Statement<'_>)>;

/// All commands. The first are those that large files consist of.
static COMMANDS: [SceneCommand; 30] = [
    command("tri", "a b c", |r, s| r.tri(s)),
    command("vertex", "x y z", |r, s| r.vertex(s)),
    command("trinormal", "a b c", |r, s| r.trinormal(s)),
    command("vertexnormal", "x y z nx ny nz", |r, s| r.vertexnormal(s)),
    command("sphere", "x y z radius", |r, s| r.sphere(s)),
    command("translate", "x y z", |r, s| r.translate(s)),
    command("rotate", "x y z degrees", |r, s| r.rotate(s)),
    command("scale", "x y z", |r, s| r.scale(s)),
    command("pushTransform", "", |r, s| r.push_transform(s)),
    command("popTransform", "", |r, s| r.pop_transform(s)),
    command("ambient", "r g b", |r, s| r.color(s, |m| &mut m.ka)),
    command("diffuse", "r g b", |r, s| r.color(s, |m| &mut m.kd)),
    command("specular", "r g b", |r, s| r.color(s, |m| &mut m.ks)),
    command("emission", "r g b", |r, s| r.color(s, |m| &mut m.ke)),
    command("transmission", "r g b", |r, s| r.color(s, |m| &mut m.kt)),
    command("shininess", "exponent", |r, s| r.shininess(s)),
    command("ior", "index", |r, s| r.ior(s)),
    command("gloss", "exponent", |r, s| r.gloss(s)),
    command("directional", "x y z r g b", |r, s| r.directional(s)),
    command("point", "x y z r g b", |r, s| r.point(s)),
    command("spherelight", "x y z radius r g b", |r, s| r.spherelight(s)),
    command(
        "rectlight",
        "cornerx cornery cornerz edgex edgey edgez edgex edgey edgez r g b",
        |r, s| r.rectlight(s),
    ),
    command("attenuation", "constant linear quadratic", |r, s| {
        r.attenuation(s)
    }),
    command("size", "width height", |r, s| r.size(s)),
    command(
        "camera",
        "fromx fromy fromz atx aty atz upx upy upz fovy",
        |r, s| r.camera(s),
    ),
    command("ortho", "height", |r, s| r.ortho(s)),
    command("maxdepth", "bounces", |r, s| r.maxdepth(s)),
    command("output", "file", |r, s| r.output(s)),
    command("maxverts", "count", |r, s| r.maxverts(s)),
    command("maxvertnorms", "count", |r, s| r.maxvertnorms(s)),
];

/// One line: a command of the table with its operands.
pub(super) struct Statement<'a> {
    command: &'static SceneCommand,
    name: TextToken<'a>,
    operands: TestTokens<'a>,
}

impl<'a> Statement<'a> {
    /// The span of the command.
    pub(super) fn span(&self) -> Span {
        self.name.span()
    }

    /// The span of operand `k` from 0, or of the command if there is none.
    pub(super) fn operand_place(&self, k: usize) -> Span {
        let operand = self.operands.clone().nth(k);
        operand.unwrap_or(self.name).span()
    }

    /// All operands as one, with the spaces between them.
    pub(super) fn joined(&self) -> Option<TextToken<'a>> {
        self.operands.joined()
    }

    /// The operands, if there are exactly `N` and each can be parsed.
    fn parsed<T: Copy + Default, const N: usize>(
        &self,
        parse: fn(&str) -> Result<T, String>,
    ) -> Option<[T; N]> {
        let mut operands = self.operands.clone();
        let mut values = [T::default(); N];
        for value in &mut values {
            *value = parse(operands.next()?.text).ok()?;
        }
        operands.next().is_none().then_some(values)
    }
}

impl TestReader<'_> {
    /// Runs one line.
    pub(super) fn run(&mut self, name: TextToken<'_>, operands: TestTokens<'_>) {
        match COMMANDS.iter().find(|command| command.name == name.text) {
            Some(command) => {
                let statement = Statement {
                    command,
                    name,
                    operands,
                };
                (command.run)(self, &statement);
            }
            None => self.report.error_with_help(
                name.span(),
                format!("unknown command {}", quoted(name.text)),
                format!("the closest known command is `{}`", closest(name.text)),
            ),
        }
        self.seen.any = true;
    }

    /// The operands as finite numbers, or an error for each fault.
    pub(super) fn numbers<const N: usize>(
        &mut self,
        statement: &Statement<'_>,
    ) -> Option<[f32; N]> {
        self.operands(statement, number)
    }

    /// The operands as finite numbers of positions and transforms, or an error for each fault. They
    /// are in double precision if the scene is moved, and else rounded to single precision.
    pub(super) fn coordinates<const N: usize>(
        &mut self,
        statement: &Statement<'_>,
    ) -> Option<[f64; N]> {
        self.operands(statement, coordinate(self.origin))
    }

    /// The operands as counts or indices, or an error for each fault.
    pub(super) fn counts<const N: usize>(&mut self, statement: &Statement<'_>) -> Option<[u64; N]> {
        self.operands(statement, count)
    }

    /// Adds an error at an operand, from 0.
    pub(super) fn refuse(
        &mut self,
        statement: &Statement<'_>,
        operand: usize,
        message: impl Into<String>,
    ) {
        self.report.error(statement.operand_place(operand), message);
    }

    /// Returns true if there are no operands, and adds an error otherwise.
    pub(super) fn nothing(&mut self, statement: &Statement<'_>) -> bool {
        self.numbers::<0>(statement).is_some()
    }

    fn operands<T: Copy + Default, const N: usize>(
        &mut self,
        statement: &Statement<'_>,
        parse: fn(&str) -> Result<T, String>,
    ) -> Option<[T; N]> {
        let values = statement.parsed(parse);
        if values.is_none() {
            self.explain_operands(statement, N, parse);
        }
        values
    }

    /// Adds the errors of [`Statement::parsed`]. It is a separate function because most lines are
    /// correct.
    fn explain_operands<T>(
        &mut self,
        statement: &Statement<'_>,
        expected: usize,
        parse: fn(&str) -> Result<T, String>,
    ) {
        let command = statement.command;
        let count = statement.operands.clone().take(expected + 1).count();
        if count < expected {
            return self.missing_operands(statement, count, expected);
        }
        for operand in statement.operands.clone().take(expected) {
            if let Err(message) = parse(operand.text) {
                self.report.error(operand.span(), message);
            }
        }
        if let Some(surplus) = statement.operands.clone().nth(expected) {
            let takes = match expected {
                0 => String::from("no operands"),
                _ => format!("`{}`", command.operands),
            };
            self.report.error(
                surplus.span(),
                format!(
                    "surplus operand {}: `{}` takes {takes}",
                    quoted(surplus.text),
                    command.name
                ),
            );
        }
    }

    /// Adds an error: a statement has too few operands.
    pub(super) fn missing_operands(
        &mut self,
        statement: &Statement<'_>,
        count: usize,
        expected: usize,
    ) {
        let SceneCommand { name, operands, .. } = statement.command;
        let plural = if expected == 1 { "" } else { "s" };
        self.report.error(
            statement.span(),
            format!("`{name}` needs {expected} operand{plural} (`{operands}`), but has {count}"),
        );
    }
}

/// The command with the smallest edit distance to a name, upper or lower case alike.
fn closest(name: &str) -> &'static str {
    // No command has 32 characters; the rest of a line without spaces could be megabytes.
    let name: String = name.chars().take(32).flat_map(char::to_lowercase).collect();
    let distance =
        |command: &&SceneCommand| strsim::osa_distance(&command.name.to_lowercase(), &name);
    let closest = COMMANDS.iter().min_by_key(distance);
    closest.map_or("size", |command| command.name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Checks the table: `explain_operands` takes the number of operands from the code, but their
    /// names from the table.
    #[test]
    fn every_command_names_as_many_operands_as_it_takes() {
        for command in &COMMANDS {
            let text = command.name;
            let (name, operands) = super::super::lexer::statements(text).next().unwrap();
            let mut reader = TestReader::new(text, DVec3::ZERO);
            reader.run(name, operands);
            let expected = command.operands.split_whitespace().count();
            let errors = reader.report.finish().err().unwrap_or_default();
            match expected {
                0 => assert!(
                    errors.iter().all(|e| !e.message.contains("operand")),
                    "{text}"
                ),
                _ => assert!(
                    errors[0].message.contains(&format!("needs {expected} ")),
                    "{text}: {}",
                    errors[0].message
                ),
            }
        }
    }
}
