//! Chunks, buffers and URIs as written by other programs.

use super::{File, base64, messages, read};
use phalanx::formats::{Options, load};
use serde_json::json;

/// A GLB with these chunks and its length in the header.
fn glb(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
    let word = |n: usize| (n as u32).to_le_bytes();
    let mut out = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    for (kind, body) in chunks {
        out.extend(word(body.len()));
        out.extend(*kind);
        out.extend(*body);
    }
    let length = word(out.len());
    out[8..12].copy_from_slice(&length);
    out
}

fn document(file: &File) -> Vec<u8> {
    let mut json = file.json.clone();
    json["buffers"] = json!([{"byteLength": file.buffer.len()}]);
    json.to_string().into_bytes()
}

fn has_a_triangle(bytes: &[u8]) -> Vec<String> {
    let loaded = read("glb", bytes).unwrap_or_else(|errors| panic!("{errors:?}"));
    assert_eq!(loaded.scene.prim_count(), 1);
    messages(&loaded.warnings)
        .into_iter()
        .map(str::to_owned)
        .collect()
}

#[test]
fn chunks_may_be_padded_with_zeros() {
    let file = File::triangle();
    let mut json = document(&file);
    json.extend([0; 5]);
    let mut buffer = file.buffer.clone();
    buffer.extend([0; 3]);
    assert!(has_a_triangle(&glb(&[(b"JSON", &json), (b"BIN\0", &buffer)])).is_empty());
    // The text alone, too.
    let mut text = file.text().into_bytes();
    text.extend(b" \n\0\0");
    assert!(has_a_triangle(&text).is_empty());
}

#[test]
fn bytes_after_the_chunks_are_ignored() {
    let file = File::triangle();
    let (json, buffer) = (document(&file), &file.buffer);
    let chunks: [(&[u8; 4], &[u8]); 2] = [(b"JSON", &json), (b"BIN\0", buffer)];
    let mut after = glb(&chunks);
    after.extend(b"anything at all");
    assert!(has_a_triangle(&after).is_empty());
    // Counted in the length, or a length that counts too much.
    let word = (after.len() as u32).to_le_bytes();
    after[8..12].copy_from_slice(&word);
    assert!(has_a_triangle(&after).is_empty());
    let mut longer = glb(&chunks);
    longer[8..12].copy_from_slice(&[0xff; 4]);
    assert!(has_a_triangle(&longer).is_empty());
    // Chunks of extensions, before the buffer and after it.
    let others = glb(&[
        (b"JSON", &json),
        (b"ABCD", &[1; 12]),
        (b"BIN\0", buffer),
        (b"EFGH", &[]),
    ]);
    assert!(has_a_triangle(&others).is_empty());
}

#[test]
fn a_chunk_whose_padding_is_not_counted() {
    let file = File::triangle();
    let mut json = document(&file);
    while json.len() % 4 != 3 {
        json.push(b' ');
    }
    let mut bytes = b"glTF\x02\0\0\0\0\x10\0\0".to_vec();
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(&json);
    bytes.push(0);
    bytes.extend((file.buffer.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(&file.buffer);
    assert!(has_a_triangle(&bytes).is_empty());
}

/// Not an error as long as nothing reads beyond the existing bytes.
#[test]
fn a_buffer_that_is_shorter_than_it_says() {
    let mut file = File::triangle();
    let json = document(&file);
    file.buffer.truncate(36);
    let json = String::from_utf8(json)
        .unwrap()
        .replace("\"byteLength\":36}]", "\"byteLength\":40}]");
    let result = has_a_triangle(&glb(&[
        (b"JSON", json.as_bytes()),
        (b"BIN\0", &file.buffer),
    ]));
    assert!(
        result.len() == 1 && result[0].contains("it should have 40 bytes, but has 36"),
        "{result:?}"
    );
}

#[test]
fn data_uris_of_all_kinds() {
    let mut file = File::triangle();
    // Bytes whose text has both letters that URIs like to avoid.
    file.buffer.extend([0xfb, 0xff, 0xfe, 0]);
    let text = base64(&file.buffer);
    assert!(text.contains('+') && text.contains('/'));
    let with = |uri: String| {
        let mut json = file.json.clone();
        json["buffers"] = json!([{"byteLength": file.buffer.len(), "uri": uri}]);
        read("gltf", json.to_string().as_bytes())
    };
    let percent: String = file
        .buffer
        .iter()
        .map(|byte| format!("%{byte:02x}"))
        .collect();
    for uri in [
        format!("data:;base64,{text}"),
        format!("data:application/gltf-buffer;base64,{text}"),
        format!("data:text/plain;charset=utf-8;base64,{text}"),
        format!("DATA:Application/Octet-Stream;BASE64,{text}"),
        format!("data:;base64,{}", text.trim_end_matches('=')),
        format!("data:;base64,{}", text.replace('+', "-").replace('/', "_")),
        format!(
            "data:;base64,{}",
            text.replace('+', "%2B")
                .replace('/', "%2f")
                .replace('=', "%3D")
        ),
        format!("data:;base64,{}\n{}", &text[..20], &text[20..]),
        format!("data:application/octet-stream,{percent}"),
    ] {
        let loaded = with(uri.clone()).unwrap_or_else(|errors| panic!("{uri}: {errors:?}"));
        assert_eq!(loaded.scene.prim_count(), 1, "{uri}");
        assert!(loaded.warnings.is_empty(), "{uri}: {:?}", loaded.warnings);
    }
    let broken = with("data:;base64,A?AA".into())
        .map(|_| ())
        .expect_err("broken");
    assert!(
        broken[0].message.contains("base64 text is broken"),
        "{broken:?}"
    );
    assert!(with("data:".into()).is_err() && with("da".into()).is_err());
}

#[test]
fn names_of_files_may_be_escaped_or_look_so() {
    let folder = tempfile::tempdir().unwrap();
    let file = File::triangle();
    let path = folder.path().join("scene.gltf");
    let read = |name: &str, uri: &str| {
        std::fs::write(folder.path().join(name), &file.buffer).unwrap();
        let mut json = file.json.clone();
        json["buffers"] = json!([{"byteLength": file.buffer.len(), "uri": uri}]);
        std::fs::write(&path, json.to_string()).unwrap();
        let loaded = load(&path, &Options::default());
        std::fs::remove_file(folder.path().join(name)).unwrap();
        loaded.map(|loaded| loaded.scene.prim_count())
    };
    for (name, uri) in [
        ("a b.bin", "a%20b.bin"),
        ("a b.bin", "a b.bin"),
        ("größe.bin", "gr%C3%B6%c3%9fe.bin"),
        ("größe.bin", "größe.bin"),
        ("100%.bin", "100%.bin"),
        ("a%20b.bin", "a%20b.bin"),
        ("a+b.bin", "a+b.bin"),
        ("a.bin", "./a.bin"),
    ] {
        let triangles = read(name, uri).unwrap_or_else(|error| panic!("{uri}: {error}"));
        assert_eq!(triangles, 1, "{uri}");
    }
    assert!(read("x.bin", "y.bin").is_err());
}

/// Compressed data, with the same data also uncompressed.
#[test]
fn the_fallback_of_compressed_views_is_read() {
    let mut file = File::triangle();
    file.json["bufferViews"][0]["extensions"] = json!({"EXT_meshopt_compression": {"buffer": 1}});
    file.json["extensionsUsed"] = json!(["EXT_meshopt_compression"]);
    let loaded = file.loaded();
    assert_eq!(loaded.scene.prim_count(), 1);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let mut json = file.json.clone();
    json["buffers"] =
        json!([{"byteLength": 36, "extensions": {"EXT_meshopt_compression": {"fallback": true}}}]);
    let refused = read("gltf", json.to_string().as_bytes())
        .map(|_| ())
        .expect_err("no bytes");
    assert!(
        refused[0].message.contains("compressed by meshopt"),
        "{refused:?}"
    );
}
