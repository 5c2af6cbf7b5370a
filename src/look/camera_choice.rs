//! The choice among the cameras of a file.

use super::overrides::Overrides;
use phalanx_files::quoted;
use phalanx_scene::{Scene, SceneError};

/// Most cameras that a message lists.
const MAX_LISTED: usize = 12;

/// Takes the view of the camera that the overrides name: the first of that name, or else the one of
/// that number, from 0.
///
/// # Errors
/// [`SceneError::NoCamera`].
pub(super) fn choose(scene: &mut Scene, overrides: &Overrides) -> Result<(), SceneError> {
    let Some(label) = &overrides.camera else {
        return Ok(());
    };
    let named = |name: u32| scene.names.get(name) == Some(label.trim());
    let by_name = scene.cameras.iter().find(|camera| named(camera.name));
    let number: Option<usize> = label.trim().parse().ok();
    let by_number = number.and_then(|number| scene.cameras.get(number));
    let chosen = by_name.or(by_number).copied().ok_or_else(|| {
        let cameras = if scene.cameras.is_empty() {
            "the scene has no cameras to choose from".to_owned()
        } else {
            format!("the cameras are {}", listed(scene, |_| true))
        };
        SceneError::NoCamera {
            asked: quoted(label),
            known: cameras,
        }
    })?;
    scene.use_camera(chosen);
    Ok(())
}

/// A note on the camera that is used, if there are several and the overrides name none.
pub(super) fn note(scene: &Scene, overrides: &Overrides) -> Option<String> {
    let used = scene.used_camera()?;
    if overrides.camera.is_some() || overrides.view.is_some() || scene.cameras.len() < 2 {
        return None;
    }
    let (count, others) = (scene.cameras.len(), listed(scene, |row| row != used));
    let used = listed(scene, |row| row == used);
    Some(format!(
        "the file has {count} cameras: {used} is used, not {others} (see --camera-name)"
    ))
}

/// The cameras of some rows, by their names and numbers.
fn listed(scene: &Scene, is_meant: impl Fn(usize) -> bool) -> String {
    let cameras = scene.cameras.iter().enumerate();
    let labels = cameras
        .filter(|(row, _)| is_meant(*row))
        .map(|(row, camera)| match scene.names.get(camera.name) {
            Some(name) => format!("{} ({row})", quoted(name)),
            None => row.to_string(),
        });
    let labels: Vec<String> = labels.collect();
    let (shown, more) = labels.split_at(labels.len().min(MAX_LISTED));
    match more.len() {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}
