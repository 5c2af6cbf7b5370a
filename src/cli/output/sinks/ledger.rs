//! The files that this process reads and writes. No output replaces an input or another output.
//!
//! Files are compared by device and inode on Unix, elsewhere by canonical name, so that different
//! names and links are recognised. Pipes and devices are not compared. A file that a command
//! resumes from (finished tiles, a list of frames) is recorded only as an output.

use super::stdout::is_dash;
use crate::cli::output::error::CliError;
use phalanx::files::{Destination, shown_path};
use phalanx::formats::foreign;
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
    /// Purpose and name of each input, for messages, by its identity.
    read: BTreeMap<PathBuf, String>,
    /// Identity of each output, with option and name for messages, by the option.
    written: BTreeMap<&'static str, (PathBuf, String)>,
}

fn ledger() -> MutexGuard<'static, Ledger> {
    LEDGER.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The identity of a regular file: device and inode on Unix, elsewhere its canonical name.
fn identity(path: &Path) -> Option<PathBuf> {
    let file = path.metadata().ok()?;
    #[cfg(unix)]
    let id = format!("{} {}", file.dev(), file.ino()).into();
    #[cfg(not(unix))]
    let id = path.canonicalize().ok()?;
    file.is_file().then_some(id)
}

/// Number of bytes needed to recognise a compressed file, or a placeholder for another file.
const HEAD: u64 = 64;

/// Up to `most` first bytes of a regular file; empty if it cannot be read.
fn first_bytes(path: &Path, most: u64) -> Vec<u8> {
    let mut head = Vec::new();
    if path.is_file() {
        _ = File::open(path).and_then(|file| file.take(most).read_to_end(&mut head));
    }
    head
}

/// Records an input, with its purpose for messages. Refuses one that an output would replace, and
/// one that is compressed or a placeholder.
pub fn reads(what: &str, path: &Path) -> Result<(), CliError> {
    let Some(id) = identity(path) else {
        return Ok(());
    };
    // The file's reader reports other errors.
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

/// Records an output, named by the option `origin`; refuses one that replaces an input or another
/// option's output. An option has one file at a time, so that a sequence can write one after
/// another.
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
        let message = format!("{first} and {origin} are the same file, {shown}: choose another");
        return Err(CliError::Usage(message));
    }
    ledger.written.insert(origin, (id, written));
    Ok(())
}

/// The input, with its purpose, or another program's picture that a default output would replace.
pub fn taken(path: &Path) -> Option<String> {
    let input = identity(path).and_then(|id| ledger().read.get(&id).cloned());
    input.or_else(|| foreign_picture(path))
}

/// The path, with `-render` appended to its stem until it is not `taken`, and what has it.
pub fn free_path(
    path: &Path,
    taken: impl Fn(&Path) -> Option<String>,
) -> (PathBuf, Option<String>) {
    let mut free = path.to_path_buf();
    while taken(&free).is_some() {
        let [stem, ending] = [free.file_stem(), free.extension()].map(Option::unwrap_or_default);
        free = format!("{}-render.{}", stem.display(), ending.display()).into();
    }
    (free, taken(path))
}

/// A description of a PNG at this path that another program wrote, such as a texture whose name a
/// cache does not record. PNGs of this program name it before their pixels.
fn foreign_picture(path: &Path) -> Option<String> {
    let head = first_bytes(path, 4096);
    let ours = head.windows(8).any(|word| word == b"phalanx ");
    (head.starts_with(b"\x89PNG") && !ours).then(|| "a picture from another program".to_owned())
}

fn refusal(written: &str, read: &str) -> CliError {
    CliError::Usage(format!(
        "{written} would overwrite {read}: choose another file"
    ))
}
