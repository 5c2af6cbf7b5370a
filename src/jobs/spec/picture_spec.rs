//! The complete description of a picture: its scene, and the options that change it.

use super::encoding_spec::EncodingSpec;
use super::option_row::{command_line, unless_default, words};
use super::pixel_spec::PixelSpec;
use super::scene_overrides::SceneOverrides;
use phalanx_files::{operand, shown_path};
use phalanx_image::{Crop, ImageFormat, PictureFile, PictureHeader};
use phalanx_io::open::standard_name;
use phalanx_render::frame::Aov;
use phalanx_scene::{CameraMatrices, OutputEncoding, Scene, material_names, object_names};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The description of a picture. It has no threads, tile size, kernel or engine, because no picture
/// depends on them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PictureSpec {
    /// The scene: a file name or a standard scene.
    pub scene: String,
    /// Format of the scene file; `None` to use its extension.
    pub format: Option<String>,
    /// Options that override parts of the scene.
    pub overrides: SceneOverrides,
    /// Options that change pixels.
    pub pixels: PixelSpec,
    /// Options of the picture's file.
    pub encoding: EncodingSpec,
}

impl PictureSpec {
    /// The same picture with all options written out for this scene.
    pub fn resolve(&self, scene: &Scene) -> PictureSpec {
        PictureSpec {
            pixels: PixelSpec::of(&self.pixels.settings(scene)),
            encoding: self.encoding.resolve(scene.encoding),
            ..self.clone()
        }
    }

    /// The header of a file of this picture, whose command lacks the file's own options:
    /// [`set_header`] adds them. It is made of what changes the picture, never of folders, so that
    /// equal pictures are equal files.
    ///
    /// The scene has the view of the picture. `is_moved` is true if that is not the view that the
    /// scene's name and the overrides give, so that the command has to name it.
    pub fn header(&self, scene: &Scene, is_moved: bool) -> PictureHeader {
        let name = self.portable_name();
        let view = scene.shortest_view(&scene.view);
        let overrides = if is_moved {
            self.overrides.with_view(scene, &view)
        } else {
            self.overrides.clone()
        };
        let overrides = overrides.without_folders();
        // A name with U+FFFD may have other bytes: a command of it would not find the file.
        let mut command = self.render_words(&name, &overrides, scene);
        command.retain(|_| self.has_exact_name());
        let size = self.pixels.size.unwrap_or((scene.width, scene.height));
        let matrices = CameraMatrices::of(scene, size);
        let matrices = matrices.map(|m| [m.world_to_camera, m.world_to_ndc]);
        let has = |aov| self.pixels.aovs().has(aov);
        let objects = has(Aov::CryptoObject).then(|| manifest(object_names(scene)));
        let materials = has(Aov::CryptoMaterial).then(|| manifest(material_names(scene)));
        PictureHeader {
            scene: shown_path(&name),
            command: command_line(&command),
            matrices: matrices.ok(),
            objects: objects.unwrap_or_default(),
            materials: materials.unwrap_or_default(),
        }
    }

    /// The command that renders this picture of a scene to a file, from the folder that the scene's
    /// name is relative to. `more` are further words.
    pub fn command(&self, scene: &Scene, output: &str, more: &[&str]) -> String {
        let name = Path::new(&self.scene);
        let mut command = self.render_words(name, &self.overrides, scene);
        command.extend(words(&self.encoding.rows()));
        let more = ["-o", output].into_iter().chain(more.iter().copied());
        command.extend(more.map(str::to_owned));
        command_line(&command)
    }

    /// The words of a command that renders this picture, without its file and the file's options.
    fn render_words(&self, name: &Path, overrides: &SceneOverrides, scene: &Scene) -> Vec<String> {
        let name = operand(name).display().to_string();
        let mut command = ["phalanx", "render", &name].map(str::to_owned).to_vec();
        let format = self.format.iter();
        command.extend(format.flat_map(|f| ["--format".to_owned(), f.clone()]));
        command.extend(words(&overrides.rows()));
        // Other formats have another default.
        let is_default = |spp: &u32| *spp == 1 && !scene.defaulted.samples;
        let pixels = PixelSpec {
            spp: self.pixels.spp.filter(|spp| !is_default(spp)),
            aa: unless_default(self.pixels.aa),
            filter: unless_default(self.pixels.filter),
            integrator: unless_default(self.pixels.integrator),
            ..self.pixels.clone()
        };
        command.extend(words(&pixels.rows()));
        command
    }

    /// The file of this picture, which is fully resolved, for a scene with this origin. Its header
    /// is empty.
    pub fn file(&self, format: ImageFormat, origin: [f64; 3]) -> PictureFile {
        let window = self.pixels.window();
        let (width, height, corner) = (window.width, window.height, (window.x, window.y));
        let size = self.pixels.size.unwrap_or_default();
        PictureFile {
            width,
            height,
            crop: ((width, height) != size).then_some(Crop { corner, of: size }),
            format,
            aovs: self.pixels.aovs(),
            origin,
            exposure: self.encoding.exposure(OutputEncoding::LINEAR),
            depth: self.encoding.depth(),
            header: PictureHeader::NONE,
        }
    }

    /// Returns true if the scene's name is valid UTF-8, so that a command can have it.
    pub fn has_exact_name(&self) -> bool {
        !self.scene.contains('\u{fffd}')
    }

    /// The scene's name without its folders, which differ between machines.
    fn portable_name(&self) -> PathBuf {
        let path = Path::new(&self.scene);
        let name = path.file_name().map_or(path, Path::new);
        if standard_name(path).is_some() || name == path {
            path.to_owned()
        } else if standard_name(name).is_some() || name == "-" {
            // Without its folder, it might be a standard scene or stdin.
            Path::new(".").join(name)
        } else {
            name.to_owned()
        }
    }
}

/// Most names in a file, and most bytes of them.
const MAX_NAMES: usize = 1 << 16;
const MAX_NAME_BYTES: usize = 1 << 22;

/// The names for a file, each once, or none if they are too many.
fn manifest(names: impl Iterator<Item = String>) -> Vec<String> {
    let (mut all, mut bytes) = (BTreeSet::new(), 0);
    for name in names {
        let length = name.len();
        bytes += if all.insert(name) { length } else { 0 };
        if all.len() > MAX_NAMES || bytes > MAX_NAME_BYTES {
            return Vec::new();
        }
    }
    Vec::from_iter(all)
}

/// Sets the header of a file, and completes its command, if it has one, with the file's format and
/// what becomes of radiance in it.
pub fn set_header(file: &mut PictureFile, mut header: PictureHeader) {
    let mut options = Vec::new();
    if file.format != ImageFormat::Png {
        options.extend(["--format", file.format.ending()].map(str::to_owned));
    }
    let encoding = EncodingSpec::of(file.exposure, file.depth);
    let bits = encoding.bits;
    let encoding = EncodingSpec {
        bits: bits.filter(|bits| file.format.bits().contains(bits)),
        ..if file.format.is_linear() { EncodingSpec::default() } else { encoding }
    };
    options.extend(words(&encoding.rows()));
    if !header.command.is_empty() && !options.is_empty() {
        header.command = format!("{} {}", header.command, command_line(&options));
    }
    file.header = header;
}
