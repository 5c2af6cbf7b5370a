//! Paths to which a plan may write its picture: those in its own folder. A plan may come from
//! anyone, and the user who merges it has not chosen where it writes.

use phalanx_files::folder_of;
use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf, absolute};

const OUTSIDE: &str = "lies outside the plan's folder";

/// The path of a picture that a plan in the file `plan` names `output`. An error gives the reason
/// why the plan may not write there.
pub(super) fn allowed(plan: &Path, output: &Path) -> Result<PathBuf, &'static str> {
    let folder = folder_of(plan);
    // Without a leading `./` if the plan's folder is the current one.
    let path = plan.with_file_name(output);
    if path.file_name().is_none() {
        return Err("is no name of a file");
    }
    match real(&path) {
        Ok(real) => {
            let home = folder.canonicalize();
            if !home.is_ok_and(|home| real.starts_with(home)) {
                return Err(OUTSIDE);
            }
            // A plan may not choose a pipe or a device that exists there either.
            match fs::metadata(&real) {
                Ok(metadata) if !metadata.is_file() => Err("is no regular file"),
                _ => Ok(path),
            }
        }
        // Nothing can be written there, which the attempt to write will report. The path is allowed
        // if it is in the folder.
        Err(_) if descends(output) && !path.is_symlink() => Ok(path),
        Err(_) => Err(OUTSIDE),
    }
}

/// The name of the picture `output` in a plan in the file `plan`: relative to the plan's folder
/// where it lies in that, else absolute. A plan with an absolute path is merged only by a user who
/// names the picture again.
///
/// # Errors
/// The system cannot determine where they are.
pub fn kept_output(plan: &Path, output: &Path) -> io::Result<PathBuf> {
    let output = absolute(output)?;
    let home = folder_of(plan).canonicalize()?;
    let inside = real(&output).ok();
    let inside = inside.and_then(|real| Some(real.strip_prefix(&home).ok()?.to_path_buf()));
    // A link to a picture is stored by the link's name, because its target may change.
    let name = match inside {
        Some(_) if output.is_symlink() => {
            let folder = folder_of(&output).canonicalize()?;
            let seen = folder.strip_prefix(&home).ok();
            seen.zip(output.file_name())
                .map(|(folder, name)| folder.join(name))
        }
        inside => inside,
    };
    Ok(name.unwrap_or(output))
}

/// The path that writing to `path` would write to, with links followed.
fn real(path: &Path) -> io::Result<PathBuf> {
    if fs::symlink_metadata(path).is_ok() {
        return path.canonicalize();
    }
    let name = path.file_name().unwrap_or_default();
    Ok(folder_of(path).canonicalize()?.join(name))
}

fn descends(path: &Path) -> bool {
    let normal = |part| matches!(part, Component::Normal(_) | Component::CurDir);
    path.components().all(normal)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn a_plan_sends_its_picture_nowhere_but_into_its_folder() {
        let room = tempfile::tempdir().unwrap();
        let path_of = |name: &str| room.path().join(name);
        for folder in ["job/in", "job/deep", "else"] {
            fs::create_dir_all(path_of(folder)).unwrap();
        }
        fs::write(path_of("job/old.png"), "").unwrap();
        fs::write(path_of("else/old.png"), "").unwrap();
        symlink(path_of("else"), path_of("job/out")).unwrap();
        symlink("../else/old.png", path_of("job/linked.png")).unwrap();
        symlink("../else/new.png", path_of("job/dangling.png")).unwrap();
        symlink("old.png", path_of("job/inner.png")).unwrap();
        symlink("in", path_of("job/within")).unwrap();
        let plan = path_of("job/p.json");
        let inside = path_of("job/x.png");
        for good in [
            "x.png",
            "old.png",
            "./x.png",
            "in/x.png",
            "inner.png",
            "within/x.png",
            "in/../x.png",
            "../job/x.png",
            inside.to_str().unwrap(),
            "nowhere/x.png",
        ] {
            let path = allowed(&plan, Path::new(good));
            assert_eq!(path, Ok(path_of("job").join(good)), "{good}");
        }
        let outside = path_of("else/x.png");
        for bad in [
            "../x.png",
            "../else/old.png",
            "in/../../x.png",
            outside.to_str().unwrap(),
            "/x.png",
            "/dev/null",
            "out/x.png",
            "out/old.png",
            "linked.png",
            "dangling.png",
            "../nowhere/x.png",
            "/nowhere/x.png",
            "out/../../x.png",
            "..",
            "/",
            "in/..",
        ] {
            assert!(allowed(&plan, Path::new(bad)).is_err(), "{bad}");
        }
        let pipe = path_of("job/pipe.png");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        assert!(allowed(&plan, Path::new("pipe.png")).is_err());
    }

    #[test]
    fn pictures_in_the_folder_are_named_from_there_and_others_absolutely() {
        let room = tempfile::tempdir().unwrap();
        let path_of = |name: &str| room.path().join(name);
        for folder in ["job/in", "else"] {
            fs::create_dir_all(path_of(folder)).unwrap();
        }
        fs::write(path_of("job/old.png"), "").unwrap();
        symlink("../else/new.png", path_of("job/dangling.png")).unwrap();
        symlink("old.png", path_of("job/inner.png")).unwrap();
        let plan = path_of("job/p.json");
        for (name, expected) in [
            ("job/x.png", "x.png"),
            ("job/old.png", "old.png"),
            ("job/in/x.png", "in/x.png"),
            ("job/in/../x.png", "x.png"),
            ("else/../job/x.png", "x.png"),
            ("job/inner.png", "inner.png"),
        ] {
            let actual = kept_output(&plan, &path_of(name)).unwrap();
            assert_eq!(actual, Path::new(expected), "{name}");
            assert!(allowed(&plan, &actual).is_ok(), "{name}");
        }
        for name in ["x.png", "else/x.png", "job/dangling.png", "nowhere/x.png"] {
            let actual = kept_output(&plan, &path_of(name)).unwrap();
            assert_eq!(actual, path_of(name));
            assert!(allowed(&plan, &actual).is_err(), "{name}");
        }
    }
}
