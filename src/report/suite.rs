//! The standard suite: the scenes to measure if none is given, and the expected hits of their rays.

use super::record::RaySetRecord;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A suite, as stored in `perf/suite.toml`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Suite {
    /// Picture size that the rays belong to.
    pub size: [u32; 2],
    /// Number of samples of each row.
    pub repeat: usize,
    /// Number of samples of each row with `--quick`.
    pub quick_repeat: usize,
    /// Minimum total time of the samples of a row, in seconds.
    pub min_time: f64,
    /// The scenes, in the order in which they are measured.
    pub scene: Vec<SuiteScene>,
}

/// A scene of a suite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SuiteScene {
    /// Name of the scene to open, such as `standard:terrain:20k`.
    pub name: String,
    /// Family of the scene. Scenes of one family differ in size only.
    pub family: String,
    /// Step of the scene: `small`, `medium` or `large`.
    pub step: String,
    /// True if `--quick` measures the scene, too.
    #[serde(default)]
    pub quick: bool,
    /// The right results at the suite's size, by kind of rays.
    #[serde(default)]
    pub expected: BTreeMap<String, RaySetRecord>,
}

/// The reason why a suite cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct SuiteError(String);

impl Suite {
    /// Reads a suite.
    ///
    /// # Errors
    /// [`SuiteError`] gives the position of the mistake.
    pub fn parse(text: &str) -> Result<Suite, SuiteError> {
        toml::from_str(text).map_err(|error| SuiteError(error.to_string()))
    }

    /// The suite as text.
    ///
    /// # Errors
    /// None that can be provoked: every part of a suite can be written as TOML.
    pub fn to_text(&self) -> Result<String, SuiteError> {
        toml::to_string(self).map_err(|error| SuiteError(error.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_suite_of_this_repository_expects_answers_of_every_scene() {
        let suite = Suite::parse(include_str!("../../perf/suite.toml")).expect("perf/suite.toml");
        assert!(suite.scene.iter().any(|scene| scene.quick));
        assert!(suite.quick_repeat <= suite.repeat);
        for scene in &suite.scene {
            assert!(
                crate::RayKind::ALL
                    .iter()
                    .any(|kind| scene.expected.contains_key(kind.name())),
                "{}",
                scene.name
            );
        }
        let text = suite.to_text().expect("as text");
        assert_eq!(Suite::parse(&text), Ok(suite));
    }

    #[test]
    fn what_is_no_suite_is_refused_with_its_line() {
        let error = Suite::parse("size = [512, 512]\nrepeat = \"seven\"\n").unwrap_err();
        assert!(error.to_string().contains("line 2"), "{error}");
        assert!(
            Suite::parse(
                "size = [512, 512]\nrepeat = 7\nquick_repeat = 5\nmin_time = 0.1\nscenes = []\nscene = []\n"
            )
            .is_err()
        );
    }
}
