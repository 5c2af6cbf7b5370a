//! Values of the options that override parts of a scene.

use super::as_text::OptionValue;
use super::numbers::{parse_distance, parse_number};
use glam::{DVec3, Vec3};
use phalanx_formats::Origin;
use phalanx_io::EnvironmentSource;
use phalanx_look::AddedLight;
use phalanx_scene::{Material, OrthoHeight};

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
        let good = |angle: &f32| (0.0..=180.0).contains(angle);
        parse_number(text, good, "degrees from 0 to 180, as in --smooth=45").map(SmoothAngle)
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
        parse_distance(text).map(PointRadius)
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
pub(super) fn doubles(text: &str) -> Result<Vec<f64>, String> {
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

pub(super) fn number(text: &str) -> Result<f32, String> {
    let number = text.trim().parse().ok().filter(|n: &f32| n.is_finite());
    number.ok_or_else(|| format!("`{text}` is not a number"))
}

pub(super) fn joined<T: ToString>(numbers: [T; 3]) -> String {
    numbers.map(|number| number.to_string()).join(",")
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
