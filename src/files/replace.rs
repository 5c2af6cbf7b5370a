//! All files are written through this module: regular ones appear whole or not at all, everything
//! else is written into.

use super::destination::Destination;
use super::folder::folder_of;
use super::temporary;
use std::fs::{self, File, OpenOptions, Permissions};
use std::io::{self, BufWriter, Cursor, Seek, Write};
use std::path::Path;
use tempfile::NamedTempFile;

/// A writer for formats that seek back to fill in values that become known later.
pub trait WriteSeek: Write + Seek {}

impl<T: Write + Seek> WriteSeek for T {}

/// Writes the file at `path` through `fill`. The method depends on the kind of file that is there
/// now (see [`Destination`]).
///
/// A regular file, or a new one, is written as a temporary file in the same folder, which is synced
/// and renamed over it. It gets the permissions of the file that it replaces, and its owner if the
/// system allows that; a read-only file is rejected. If `path` is a link, its target is replaced
/// and the link stays. Pipes, devices and open files of this process (`/dev/stdout`) are written
/// into as the bytes arrive, and are never renamed over.
///
/// # Errors
/// The first error of any step. Then no temporary file is left, and a regular file that was at
/// `path` is still there.
pub fn replace_file(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let destination = Destination::of(path)?;
    match (&destination, destination.open_stream()?) {
        (_, Some(stream)) => write_through(stream, |out| fill(out)).map(drop),
        (Destination::File(path), None) => replace(path, |out| fill(out)),
        (_, None) => Ok(()),
    }
}

/// As [`replace_file`], for formats that seek. For a pipe, device or open file, the bytes are
/// assembled in memory first.
pub fn replace_file_seeking(
    path: &Path,
    fill: impl FnOnce(&mut dyn WriteSeek) -> io::Result<()>,
) -> io::Result<()> {
    match Destination::of(path)? {
        Destination::File(path) => replace(&path, fill),
        Destination::Stream(_) | Destination::Open(_) => {
            let bytes = in_memory(fill)?;
            replace_file(path, |out| out.write_all(&bytes))
        }
    }
}

/// The bytes that `fill` writes.
pub fn in_memory(fill: impl FnOnce(&mut dyn WriteSeek) -> io::Result<()>) -> io::Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    fill(&mut bytes)?;
    Ok(bytes.into_inner())
}

/// Returns the destination that [`replace_file`] would find there, and rejects one that it could
/// not write. Call this before hours of work, not after. It does not block or leave anything
/// behind; leftovers of killed runs are removed.
///
/// # Errors
/// The system's reason why it cannot be written.
pub fn check_writable(path: &Path) -> io::Result<Destination> {
    let destination = Destination::of(path)?;
    match &destination {
        Destination::File(path) => {
            temporary::remove_leftovers(path);
            temporary_beside(path)?.close()?;
        }
        Destination::Stream(_) | Destination::Open(_) => destination.check_stream()?,
    }
    Ok(destination)
}

fn replace(path: &Path, fill: impl FnOnce(&mut dyn WriteSeek) -> io::Result<()>) -> io::Result<()> {
    // Dropping it on an early return removes it.
    let mut temporary = temporary_beside(path)?;
    let file = write_through(temporary.as_file_mut(), |out| fill(out))?;
    file.sync_all()?;
    temporary.persist(path).map_err(|e| e.error)?;
    sync_folder(folder_of(path));
    Ok(())
}

/// Writes through a buffer, and flushes it.
fn write_through<W: Write>(
    file: W,
    fill: impl FnOnce(&mut BufWriter<W>) -> io::Result<()>,
) -> io::Result<W> {
    let mut writer = BufWriter::new(file);
    fill(&mut writer)?;
    writer.into_inner().map_err(|e| e.into_error())
}

fn temporary_beside(path: &Path) -> io::Result<NamedTempFile> {
    let existing = fs::metadata(path).ok();
    if existing.is_some() {
        // Its folder would allow replacing it, but that is not what its owner intended by making it
        // read-only.
        OpenOptions::new().write(true).open(path)?;
    }
    // If others may not read the file, they may not read its bytes while they are written either.
    let permissions = existing.as_ref().map(|existing| existing.permissions());
    let temporary = temporary::create(path, permissions.or_else(ordinary_permissions))?;
    if let Some(existing) = existing {
        keep_ownership(temporary.as_file(), &existing)?;
    }
    Ok(temporary)
}

/// Gives a new file the owner, the group and the permissions of another one. Only the system's
/// administrator may give files away, and permissions of a new file are reduced by the umask.
#[cfg(unix)]
fn keep_ownership(file: &File, existing: &fs::Metadata) -> io::Result<()> {
    use std::os::unix::fs::{MetadataExt, fchown};
    if fchown(file, Some(existing.uid()), Some(existing.gid())).is_err() {
        let _ = fchown(file, None, Some(existing.gid()));
    }
    // After the owner, whose change takes permissions away.
    file.set_permissions(existing.permissions())
}

/// Keeps nothing: the only permission is read-only, and a read-only file could not be renamed.
#[cfg(not(unix))]
fn keep_ownership(_: &File, _: &fs::Metadata) -> io::Result<()> {
    Ok(())
}

/// The permissions of a file from `File::create` (less the umask), instead of the 0600 of temporary
/// files.
#[cfg(unix)]
fn ordinary_permissions() -> Option<Permissions> {
    use std::os::unix::fs::PermissionsExt;
    Some(Permissions::from_mode(0o666))
}

#[cfg(not(unix))]
fn ordinary_permissions() -> Option<Permissions> {
    None
}

/// Makes the rename itself durable. The file is complete either way, so it is not a failure if a
/// system cannot do this.
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
            let fill = |_: &mut dyn Write| panic!("must not be reached");
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
        let path_of = |name: &str| folder.path().join(name);
        fs::write(path_of("ordinary"), "").unwrap();
        symlink("target", path_of("link")).unwrap();
        fs::write(path_of("target"), "old").unwrap();
        replace_file(&path_of("link"), |w| w.write_all(b"new")).unwrap();
        assert!(path_of("link").is_symlink());
        assert_eq!(fs::read(path_of("target")).unwrap(), b"new");
        let mode = |name| fs::metadata(path_of(name)).unwrap().permissions().mode();
        assert_eq!(mode("target"), mode("ordinary"));
        for bits in [0o600, 0o640, 0o666, 0o755] {
            fs::set_permissions(path_of("target"), fs::Permissions::from_mode(bits)).unwrap();
            replace_file(&path_of("link"), |w| w.write_all(b"newer")).unwrap();
            assert_eq!(mode("target") & 0o7777, bits);
        }
    }

    /// Checks, as only an administrator can, that a file keeps its owner.
    #[cfg(unix)]
    #[test]
    fn owners_are_kept() {
        use std::os::unix::fs::{MetadataExt, chown};
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        fs::write(&path, "old").unwrap();
        if chown(&path, Some(12_345), Some(54_321)).is_err() {
            return;
        }
        replace_file(&path, |w| w.write_all(b"new")).unwrap();
        let existing = fs::metadata(&path).unwrap();
        assert_eq!((existing.uid(), existing.gid()), (12_345, 54_321));
    }

    /// Checks what an administrator is not refused.
    #[cfg(unix)]
    #[test]
    fn read_only_files_stay() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        fs::write(&path, "old").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o444)).unwrap();
        let allowed = OpenOptions::new().write(true).open(&path).is_ok();
        assert_eq!(check_writable(&path).is_ok(), allowed);
        let replaced = replace_file(&path, |w| w.write_all(b"new"));
        assert_eq!(replaced.is_ok(), allowed);
        assert_eq!(names(folder.path()), ["a.png"]);
    }
}
