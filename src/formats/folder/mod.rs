//! The folder of a scene file: files named by a scene are read from here, and from folders that the
//! user has opened.
//!
//! Names come from other machines, so the first of these that exists is used:
//!
//! 1. the name, relative to the file that has it, then to the scene file, then to each opened
//!    folder, and the same without blanks and quotes around it; an absolute name as it is;
//! 2. its last component in the same folders: exporters write their own paths;
//! 3. the same regardless of case, if exactly one file has that name.
//!
//! Nothing outside the scene file's folder and the opened ones is accessed. `..` is resolved in the
//! name before it is checked, and links are followed before the file's folder is checked again, so
//! neither leads out.

pub mod foreign;

use crate::diagnostics::{DiagnosticSink, Span, quoted_file};
use crate::memory::MemoryLedger;
use std::cell::{Cell, OnceCell, RefCell};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The folder in which a scene file's other files are looked for.
pub(crate) struct Folder {
    /// `None` for a scene without a file.
    path: Option<PathBuf>,
    /// Name of the scene file without its ending.
    stem: String,
    /// Further folders that the user has opened.
    opened: Vec<PathBuf>,
    /// Both, resolved when the first file is looked for.
    roots: OnceCell<Result<Roots, String>>,
    memory: MemoryLedger,
    /// Names that may still be searched for beyond their own path.
    searches_left: Cell<u32>,
    /// Files that were found.
    files: RefCell<BTreeSet<PathBuf>>,
    /// Entries of folders that may still be compared with names.
    entries_left: Cell<u32>,
}

/// Maximum number of a scene's names that are searched for under other names, and of folder entries
/// that are compared with them. Ordinary files have a few, hostile ones have millions.
const MAX_SEARCHES: u32 = 1000;
const MAX_ENTRIES: u32 = 100_000;

const OUTSIDE: &str = "it is not in the scene file's folder (--allow-path opens a further folder)";
const REMOTE: &str =
    "files are not fetched from the network: save it in the scene file's folder under its name";
const LINKED: &str =
    "it leads out of the scene file's folder (--allow-path opens a further folder)";

/// A file of the folder. Two are equal if they are the same file, even if found by different names.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Found(PathBuf);

/// A file that was found, perhaps by another name than the scene's.
#[derive(Clone, Debug)]
pub(crate) struct NamedFile {
    pub(crate) file: Found,
    /// The name by which it was found, unless it differs only by the removal of an exporter's path.
    pub(crate) instead: Option<String>,
}

impl NamedFile {
    /// The file, with a warning if it was found by another name than `name`.
    pub(crate) fn accepted(self, name: &str, span: Span, report: &mut DiagnosticSink) -> Found {
        if let Some(instead) = self.instead {
            let (name, instead) = (quoted_file(name), quoted_file(&instead));
            let message = format!("there is no file {name}: {instead} is read instead");
            report.warning(span, message);
        }
        self.file
    }
}

/// Folders that files may lie in, resolved, and further spellings of the same.
struct Roots {
    resolved: Vec<PathBuf>,
    spelled: Vec<PathBuf>,
}

impl Folder {
    /// The folder of a scene file.
    pub(crate) fn of(file: &Path) -> Folder {
        let parent = file.parent().filter(|p| !p.as_os_str().is_empty());
        Folder {
            path: Some(parent.unwrap_or(Path::new(".")).to_path_buf()),
            stem: file
                .file_stem()
                .unwrap_or_default()
                .to_string_lossy()
                .into(),
            ..Folder::none()
        }
    }

    /// No folder: no file is found.
    pub(crate) fn none() -> Folder {
        Folder {
            path: None,
            stem: String::new(),
            opened: Vec::new(),
            roots: OnceCell::new(),
            memory: MemoryLedger::of(None),
            searches_left: Cell::new(MAX_SEARCHES),
            files: RefCell::default(),
            entries_left: Cell::new(MAX_ENTRIES),
        }
    }

    /// The same folder, with at most `most` bytes of memory for the files that the scene names.
    pub(crate) fn with_limit(self, most: Option<u64>) -> Folder {
        Folder {
            memory: MemoryLedger::of(most),
            ..self
        }
    }

    /// The same folder, and further ones in which files may lie.
    pub(crate) fn with_opened(self, opened: &[PathBuf]) -> Folder {
        Folder {
            opened: opened.to_vec(),
            roots: OnceCell::new(),
            ..self
        }
    }

    /// The real paths of all files that were found.
    pub(crate) fn into_files(self) -> Vec<PathBuf> {
        self.files.into_inner().into_iter().collect()
    }

    /// The name of the scene file without its ending; some formats have a placeholder for it.
    pub(crate) fn scene_stem(&self) -> &str {
        &self.stem
    }

    /// The ledger of the memory that the scene takes.
    pub(crate) fn memory(&self) -> &MemoryLedger {
        &self.memory
    }

    /// The bytes of a file, if there is memory for them while they are parsed. The error is like
    /// that of [`Folder::find`].
    pub(crate) fn read(&self, file: &Found) -> Result<Vec<u8>, String> {
        let name = file.0.file_name().unwrap_or_default().to_string_lossy();
        let size = std::fs::metadata(&file.0).map_or(0, |m| m.len());
        self.memory
            .lend(size, format_args!("to read {}", quoted_file(&name)))?;
        let bytes = std::fs::read(&file.0).map_err(|e| e.to_string())?;
        match foreign::refusal(&bytes) {
            Some(words) => Err(words),
            None => Ok(bytes),
        }
    }

    /// Finds the file of a name in the scene file, with `/` or `\` between folders. The error says
    /// why there is none, for a message that names the file already.
    pub(crate) fn find(&self, name: &str) -> Result<Found, String> {
        self.find_for(None, name).map(|named| named.file)
    }

    /// Finds the file of a name in `file`, or in the scene file if that is `None`. Otherwise as
    /// [`Folder::find`].
    pub(crate) fn find_for(&self, file: Option<&Found>, name: &str) -> Result<NamedFile, String> {
        self.look_up(file, name, true)
    }

    /// Finds a file by a name in the scene file that is its exact path.
    pub(crate) fn find_exact(&self, name: &str) -> Option<NamedFile> {
        self.look_up(None, name, false).ok()
    }

    /// Notes a file of the scene that the picture does not use: it belongs to the scene all the
    /// same.
    pub(crate) fn note(&self, name: &str) {
        let last = name.rsplit(['/', '\\']).next().unwrap_or(name);
        for name in [name, last] {
            _ = self.look_up(None, name, false);
        }
    }

    /// Finds a file by its path, and if `search` is true by other names, too; notes it.
    fn look_up(&self, file: Option<&Found>, name: &str, search: bool) -> Result<NamedFile, String> {
        let named = self.seek(file, name, search)?;
        self.files.borrow_mut().insert(named.file.0.clone());
        Ok(named)
    }

    fn seek(&self, file: Option<&Found>, name: &str, search: bool) -> Result<NamedFile, String> {
        let Some(folder) = &self.path else {
            return Err("the scene has no folder".into());
        };
        // Spaces and quotes around a name may be part of it.
        let literal = name.replace('\\', "/");
        // Some programs escape a space that is part of a name.
        let name = without_quotes(name).replace("\\ ", " ").replace('\\', "/");
        let Some(last) = last_component(&name) else {
            return Err(OUTSIDE.into());
        };
        let roots = self.roots.get_or_init(|| Roots::of(folder, &self.opened));
        let roots = roots.as_ref().map_err(String::clone)?;
        let mut bases: Vec<&Path> = file.and_then(|file| file.0.parent()).into_iter().collect();
        bases.extend(roots.resolved.iter().map(PathBuf::as_path));
        bases.dedup();

        let absolute = is_absolute(&name);
        let paths_of = |name: &str| -> Vec<PathBuf> {
            if is_absolute(name) {
                vec![joined(Path::new("/"), name)]
            } else {
                bases.iter().map(|base| joined(base, name)).collect()
            }
        };
        let mut paths = paths_of(&name);
        if literal != name {
            paths.splice(0..0, paths_of(&literal));
        }
        let mut reason = None;
        for path in paths {
            match roots.open(&path) {
                Ok(file) => {
                    let instead = None;
                    return Ok(NamedFile { file, instead });
                }
                Err(error) => _ = reason.get_or_insert(error),
            }
        }
        let other = search.then(|| self.search(roots, &bases, (&name, last, absolute)));
        other.flatten().ok_or_else(|| {
            if is_remote(&name) { REMOTE.into() } else { reason.unwrap_or_default() }
        })
    }

    /// Finds a file by the last component of its name, or in the other case.
    fn search(
        &self,
        roots: &Roots,
        bases: &[&Path],
        (name, last, absolute): (&str, &str, bool),
    ) -> Option<NamedFile> {
        self.searches_left
            .set(self.searches_left.get().checked_sub(1)?);
        let note = |instead: &str| (!absolute).then(|| instead.to_owned());
        // A name without folders has been looked for as it is.
        let bare = name == last && !absolute;
        let shortened = if bare { &[] } else { bases };
        for base in shortened {
            if let Ok(file) = roots.open(&base.join(last)) {
                let instead = note(last);
                return Some(NamedFile { file, instead });
            }
        }
        let names = [(!absolute).then_some(name), (!bare).then_some(last)];
        for name in names.into_iter().flatten() {
            for base in bases {
                let path = self.find_any_case(roots, base, name);
                if let Some(file) = path.and_then(|path| roots.open(&path).ok()) {
                    let instead = file.0.file_name();
                    let instead = instead.map(|name| name.to_string_lossy().into_owned());
                    return Some(NamedFile { file, instead });
                }
            }
        }
        None
    }

    /// The only path that differs from this one in the case of its letters. Nothing is listed
    /// outside the folders of `roots`.
    fn find_any_case(&self, roots: &Roots, base: &Path, name: &str) -> Option<PathBuf> {
        let mut path = base.to_path_buf();
        for component in name.split('/').filter(|part| !matches!(*part, "" | ".")) {
            let next = joined(&path, component);
            if !roots.may_hold(&next) {
                return None;
            }
            path = match next.symlink_metadata() {
                Ok(_) => next,
                Err(_) => path.join(self.only_entry(roots, &path, component)?),
            };
        }
        Some(path)
    }

    /// The name of the only entry of a folder that differs from `name` in the case of its letters.
    fn only_entry(&self, roots: &Roots, folder: &Path, name: &str) -> Option<PathBuf> {
        let folder = folder.canonicalize().ok()?;
        if !roots.holds(&folder) {
            return None;
        }
        let mut only = None;
        for entry in std::fs::read_dir(folder).ok()? {
            self.entries_left
                .set(self.entries_left.get().checked_sub(1)?);
            let entry = entry.ok()?.file_name();
            let alike = entry
                .to_str()
                .is_some_and(|e| e.to_lowercase() == name.to_lowercase());
            if alike && only.replace(PathBuf::from(entry)).is_some() {
                return None;
            }
        }
        only
    }
}

impl Roots {
    fn of(folder: &Path, opened: &[PathBuf]) -> Result<Roots, String> {
        let root = folder.canonicalize().map_err(|e| e.to_string())?;
        let mut roots = Roots {
            resolved: vec![root],
            spelled: Vec::new(),
        };
        for folder in opened {
            roots.resolved.extend(folder.canonicalize());
            roots.spelled.extend(std::path::absolute(folder));
        }
        Ok(roots)
    }

    /// Returns true for a resolved path in one of the folders.
    fn holds(&self, resolved: &Path) -> bool {
        self.resolved.iter().any(|root| resolved.starts_with(root))
    }

    /// Returns true for a path without `..` that is in one of the folders unless a link leads out.
    fn may_hold(&self, path: &Path) -> bool {
        self.holds(path) || self.spelled.iter().any(|root| path.starts_with(root))
    }

    /// The file of an absolute path without `..`, if it lies in one of the folders.
    fn open(&self, path: &Path) -> Result<Found, String> {
        // A path outside is not accessed at all, so that messages do not reveal what is there.
        if !self.may_hold(path) {
            return Err(OUTSIDE.into());
        }
        // A single request, whereas resolving makes one for every folder on the way: most of the
        // names that are tried do not exist.
        let metadata = path.metadata().map_err(|e| e.to_string())?;
        let file = path.canonicalize().map_err(|e| e.to_string())?;
        if !self.holds(&file) {
            return Err(LINKED.into());
        }
        if !metadata.is_file() {
            return Err("it is not a regular file".into());
        }
        Ok(Found(file))
    }
}

/// A name without the quotes and blanks around it.
fn without_quotes(name: &str) -> &str {
    let name = name.trim();
    let inner = |quote: char| name.strip_prefix(quote)?.strip_suffix(quote);
    inner('"').or_else(|| inner('\'')).unwrap_or(name).trim()
}

/// The last component of a name, if it names a file.
fn last_component(name: &str) -> Option<&str> {
    let last = name.rsplit('/').next()?;
    let last = without_drive(last).unwrap_or(last);
    (!matches!(last, "" | "." | "..")).then_some(last)
}

/// The rest of a name behind the letter of a drive.
fn without_drive(name: &str) -> Option<&str> {
    let rest = name.strip_prefix(|c: char| c.is_ascii_alphabetic())?;
    rest.strip_prefix(':')
}

/// Returns true for a path from the root of a file system, on any system.
fn is_absolute(name: &str) -> bool {
    let scheme = name
        .get(..5)
        .is_some_and(|s| s.eq_ignore_ascii_case("file:"));
    name.starts_with('/') || without_drive(name).is_some() || scheme
}

/// Returns true for the address of a file on another machine, such as `https://…`.
fn is_remote(name: &str) -> bool {
    let scheme = name.split_once("://").map_or("", |(scheme, _)| scheme);
    let letters = |c: char| c.is_ascii_alphanumeric() || "+-.:".contains(c);
    scheme.len() > 1 && scheme.chars().all(letters) && !scheme.eq_ignore_ascii_case("file")
}

/// A folder and a name relative to it, in which `.` and `..` are resolved.
fn joined(base: &Path, name: &str) -> PathBuf {
    let mut path = base.to_path_buf();
    for component in name.split('/') {
        match component {
            "" | "." => {}
            ".." => _ = path.pop(),
            _ => path.push(component),
        }
    }
    path
}

#[cfg(test)]
mod tests;
