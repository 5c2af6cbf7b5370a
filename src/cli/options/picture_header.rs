//! Header of a picture file: the scene's name, and the command that makes the picture. It is made
//! of what changes the picture, never of threads, tile sizes, kernels, engines or folders, so that
//! equal pictures are equal files.

use super::scene_args::SceneArgs;
use crate::cli::output::{CliError, OutputFile};
use phalanx::files::shown_text;
use phalanx::formats::{AddedLight, Origin, OrthoHeight, UpAxis};
use phalanx::frame::{Aov, Settings, Tile};
use phalanx::image::{Depth, ImageFormat, PictureFile, PictureHeader};
use phalanx::jobs::PictureSettings;
use phalanx::open::standard_name;
use phalanx::scene::{
    CameraMatrices, Material, OutputEncoding, Quantize, Scene, Transfer, View, material_names,
    object_names,
};
use std::ffi::OsStr;
use std::path::Path;

/// Words of `render` that a command may lack, because they are its defaults.
const DEFAULTS: [(&str, &str); 4] = [
    ("--spp", "1"),
    ("--filter", "box"),
    ("--aa", "uniform"),
    ("--integrator", "whitted"),
];

/// The scene of a picture, as its header names it.
pub struct NamedScene<'a> {
    /// The argument of the command line.
    pub name: &'a Path,
    /// Options beside it.
    pub args: &'a SceneArgs,
    /// The scene itself, with the view of the picture.
    pub scene: &'a Scene,
    /// True if the view is not the one that the name and the options give.
    pub is_moved: bool,
}

impl<'a> NamedScene<'a> {
    /// The scene of a frame of a sequence that began with the view `start`.
    pub fn of_frame(
        name: &'a Path,
        args: &'a SceneArgs,
        scene: &'a Scene,
        start: &View,
    ) -> NamedScene<'a> {
        NamedScene {
            name,
            args,
            scene,
            is_moved: scene.view != *start || scene.defaulted.view,
        }
    }

    /// A file with the header of this picture.
    pub fn with_header(
        &self,
        output: &OutputFile,
        settings: &Settings,
    ) -> Result<OutputFile, CliError> {
        let mut output = output.clone();
        set_header(&mut output, self.header(settings)?);
        Ok(output)
    }

    /// The header of a file of this picture, whose command lacks the file's own options:
    /// [`set_header`] adds them.
    pub fn header(&self, settings: &Settings) -> Result<PictureHeader, CliError> {
        let scene = self.shown_name();
        let mut words = vec!["phalanx".to_owned(), "render".to_owned(), scene.clone()];
        words.extend(self.scene_words()?);
        words.extend(settings_words(settings));
        let size = (settings.width, settings.height);
        let matrices = CameraMatrices::of(self.scene, size);
        let matrices = matrices.map(|m| [m.world_to_camera, m.world_to_ndc]);
        Ok(PictureHeader {
            scene,
            command: command_line(&words),
            matrices: matrices.ok(),
            objects: match settings.aovs.has(Aov::CryptoObject) {
                true => manifest(object_names(self.scene)),
                false => Vec::new(),
            },
            materials: match settings.aovs.has(Aov::CryptoMaterial) {
                true => manifest(material_names(self.scene)),
                false => Vec::new(),
            },
        })
    }

    /// The name without its folders, which differ between machines.
    fn shown_name(&self) -> String {
        let name = match standard_name(self.name) {
            Some(name) => OsStr::new(name),
            None => self.name.file_name().unwrap_or(self.name.as_os_str()),
        };
        shown_text(&name.to_string_lossy())
    }

    /// Options beside the scene that were given. Those that only say where files lie, or how much
    /// memory may be used, are left out.
    fn scene_words(&self) -> Result<Vec<String>, CliError> {
        let SceneArgs {
            camera,
            up,
            ortho,
            light,
            background,
            material,
            two_sided,
            origin,
            allow_path: _,
            max_memory: _,
            format: _,
        } = self.args;
        let mut words = Vec::new();
        let mut add = |option: &str, value: String| words.extend([option.to_owned(), value]);
        if let Some(format) = self.args.scene_format()? {
            add("--format", format.to_owned());
        }
        match (self.is_moved, camera) {
            (true, _) => {
                let [view, ortho] = view_words(self.scene);
                words.extend(view.into_iter().chain(ortho));
            }
            (false, given) => {
                let given = given.iter().flatten().cloned();
                words.extend(camera.iter().map(|_| "--camera".to_owned()).chain(given));
                words.extend(ortho.map(|ortho| match ortho {
                    OrthoHeight::Fitting => "--ortho".to_owned(),
                    OrthoHeight::Given(height) => format!("--ortho={height}"),
                }));
                let name = |up: UpAxis| UpAxis::ALL.iter().find(|(_, axis)| *axis == up);
                let up = up.and_then(name);
                words.extend(up.map(|(name, _)| format!("--up={name}")));
            }
        }
        let mut add = |option: &str, value: String| words.extend([option.to_owned(), value]);
        for light in light {
            add("--light", light_word(light));
        }
        if let Some(color) = background {
            add("--background", joined(color.to_array()));
        }
        if let Some(material) = material {
            add("--material", material_word(material));
        }
        words.extend(two_sided.then(|| "--two-sided".to_owned()));
        let mut add = |option: &str, value: String| words.extend([option.to_owned(), value]);
        match origin {
            Origin::Auto => {}
            Origin::File => add("--origin", "none".to_owned()),
            Origin::At(origin) => add("--origin", joined(*origin)),
        }
        Ok(words)
    }
}

/// Most names in a file: some megabytes.
const MAX_NAMES: usize = 1 << 16;

/// The names for a file, or none if they are too many.
fn manifest(names: impl Iterator<Item = String>) -> Vec<String> {
    let names: Vec<String> = names.take(MAX_NAMES + 1).collect();
    match names.len() > MAX_NAMES {
        true => Vec::new(),
        false => names,
    }
}

/// Sets the header of a file, and completes its command, if it has one.
pub fn set_header(output: &mut OutputFile, mut header: PictureHeader) {
    let words = encoding_words(&output.file);
    if !header.command.is_empty() && !words.is_empty() {
        header.command = format!("{} {}", header.command, command_line(&words));
    }
    output.file.header = header;
}

fn command_line(words: &[String]) -> String {
    let words: Vec<String> = words.iter().map(|word| in_shell(word)).collect();
    words.join(" ")
}

/// The view of a scene as options, in the coordinates of its file.
fn view_words(scene: &Scene) -> [Vec<String>; 2] {
    let View {
        eye,
        center,
        up,
        fovy,
        ortho,
    } = scene.view;
    let [eye, center] = [eye, center].map(|at| joined(scene.file_position(at).to_array()));
    let camera = ["--camera".to_owned(), eye, center];
    let camera = camera
        .into_iter()
        .chain([joined(up.to_array()), fovy.to_string()]);
    let height = ortho.map(|height| f64::from(height) / f64::from(scene.scale));
    let ortho = height.map(|height| format!("--ortho={height}"));
    [camera.collect(), ortho.into_iter().collect()]
}

/// Settings that pixels depend on, with the picture's size, region and layers.
fn settings_words(settings: &Settings) -> Vec<String> {
    let mut words = vec![
        "--size".to_owned(),
        format!("{}x{}", settings.width, settings.height),
    ];
    if settings.window() != Tile::whole(settings.width, settings.height) {
        let Tile {
            x,
            y,
            width,
            height,
        } = settings.window();
        words.push("--region".to_owned());
        words.extend([x, y, width, height].map(|n| n.to_string()));
    }
    let layers = Aov::ALL.iter().filter(|(_, aov)| settings.aovs.has(*aov));
    let layers: Vec<&str> = layers.map(|(name, _)| *name).collect();
    if !layers.is_empty() {
        words.extend(["--aov".to_owned(), layers.join(",")]);
    }
    for (option, value) in PictureSettings::of(settings).given_options() {
        if !DEFAULTS.contains(&(option, &value)) {
            words.extend([option.to_owned(), value]);
        }
    }
    words
}

/// The file's format, and what becomes of radiance in it.
fn encoding_words(file: &PictureFile) -> Vec<String> {
    let mut words = Vec::new();
    let mut add = |option: &str, value: &str| {
        words.extend([option.to_owned(), value.to_owned()]);
    };
    if file.format != ImageFormat::Png {
        add("--format", file.format.ending());
    }
    if file.format.is_linear() {
        return words;
    }
    let OutputEncoding { transfer, quantize } = file.exposure.encoding;
    add(
        "--transfer",
        match transfer {
            Transfer::None => "none",
            Transfer::Srgb => "srgb",
        },
    );
    add(
        "--quantize",
        match quantize {
            Quantize::Floor => "floor",
            Quantize::Round => "round",
        },
    );
    if file.depth == Depth::Sixteen {
        add("--bits", "16");
    }
    if file.exposure.stops != 0.0 {
        words.push(format!("--exposure={}", file.exposure.stops));
    }
    words
}

fn light_word(light: &AddedLight) -> String {
    match light {
        AddedLight::Point { position, color } => {
            format!(
                "{},{}",
                joined(position.to_array()),
                joined(color.to_array())
            )
        }
        AddedLight::Directional { toward, color } => {
            format!(
                "dir:{},{}",
                joined(toward.to_array()),
                joined(color.to_array())
            )
        }
    }
}

/// The parts of a material that its option may name.
fn material_word(material: &Material) -> String {
    let Material {
        ka, ke, kd, ks, kt, ..
    } = material;
    let colors = [("ka", ka), ("kd", kd), ("ks", ks), ("ke", ke), ("kt", kt)];
    let colors = colors.map(|(key, color)| format!("{key}={}", joined(color.to_array())));
    let numbers = [
        ("shininess", material.shininess),
        ("ior", material.ior),
        ("gloss", material.gloss),
    ];
    let numbers = numbers.map(|(key, number)| format!("{key}={number}"));
    let all: Vec<String> = colors.into_iter().chain(numbers).collect();
    all.join(" ")
}

fn joined<T: ToString>(numbers: [T; 3]) -> String {
    numbers.map(|number| number.to_string()).join(",")
}

/// A word as shells read it.
fn in_shell(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_.,:/=+".contains(c);
    match !word.is_empty() && word.chars().all(plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', "'\\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_with_spaces_are_quoted() {
        assert_eq!(in_shell("a-b.test"), "a-b.test");
        assert_eq!(in_shell("kd=1 ks=.5"), "'kd=1 ks=.5'");
        assert_eq!(in_shell("it's"), "'it'\\''s'");
        assert_eq!(in_shell(""), "''");
    }
}
