//! The parts of a scene that are not columns, as bytes: numbers little-endian, floats by their
//! bits, texts with their length before them.

use glam::Vec3;
use phalanx_scene::{
    DefaultedParts, Environment, EnvironmentLight, EnvironmentMap, EnvironmentTexels,
    MAX_TEXTURE_SIDE, NO_NAME, OrthoHeight, OutputEncoding, Quantize, Scene, SceneCamera, Texture,
    Transfer, UpAxis, View, Wrap,
};

/// Values that the settings hold beside the scene's own.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Extra {
    /// SAH cost of the tree: see [`phalanx_trace::bvh::Bvh::sah`].
    pub(super) sah: f64,
    /// For each texture, true if its texels have an opacity.
    pub(super) has_alpha: Vec<bool>,
}

impl Extra {
    /// The values for a scene and the cost of its tree.
    pub(super) fn of(scene: &Scene, sah: f64) -> Extra {
        let textures = scene.textures.iter();
        Extra {
            sah,
            has_alpha: textures.map(|t| !t.alpha.is_empty()).collect(),
        }
    }
}

/// The settings of a scene.
pub(super) fn write(scene: &Scene, extra: &Extra) -> Vec<u8> {
    let mut out = Vec::new();
    let _ = pass(&mut SettingsPass::Write(&mut out), scene, extra);
    out
}

/// A scene with these settings, its columns empty and its textures without texels; `None` if the
/// bytes are no settings.
pub(super) fn read(bytes: &[u8]) -> Option<(Scene, Extra)> {
    let mut input = SettingsPass::Read(bytes);
    let (scene, extra) = pass(&mut input, &Scene::default(), &Extra::default())?;
    let side = 1..=MAX_TEXTURE_SIDE;
    let fits = |t: &Texture| side.contains(&t.width) && side.contains(&t.height);
    // Values that tracing multiplies with must be finite; the scale must be a power of two, as
    // `Scene::rescale_to_f32_range` makes it.
    let power =
        scene.scale > 0.0 && scene.scale.is_normal() && scene.scale.to_bits() & 0x7f_ffff == 0;
    let finite = scene.background.is_finite()
        && scene.light_scale.is_normal()
        && scene.light_scale > 0.0
        && scene.origin.iter().all(|axis| axis.is_finite());
    let is_complete = matches!(input, SettingsPass::Read([]));
    (is_complete && finite && power && scene.textures.iter().all(fits)).then_some((scene, extra))
}

/// All settings in the order of their bytes. To write, `from` and `extra` are passed through; to
/// read, they stand for what is not known yet.
fn pass(bytes: &mut SettingsPass, from: &Scene, extra: &Extra) -> Option<(Scene, Extra)> {
    let (view, defaulted) = (from.view, &from.defaulted);
    let (ortho, height) = match defaulted.ortho {
        None => (0, 0.0),
        Some(OrthoHeight::Fitting) => (1, 0.0),
        Some(OrthoHeight::Given(height)) => (2, height),
    };
    let mut scene = Scene {
        width: bytes.word(from.width)?,
        height: bytes.word(from.height)?,
        max_depth: bytes.word(from.max_depth)?,
        background: bytes.vec3(from.background)?,
        environment: match bytes.flag(from.environment.is_some())? {
            true => Some(environment(bytes, from.environment.as_ref())?),
            false => None,
        },
        smooth_shadows: bytes.flag(from.smooth_shadows)?,
        light_scale: bytes.float(from.light_scale)?,
        emission_lights: bytes.flag(from.emission_lights)?,
        scale: bytes.float(from.scale)?,
        origin: bytes.each(from.origin, SettingsPass::double)?,
        encoding: OutputEncoding {
            transfer: bytes.one_of(from.encoding.transfer, [Transfer::None, Transfer::Srgb])?,
            quantize: bytes.one_of(from.encoding.quantize, [Quantize::Floor, Quantize::Round])?,
        },
        view: bytes.view(view)?,
        defaulted: DefaultedParts {
            view: bytes.flag(defaulted.view)?,
            light: bytes.flag(defaulted.light)?,
            samples: bytes.flag(defaulted.samples)?,
            sky: bytes.flag(defaulted.sky)?,
            up: bytes.one_of(defaulted.up, UpAxis::ALL.map(|(_, axis)| axis))?,
            ortho: match bytes.one_of(ortho, [0, 1, 2])? {
                0 => None,
                1 => Some(OrthoHeight::Fitting),
                _ => Some(OrthoHeight::Given(bytes.length(height)?)),
            },
            ortho_size: bytes.option(defaulted.ortho_size, SettingsPass::size)?,
            made_for: bytes.option(defaulted.made_for, |bytes, (aspect, turntable)| {
                Some((bytes.length(aspect)?, bytes.flag(turntable)?))
            })?,
        },
        output: bytes.text(from.output.as_deref())?,
        ..Scene::default()
    };
    let lights = &from.lights.directional;
    for k in 0..bytes.word(lights.len() as u32)? as usize {
        let directional = lights.get(k).copied().unwrap_or_default();
        scene.lights.directional.push(bytes.flag(directional)?);
    }
    for k in 0..bytes.word(from.cameras.len() as u32)? as usize {
        let camera = from.cameras.get(k).copied();
        let camera = camera.unwrap_or(SceneCamera {
            name: NO_NAME,
            view,
            ortho_size: None,
            width: from.width,
        });
        scene.cameras.push(SceneCamera {
            name: bytes.word(camera.name)?,
            view: bytes.view(camera.view)?,
            ortho_size: bytes.option(camera.ortho_size, SettingsPass::size)?,
            width: bytes.word(camera.width)?,
        });
    }
    let mut has_alpha = Vec::new();
    for k in 0..bytes.word(from.textures.len() as u32)? as usize {
        has_alpha.push(bytes.flag(extra.has_alpha.get(k).copied().unwrap_or_default())?);
        let texture = from.textures.get(k);
        let (width, height, wrap, nearest) = texture
            .map(|t| (t.width, t.height, t.wrap, t.nearest))
            .unwrap_or_default();
        scene.textures.push(Texture {
            width: bytes.word(width)?,
            height: bytes.word(height)?,
            wrap: bytes.each(wrap, |bytes, wrap| {
                bytes.one_of(wrap, [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror])
            })?,
            nearest: bytes.flag(nearest)?,
            texels: Default::default(),
            alpha: Default::default(),
        });
    }
    let sah = bytes.double(extra.sah)?;
    Some((scene, Extra { sah, has_alpha }))
}

/// An environment, read without texels.
fn environment(bytes: &mut SettingsPass, from: Option<&Environment>) -> Option<Environment> {
    let [nadir, zenith] = [Vec3::ZERO; 2];
    let none = Environment::new(EnvironmentLight::Gradient { nadir, zenith }, UpAxis::Y, 0.0);
    let from = from.unwrap_or(&none);
    let (up, turn) = from.placement();
    let (colors, size, kind) = match &from.light {
        &EnvironmentLight::Gradient { nadir, zenith } => ([nadir, zenith], [0; 2], 0),
        EnvironmentLight::Map(map) => {
            let kind = map.texels.column().row_size();
            ([nadir, zenith], [map.width, map.height], kind)
        }
    };
    let up = bytes.one_of(up, UpAxis::ALL.map(|(_, axis)| axis))?;
    let turn = bytes.double(turn)?;
    let [nadir, zenith] = bytes.each(colors, SettingsPass::vec3)?;
    let [width, height] = bytes.each(size, SettingsPass::word)?;
    let texels = match bytes.one_of(kind, [0, 4, 6, 12])? {
        4 => Some(EnvironmentTexels::Rgbe(Default::default())),
        6 => Some(EnvironmentTexels::Half(Default::default())),
        12 => Some(EnvironmentTexels::Float(Default::default())),
        _ => None,
    };
    let light = match texels {
        Some(texels) => {
            let map = EnvironmentMap {
                width,
                height,
                texels,
            };
            EnvironmentLight::Map(map.into())
        }
        None => EnvironmentLight::Gradient { nadir, zenith },
    };
    let mut environment = Environment::new(light, up, turn);
    environment.scale = bytes.float(from.scale)?;
    environment.is_background = bytes.flag(from.is_background)?;
    Some(environment)
}

/// One way through the settings. Each step takes a value: it is written and returned, or the one
/// that was written is read. A count is trusted only once as many bytes are there.
enum SettingsPass<'a> {
    Write(&'a mut Vec<u8>),
    Read(&'a [u8]),
}

impl SettingsPass<'_> {
    fn word(&mut self, word: u32) -> Option<u32> {
        match self {
            SettingsPass::Write(out) => {
                out.extend(word.to_le_bytes());
                Some(word)
            }
            SettingsPass::Read(bytes) => {
                let (word, rest) = bytes.split_first_chunk()?;
                *bytes = rest;
                Some(u32::from_le_bytes(*word))
            }
        }
    }

    fn one_of<T: Copy + PartialEq, const N: usize>(&mut self, value: T, all: [T; N]) -> Option<T> {
        let index = all.iter().position(|&other| other == value)?;
        all.get(self.word(index as u32)? as usize).copied()
    }

    fn flag(&mut self, flag: bool) -> Option<bool> {
        self.one_of(flag, [false, true])
    }

    fn float(&mut self, number: f32) -> Option<f32> {
        self.word(number.to_bits()).map(f32::from_bits)
    }

    fn double(&mut self, number: f64) -> Option<f64> {
        let bits = number.to_bits();
        let (low, high) = (self.word(bits as u32)?, self.word((bits >> 32) as u32)?);
        Some(f64::from_bits(u64::from(low) | u64::from(high) << 32))
    }

    /// A number that is read only where it is positive and finite.
    fn length(&mut self, length: f64) -> Option<f64> {
        let length = self.double(length)?;
        let good = length > 0.0 && length.is_finite();
        (good || matches!(self, SettingsPass::Write(_))).then_some(length)
    }

    fn each<T: Copy, const N: usize>(
        &mut self,
        mut values: [T; N],
        one: impl Fn(&mut Self, T) -> Option<T>,
    ) -> Option<[T; N]> {
        for value in &mut values {
            *value = one(self, *value)?;
        }
        Some(values)
    }

    fn vec3(&mut self, v: Vec3) -> Option<Vec3> {
        self.each(v.to_array(), Self::float).map(Vec3::from)
    }

    /// Width and height.
    fn size(&mut self, size: [f64; 2]) -> Option<[f64; 2]> {
        self.each(size, SettingsPass::length)
    }

    fn view(&mut self, view: View) -> Option<View> {
        Some(View {
            eye: self.vec3(view.eye)?,
            center: self.vec3(view.center)?,
            up: self.vec3(view.up)?,
            fovy: self.float(view.fovy)?,
            ortho: self.option(view.ortho, SettingsPass::float)?,
        })
    }

    fn option<T: Default>(
        &mut self,
        value: Option<T>,
        one: impl Fn(&mut Self, T) -> Option<T>,
    ) -> Option<Option<T>> {
        if self.flag(value.is_some())? {
            one(self, value.unwrap_or_default()).map(Some)
        } else {
            Some(None)
        }
    }

    fn text(&mut self, text: Option<&str>) -> Option<Option<String>> {
        let is_some = self.flag(text.is_some())?;
        let text = text.unwrap_or_default();
        let length = self.word(text.len() as u32)? as usize;
        let text = match self {
            SettingsPass::Write(out) => {
                out.extend(text.as_bytes());
                text
            }
            SettingsPass::Read(bytes) => {
                let (text, rest) = bytes.split_at_checked(length)?;
                *bytes = rest;
                std::str::from_utf8(text).ok()?
            }
        };
        Some(is_some.then(|| text.to_owned()))
    }
}
