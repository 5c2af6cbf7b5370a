//! The parts of a scene that are not columns, as bytes: numbers little-endian, floats by their
//! bits, texts with their length before them.

use glam::Vec3;
use phalanx_scene::{
    DefaultedParts, MAX_TEXTURE_SIDE, OrthoHeight, OutputEncoding, Quantize, Scene, Sky, Texture,
    Transfer, UpAxis, View, Wrap,
};

/// Values that the settings hold beside the scene's own.
#[derive(Clone, Debug, PartialEq)]
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
    let mut out = SettingsWriter(Vec::new());
    for number in [scene.width, scene.height, scene.max_depth] {
        out.word(number);
    }
    out.vec3(scene.background);
    out.flag(scene.sky.is_some());
    if let Some(Sky { up, nadir, zenith }) = scene.sky {
        [up, nadir, zenith].into_iter().for_each(|v| out.vec3(v));
    }
    out.float(scene.scale);
    for axis in scene.origin {
        out.double(axis);
    }
    out.word(scene.encoding.transfer as u32);
    out.word(scene.encoding.quantize as u32);
    let view = &scene.view;
    for position in [view.eye, view.center, view.up] {
        out.vec3(position);
    }
    out.float(view.fovy);
    out.flag(view.ortho.is_some());
    if let Some(height) = view.ortho {
        out.float(height);
    }
    let DefaultedParts {
        view,
        light,
        sky,
        up,
        ortho,
        ortho_size,
        made_for,
    } = scene.defaulted;
    [view, light, sky]
        .into_iter()
        .for_each(|flag| out.flag(flag));
    out.word(up as u32);
    out.word(match ortho {
        None => 0,
        Some(OrthoHeight::Fitting) => 1,
        Some(OrthoHeight::Given(_)) => 2,
    });
    if let Some(OrthoHeight::Given(height)) = ortho {
        out.double(height);
    }
    out.flag(ortho_size.is_some());
    for side in ortho_size.into_iter().flatten() {
        out.double(side);
    }
    out.flag(made_for.is_some());
    if let Some((aspect, turntable)) = made_for {
        out.double(aspect);
        out.flag(turntable);
    }
    out.text(scene.output.as_deref());
    out.word(scene.lights.len() as u32);
    for &directional in scene.lights.directional.iter() {
        out.flag(directional);
    }
    out.word(scene.textures.len() as u32);
    for (texture, &has_alpha) in scene.textures.iter().zip(&extra.has_alpha) {
        out.flag(has_alpha);
        out.word(texture.width);
        out.word(texture.height);
        for wrap in texture.wrap {
            out.word(wrap as u32);
        }
    }
    out.double(extra.sah);
    out.0
}

/// A scene with these settings, its columns empty and its textures without texels; `None` if the
/// bytes are no settings.
pub(super) fn read(bytes: &[u8]) -> Option<(Scene, Extra)> {
    let mut input = SettingsReader(bytes);
    let mut scene = Scene {
        width: input.word()?,
        height: input.word()?,
        max_depth: input.word()?,
        background: input.vec3()?,
        sky: match input.flag()? {
            true => Some(Sky {
                up: input.vec3()?,
                nadir: input.vec3()?,
                zenith: input.vec3()?,
            }),
            false => None,
        },
        scale: input.float()?,
        origin: [input.double()?, input.double()?, input.double()?],
        encoding: OutputEncoding {
            transfer: input.one_of([Transfer::None, Transfer::Srgb])?,
            quantize: input.one_of([Quantize::Floor, Quantize::Round])?,
        },
        view: View {
            eye: input.vec3()?,
            center: input.vec3()?,
            up: input.vec3()?,
            fovy: input.float()?,
            ortho: match input.flag()? {
                true => Some(input.float()?),
                false => None,
            },
        },
        defaulted: DefaultedParts {
            view: input.flag()?,
            light: input.flag()?,
            sky: input.flag()?,
            up: input.one_of(UpAxis::ALL.map(|(_, axis)| axis))?,
            ortho: match input.one_of([0, 1, 2])? {
                0 => None,
                1 => Some(OrthoHeight::Fitting),
                _ => Some(OrthoHeight::Given(input.length()?)),
            },
            ortho_size: match input.flag()? {
                true => Some([input.length()?, input.length()?]),
                false => None,
            },
            made_for: match input.flag()? {
                true => Some((input.length()?, input.flag()?)),
                false => None,
            },
        },
        output: input.text()?,
        ..Scene::default()
    };
    for _ in 0..input.word()? {
        scene.lights.directional.push(input.flag()?);
    }
    let mut has_alpha = Vec::new();
    for _ in 0..input.word()? {
        has_alpha.push(input.flag()?);
        scene.textures.push(Texture {
            width: input.word()?,
            height: input.word()?,
            wrap: [input.wrap()?, input.wrap()?],
            texels: Default::default(),
            alpha: Default::default(),
        });
    }
    let side = 1..=MAX_TEXTURE_SIDE;
    let fits = |t: &Texture| side.contains(&t.width) && side.contains(&t.height);
    if !scene.textures.iter().all(fits) {
        return None;
    }
    // Values that tracing multiplies with must be finite; the scale must be a power of two, as
    // `Scene::rescale_to_f32_range` makes it.
    let power =
        scene.scale > 0.0 && scene.scale.is_normal() && scene.scale.to_bits() & 0x7f_ffff == 0;
    let lit = |sky: Sky| sky.up.is_finite() && sky.nadir.is_finite() && sky.zenith.is_finite();
    let finite = scene.background.is_finite()
        && scene.sky.is_none_or(lit)
        && scene.origin.iter().all(|axis| axis.is_finite());
    if !finite || !power {
        return None;
    }
    let sah = input.double()?;
    input
        .0
        .is_empty()
        .then_some((scene, Extra { sah, has_alpha }))
}

struct SettingsWriter(Vec<u8>);

impl SettingsWriter {
    fn word(&mut self, word: u32) {
        self.0.extend(word.to_le_bytes());
    }

    fn flag(&mut self, flag: bool) {
        self.word(u32::from(flag));
    }

    fn float(&mut self, number: f32) {
        self.word(number.to_bits());
    }

    fn double(&mut self, number: f64) {
        self.0.extend(number.to_bits().to_le_bytes());
    }

    fn vec3(&mut self, v: Vec3) {
        for c in v.to_array() {
            self.float(c);
        }
    }

    fn text(&mut self, text: Option<&str>) {
        self.flag(text.is_some());
        let bytes = text.unwrap_or_default().as_bytes();
        self.word(bytes.len() as u32);
        self.0.extend(bytes);
    }
}

/// Reads the bytes that [`SettingsWriter`] wrote. A count is trusted only once as many bytes are
/// there.
struct SettingsReader<'a>(&'a [u8]);

impl SettingsReader<'_> {
    fn word(&mut self) -> Option<u32> {
        let (word, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(u32::from_le_bytes(*word))
    }

    fn flag(&mut self) -> Option<bool> {
        self.one_of([false, true])
    }

    fn float(&mut self) -> Option<f32> {
        self.word().map(f32::from_bits)
    }

    fn double(&mut self) -> Option<f64> {
        let bits = u64::from(self.word()?) | u64::from(self.word()?) << 32;
        Some(f64::from_bits(bits))
    }

    /// A number that is positive and finite.
    fn length(&mut self) -> Option<f64> {
        self.double()
            .filter(|&length| length > 0.0 && length.is_finite())
    }

    fn vec3(&mut self) -> Option<Vec3> {
        Some(Vec3::new(self.float()?, self.float()?, self.float()?))
    }

    fn one_of<T: Copy, const N: usize>(&mut self, all: [T; N]) -> Option<T> {
        all.get(self.word()? as usize).copied()
    }

    fn wrap(&mut self) -> Option<Wrap> {
        self.one_of([Wrap::Repeat, Wrap::Clamp, Wrap::Mirror])
    }

    fn text(&mut self) -> Option<Option<String>> {
        let there = self.flag()?;
        let length = self.word()? as usize;
        let (bytes, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        let text = std::str::from_utf8(bytes).ok()?;
        Some(there.then(|| text.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_survive_and_their_prefixes_do_not() {
        let mut scene = Scene {
            width: 7,
            max_depth: 3,
            output: Some("bild-ä.png".into()),
            encoding: OutputEncoding::SRGB,
            scale: 0.25,
            origin: [500_000.1, -0.0, -4e6],
            background: Vec3::new(0.1, -0.0, 3.0),
            ..Scene::default()
        };
        scene.lights.add_directional(Vec3::Y, Vec3::ONE);
        scene.lights.add_point(Vec3::Y, Vec3::ONE, Vec3::X);
        scene.textures.push(Texture {
            width: 2,
            height: 9,
            wrap: [Wrap::Mirror, Wrap::Clamp],
            texels: Default::default(),
            alpha: Default::default(),
        });
        scene.view.ortho = Some(7.0);
        scene.defaulted = DefaultedParts {
            light: true,
            up: UpAxis::NegY,
            ortho: Some(OrthoHeight::Given(2.5)),
            ortho_size: Some([3.0, 0.1]),
            made_for: Some((1.5, true)),
            ..DefaultedParts::default()
        };
        scene.sky = Some(Sky {
            up: Vec3::Y,
            nadir: Vec3::ZERO,
            zenith: Vec3::ONE,
        });
        let bytes = write(&scene, &Extra::of(&scene, 12.5));
        let (back, extra) = read(&bytes).expect("settings");
        assert_eq!(write(&back, &extra), bytes);
        assert_eq!((back.view, back.sky), (scene.view, scene.sky));
        assert_eq!(back.defaulted, scene.defaulted);
        assert_eq!((back.width, back.output), (7, scene.output));
        assert_eq!(back.textures, scene.textures);
        assert_eq!(back.origin, scene.origin);
        assert_eq!(*back.lights.directional, [true, false]);
        for length in 0..bytes.len() {
            assert!(read(&bytes[..length]).is_none(), "{length}");
        }
        assert!(read(&[&bytes[..], &[0]].concat()).is_none());
        let spoiled = [
            |s: &mut Scene| s.background.y = f32::NAN,
            |s: &mut Scene| s.sky.as_mut().expect("a sky").zenith.x = f32::NAN,
            |s: &mut Scene| s.scale = 0.75,
            |s: &mut Scene| s.scale = 0.0,
            |s: &mut Scene| s.scale = -1.0,
            |s: &mut Scene| s.origin[1] = f64::NAN,
            |s: &mut Scene| s.origin[2] = f64::INFINITY,
            |s: &mut Scene| s.defaulted.ortho_size = Some([1.0, f64::NAN]),
            |s: &mut Scene| s.defaulted.ortho = Some(OrthoHeight::Given(-1.0)),
            |s: &mut Scene| s.textures[0].width = 0,
            |s: &mut Scene| s.textures[0].height = u32::MAX,
        ];
        for (k, spoil) in spoiled.into_iter().enumerate() {
            let (mut bad, extra) = read(&bytes).expect("settings");
            spoil(&mut bad);
            assert!(read(&write(&bad, &extra)).is_none(), "{k}");
        }
    }
}
