//! Headers of OpenEXR files: channels, and the attributes that other programs read.

use super::description::{BAND_ROWS, Crop, PictureFile};
use super::header::SOFTWARE;
use exr::math::{RoundingMode, Vec2};
use exr::meta::BlockDescription;
use exr::meta::attribute::{
    AttributeValue, ChannelDescription, LevelMode, LineOrder, SampleType, Text, TileDescription,
};
use exr::meta::header::Header;
use exr::prelude::{Compression, SmallVec};
use phalanx_scene::film::Aov;
use phalanx_scene::matte_id;
use serde_json::{Map, Value};
use std::io::{self, Cursor};

/// Side of a tile in pixels. Heights of bands are multiples of it, so that no tile is in two bands.
pub(super) const TILE: usize = BAND_ROWS as usize;

/// A channel of the file: its name, the type of its samples, and the index of its plane in a film.
pub(super) type ExrChannel = (&'static str, SampleType, usize);

/// Name of the attribute for the scene's origin in the coordinates of its file, as three decimals,
/// in a picture file with positions. Far from the origin, positions in the file's coordinates are
/// rounded to single precision; positions in the scene were not.
const ORIGIN: &str = "phalanx.origin";

/// Name of the attribute for the scene's name.
const SCENE: &str = "phalanx.scene";

/// Name of the attribute for the command that renders the picture.
const COMMAND: &str = "phalanx.command";

/// A text of any characters: attributes are UTF-8.
fn text(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}

/// The header of a file.
pub(super) fn header(file: &PictureFile, channels: &[ExrChannel]) -> Header {
    let channel = |&(name, sample_type, _): &ExrChannel| ChannelDescription {
        name: Text::from(name),
        sample_type,
        quantize_linearly: false,
        sampling: Vec2(1, 1),
    };
    let blocks = BlockDescription::Tiles(TileDescription {
        tile_size: Vec2(TILE, TILE),
        level_mode: LevelMode::Singular,
        rounding_mode: RoundingMode::Down,
    });
    let size = Vec2(file.width as usize, file.height as usize);
    let name = Text::default();
    let mut header = Header::new(name, size, channels.iter().map(channel).collect()).with_encoding(
        Compression::ZIP16,
        blocks,
        LineOrder::Increasing,
    );
    if let Some(Crop {
        corner,
        of: picture,
    }) = file.crop
    {
        let [x, y] = [corner.0, corner.1].map(|place| place as i32);
        header.own_attributes.layer_position = Vec2(x, y);
        header.shared_attributes.display_window.size = Vec2(picture.0 as usize, picture.1 as usize);
    }
    header.own_attributes.layer_name = None;
    header.shared_attributes.pixel_aspect = 1.0;
    let own = &mut header.own_attributes;
    own.software_name = Some(text(SOFTWARE));
    if let Some([camera, ndc]) = file.header.matrices {
        own.world_to_camera = Some(camera);
        own.world_to_normalized_device = Some(ndc);
    }
    for (name, value) in attributes(file) {
        let value = AttributeValue::Text(text(&value));
        own.other.insert(text(&name), value);
    }
    header
}

/// Further attributes, each with its text.
fn attributes(file: &PictureFile) -> Vec<(String, String)> {
    let header = &file.header;
    let mut all = vec![
        (SCENE.to_owned(), header.scene.clone()),
        (COMMAND.to_owned(), header.command.clone()),
    ];
    all.retain(|(_, text)| !text.is_empty());
    if file.origin != [0.0; 3] {
        let [x, y, z] = file.origin;
        all.push((ORIGIN.to_owned(), format!("{x} {y} {z}")));
    }
    for (aov, layer, names) in [
        (Aov::CryptoObject, "CryptoObject", &header.objects),
        (Aov::CryptoMaterial, "CryptoMaterial", &header.materials),
    ] {
        if file.aovs.has(aov) {
            all.extend(cryptomatte(layer, names));
        }
    }
    all
}

/// The attributes of a layer of identifiers, as in the Cryptomatte specification 1.2.0: the names
/// of its channels begin with the name of the layer.
fn cryptomatte(layer: &str, names: &[String]) -> Vec<(String, String)> {
    // Seven of the eight digits of the name's hash.
    let key = format!("cryptomatte/{:07x}", matte_id(layer) >> 4);
    let mut all = vec![
        (format!("{key}/name"), layer.to_owned()),
        (format!("{key}/hash"), "MurmurHash3_32".to_owned()),
        (format!("{key}/conversion"), "uint32_to_float32".to_owned()),
    ];
    if !names.is_empty() {
        let id = |name: &String| (name.clone(), format!("{:08x}", matte_id(name)).into());
        let manifest: Map<String, Value> = names.iter().map(id).collect();
        let manifest = Value::Object(manifest).to_string();
        all.push((format!("{key}/manifest"), manifest));
    }
    all
}

/// The first bytes of a file with this header, with its attributes sorted by name, as in OpenEXR.
/// The crate writes them in an order that differs from run to run.
pub(super) fn sorted_header(header: &Header) -> io::Result<Vec<u8>> {
    let mut file = Cursor::new(Vec::new());
    let headers = SmallVec::from_iter([header.clone()]);
    let written = exr::block::write(&mut file, headers, true, |_, _| {
        Err(exr::error::Error::Aborted)
    });
    match written {
        Err(exr::error::Error::Aborted) | Ok(()) => {}
        Err(error) => return Err(io::Error::other(error)),
    }
    let bytes = file.into_inner();
    let sorted = sort_attributes(&bytes);
    sorted.ok_or_else(|| io::Error::other("the encoder writes another head"))
}

/// Bytes of the magic number and the version, which the attributes follow.
const PREFIX: usize = 8;

/// The bytes of a header up to its end, with sorted attributes; `None` if it is cut short.
fn sort_attributes(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut rest = bytes.get(PREFIX..)?;
    let mut attributes = Vec::new();
    // Each is a name, a type, the length of its value, and its value. An empty name ends them.
    while *rest.first()? != 0 {
        let name = rest.iter().position(|&b| b == 0)?;
        let kind = rest[name + 1..].iter().position(|&b| b == 0)?;
        let length = name + kind + 2;
        let value = u32::from_le_bytes(*rest.get(length..)?.first_chunk()?) as usize;
        let (attribute, later) = rest.split_at_checked(length + 4 + value)?;
        attributes.push((&attribute[..name], attribute));
        rest = later;
    }
    attributes.sort_unstable();
    let mut sorted = bytes[..PREFIX].to_vec();
    for (_, attribute) in attributes {
        sorted.extend_from_slice(attribute);
    }
    sorted.push(0);
    Some(sorted)
}

#[cfg(test)]
mod tests {
    use super::super::test_film::PLAIN_EXR;
    use super::*;
    use crate::PictureHeader;
    use phalanx_scene::film::Aovs;

    const RED: &[ExrChannel] = &[("R", SampleType::F32, 0)];

    #[test]
    fn only_a_moved_scene_has_its_origin_in_the_header() {
        let far = PictureFile {
            origin: [500_000.5, 0.0, -4e6],
            ..PLAIN_EXR
        };
        let description = |file: &PictureFile| {
            let header = header(file, RED);
            let value = header
                .own_attributes
                .other
                .get(&Text::from(ORIGIN))
                .cloned();
            value.map(|value| value.into_text().unwrap().to_string())
        };
        assert_eq!(description(&far).as_deref(), Some("500000.5 0 -4000000"));
        let near = PictureFile {
            origin: [0.0; 3],
            ..far.clone()
        };
        assert_eq!(description(&near), None);
    }

    #[test]
    fn attributes_are_sorted_and_the_same_each_time() {
        let file = PictureFile {
            aovs: Aovs::all(),
            origin: [1.0, 2.0, 3.0],
            header: PictureHeader {
                scene: "ä.test".to_owned(),
                command: "phalanx render".to_owned(),
                matrices: Some([[1.0; 16], [2.0; 16]]),
                objects: vec!["sphere0".to_owned()],
                materials: vec!["hello".to_owned(), "b".to_owned()],
            },
            ..PLAIN_EXR
        };
        let first = sorted_header(&header(&file, RED)).unwrap();
        for _ in 0..8 {
            assert!(sorted_header(&header(&file, RED)).unwrap() == first);
        }
        assert_eq!(sort_attributes(&first).as_ref(), Some(&first));
        assert_eq!(sort_attributes(&first[..first.len() - 1]), None);
        let has = |text: &str| memchr::memmem::find(&first, text.as_bytes()).is_some();
        for text in [
            "phalanx.scene\0string\0\u{7}\0\0\0ä.test",
            "\"hello\":\"248bfa47\"",
            "worldToCamera\0m44f\0",
            "worldToNDC\0m44f\0",
        ] {
            assert!(has(text), "{text:?}");
        }
    }
}
