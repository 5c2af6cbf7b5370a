//! The files that this process reads and writes. No result takes the place of an input, nor of
//! another result.
//!
//! Files are compared by device and inode, or where there are none by their real names, whatever
//! names and links lead to them. Pipes and devices are written into, and are not compared. A file
//! that a command goes on with (finished tiles, a list of frames) is noted as written alone.

use super::error::CliError;
use super::stdout::is_dash;
use phalanx::image::Destination;
use phalanx::scene::shown_path;
use std::collections::BTreeMap;
#[cfg(unix)]
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

static LEDGER: Mutex<Ledger> = Mutex::new(Ledger {
    read: BTreeMap::new(),
    written: Vec::new(),
});

struct Ledger {
    /// Each file's purpose and name, for messages.
    read: BTreeMap<FileId, String>,
    written: Vec<WrittenFile>,
}

struct WrittenFile {
    /// The option that names it, and for messages its name, too.
    origin: &'static str,
    shown: String,
    place: PathBuf,
    /// `None` if it does not exist yet.
    id: Option<FileId>,
}

#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct FileId(
    /// Device and inode.
    #[cfg(unix)]
    (u64, u64),
    /// The real name.
    #[cfg(not(unix))]
    PathBuf,
);

impl FileId {
    /// The identity of a regular file, links followed.
    fn of(path: &Path) -> Option<FileId> {
        let file = path.metadata().ok()?;
        #[cfg(unix)]
        let id = (file.dev(), file.ino());
        #[cfg(not(unix))]
        let id = path.canonicalize().ok()?;
        file.is_file().then_some(FileId(id))
    }
}

fn ledger() -> MutexGuard<'static, Ledger> {
    LEDGER.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Notes a file that is read, for messages with its purpose; refuses one that a result would
/// replace.
pub fn reads(what: &str, path: &Path) -> Result<(), CliError> {
    let (id, mut ledger) = (FileId::of(path), ledger());
    let read = format!("{what} {}", shown_path(path));
    let written = ledger.written.iter().find(|file| file.id == id);
    if let Some(written) = written.filter(|_| id.is_some()) {
        return Err(refusal(written, &read));
    }
    ledger.read.extend(id.map(|id| (id, read)));
    Ok(())
}

/// Notes a file that is written, named by the option `origin`; refuses one in the place of an input
/// or of another option's. An option has one file at a time, so that frames may follow each other.
pub fn writes(origin: &'static str, path: &Path) -> Result<(), CliError> {
    let (place, id) = match Destination::of(path) {
        _ if is_dash(path) => (path.to_path_buf(), None),
        Ok(Destination::File(place)) => (place, FileId::of(path)),
        _ => return Ok(()),
    };
    let written = WrittenFile {
        origin,
        shown: format!("{origin} {}", shown_path(path)),
        id,
        place,
    };
    if let (Some(_), Some(read)) = (&written.id, input_at(path)) {
        return Err(refusal(&written, &read));
    }
    let mut ledger = ledger();
    ledger.written.retain(|other| other.origin != origin);
    let same = |other: &&WrittenFile| other.place == written.place;
    if let Some(other) = ledger.written.iter().find(same) {
        return Err(CliError::Usage(format!(
            "{} and {origin} are the same file, {}: name another one",
            other.origin,
            shown_path(path)
        )));
    }
    ledger.written.push(written);
    Ok(())
}

/// The input that a result at this path would replace, with its purpose.
pub fn input_at(path: &Path) -> Option<String> {
    ledger().read.get(&FileId::of(path)?).cloned()
}

fn refusal(written: &WrittenFile, read: &str) -> CliError {
    let written = &written.shown;
    CliError::Usage(format!("{written} would replace {read}: name another file"))
}
