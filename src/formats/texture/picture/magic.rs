//! Kinds of pictures, identified by their first bytes.

/// First bytes of a PNG.
pub(super) const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";
/// First bytes of a JPEG.
pub(super) const JPEG: &[u8] = b"\xff\xd8\xff";
/// First bytes of a BMP.
pub(super) const BMP: &[u8] = b"BM";

/// Returns true for the first bytes of a WebP.
pub(super) fn is_webp(bytes: &[u8]) -> bool {
    bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP")
}

/// First bytes of unsupported kinds of pictures, and their names.
const UNREAD: [(&[u8], &str); 24] = [
    (b"GIF87a", "a GIF picture"),
    (b"GIF89a", "a GIF picture"),
    (b"DDS ", "a DDS picture"),
    (b"\xabKTX 20", "a KTX2 picture"),
    (b"\xabKTX 11", "a KTX picture"),
    (b"II*\0", "a TIFF picture"),
    (b"MM\0*", "a TIFF picture"),
    (b"II+\0", "a TIFF picture"),
    (b"MM\0+", "a TIFF picture"),
    (b"#?RADIANCE", "an HDR picture"),
    (b"#?RGBE", "an HDR picture"),
    (b"\x76\x2f\x31\x01", "an OpenEXR picture"),
    (b"8BPS", "a Photoshop picture"),
    (b"\0\0\0\x0cjP  ", "a JPEG 2000 picture"),
    (b"\xff\x4f\xff\x51", "a JPEG 2000 picture"),
    (b"\0\0\0\x0cJXL ", "a JPEG XL picture"),
    (b"\xff\x0a", "a JPEG XL picture"),
    (b"qoif", "a QOI picture"),
    (b"P5", "a PGM picture"),
    (b"P6", "a PPM picture"),
    (b"\x01\xda", "an SGI picture"),
    (b"\0\0\x01\0", "an icon (ICO)"),
    (b"<svg", "an SVG drawing"),
    (b"<?xml", "an XML file"),
];

/// Identifies bytes that are not a picture of a supported kind.
pub(super) fn refusal(bytes: &[u8]) -> String {
    let unread = UNREAD.iter().find(|(magic, _)| bytes.starts_with(magic));
    let brand = bytes.get(4..8) == Some(b"ftyp");
    let name = match unread {
        Some((_, name)) => name,
        None if brand && bytes.get(8..12) == Some(b"avif") => "an AVIF picture",
        None if brand => "a HEIC picture",
        None if bytes.is_empty() => return "it is empty".into(),
        None => {
            return "it is not a picture of a kind that is read: PNG, JPEG, TGA, BMP or WebP"
                .into();
        }
    };
    format!("it is {name}, which is not read: convert it to PNG")
}
