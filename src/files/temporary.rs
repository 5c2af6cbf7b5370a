//! Temporary files next to their final place, and leftovers of killed runs.
//!
//! A temporary file is locked while its process lives, and the system unlocks it however the
//! process ends, so one that can be locked is a leftover. Its name includes the machine's, because
//! a lock on a shared disk may apply only to the processes of one machine.

use super::folder::folder_of;
use std::fs::{self, File, Permissions, TryLockError};
use std::io;
use std::path::Path;
use tempfile::{Builder, NamedTempFile};

const PREFIX: &str = ".phalanx-";
const SUFFIX: &str = ".part";
/// Number of letters and digits that make a name unique.
const RANDOM: usize = 6;
/// Number of attempts to create a file that is not mistaken for a leftover before it is locked.
const ATTEMPTS: usize = 100;

/// A new file in the folder of a path, with these permissions less the umask.
pub(super) fn create(path: &Path, permissions: Option<Permissions>) -> io::Result<NamedTempFile> {
    let prefix = format!("{PREFIX}{}", host());
    let mut builder = Builder::new();
    builder.prefix(&prefix).suffix(SUFFIX).rand_bytes(RANDOM);
    if let Some(permissions) = permissions {
        builder.permissions(permissions);
    }
    for _ in 0..ATTEMPTS {
        let file = builder.tempfile_in(folder_of(path))?;
        match file.as_file().try_lock() {
            Err(TryLockError::WouldBlock) => continue,
            // Without locks, leftovers are not removed either.
            Err(TryLockError::Error(_)) => return Ok(file),
            Ok(()) if file.path().exists() => return Ok(file),
            Ok(()) => {}
        }
    }
    Err(io::Error::other(
        "temporary files disappear as they are made",
    ))
}

/// Removes leftovers of killed runs on this machine next to a path, as far as possible.
pub(super) fn remove_leftovers(path: &Path) {
    let Ok(entries) = fs::read_dir(folder_of(path)) else {
        return;
    };
    let host = host();
    for entry in entries.flatten() {
        let name = entry.file_name();
        let ours = name.to_str().is_some_and(|name| is_ours(name, &host));
        if ours && entry.file_type().is_ok_and(|kind| kind.is_file()) {
            let path = entry.path();
            // Held until the file is gone, so that no process locks it in the meantime.
            if let Ok(file) = File::open(&path)
                && file.try_lock().is_ok()
            {
                let _ = fs::remove_file(&path);
            }
        }
    }
}

/// Returns true for the name of a temporary file of this machine, or of none.
fn is_ours(name: &str, host: &str) -> bool {
    let name = name
        .strip_prefix(PREFIX)
        .and_then(|name| name.strip_suffix(SUFFIX));
    let random = name.map(|name| name.strip_prefix(host).unwrap_or(name));
    random.is_some_and(|random| {
        random.len() == RANDOM && random.bytes().all(|byte| byte.is_ascii_alphanumeric())
    })
}

/// The machine's name and a hyphen, shortened to fit file names; empty if it has none.
fn host() -> String {
    let name = fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let plain = |c: &char| c.is_ascii_alphanumeric() || *c == '-';
    let name: String = name.chars().filter(plain).take(64).collect();
    if name.is_empty() { name } else { format!("{name}-") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leftovers_are_removed_and_files_in_use_are_not() {
        let folder = tempfile::tempdir().unwrap();
        let path_of = |name: &str| folder.path().join(name);
        let used = create(&path_of("a.png"), None).unwrap();
        let left = create(&path_of("a.png"), None).unwrap();
        let left = left.into_temp_path().keep().unwrap();
        let others = [
            "a.png",
            ".phalanx-abc.part",
            ".phalanx-abcdef.png",
            ".phalanx-elsewhere-abcdef.part",
            ".other-abcdef.part",
        ];
        for name in others.iter().chain(&[".phalanx-abcdef.part"]) {
            fs::write(path_of(name), "").unwrap();
        }
        fs::create_dir(path_of(".phalanx-ghijkl.part")).unwrap();
        remove_leftovers(&path_of("a.png"));
        assert!(used.path().exists() && path_of(".phalanx-ghijkl.part").exists());
        assert!(!left.exists() && !path_of(".phalanx-abcdef.part").exists());
        assert!(others.iter().all(|name| path_of(name).exists()));
        drop(used);
        remove_leftovers(&path_of("nowhere/a.png"));
    }
}
