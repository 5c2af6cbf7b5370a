//! The files that this process reads and writes. No result takes the place of an input, nor of
//! another result.
//!
//! Files are compared by device and inode, or elsewhere than on Unix by their real names, whatever
//! names and links lead to them. Pipes and devices are written into, and are not compared. A file
//! that a command goes on with (finished tiles, a list of frames) is noted as written alone.

use super::error::CliError;
use super::stdout::is_dash;
use phalanx::files::Destination;
use phalanx::formats::foreign;
use phalanx::scene::shown_path;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
#[cfg(unix)]
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

static LEDGER: Mutex<Ledger> = Mutex::new(Ledger {
    read: BTreeMap::new(),
    written: BTreeMap::new(),
});

struct Ledger {
    /// Purpose and name of each, for messages, by its identity.
    read: BTreeMap<PathBuf, String>,
    /// Identity of each, and option and name for messages, by the option.
    written: BTreeMap<&'static str, (PathBuf, String)>,
}

fn ledger() -> MutexGuard<'static, Ledger> {
    LEDGER.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The identity of a regular file: its real name, or on Unix device and inode in place of one.
fn identity(path: &Path) -> Option<PathBuf> {
    let file = path.metadata().ok()?;
    #[cfg(unix)]
    let id = format!("{} {}", file.dev(), file.ino()).into();
    #[cfg(not(unix))]
    let id = path.canonicalize().ok()?;
    file.is_file().then_some(id)
}

/// Number of bytes that tell a packed file, or one that stands for another.
const HEAD: u64 = 64;

/// The first bytes of a regular file, `most` of them; none of what cannot be read.
pub fn first_bytes(path: &Path, most: u64) -> Vec<u8> {
    let mut head = Vec::new();
    if path.is_file() {
        _ = File::open(path).and_then(|file| file.take(most).read_to_end(&mut head));
    }
    head
}

/// Notes a file that is read, for messages with its purpose; refuses one that a result would
/// replace, and one that is packed or kept elsewhere.
pub fn reads(what: &str, path: &Path) -> Result<(), CliError> {
    let Some(id) = identity(path) else {
        return Ok(());
    };
    // Other faults are told by the file's reader.
    if let Some(why) = foreign::refusal(&first_bytes(path, HEAD)) {
        return Err(CliError::cannot_read(shown_path(path), why));
    }
    let read = format!("{what} {}", shown_path(path));
    let mut ledger = ledger();
    if let Some((_, written)) = ledger.written.values().find(|(other, _)| *other == id) {
        return Err(refusal(written, &read));
    }
    ledger.read.insert(id, read);
    Ok(())
}

/// Notes a file that is written, named by the option `origin`; refuses one in the place of an input
/// or of another option's. An option has one file at a time, so that frames may follow each other.
pub fn writes(origin: &'static str, path: &Path) -> Result<(), CliError> {
    let id = match Destination::of(path) {
        _ if is_dash(path) => path.into(),
        Ok(Destination::File(place)) => identity(&place).unwrap_or(place),
        _ => return Ok(()),
    };
    let written = format!("{origin} {}", shown_path(path));
    let mut ledger = ledger();
    ledger.written.remove(origin);
    if let Some(read) = ledger.read.get(&id) {
        return Err(refusal(&written, read));
    }
    if let Some((first, _)) = ledger.written.iter().find(|(_, (other, _))| *other == id) {
        let shown = shown_path(path);
        return Err(CliError::Usage(format!(
            "{first} and {origin} are the same file, {shown}: name another one"
        )));
    }
    ledger.written.insert(origin, (id, written));
    Ok(())
}

/// The input that a result at this path would replace, with its purpose.
pub fn input_at(path: &Path) -> Option<String> {
    ledger().read.get(&identity(path)?).cloned()
}

fn refusal(written: &str, read: &str) -> CliError {
    CliError::Usage(format!("{written} would replace {read}: name another file"))
}
