//! Options that override parts of a scene file, or supply what a mesh lacks. Each is stored as
//! written on the command line, in one form for each value.

#[cfg(feature = "clap")]
use super::as_text::names;
use super::as_text::{AsText, OptionValue};
#[cfg(feature = "clap")]
use super::headings;
use super::option_row::OptionForm::{Attached, Flag, Repeated, Words};
use super::option_row::{OptionRow, command_line, unless_default, words};
use glam::{DVec3, Vec3};
use phalanx_formats::{Origin, ReadOptions};
use phalanx_io::EnvironmentSource;
use phalanx_io::open::Options;
use phalanx_look::{AddedLight, Overrides};
use phalanx_scene::{FileView, Material, OrthoHeight, Scene, UpAxis};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Most degrees of `--environment-turn`, either way.
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
    /// Lights at the camera, instead of the file's
    ///
    /// Replaces the file's lights with the key light and the fill light of files that have none.
    /// They move with the camera, also in sequences.
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
    /// Surroundings from infinitely far away: a picture of all directions in equirectangular
    /// projection (Radiance HDR, OpenEXR or PFM), a sky that is dark below and bright above, or a
    /// linear colour R,G,B. Seen behind the scene, unless --background is given, in mirrors and
    /// through glass. Its zenith is the scene's up axis (see --up).
    #[cfg_attr(feature = "clap", arg(long, value_name = "ENV", value_parser = AsText::<EnvironmentSource>::parse))]
    pub environment: Option<AsText<EnvironmentSource>>,
    /// Turn of the environment about the up axis
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
    /// Gives vertex normals to triangles of PLY, STL, OBJ and glTF files that have none. Edges of
    /// more than ANGLE degrees stay sharp, as with --smooth=60. [default: all; 30 without ANGLE]
    #[cfg_attr(feature = "clap", arg(long, value_name = "ANGLE", num_args = 0..=1, require_equals = true, default_missing_value = "30", value_parser = AsText::<SmoothAngle>::parse))]
    pub smooth: Option<AsText<SmoothAngle>>,
    /// Radius of points, if the file is a point cloud
    ///
    /// Radius of the spheres that are drawn for the points of a PLY or OBJ file without faces, in
    /// its units. [default: 1.5 times the median distance between nearest neighbours]
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

/// Value of `--ortho` without a height.
const FITTING: &str = "fit";

impl OptionValue for OrthoHeight {
    fn parse(text: &str) -> Result<OrthoHeight, String> {
        match (text, doubles(text).as_deref()) {
            (FITTING, _) => Ok(OrthoHeight::Fitting),
            (_, Ok(&[height])) if height > 0.0 => Ok(OrthoHeight::Given(height)),
            _ => Err("expected a height above 0, as in --ortho=3.5".into()),
        }
    }

    fn text(&self) -> String {
        match self {
            OrthoHeight::Fitting => FITTING.to_owned(),
            OrthoHeight::Given(height) => height.to_string(),
        }
    }
}

/// Angle in degrees up to which edges are smooth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothAngle(pub f32);

impl OptionValue for SmoothAngle {
    fn parse(text: &str) -> Result<SmoothAngle, String> {
        let angle = number(text)
            .ok()
            .filter(|angle| (0.0..=180.0).contains(angle));
        let angle = angle.ok_or("expected degrees from 0 to 180, as in --smooth=45");
        Ok(SmoothAngle(angle?))
    }

    fn text(&self) -> String {
        self.0.to_string()
    }
}

/// Radius of the points of a cloud.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointRadius(pub f32);

impl OptionValue for PointRadius {
    fn parse(text: &str) -> Result<PointRadius, String> {
        let radius = number(text).ok().filter(|radius| *radius > 0.0);
        radius
            .map(PointRadius)
            .ok_or_else(|| "expected a radius above 0, as in 0.01".into())
    }

    fn text(&self) -> String {
        self.0.to_string()
    }
}

impl OptionValue for AddedLight {
    fn parse(text: &str) -> Result<AddedLight, String> {
        let toward = text.strip_prefix("dir:");
        let (position, color) = match doubles(toward.unwrap_or(text)).as_deref() {
            Ok(&[x, y, z]) => (DVec3::new(x, y, z), Vec3::ONE),
            Ok(&[x, y, z, r, g, b]) => {
                let color = [r, g, b].map(|part| part as f32);
                (DVec3::new(x, y, z), color_of(color)?)
            }
            _ => {
                return Err(
                    "expected X,Y,Z or X,Y,Z,R,G,B, with `dir:` before it for a direction".into(),
                );
            }
        };
        if toward.is_none() {
            Ok(AddedLight::Point { position, color })
        } else if position.as_vec3() == Vec3::ZERO {
            Err("the direction of a light cannot be 0,0,0".into())
        } else {
            Ok(AddedLight::Directional {
                toward: position.as_vec3(),
                color,
            })
        }
    }

    fn text(&self) -> String {
        let (place, color) = match self {
            AddedLight::Point { position, color } => (joined(position.to_array()), color),
            AddedLight::Directional { toward, color } => {
                (format!("dir:{}", joined(toward.to_array())), color)
            }
        };
        format!("{place},{}", color.text())
    }
}

/// A linear colour.
impl OptionValue for Vec3 {
    fn parse(text: &str) -> Result<Vec3, String> {
        match numbers(text).as_deref() {
            Ok(&[grey]) => color_of([grey; 3]),
            Ok(&[r, g, b]) => color_of([r, g, b]),
            _ => Err("expected R,G,B or a single number for grey, as in 1,1,1".into()),
        }
    }

    fn text(&self) -> String {
        joined(self.to_array())
    }
}

/// Text of a sky.
const SKY: &str = "sky";

impl OptionValue for EnvironmentSource {
    fn parse(text: &str) -> Result<EnvironmentSource, String> {
        match (text, numbers(text)) {
            (SKY, _) => Ok(EnvironmentSource::Sky),
            (_, Ok(_)) => Vec3::parse(text).map(EnvironmentSource::Color),
            ("", _) => Err("expected a file, sky or R,G,B".into()),
            _ => Ok(EnvironmentSource::File(text.into())),
        }
    }

    fn text(&self) -> String {
        match self {
            EnvironmentSource::Sky => SKY.to_owned(),
            EnvironmentSource::Color(color) => color.text(),
            EnvironmentSource::File(path) => {
                let text = path.display().to_string();
                // A file may have the name of a sky, or of a colour.
                let is_file = matches!(Self::parse(&text), Ok(EnvironmentSource::File(_)));
                if is_file { text } else { format!("./{text}") }
            }
        }
    }
}

#[cfg(feature = "clap")]
fn parse_turn(text: &str) -> Result<f64, String> {
    let turn = text
        .parse()
        .ok()
        .filter(|turn: &f64| turn.abs() <= MAX_TURN);
    turn.ok_or_else(|| format!("expected degrees from -{MAX_TURN} to {MAX_TURN}, as in 90"))
}

fn color_of(color: [f32; 3]) -> Result<Vec3, String> {
    if color.iter().all(|&c| c >= 0.0) {
        Ok(color.into())
    } else {
        Err("a colour cannot be negative".into())
    }
}

const KEYS: &str = "ka, kd, ks, ke, kt, shininess, ior or gloss";

impl OptionValue for Material {
    fn parse(text: &str) -> Result<Material, String> {
        let mut surface = Material {
            ka: Vec3::ZERO,
            ..Material::default()
        };
        let mut ambient = None;
        let pairs = text.split(|c: char| c.is_whitespace() || c == ';');
        for pair in pairs.filter(|pair| !pair.is_empty()) {
            let pair = pair.split_once('=');
            let (key, value) = pair.ok_or(format!("expected KEY=VALUE with {KEYS}"))?;
            match key {
                "ka" => ambient = Some(Vec3::parse(value)?),
                "kd" => surface.kd = Vec3::parse(value)?,
                "ks" => surface.ks = Vec3::parse(value)?,
                "ke" => surface.ke = Vec3::parse(value)?,
                "kt" => surface.kt = Vec3::parse(value)?,
                "shininess" => surface.shininess = at_least(key, value, |s| s >= 0.0)?,
                "ior" => surface.ior = at_least(key, value, |n| n > 0.0)?,
                "gloss" => surface.gloss = at_least(key, value, |n| n >= 0.0)?,
                _ => return Err(format!("unknown material key `{key}`: expected {KEYS}")),
            }
        }
        surface.ka = ambient.unwrap_or(surface.kd * 0.2);
        Ok(surface)
    }

    fn text(&self) -> String {
        let colors = [self.ka, self.kd, self.ks, self.ke, self.kt].map(|color| color.text());
        let [a, d, s, e, t] = colors;
        format!(
            "ka={a} kd={d} ks={s} ke={e} kt={t} shininess={} ior={} gloss={}",
            self.shininess, self.ior, self.gloss
        )
    }
}

fn at_least(key: &str, text: &str, good: impl Fn(f32) -> bool) -> Result<f32, String> {
    let value = number(text)?;
    if good(value) { Ok(value) } else { Err(format!("{key} cannot be {text}")) }
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

impl OptionValue for Origin {
    fn parse(text: &str) -> Result<Origin, String> {
        match (text, doubles(text).as_deref()) {
            ("auto", _) => Ok(Origin::Auto),
            ("none", _) => Ok(Origin::File),
            (_, Ok(&[x, y, z])) => Ok(Origin::At([x, y, z])),
            _ => Err("expected auto, none, or three numbers X,Y,Z".to_owned()),
        }
    }

    fn text(&self) -> String {
        match self {
            Origin::Auto => "auto".to_owned(),
            Origin::File => "none".to_owned(),
            Origin::At(origin) => joined(*origin),
        }
    }
}

/// Numbers within the range of single precision, in double precision.
fn doubles(text: &str) -> Result<Vec<f64>, String> {
    let double = |text: &str| {
        number(text)?;
        let parsed = text.trim().parse();
        parsed.map_err(|_| format!("`{text}` is not a number"))
    };
    text.split(',').map(double).collect()
}

fn numbers(text: &str) -> Result<Vec<f32>, String> {
    text.split(',').map(number).collect()
}

fn number(text: &str) -> Result<f32, String> {
    let number = text.trim().parse().ok().filter(|n: &f32| n.is_finite());
    number.ok_or_else(|| format!("`{text}` is not a number"))
}

fn joined<T: ToString>(numbers: [T; 3]) -> String {
    numbers.map(|number| number.to_string()).join(",")
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
    use super::*;

    #[test]
    fn lights_are_points_or_directions() {
        let point = |position, color| Ok(AddedLight::Point { position, color });
        assert_eq!(
            AddedLight::parse("1,-2,.5"),
            point(DVec3::new(1.0, -2.0, 0.5), Vec3::ONE)
        );
        assert_eq!(
            AddedLight::parse("1,2,3,.5,0,1"),
            point(DVec3::new(1.0, 2.0, 3.0), Vec3::new(0.5, 0.0, 1.0))
        );
        let toward = AddedLight::Directional {
            toward: Vec3::NEG_X,
            color: Vec3::ONE,
        };
        assert_eq!(AddedLight::parse("dir:-1,0,0"), Ok(toward));
        for bad in [
            "",
            "1,2",
            "1,2,3,4",
            "1,2,x",
            "dir:0,0,0",
            "1,2,3,-1,0,0",
            "1,2,inf",
            "nan,0,0",
        ] {
            assert!(AddedLight::parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_material_is_what_is_named_and_little_else() {
        let surface = Material::parse("kd=.5,.25,0 ks=.3; shininess=80 gloss=9").unwrap();
        assert_eq!(surface.kd, Vec3::new(0.5, 0.25, 0.0));
        assert_eq!(surface.ka, surface.kd * 0.2);
        assert_eq!((surface.ks, surface.shininess), (Vec3::splat(0.3), 80.0));
        assert_eq!(surface.gloss, 9.0);
        assert_eq!((surface.kt, surface.ior), (Vec3::ZERO, 1.0));
        assert_eq!(Material::parse("ka=0 kd=1").unwrap().ka, Vec3::ZERO);
        for bad in [
            "kd",
            "kd=",
            "kd=1,2",
            "kd=-1",
            "colour=1",
            "ior=0",
            "shininess=-1",
            "gloss=-1",
            "kd=.1,.2,.3,.4",
        ] {
            assert!(Material::parse(bad).is_err(), "{bad}");
        }
    }

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
            for kept in [overrides.clone(), overrides.without_folders()] {
                let AsText(source) = kept.environment.unwrap();
                let again = EnvironmentSource::parse(&source.text());
                assert!(matches!(again, Ok(EnvironmentSource::File(_))), "{again:?}");
            }
        }
    }

    #[test]
    fn an_origin_is_a_word_or_a_place() {
        assert_eq!(Origin::parse("auto"), Ok(Origin::Auto));
        assert_eq!(Origin::parse("none"), Ok(Origin::File));
        let place = Origin::parse("500000.1,0,-4e6");
        assert_eq!(place, Ok(Origin::At([500_000.1, 0.0, -4e6])));
        for bad in ["", "Auto", "1,2", "1,2,3,4", "1,2,x", "1,2,inf"] {
            assert!(Origin::parse(bad).is_err(), "{bad}");
        }
    }
}
