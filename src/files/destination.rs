//! The kind of file at a path determines how it is written: a regular file is replaced, everything
//! else is written into.

use super::descriptor;
use super::folder::folder_of;
use super::shown_path::shown_path;
use std::fs::{self, File, OpenOptions};
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};

/// The kind of file at a path, links followed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Destination {
    /// A regular file, or one yet to be created, by its folder's real name. It is replaced as a
    /// whole.
    File(PathBuf),
    /// A pipe or a device: it is opened and written into.
    Stream(PathBuf),
    /// An open file of this process by its number, as `/dev/stdout` names one. It is written into
    /// at its current position, so that other writers continue after it.
    Open(i32),
}

/// Maximum number of links that are followed one after the other, as on Linux.
const MAX_LINKS: usize = 40;

const STDOUT: i32 = 1;

impl Destination {
    /// Determines the kind of file at a path. Nothing is opened: opening a pipe waits for its
    /// reader, and opening a device may have an effect.
    ///
    /// # Errors
    /// A folder, a socket, links in a circle, or the system's reason why the kind is unknown.
    pub fn of(path: &Path) -> io::Result<Destination> {
        let mut target = path.to_path_buf();
        for _ in 0..MAX_LINKS {
            if let Some(number) = descriptor::number_of(&target) {
                return Ok(Destination::Open(number));
            }
            let file = match fs::symlink_metadata(&target) {
                Err(error) if error.kind() == io::ErrorKind::NotFound => None,
                other => Some(other?),
            };
            match file {
                Some(file) if file.is_symlink() && !descriptor::of_another_process(&target) => {
                    target = folder_of(&target).join(fs::read_link(&target)?);
                }
                Some(file) if file.is_dir() => {
                    return Err(io::Error::new(
                        io::ErrorKind::IsADirectory,
                        "there is a folder of that name",
                    ));
                }
                Some(file) if is_socket(&file) => {
                    return Err(io::Error::new(
                        io::ErrorKind::Unsupported,
                        "it is a socket, which cannot be opened by its name",
                    ));
                }
                Some(file) if !file.is_file() => return Ok(Destination::Stream(target)),
                _ => return file_at(&target),
            }
        }
        Err(io::Error::other("too many links, or links in a circle"))
    }

    /// Returns true if this is the process's standard output.
    pub fn is_stdout(&self) -> bool {
        *self == Destination::Open(STDOUT)
    }

    /// Returns true if this is shown on a terminal. A device that is not open yet is not examined.
    pub fn is_terminal(&self) -> bool {
        match self {
            Destination::Open(number) => {
                descriptor::duplicate(*number).is_ok_and(|f| f.is_terminal())
            }
            Destination::File(_) | Destination::Stream(_) => false,
        }
    }

    /// Rejects a destination that cannot be written into, as far as that can be determined without
    /// writing. Regular files are not examined here.
    pub(super) fn check_stream(&self) -> io::Result<()> {
        match self {
            Destination::File(_) => Ok(()),
            Destination::Stream(path) => {
                if fs::metadata(path)?.permissions().readonly() {
                    Err(io::ErrorKind::PermissionDenied.into())
                } else {
                    Ok(())
                }
            }
            Destination::Open(number) => {
                let mut file = descriptor::duplicate(*number)?;
                // No empty write here: on a datagram socket it would be a message.
                if is_socket(&file.metadata()?) { Ok(()) } else { file.write(&[]).map(drop) }
            }
        }
    }

    /// Opens the pipe, device or open file for writing; a pipe waits for its reader. `None` for a
    /// regular file.
    pub(super) fn open_stream(&self) -> io::Result<Option<File>> {
        match self {
            Destination::File(_) => Ok(None),
            // Only a file that another process has open can be a regular one here.
            Destination::Stream(path) => {
                let regular = fs::metadata(path)?.is_file();
                let mut options = OpenOptions::new();
                options.write(true).append(regular).open(path).map(Some)
            }
            Destination::Open(number) => descriptor::duplicate(*number).map(Some),
        }
    }
}

fn file_at(path: &Path) -> io::Result<Destination> {
    let folder = folder_of(path);
    let none = || {
        let folder = shown_path(folder);
        let message = format!("there is no folder {folder}");
        io::Error::new(io::ErrorKind::NotFound, message)
    };
    let name = path.file_name().ok_or(io::ErrorKind::InvalidFilename)?;
    match folder.canonicalize() {
        Ok(folder) if folder.is_dir() => Ok(Destination::File(folder.join(name))),
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Err(none()),
    }
}

#[cfg(unix)]
fn is_socket(metadata: &fs::Metadata) -> bool {
    std::os::unix::fs::FileTypeExt::is_socket(&metadata.file_type())
}

#[cfg(not(unix))]
fn is_socket(_: &fs::Metadata) -> bool {
    false
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn links_are_followed_to_what_there_is_or_is_to_be() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().canonicalize().unwrap();
        let path_of = |name: &str| folder.join(name);
        fs::create_dir(path_of("sub")).unwrap();
        symlink("sub/link", path_of("first")).unwrap();
        symlink("../made", path_of("sub/link")).unwrap();
        symlink("/dev/null", path_of("null")).unwrap();
        symlink("/dev/stdout", path_of("out")).unwrap();
        symlink("circle", path_of("circle")).unwrap();
        let kind = |name: &str| Destination::of(&path_of(name));
        assert_eq!(kind("first").unwrap(), Destination::File(path_of("made")));
        assert_eq!(
            kind("sub/../new").unwrap(),
            Destination::File(path_of("new"))
        );
        assert_eq!(
            kind("null").unwrap(),
            Destination::Stream("/dev/null".into())
        );
        assert!(kind("out").unwrap().is_stdout());
        assert!(kind("circle").unwrap_err().to_string().contains("circle"));
        let folder = kind("sub").unwrap_err();
        assert_eq!(folder.kind(), io::ErrorKind::IsADirectory);
        let missing = kind("no/where").unwrap_err();
        assert_eq!(missing.kind(), io::ErrorKind::NotFound);
        assert!(kind("first/where").is_err());
    }

    #[test]
    fn open_files_are_known_by_whatever_name_they_have() {
        for name in ["/dev/fd/2", "/proc/self/fd/2", "/proc/thread-self/fd/2"] {
            if Path::new(name).exists() {
                assert_eq!(
                    Destination::of(name.as_ref()).unwrap(),
                    Destination::Open(2),
                    "{name}"
                );
            }
        }
        let closed = Destination::Open(i32::MAX);
        assert!(closed.check_stream().is_err() && closed.open_stream().is_err());
    }
}
