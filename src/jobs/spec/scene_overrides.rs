//! Options that override parts of a scene file, or supply what a mesh lacks. Each is stored as
//! written on the command line, in one form for each value.

use super::as_text::AsText;
#[cfg(feature = "clap")]
use super::as_text::names;
#[cfg(feature = "clap")]
use super::headings;
#[cfg(feature = "clap")]
use super::numbers::parse_number;
use super::option_row::OptionForm::{Attached, Flag, Repeated, Words};
use super::option_row::{OptionRow, command_line, unless_default, words};
use super::scene_values::{PointRadius, SmoothAngle, doubles, joined, number};
use glam::{DVec3, Vec3};
use phalanx_formats::{Origin, ReadOptions};
use phalanx_io::EnvironmentSource;
use phalanx_io::open::Options;
use phalanx_look::{AddedLight, Overrides};
use phalanx_scene::{FileView, Material, OrthoHeight, Scene, UpAxis};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Limit on `--environment-turn` in either direction, in degrees.
#[cfg(feature = "clap")]
const MAX_TURN: f64 = 36_000.0;

/// Options of every command that opens a scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "clap", derive(clap::Args), command(next_help_heading = headings::SCENE))]
pub struct SceneOverrides {
    /// Point light at X,Y,Z, or sun from dir:X,Y,Z
    ///
    /// Replaces the file's lights with a point light at X,Y,Z, or a directional light from
    /// dir:X,Y,Z. Append ,R,G,B for a linear colour [default: white]. Repeatable, as in --light
    /// 4,4,4 --light dir:-1,1,0,.2,.2,.3
    #[cfg_attr(feature = "clap", arg(long, value_name = "LIGHT", value_parser = AsText::<AddedLight>::parse, allow_hyphen_values = true))]
    pub light: Vec<AsText<AddedLight>>,
    /// Lights at the camera instead of the file's
    ///
    /// Replaces the file's lights with the default key light and fill light, which move with the
    /// camera, in sequences too.
    #[cfg_attr(
        feature = "clap",
        arg(long, hide_short_help = true, conflicts_with = "light")
    )]
    pub headlight: bool,
    /// Background colour, linear
    ///
    /// Replaces the file's background with a linear colour R,G,B, or a single number for grey.
    #[cfg_attr(feature = "clap", arg(long, value_name = "R,G,B", value_parser = AsText::<Vec3>::parse))]
    pub background: Option<AsText<Vec3>>,
    /// Environment: HDR, EXR or PFM file, sky, or R,G,B
    ///
    /// Infinitely distant surroundings: an equirectangular picture (Radiance HDR, OpenEXR or PFM),
    /// a sky that is dark below and bright above, or a linear colour R,G,B. They show in mirrors,
    /// through glass and, unless --background is given, behind the scene. The zenith is the
    /// scene's up axis (see --up).
    #[cfg_attr(feature = "clap", arg(long, value_name = "ENV", value_parser = AsText::<EnvironmentSource>::parse))]
    pub environment: Option<AsText<EnvironmentSource>>,
    /// Rotation of the environment about the up axis
    ///
    /// In degrees, counter-clockwise as seen from above.
    #[cfg_attr(feature = "clap", arg(long, value_name = "DEGREES", hide_short_help = true, value_parser = parse_turn, allow_hyphen_values = true))]
    pub environment_turn: Option<f64>,
    /// Default material, as in "kd=.8,.2,.1 ks=.3"
    ///
    /// Material of triangles for which the file names none. Keys: ka, kd, ks, ke and kt (colours),
    /// shininess, ior and gloss, as in --material "kd=.8,.2,.1 ks=.3 shininess=80". Omitted keys
    /// are 0, except ka (a fifth of kd), shininess (1) and ior (1).
    #[cfg_attr(feature = "clap", arg(long, value_name = "MATERIAL", value_parser = AsText::<Material>::parse))]
    pub material: Option<AsText<Material>>,
    /// Smooth surfaces where the file has no normals
    ///
    /// Adds vertex normals to triangles of PLY, STL, OBJ and glTF files that have none. Edges of
    /// more than ANGLE degrees stay sharp, as with --smooth=60. [default: off; ANGLE: 30]
    #[cfg_attr(feature = "clap", arg(long, value_name = "ANGLE", num_args = 0..=1, require_equals = true, default_missing_value = "30", value_parser = AsText::<SmoothAngle>::parse))]
    pub smooth: Option<AsText<SmoothAngle>>,
    /// Radius of points, if the file is a point cloud
    ///
    /// Radius of the spheres drawn for the points of a PLY or OBJ file without faces, in the
    /// file's units. [default: 1.5 times the median distance between nearest neighbours]
    #[cfg_attr(feature = "clap", arg(long, value_name = "R", hide_short_help = true, value_parser = AsText::<PointRadius>::parse))]
    pub point_radius: Option<AsText<PointRadius>>,
    /// Show single-sided glTF materials from behind
    ///
    /// Without this option, camera, mirror and refracted rays pass through the backs of glTF
    /// materials that are neither doubleSided nor transmissive. Shadows are the same either way.
    #[cfg_attr(feature = "clap", arg(long, hide_short_help = true))]
    pub two_sided: bool,
    /// Shadow terminator of triangles with vertex normals: smooth or faceted
    ///
    /// Border between light and shade on triangles with vertex normals: as on the smooth surface
    /// that the normals describe, or along the triangles' edges. Shadows that fall on them begin
    /// on the same surface. [default: smooth for OBJ, PLY and glTF; faceted for all others]
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "SHAPE",
            hide_short_help = true,
            hide_possible_values = true
        )
    )]
    pub terminator: Option<Terminator>,
    /// Origin of the scene's coordinates: auto, none or X,Y,Z
    ///
    /// Point of the file that becomes the origin of the scene's own coordinates: near the geometry
    /// if that is far from zero (auto, the default), the file's own origin (none), or X,Y,Z.
    /// Positions in options and reports are always in the file's coordinates.
    #[cfg_attr(feature = "clap", arg(long, value_name = "ORIGIN", hide_short_help = true, value_parser = AsText::<Origin>::parse, allow_hyphen_values = true))]
    pub origin: Option<AsText<Origin>>,
    /// Additional folder for files that the scene refers to
    ///
    /// Allow material files, textures and buffers in this folder as well as in the scene's own, as
    /// in --allow-path ../textures. Repeatable. Nothing else outside the scene's folder is read.
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR", hide_short_help = true, value_parser = parse_folder))]
    pub allow_path: Vec<PathBuf>,
    /// Camera, as in 0,1,5 0,0,0 0,1,0 45
    ///
    /// Replaces the file's camera: position, target, up vector, and vertical field of view in
    /// degrees, as in --camera 0,1,5 0,0,0 0,1,0 45
    #[cfg_attr(feature = "clap", arg(long, num_args = 4, value_names = ["FROM", "AT", "UP", "FOV"], help_heading = headings::CAMERA, allow_hyphen_values = true))]
    pub camera: Option<Vec<String>>,
    /// Camera of the file, by name or number
    ///
    /// Uses the file's camera of this name or, if there is none, of this number, counted from 0 as
    /// phalanx info lists them. [default: the first]
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME|NUMBER", help_heading = headings::CAMERA, allow_hyphen_values = true, conflicts_with = "camera"))]
    pub camera_name: Option<String>,
    /// Up axis, if the file has no camera
    ///
    /// x, y, z, -x, -y or -z. Applies to the camera that frames the whole model if the file has
    /// none. [default: y; z for STL]
    #[cfg_attr(feature = "clap", arg(long, value_name = "AXIS", help_heading = headings::CAMERA, hide_possible_values = true, value_parser = names::<UpAxis>(UpAxis::ALL.map(|(name, _)| name)), allow_hyphen_values = true))]
    pub up: Option<AsText<UpAxis>>,
    /// Orthographic camera, HEIGHT units high
    ///
    /// Orthographic instead of perspective projection. HEIGHT is the visible height in the file's
    /// units, as in --ortho=3.5. Without it, the target keeps its apparent size; a camera that was
    /// added to a file without one frames the whole model.
    #[cfg_attr(feature = "clap", arg(long, value_name = "HEIGHT", help_heading = headings::CAMERA, num_args = 0..=1, require_equals = true, default_missing_value = "fit", value_parser = AsText::<OrthoHeight>::parse))]
    pub ortho: Option<AsText<OrthoHeight>>,
}

impl SceneOverrides {
    /// Options for opening a scene.
    ///
    /// # Errors
    /// The invalid option, and its valid values.
    pub fn options(&self) -> Result<Options, String> {
        let view = self.camera.as_deref().map(view).transpose();
        let look = Overrides {
            view: view.map_err(|reason| format!("--camera: {reason}"))?,
            camera: self.camera_name.clone(),
            up: self.up.map(|up| up.0),
            ortho: self.ortho.map(|ortho| ortho.0),
            lights: self.light.iter().map(|light| light.0).collect(),
            headlight: self.headlight,
            background: self.background.map(|color| color.0),
            environment_turn: self.environment_turn,
            two_sided: self.two_sided,
            smooth_shadows: self.terminator.map(|shape| shape == Terminator::Smooth),
            ..Overrides::default()
        };
        let read = ReadOptions {
            material: self.material.map(|material| material.0),
            smooth: self.smooth.map(|angle| angle.0.0),
            point_radius: self.point_radius.map(|radius| radius.0.0),
            origin: self.origin.map(|origin| origin.0).unwrap_or_default(),
            allow_paths: self.allow_path.clone(),
            ..ReadOptions::default()
        };
        Ok(Options {
            read,
            look,
            environment: self.environment.as_ref().map(|source| source.0.clone()),
        })
    }

    /// The options in the order of commands, without defaults.
    pub(crate) fn rows(&self) -> Vec<OptionRow> {
        let turn = self.environment_turn.map(|turn| turn.to_string());
        let fitting = self.ortho == Some(AsText(OrthoHeight::Fitting));
        vec![
            OptionRow::new("camera", Words, &self.camera),
            OptionRow::new("camera_name", Attached, &self.camera_name),
            OptionRow::new("ortho", if fitting { Flag } else { Attached }, &self.ortho),
            OptionRow::new("up", Attached, &self.up),
            OptionRow::new("light", Repeated, &self.light),
            OptionRow::new("headlight", Flag, &self.headlight),
            OptionRow::new("background", Words, &self.background),
            OptionRow::new("environment", Attached, &self.environment),
            OptionRow::new("environment_turn", Attached, &turn),
            OptionRow::new("material", Words, &self.material),
            OptionRow::new("smooth", Attached, &self.smooth),
            OptionRow::new("point_radius", Words, &self.point_radius),
            OptionRow::new("two_sided", Flag, &self.two_sided),
            OptionRow::new("terminator", Words, &self.terminator),
            OptionRow::new("origin", Words, &unless_default(self.origin)),
            OptionRow::new("allow_path", Attached, &self.allow_path),
        ]
    }

    /// These overrides without the folders of files, which differ between machines.
    pub(super) fn without_folders(mut self) -> SceneOverrides {
        self.allow_path.clear();
        if let Some(AsText(EnvironmentSource::File(path))) = &mut self.environment
            && let Some(name) = path.file_name()
        {
            *path = name.into();
        }
        self
    }

    /// These overrides with this view written out as the camera of a scene.
    pub fn with_view(&self, scene: &Scene, view: &FileView) -> SceneOverrides {
        SceneOverrides {
            camera_name: None,
            // The environment has an axis, too.
            up: self.up.filter(|_| scene.environment.is_some()),
            ..self.clone()
        }
        .seen_from(view)
    }

    fn seen_from(self, view: &FileView) -> SceneOverrides {
        let [eye, center] = [view.eye, view.center].map(|point| joined(point.to_array()));
        let up = joined(view.up.to_array());
        SceneOverrides {
            camera: Some(vec![eye, center, up, view.fovy.to_string()]),
            ortho: view.ortho.map(|height| AsText(OrthoHeight::Given(height))),
            ..self
        }
    }
}

/// The options of a command that give this view.
pub fn camera_options(view: &FileView) -> String {
    let overrides = SceneOverrides::default().seen_from(view);
    command_line(&words(&overrides.rows()))
}

fn view(parts: &[String]) -> Result<FileView, String> {
    let [from, center, up, fov] = parts else {
        return Err("expected FROM AT UP FOV, as in --camera 0,1,5 0,0,0 0,1,0 45".into());
    };
    let position = |name: &str, text: &str| match doubles(text).as_deref() {
        Ok(&[x, y, z]) => Ok(DVec3::new(x, y, z)),
        _ => Err(format!(
            "expected three numbers for {name}, as in 0,1,5, not `{text}`"
        )),
    };
    let view = FileView {
        eye: position("FROM", from)?,
        center: position("AT", center)?,
        up: position("UP", up)?.as_vec3(),
        fovy: number(fov)?,
        ortho: None,
    };
    view.check().map_err(|error| error.to_string())?;
    Ok(view)
}

/// Border between light and shade on triangles with vertex normals.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Terminator {
    /// Along the triangles' edges.
    #[cfg_attr(feature = "clap", value(help = None::<&str>))]
    Faceted,
    /// As on the smooth surface that the normals describe.
    #[cfg_attr(feature = "clap", value(help = None::<&str>))]
    Smooth,
}

#[cfg(feature = "clap")]
fn parse_turn(text: &str) -> Result<f64, String> {
    let expected = format!("degrees from -{MAX_TURN} to {MAX_TURN}, as in 90");
    parse_number(text, |turn: &f64| turn.abs() <= MAX_TURN, expected)
}

#[cfg(feature = "clap")]
fn parse_folder(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match std::fs::metadata(&path) {
        Ok(folder) if folder.is_dir() => Ok(path),
        Ok(_) => Err("not a folder".to_owned()),
        Err(error) => Err(error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::as_text::OptionValue;
    use super::*;

    #[test]
    fn a_camera_is_three_places_and_an_angle() {
        let parsed = |text: &str| view(&text.split(' ').map(str::to_owned).collect::<Vec<_>>());
        let camera = parsed("0,1,-5 0,0,0 0,1,0 45").unwrap();
        assert_eq!(
            (camera.eye, camera.fovy),
            (DVec3::new(0.0, 1.0, -5.0), 45.0)
        );
        for (bad, part) in [
            ("0,1 0,0,0 0,1,0 45", "FROM"),
            ("0,1,5 0,0,0 0,1,0 --json", "--json"),
            ("0,1,5 0,0,0 0,1,0 180", "field of view"),
            ("0,0,0 0,0,0 0,1,0 45", "stands on"),
            ("0,1,0 0,0,0 0,1,0 45", "parallel"),
        ] {
            assert!(
                parsed(bad).unwrap_err().contains(part),
                "{bad}: {:?}",
                parsed(bad)
            );
        }
    }

    #[test]
    fn places_keep_what_single_precision_would_round() {
        let parts = ["500000.31,8,12", "500000.3,8,12", "0,1,0", "45"];
        let view = view(&parts.map(str::to_owned)).unwrap();
        assert_eq!(view.eye.x, 500_000.31);
        let light = AddedLight::parse("-4012345.1,0,0");
        assert!(
            matches!(light, Ok(AddedLight::Point { position, .. }) if position.x == -4_012_345.1)
        );
    }

    #[test]
    fn files_with_the_names_of_a_sky_and_of_a_colour_stay_files() {
        for name in ["sky", "1,2,3", "-1", "1,2", "a/sky", "a.hdr"] {
            let overrides = SceneOverrides {
                environment: Some(AsText(EnvironmentSource::File(name.into()))),
                ..SceneOverrides::default()
            };
            for overrides in [overrides.clone(), overrides.without_folders()] {
                let AsText(source) = overrides.environment.unwrap();
                let again = EnvironmentSource::parse(&source.text());
                assert!(matches!(again, Ok(EnvironmentSource::File(_))), "{again:?}");
            }
        }
    }
}
