//! Files that appear whole or not at all.

use std::fs::{File, Permissions};
use std::io::{self, BufWriter, Seek, Write};
use std::path::{Path, PathBuf};
use tempfile::{Builder, NamedTempFile};

/// What a file is written through: some formats go back to say what they could not know before.
pub trait Out: Write + Seek {}

impl<T: Write + Seek> Out for T {}

/// Writes a file through `fill` into a temporary one in the same folder, syncs it, and renames it over `path`.
///
/// # Errors
/// The first error of any step. Then there is no temporary file left, and what stood at `path` stands there still.
pub fn replace_file(
    path: &Path,
    fill: impl FnOnce(&mut dyn Out) -> io::Result<()>,
) -> io::Result<()> {
    // A link keeps pointing where it did: the file behind it is what gets replaced.
    let path = &path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    refuse_folder(path)?;
    // Dropping it on an early return removes it.
    let mut temporary = temporary_beside(path)?;
    let mut writer = BufWriter::new(temporary.as_file_mut());
    fill(&mut writer)?;
    writer.flush()?;
    drop(writer);
    temporary.as_file().sync_all()?;
    temporary.persist(path).map_err(|e| e.error)?;
    sync_folder(&folder_of(path));
    Ok(())
}

/// Whether [`replace_file`] could write there now: to be asked before hours of work, not after.
///
/// # Errors
/// The system's reason why not.
pub fn check_writable(path: &Path) -> io::Result<()> {
    let path = &path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    refuse_folder(path)?;
    temporary_beside(path)?.close()
}

fn refuse_folder(path: &Path) -> io::Result<()> {
    if path.is_dir() {
        return Err(io::Error::new(
            io::ErrorKind::IsADirectory,
            "there is a folder of that name",
        ));
    }
    Ok(())
}

fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

fn temporary_beside(path: &Path) -> io::Result<NamedTempFile> {
    let folder = folder_of(path);
    if !folder.is_dir() {
        return Err(io::Error::new(
            io::ErrorKind::NotFound,
            format!("there is no folder {}", folder.display()),
        ));
    }
    let mut builder = Builder::new();
    builder.prefix(".phalanx-").suffix(".part");
    if let Some(permissions) = ordinary_permissions() {
        builder.permissions(permissions);
    }
    builder.tempfile_in(folder)
}

/// What a file made with `File::create` would get (less the umask), not the 0600 of temporary files.
#[cfg(unix)]
fn ordinary_permissions() -> Option<Permissions> {
    use std::os::unix::fs::PermissionsExt;
    Some(Permissions::from_mode(0o666))
}

#[cfg(not(unix))]
fn ordinary_permissions() -> Option<Permissions> {
    None
}

/// Makes the rename itself durable. The file is complete either way, so a system that cannot is no failure.
fn sync_folder(folder: &Path) {
    if cfg!(unix)
        && let Ok(folder) = File::open(folder)
    {
        let _ = folder.sync_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<_> = entries
            .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        fs::write(&path, "old").unwrap();
        let failed = replace_file(&path, |w| {
            w.write_all(b"half of the new one")?;
            w.flush()?;
            Err(io::Error::other("disk full"))
        });
        assert_eq!(failed.unwrap_err().to_string(), "disk full");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["a.png"]);
    }

    #[test]
    fn a_finished_write_replaces_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        fs::write(&path, "old and longer").unwrap();
        replace_file(&path, |w| w.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["a.png"]);
    }

    #[test]
    fn folders_and_missing_folders_are_refused_before_anything_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("nowhere/a.png");
        for path in [folder.path(), &missing] {
            assert!(check_writable(path).is_err(), "{path:?}");
            let fill = |_: &mut dyn Out| panic!("must not be reached");
            assert!(replace_file(path, fill).is_err(), "{path:?}");
        }
        check_writable(&folder.path().join("a.png")).unwrap();
        assert!(names(folder.path()).is_empty());
    }

    #[cfg(unix)]
    #[test]
    fn permissions_are_those_of_an_ordinary_file_and_links_stay() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("ordinary"), "").unwrap();
        symlink("target", at("link")).unwrap();
        fs::write(at("target"), "old").unwrap();
        replace_file(&at("link"), |w| w.write_all(b"new")).unwrap();
        assert!(at("link").is_symlink());
        assert_eq!(fs::read(at("target")).unwrap(), b"new");
        let mode = |name| fs::metadata(at(name)).unwrap().permissions().mode();
        assert_eq!(mode("target"), mode("ordinary"));
    }
}
