//! What a command takes where it takes a scene, opened and built within the memory that may be used.

use super::args::TreeArgs;
use super::budget::Budget;
use super::failure::Failure;
use super::output::is_dash;
use super::scene_args::SceneArgs;
use super::{bus_error, diagnose, output};
use phalanx::bvh::Bvh;
use phalanx::formats::endings;
use phalanx::frame::{Engine, Prepared};
use phalanx::open::{OpenError, is_cache, open, open_as, open_bytes, standard_name};
use phalanx::scene::Scene;
use phalanx::standard;
use std::ffi::OsStr;
use std::io::{self, Read};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// A scene, with its tree if it came with one.
pub struct Input {
    /// The scene.
    pub scene: Scene,
    /// Bytes of a mapped cache, or 0.
    pub mapped_bytes: u64,
    /// What may be used.
    pub budget: Budget,
    bvh: Option<Bvh>,
}

impl Input {
    /// Opens the scene of this name on so many threads (0: all); what its reader has to say goes to stderr.
    pub fn load(name: &Path, args: &SceneArgs, threads: usize) -> Result<Input, Failure> {
        let mut options = args.options(threads)?;
        let budget = Budget(args.max_memory);
        if let Some(name) = standard_name(name) {
            budget.for_standard(standard::parse_spec(name).map_err(OpenError::from)?)?;
        }
        // A file that cannot be asked for its size cannot be read either, which its reader will say.
        let format = args.scene_format()?;
        let of_format = |ending: &str| name.with_extension(ending);
        let file = (!is_dash(name)).then(|| std::fs::metadata(name));
        if let Some(Ok(file)) = file {
            let like = format.map_or_else(|| name.to_path_buf(), of_format);
            options.max_memory = budget.beside_file(&like, file.len())?;
        }
        if is_cache(name) {
            bus_error::watch(name);
        }
        let opened = match format {
            Some(ending) if is_dash(name) => {
                let bytes = stdin(budget)?;
                options.max_memory = budget.beside_file(&of_format(ending), bytes.len() as u64)?;
                open_bytes(name, ending, &bytes, &options)
            }
            Some(ending) if standard_name(name).is_none() => open_as(name, ending, &options),
            None if is_dash(name) => {
                return Err(Failure::Usage(format!(
                    "a scene from stdin needs its format: --format {}",
                    endings().collect::<Vec<_>>().join("|")
                )));
            }
            _ => open(name, &options),
        };
        let opened = opened.map_err(|error| budget.explained(error))?;
        diagnose::tell_warnings(name, &opened.warnings);
        diagnose::tell_notes(&opened.notes);
        Ok(Input {
            scene: opened.scene,
            mapped_bytes: opened.mapped_bytes,
            budget,
            bvh: opened.bvh,
        })
    }

    /// The tree of an engine: the one that came with the scene, the first time, or one that is built.
    pub fn prepare(
        &mut self,
        engine: Engine,
        tree: &TreeArgs,
        threads: usize,
    ) -> Result<Prepared, Failure> {
        match engine {
            Engine::Simd => self.tree(tree, threads).map(Prepared::with_tree),
            Engine::Scalar => {
                self.budget.for_tree(&self.scene, engine)?;
                Ok(Prepared::build(&self.scene, engine))
            }
        }
    }

    /// The packet engine's tree.
    pub fn tree(&mut self, tree: &TreeArgs, threads: usize) -> Result<Bvh, Failure> {
        if let Some(bvh) = self.bvh.take() {
            if tree.quality.is_some() {
                output::note(
                    "note: the scene cache has its tree: --quality changes nothing; give it to the phalanx build that \
                     makes the cache",
                );
            }
            return Ok(bvh);
        }
        self.budget.for_tree(&self.scene, Engine::Simd)?;
        Ok(Bvh::build_with(&self.scene, &tree.settings(threads)))
    }
}

/// All of stdin, or as much as shows that it is more than may be used. It can be read once.
fn stdin(budget: Budget) -> Result<Vec<u8>, Failure> {
    static READ: AtomicBool = AtomicBool::new(false);
    if READ.swap(true, Ordering::Relaxed) {
        return Err(Failure::Usage(
            "stdin can be read once: name it once, as -".to_owned(),
        ));
    }
    let mut bytes = Vec::new();
    let most = budget.0.unwrap_or(u64::MAX);
    let read = io::stdin().lock().take(most).read_to_end(&mut bytes);
    read.map_err(|e| Failure::Runtime(format!("cannot read stdin: {e}")))?;
    Ok(bytes)
}

/// What files made from a scene are called, without an ending.
pub fn stem(name: &Path) -> &OsStr {
    let standard = standard_name(name).and_then(|text| text.split(':').nth(1));
    match standard {
        _ if is_dash(name) => OsStr::new("picture"),
        Some(stem) => OsStr::new(stem),
        None => name.file_stem().unwrap_or("picture".as_ref()),
    }
}
