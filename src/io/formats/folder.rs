//! The folder of a scene file: files that a scene names are read from here only.

use super::diagnostics::quoted;
use super::memory_budget::MemoryBudget;
use std::path::{Component, Path, PathBuf};

/// The folder in which a scene file's other files are looked for.
pub(super) struct Folder {
    /// `None` for a scene without a file.
    path: Option<PathBuf>,
    allowance: MemoryBudget,
}

impl Folder {
    /// The folder of a scene file.
    pub(super) fn of(file: &Path) -> Folder {
        let parent = file.parent().filter(|p| !p.as_os_str().is_empty());
        Folder {
            path: Some(parent.unwrap_or(Path::new(".")).to_path_buf()),
            allowance: MemoryBudget::of(None),
        }
    }

    /// No folder: no file is found.
    pub(super) fn none() -> Folder {
        Folder {
            path: None,
            allowance: MemoryBudget::of(None),
        }
    }

    /// The same folder, with at most `most` bytes of memory for the files that the scene names.
    pub(super) fn within(self, most: Option<u64>) -> Folder {
        Folder {
            allowance: MemoryBudget::of(most),
            ..self
        }
    }

    /// The memory budget for the files that the scene names.
    pub(super) fn allowance(&self) -> &MemoryBudget {
        &self.allowance
    }

    /// The bytes of a file, if there is memory for them while they are parsed. The error is like
    /// that of [`Folder::find`].
    pub(super) fn read(&self, file: &Found) -> Result<Vec<u8>, String> {
        let name = || file.0.file_name().unwrap_or_default().display().to_string();
        let size = std::fs::metadata(&file.0).map_or(0, |m| m.len());
        self.allowance
            .lend(size, || format!("to read {}", quoted(&name())))?;
        std::fs::read(&file.0).map_err(|e| e.to_string())
    }

    /// Finds the file of a name in the scene file, with `/` or `\` between folders. The error says
    /// why there is none, for a message that names the file already.
    ///
    /// Links are followed before the file's folder is checked, so none leads out of the folder.
    pub(super) fn find(&self, name: &str) -> Result<Found, String> {
        let Some(folder) = &self.path else {
            return Err("the scene has no folder".into());
        };
        let name = PathBuf::from(name.replace('\\', "/"));
        let inside = |c: Component| matches!(c, Component::Normal(_) | Component::CurDir);
        if name.as_os_str().is_empty() || !name.components().all(inside) {
            return Err("it is not in the scene file's folder".into());
        }
        let resolved = |path: &Path| path.canonicalize().map_err(|e| e.to_string());
        let (root, file) = (resolved(folder)?, resolved(&folder.join(&name))?);
        if !file.starts_with(&root) {
            return Err("it leads out of the scene file's folder".into());
        }
        if !file.is_file() {
            return Err("it is not a regular file".into());
        }
        Ok(Found(file))
    }
}

/// A file of the folder. Two are equal if they are the same file, even if found by different names.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Found(PathBuf);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_of_the_folder_are_read() {
        let outer = tempfile::tempdir().unwrap();
        let folder = outer.path().join("scene");
        std::fs::create_dir_all(folder.join("maps")).unwrap();
        std::fs::write(outer.path().join("secret"), "no").unwrap();
        std::fs::write(folder.join("maps/wood.png"), "yes").unwrap();
        let asset_dir = Folder::of(&folder.join("a.obj"));
        let wood = asset_dir.find("maps/wood.png").unwrap();
        assert_eq!(asset_dir.read(&wood).unwrap(), b"yes");
        assert_eq!(asset_dir.find(".\\maps\\wood.png").unwrap(), wood);
        let absolute = outer.path().join("secret");
        for outside in [
            "../secret",
            "maps/../../secret",
            "",
            "maps",
            "absent",
            absolute.to_str().unwrap(),
        ] {
            assert!(asset_dir.find(outside).is_err(), "{outside}");
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(&absolute, folder.join("link")).unwrap();
            assert!(asset_dir.find("link").unwrap_err().contains("leads out"));
        }
    }
}
