//! The standard suite: which scenes are measured where none is named, and what their rays must hit.

use super::plan::SceneInfo;
use crate::report::RaySetRecord;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A suite, as `perf/suite.toml` has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Suite {
    /// Picture size that the rays are of.
    pub size: [u32; 2],
    /// Samples of each row.
    pub repeat: usize,
    /// Seconds that the samples of a row take together at least.
    pub min_time: f64,
    /// The scenes, in the order in which they are measured.
    pub scene: Vec<SuiteScene>,
}

/// A scene of a suite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SuiteScene {
    /// What to open, such as `standard:terrain:20k`.
    pub name: String,
    /// Scenes of one family differ in size only.
    pub family: String,
    /// `small`, `medium` or `large`.
    pub step: String,
    /// Whether `--quick` measures it, too.
    #[serde(default)]
    pub quick: bool,
    /// The right answers at the suite's size, by kind of rays.
    #[serde(default)]
    pub expected: BTreeMap<String, RaySetRecord>,
}

/// Why a suite cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct SuiteError(String);

impl Suite {
    /// Reads a suite.
    ///
    /// # Errors
    /// [`SuiteError`] says where the text is no suite.
    pub fn parse(text: &str) -> Result<Suite, SuiteError> {
        toml::from_str(text).map_err(|error| SuiteError(error.to_string()))
    }

    /// The suite as text.
    ///
    /// # Errors
    /// None that can be provoked: every part of a suite has a form in TOML.
    pub fn to_text(&self) -> Result<String, SuiteError> {
        toml::to_string(self).map_err(|error| SuiteError(error.to_string()))
    }
}

impl SuiteScene {
    /// As a run takes it; answers are expected only at the suite's own size.
    pub fn heading(&self, answers: bool) -> SceneInfo {
        SceneInfo {
            name: self.name.clone(),
            family: Some(self.family.clone()),
            step: Some(self.step.clone()),
            load_seconds: 0.0,
            expected: match answers {
                true => self.expected.clone(),
                false => BTreeMap::new(),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_suite_of_this_repository_expects_answers_of_every_scene() {
        let suite = Suite::parse(include_str!("../../perf/suite.toml")).expect("perf/suite.toml");
        assert!(suite.scene.iter().any(|scene| scene.quick));
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
                "size = [512, 512]\nrepeat = 7\nmin_time = 0.1\nscenes = []\nscene = []\n"
            )
            .is_err()
        );
    }
}
