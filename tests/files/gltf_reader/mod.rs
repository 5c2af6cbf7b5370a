//! The glTF reader: hand-written files, messages about bad ones, and real files.

mod alpha;
mod bad;
mod colors;
mod containers;
mod copies;
mod corners;
mod files;
mod geometry;
mod light_units;
mod mangled;
mod materials;
mod names;
mod origin;
mod pose;
mod smooth;
mod surroundings;
mod threads;
mod tolerated;

use phalanx::formats::{Diagnostic, Loaded, Options, read_bytes};
use serde_json::{Value, json};

/// A file under construction: the document, and its one buffer.
struct File {
    json: Value,
    buffer: Vec<u8>,
}

const FLOAT: u32 = 5126;
const USHORT: u32 = 5123;

impl File {
    /// No nodes yet, and nothing visible.
    fn empty() -> File {
        let json = json!({
            "asset": {"version": "2.0"},
            "nodes": [], "meshes": [], "accessors": [], "bufferViews": [], "materials": []
        });
        File {
            json,
            buffer: Vec::new(),
        }
    }

    /// One triangle over the unit square's lower left half, shown by node 0.
    fn triangle() -> File {
        let mut file = File::empty();
        let positions = file.floats(3, &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
        file.mesh(json!({"attributes": {"POSITION": positions}}));
        file.node(json!({"mesh": 0}));
        file
    }

    fn add(&mut self, list: &str, row: Value) -> usize {
        let rows = self.json[list].as_array_mut().expect("a list");
        rows.push(row);
        rows.len() - 1
    }

    fn node(&mut self, node: Value) -> usize {
        self.add("nodes", node)
    }

    fn mesh(&mut self, primitive: Value) -> usize {
        self.add("meshes", json!({"primitives": [primitive]}))
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        let position = self.buffer.len();
        self.buffer.extend_from_slice(bytes);
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        let row = json!({"buffer": 0, "byteOffset": position, "byteLength": bytes.len()});
        self.add("bufferViews", row)
    }

    fn accessor(&mut self, bytes: &[u8], kind: u32, width: usize, count: usize) -> usize {
        let view = self.view(bytes);
        let name = ["SCALAR", "VEC2", "VEC3", "VEC4"][width - 1];
        self.add(
            "accessors",
            json!({"bufferView": view, "componentType": kind, "type": name, "count": count}),
        )
    }

    fn floats(&mut self, width: usize, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(&bytes, FLOAT, width, values.len() / width)
    }

    fn indices(&mut self, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(&bytes, USHORT, 1, values.len())
    }

    /// The file as text, with its buffer in base64, which is shorter than hexadecimal.
    fn text(&self) -> String {
        let mut json = self.json.clone();
        let data = format!(
            "data:application/octet-stream;base64,{}",
            base64(&self.buffer)
        );
        json["buffers"] = json!([{"byteLength": self.buffer.len(), "uri": data}]);
        json.to_string()
    }

    /// The file as GLB.
    fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{"byteLength": self.buffer.len()}]);
        glb(json.to_string().into_bytes(), &self.buffer)
    }

    fn read(&self) -> Result<Loaded, Vec<Diagnostic>> {
        let by_text = read("gltf", self.text().as_bytes());
        let by_glb = read("glb", &self.glb());
        assert_eq!(by_text.is_ok(), by_glb.is_ok(), "as text and as GLB");
        by_text
    }

    fn loaded(&self) -> Loaded {
        self.read().unwrap_or_else(|errors| panic!("{errors:#?}"))
    }

    /// The messages about a refused file.
    fn refused(&self) -> Vec<String> {
        let errors = self.read().map(|_| "a scene").expect_err("refused");
        errors.into_iter().map(|error| error.message).collect()
    }
}

fn read(ending: &str, bytes: &[u8]) -> Result<Loaded, Vec<Diagnostic>> {
    read_bytes(ending, bytes, &Options::default()).expect("a known ending")
}

fn glb(mut json: Vec<u8>, buffer: &[u8]) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let word = |n: usize| (n as u32).to_le_bytes();
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend(word(12 + 8 + json.len() + 8 + buffer.len()));
    out.extend(word(json.len()));
    out.extend(b"JSON");
    out.extend(json);
    out.extend(word(buffer.len()));
    out.extend(b"BIN\0");
    out.extend(buffer);
    out
}

fn base64(bytes: &[u8]) -> String {
    const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::new();
    for chunk in bytes.chunks(3) {
        let byte = |k: usize| u32::from(chunk.get(k).copied().unwrap_or(0));
        let word = byte(0) << 16 | byte(1) << 8 | byte(2);
        for k in 0..4 {
            let digit = ALPHABET[(word >> (18 - 6 * k) & 63) as usize];
            out.push(if k <= chunk.len() { char::from(digit) } else { '=' });
        }
    }
    out
}

fn messages(diagnostics: &[Diagnostic]) -> Vec<&str> {
    diagnostics.iter().map(|d| d.message.as_str()).collect()
}
