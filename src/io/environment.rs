//! Environments by name.

use glam::Vec3;
use phalanx_formats::{LoadError, read_environment};
use phalanx_look::SKY;
use phalanx_scene::EnvironmentLight;
use std::path::PathBuf;

/// The user's choice of an environment.
#[derive(Clone, Debug, PartialEq)]
pub enum EnvironmentSource {
    /// A sky, dark below and bright above.
    Sky,
    /// The same radiance from everywhere.
    Color(Vec3),
    /// A picture of all directions.
    File(PathBuf),
}

impl EnvironmentSource {
    /// Light of the environment, for which a file may take up to `max_memory` bytes (`None`: any
    /// number), and a remark on it.
    ///
    /// # Errors
    /// Those of [`read_environment`].
    pub fn light(
        &self,
        max_memory: Option<u64>,
    ) -> Result<(EnvironmentLight, Option<String>), LoadError> {
        match self {
            EnvironmentSource::Sky => Ok((SKY, None)),
            &EnvironmentSource::Color(nadir) => {
                let zenith = nadir;
                Ok((EnvironmentLight::Gradient { nadir, zenith }, None))
            }
            EnvironmentSource::File(path) => {
                let (map, remark) = read_environment(path, max_memory)?;
                Ok((EnvironmentLight::Map(map.into()), remark))
            }
        }
    }
}
