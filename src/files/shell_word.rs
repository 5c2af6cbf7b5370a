//! Words of command lines that are printed to be copied.

use super::shown_path::steers;
use std::borrow::Cow;
use std::ffi::OsStr;
use std::path::Path;
use std::str::{self, Utf8Chunk};

/// A word of a command line, as bash, zsh and ksh read it. The text is one line without characters
/// that [steer](steers) the display: a word that has some, or is not valid UTF-8, becomes `$'…'`.
pub fn shell_word(word: impl AsRef<OsStr>) -> String {
    let bytes = word.as_ref().as_encoded_bytes();
    let plain = |c: char| c.is_alphanumeric() || "-_.,:/=+".contains(c);
    match str::from_utf8(bytes) {
        // zsh replaces =NAME by the path of a program.
        Ok(text) if !text.is_empty() && !text.starts_with('=') && text.chars().all(plain) => {
            return text.to_owned();
        }
        Ok(text) if !text.contains(steers) => return format!("'{}'", text.replace('\'', r"'\''")),
        _ => {}
    }
    let octal = |bytes: &[u8]| -> String { bytes.iter().map(|b| format!("\\{b:03o}")).collect() };
    let escaped = |c: char| match c {
        '\'' | '\\' => format!("\\{c}"),
        c if steers(c) => octal(c.encode_utf8(&mut [0; 4]).as_bytes()),
        c => c.to_string(),
    };
    let escape = |chunk: Utf8Chunk| {
        let valid: String = chunk.valid().chars().map(escaped).collect();
        valid + &octal(chunk.invalid())
    };
    format!("$'{}'", bytes.utf8_chunks().map(escape).collect::<String>())
}

/// A path that a program does not read as an option.
pub fn operand(path: &Path) -> Cow<'_, Path> {
    match path.as_os_str().as_encoded_bytes() {
        [b'-', _, ..] => Path::new(".").join(path).into(),
        _ => path.into(),
    }
}

/// A path as a word of a command line.
pub fn shell_path(path: impl AsRef<Path>) -> String {
    shell_word(operand(path.as_ref()).as_os_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ordinary_words_are_not_quoted_and_all_others_are() {
        for plain in [
            "a-b.test",
            "--ortho=3.5",
            "-4,1,2",
            "standard:tree:3",
            "/a/ä_1+2.obj",
            "-",
        ] {
            assert_eq!(shell_word(plain), plain);
        }
        for (word, quoted) in [
            ("kd=1 ks=.5", "'kd=1 ks=.5'"),
            ("it's", r"'it'\''s'"),
            ("", "''"),
            ("=ls.test", "'=ls.test'"),
            ("~/a", "'~/a'"),
            ("a\u{3}\nb'\\\u{202e}ä", r"$'a\003\012b\'\\\342\200\256ä'"),
        ] {
            assert_eq!(shell_word(word), quoted);
        }
        assert_eq!(shell_path("-x.test"), "./-x.test");
        assert_eq!(shell_path("--output=y z"), "'./--output=y z'");
        assert_eq!(shell_path("a/-x"), "a/-x");
        assert_eq!(shell_path("-"), "-");
    }

    /// Checks that shells read back the bytes of a word.
    #[cfg(unix)]
    #[test]
    fn shells_read_the_word_that_was_meant() {
        use std::os::unix::ffi::OsStrExt;
        use std::process::Command;
        for shell in ["bash", "zsh"] {
            for odd in [
                &b"/a b/it's $HOME/50%;`id`\"\\!*?#"[..],
                b"=ls",
                b"a\x03\nrm -rf b\r\x1b[2J'\\7",
                b"\xff\xfe0 \xe2\x80",
                "\u{202e}ä0\u{85}1".as_bytes(),
            ] {
                let line = format!("printf %s {}", shell_word(OsStr::from_bytes(odd)));
                assert!(!line.contains(char::is_control), "{line:?}");
                // A machine may have only one of the shells.
                if let Ok(output) = Command::new(shell).args(["-c", &line]).output() {
                    assert_eq!(output.stdout, odd, "{shell}: {line}");
                }
            }
        }
    }
}
