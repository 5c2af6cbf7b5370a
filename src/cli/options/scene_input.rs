//! The scene argument of a command: opened and built within the memory limit.

use super::budget::Budget;
use super::format_args::ending_of;
use super::scene_args::{SceneArgs, WantedPicture};
use super::work_args::TreeArgs;
use super::{bus_error, heap};
use crate::cli::output::{self, CliError, is_dash};
use phalanx::bvh::Bvh;
use phalanx::files::shown_path;
use phalanx::formats::endings;
use phalanx::frame::{Accel, Engine, Settings};
use phalanx::open::{OpenError, is_cache, open, open_as, open_bytes, standard_name};
use phalanx::scene::Scene;
use phalanx::standard;
use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// A scene, with the BVH that it was stored with, if any.
pub struct SceneInput {
    /// The scene.
    pub scene: Scene,
    /// Size of the mapped cache; 0 if there is none.
    pub mapped_bytes: u64,
    /// Memory limit.
    pub budget: Budget,
    bvh: Option<Bvh>,
}

impl SceneInput {
    /// Records scenes as inputs, so that no output replaces them.
    pub fn note_all(names: impl IntoIterator<Item = impl AsRef<Path>>) -> Result<(), CliError> {
        let is_file = |name: &Path| !is_dash(name) && standard_name(name).is_none();
        let mut names = names.into_iter().filter(|name| is_file(name.as_ref()));
        names.try_for_each(|name| output::reads("the scene", name.as_ref()))
    }

    /// Opens the scene of this name for a picture, on `threads` threads (0: one per CPU). The
    /// reader's warnings and notes go to stderr.
    pub fn load(
        name: &Path,
        args: &SceneArgs,
        picture: WantedPicture,
        threads: usize,
    ) -> Result<SceneInput, CliError> {
        SceneInput::note_all([name])?;
        let mut options = args.options(picture, threads)?;
        let budget = Budget(args.max_memory);
        // For an environment; files of scenes count, too.
        options.read.max_memory = budget.0;
        heap::give_back();
        if let Some(name) = standard_name(name) {
            budget.for_standard(standard::parse_spec(name).map_err(OpenError::from)?)?;
        }
        // A file whose size cannot be queried cannot be read either; its reader reports that.
        let format = args.scene_format()?;
        let of_format = |ending: &str| name.with_extension(ending);
        let file = (!is_dash(name)).then(|| std::fs::metadata(name));
        let mut piped = None;
        if let Some(Ok(file)) = file {
            let like = format.map_or_else(|| name.to_path_buf(), of_format);
            options.read.max_memory = budget.beside_file(&like, file.len())?;
            // A pipe or device has no size. Under a memory limit, the size is known only when
            // everything has been read.
            if budget.0.is_some() && !file.is_file() && !file.is_dir() && !is_cache(&like) {
                piped = format.or_else(|| ending_of(name));
            }
        }
        if is_cache(name) {
            bus_error::watch(name);
        }
        if is_dash(name) {
            piped = format;
        }
        let opened = match (piped, format) {
            (Some(ending), _) => {
                let like = of_format(ending);
                let bytes = read_piped(name, budget.most_bytes(&like))?;
                options.read.max_memory = budget.beside_file(&like, bytes.len() as u64)?;
                open_bytes(name, ending, &bytes, &options)
            }
            (_, Some(ending)) if standard_name(name).is_none() => open_as(name, ending, &options),
            _ if is_dash(name) => {
                return Err(CliError::Usage(format!(
                    "a scene from stdin needs its format: --format {}",
                    endings().collect::<Vec<_>>().join("|")
                )));
            }
            _ => open(name, &options),
        };
        let opened = opened.map_err(|error| budget.explain(error))?;
        for file in &opened.files {
            output::reads("the scene's file", file)?;
        }
        output::print_warnings(name, &opened.warnings);
        output::print_notes(&opened.notes);
        Ok(SceneInput {
            scene: opened.scene,
            mapped_bytes: opened.mapped_bytes,
            budget,
            bvh: opened.bvh,
        })
    }

    /// The acceleration structure of an engine. The first call uses the BVH that was stored with
    /// the scene, if any; later ones build a new one.
    pub fn prepare(
        &mut self,
        engine: Engine,
        tree: &TreeArgs,
        threads: usize,
    ) -> Result<Accel, CliError> {
        match engine {
            Engine::Simd => self.tree(tree, threads).map(Accel::with_tree),
            Engine::Scalar => {
                (self.budget).for_tree(&self.scene, engine, &tree.settings(threads))?;
                Ok(Accel::build(&self.scene, engine))
            }
        }
    }

    /// As [`SceneInput::prepare`], checked and completed for a render with `films` films in memory.
    pub fn prepare_render(
        &mut self,
        settings: &Settings,
        tree: &TreeArgs,
        films: u64,
    ) -> Result<Accel, CliError> {
        let prepared = self.prepare(settings.engine, tree, settings.threads)?;
        (self.budget).for_render(&self.scene, &prepared, settings, films)?;
        prepared.build_wide_bvh(settings);
        Ok(prepared)
    }

    /// The packet engine's BVH.
    pub fn tree(&mut self, tree: &TreeArgs, threads: usize) -> Result<Bvh, CliError> {
        if let Some(bvh) = self.bvh.take() {
            if tree.quality.is_some() {
                output::note(
                    "--quality has no effect on a scene cache, which contains its BVH; pass it to phalanx build instead",
                );
            }
            return Ok(bvh);
        }
        let settings = tree.settings(threads);
        (self.budget).for_tree(&self.scene, Engine::Simd, &settings)?;
        Ok(Bvh::build_with(&self.scene, &settings))
    }
}

/// Reads stdin, a pipe or a device to its end, or one byte beyond `most`.
fn read_piped(name: &Path, most: u64) -> Result<Vec<u8>, CliError> {
    let mut bytes = Vec::new();
    let most = most.saturating_add(1);
    static STDIN_WAS_READ: AtomicBool = AtomicBool::new(false);
    if is_dash(name) && STDIN_WAS_READ.swap(true, Ordering::Relaxed) {
        let message = "stdin can be read only once: give - only once";
        return Err(CliError::Usage(message.to_owned()));
    }
    let (read, named) = if is_dash(name) {
        let read = io::stdin().lock().take(most).read_to_end(&mut bytes);
        (read, "stdin".into())
    } else {
        let file = File::open(name);
        let read = file.and_then(|file| file.take(most).read_to_end(&mut bytes));
        (read, shown_path(name))
    };
    read.map_err(|e| CliError::cannot_read(named, e))?;
    Ok(bytes)
}

/// File name, without extension, of outputs made from a scene.
pub fn stem(name: &Path) -> &OsStr {
    let named = phalanx::open::stem(name).filter(|_| !is_dash(name));
    named.unwrap_or("picture".as_ref())
}
