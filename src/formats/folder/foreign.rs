//! Files that replace others: compressed, stored elsewhere, or never downloaded.

/// First bytes of compressed files, and the programs that made them. Those of gzip include its only
/// method: many buffers of numbers begin with the first two bytes.
const PACKED: [(&[u8], &str); 6] = [
    (b"\x1f\x8b\x08", "compressed with gzip"),
    (b"\x28\xb5\x2f\xfd", "compressed with zstd"),
    (b"\xfd7zXZ\0", "compressed with xz"),
    (b"BZh", "compressed with bzip2"),
    (b"PK\x03\x04", "a ZIP archive"),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive"),
];

/// First bytes of pictures and scenes, the ending of such files, and their names.
const OTHERS: [(&[u8], &str, &str); 5] = [
    (b"\x89PNG\r\n\x1a\n", "png", "a PNG picture, not a scene"),
    (b"\xff\xd8\xff", "jpg", "a JPEG picture, not a scene"),
    (b"glTF", "glb", "binary glTF: its name should end in .glb"),
    (b"ply\n", "ply", "a PLY file: its name should end in .ply"),
    (b"ply\r", "ply", "a PLY file: its name should end in .ply"),
];

/// Identifies a file of another kind than those with these endings. Texts of all formats, and the
/// headers of binary STL, begin in other ways.
pub(crate) fn other_kind(bytes: &[u8], endings: &[&str]) -> Option<String> {
    let mut others = (OTHERS.iter()).filter(|(_, ending, _)| !endings.contains(ending));
    let (_, _, what) = others.find(|(magic, ..)| bytes.starts_with(magic))?;
    Some(format!("it is {what}"))
}

/// Identifies bytes that are neither a scene nor a part of one.
pub fn refusal(bytes: &[u8]) -> Option<String> {
    let packed = PACKED.iter().find(|(magic, _)| bytes.starts_with(magic));
    if let Some((_, what)) = packed {
        return Some(format!("it is {what}: unpack it first"));
    }
    if bytes.starts_with(b"version https://git-lfs") {
        let words =
            "it stands for a file that is kept elsewhere (Git LFS): fetch it with `git lfs pull`";
        return Some(words.to_owned());
    }
    let text = bytes.trim_ascii_start();
    let is_tag = |tag: &[u8]| {
        let head = text.get(..tag.len());
        head.is_some_and(|head| head.eq_ignore_ascii_case(tag))
    };
    let is_page = is_tag(b"<!doctype html") || is_tag(b"<html");
    is_page.then(|| "it is a web page: download the file itself".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of a buffer: the first is 1f 8b 00 3f as bytes, which gzip does not begin with.
    #[test]
    fn numbers_that_begin_like_a_packed_file_are_numbers() {
        let numbers = f32::from_bits(0x3f00_8b1f).to_le_bytes();
        assert_eq!(refusal(&numbers), None);
        assert_eq!(refusal(b" \n\x1f\x8b\x08"), None);
        assert_eq!(refusal(b"bzh is a word of a comment"), None);
    }
}
