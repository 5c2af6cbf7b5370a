//! Speed of loading meshes, as ratios within one run against widely used readers. The compared
//! readers run in alternation; both sides must find the same triangles. Exits 1 if a ratio is below
//! its floor.
//!
//! `cargo bench --bench loading`; `-- --json` prints a record. The files of 10 million triangles
//! are generated in the system's temporary folder and take half a gigabyte; `-- --small` skips
//! them. trimesh runs in the Python named by `PHALANX_PYTHON` (default `python3`), if it is
//! installed there; its start-up does not count.

use phalanx::formats::{Options, ReadOptions, load};
use ply_rs_bw::{parser, ply};
use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Instant;

/// Threads that phalanx may use: the promise is for two.
const THREADS: usize = 2;

/// One promised ratio: the median over the passes of `other` seconds ÷ `ours` seconds.
#[derive(serde::Serialize)]
struct LoadRatio {
    file: String,
    other: &'static str,
    triangles: usize,
    median: f64,
    floor: f64,
    ours_seconds: f64,
    other_seconds: f64,
}

fn main() {
    let small = std::env::args().any(|a| a == "--small");
    let scratch = tempfile::tempdir().expect("a folder for temporary files");
    let mut ratios = Vec::new();
    let mut python = Python::start();
    for file in files(scratch.path(), small) {
        let passes = if file.metadata().map_or(0, |m| m.len()) > 1 << 26 { 5 } else { 11 };
        if file.extension().is_some_and(|e| e == "obj") {
            ratios.push(compare(&file, "tobj", 3.0, passes, tobj_triangles));
            continue;
        }
        ratios.push(compare(&file, "ply-rs-bw", 2.0, passes, ply_triangles));
        if let Some(python) = &mut python {
            let trimesh = |path: &Path| python.triangles(path);
            ratios.push(compare(&file, "trimesh", 2.0, passes, trimesh));
        }
    }
    if std::env::args().any(|a| a == "--json") {
        let record =
            serde_json::json!({ "schema_version": 1, "threads": THREADS, "ratios": ratios });
        println!("{record:#}");
    } else {
        for r in &ratios {
            let rate = r.triangles as f64 / r.ours_seconds / 1e6;
            println!(
                "{:>22}  {:>9} triangles  over {:<10} {:6.2} (floor {:.1})  {:8.1} against {:8.1} ms, {rate:6.1} Mtriangles/s",
                r.file,
                r.triangles,
                r.other,
                r.median,
                r.floor,
                r.ours_seconds * 1e3,
                r.other_seconds * 1e3,
            );
        }
    }
    if ratios.iter().any(|r| r.median < r.floor) {
        std::process::exit(1);
    }
}

/// Files to load: available and generated ones.
fn files(scratch: &Path, small: bool) -> Vec<PathBuf> {
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes");
    let mut files = Vec::new();
    for name in ["armadillo", "beast", "stadium", "stanford-bunny"] {
        files.push(shared.join(format!("obj/medium/{name}.obj")));
    }
    let dragon = shared.join("ply/large/dragon_vrip_le.ply");
    files.push(dragon.clone());
    files.retain(|file| {
        let there = file.is_file();
        if !there {
            eprintln!("skipped: {} is not here", file.display());
        }
        there
    });
    if dragon.is_file() {
        let scene = load(&dragon, &Options::default())
            .expect("the dragon")
            .scene;
        let mesh = MeshFile {
            vertices: (0..scene.triangles.vertices.len())
                .map(|i| scene.triangles.vertices.get(i).to_array())
                .collect(),
            corners: scene.triangles.corners.to_vec(),
        };
        files.push(mesh.write(&scratch.join("dragon.obj"), MeshFile::write_obj));
    }
    if !small {
        let mesh = MeshFile::waves(2237);
        files.push(mesh.write(&scratch.join("waves.obj"), MeshFile::write_obj));
        files.push(mesh.write(&scratch.join("waves.ply"), MeshFile::write_ply));
    }
    files
}

/// A mesh to be written.
struct MeshFile {
    vertices: Vec<[f32; 3]>,
    corners: Vec<[u32; 3]>,
}

impl MeshFile {
    /// A square of 2 · side² triangles, wavy so that its numbers have as many digits as real ones.
    fn waves(side: u32) -> MeshFile {
        let row = side + 1;
        let position = |k: u32| {
            let (x, z) = (f64::from(k % row), f64::from(k / row));
            let y = libm::sin(x * 0.013) * 31.0 + libm::cos(z * 0.017) * 23.0;
            [(x * 0.1) as f32, y as f32, (z * -0.1) as f32]
        };
        let quad = |k: u32| {
            let a = k / side * row + k % side;
            [[a, a + 1, a + row + 1], [a, a + row + 1, a + row]]
        };
        MeshFile {
            vertices: (0..row * row).map(position).collect(),
            corners: (0..side * side).flat_map(quad).collect(),
        }
    }

    fn write(
        &self,
        path: &Path,
        how: impl Fn(&MeshFile, &mut BufWriter<File>) -> std::io::Result<()>,
    ) -> PathBuf {
        let mut out = BufWriter::new(File::create(path).expect("room for a file"));
        how(self, &mut out)
            .and_then(|()| out.flush())
            .expect("room for a file");
        path.to_path_buf()
    }

    fn write_obj(&self, out: &mut BufWriter<File>) -> std::io::Result<()> {
        for [x, y, z] in &self.vertices {
            writeln!(out, "v {x:.6} {y:.6} {z:.6}")?;
        }
        self.corners.iter().try_for_each(|t| {
            let [a, b, c] = t.map(|corner| corner + 1);
            writeln!(out, "f {a} {b} {c}")
        })
    }

    fn write_ply(&self, out: &mut BufWriter<File>) -> std::io::Result<()> {
        let (vertices, faces) = (self.vertices.len(), self.corners.len());
        write!(
            out,
            "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
             element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
        )?;
        for number in self.vertices.iter().flatten() {
            out.write_all(&number.to_le_bytes())?;
        }
        self.corners.iter().try_for_each(|t| {
            out.write_all(&[3])?;
            t.iter()
                .try_for_each(|corner| out.write_all(&corner.to_le_bytes()))
        })
    }
}

/// Seconds that the work took, and its number of triangles.
fn timed(work: impl FnOnce() -> usize) -> (f64, usize) {
    let start = Instant::now();
    let triangles = work();
    (start.elapsed().as_secs_f64(), triangles)
}

fn our_triangles(path: &Path) -> (f64, usize) {
    let options = Options {
        read: ReadOptions {
            threads: THREADS,
            ..ReadOptions::default()
        },
        ..Options::default()
    };
    let start = Instant::now();
    let loaded = load(path, &options).expect("a scene");
    let seconds = start.elapsed().as_secs_f64();
    (seconds, loaded.scene.triangles.len())
}

fn compare(
    path: &Path,
    other: &'static str,
    floor: f64,
    passes: usize,
    mut others: impl FnMut(&Path) -> (f64, usize),
) -> LoadRatio {
    // One unmeasured run brings the file into the system's cache and compares the results.
    let (ours, theirs) = (our_triangles(path), others(path));
    assert_eq!(ours.1, theirs.1, "{}: triangles by {other}", path.display());
    let passes: Vec<(f64, f64)> = (0..passes)
        .map(|_| (our_triangles(path).0, others(path).0))
        .collect();
    let median_of = |time: &dyn Fn(&(f64, f64)) -> f64| {
        let mut values: Vec<f64> = passes.iter().map(time).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    LoadRatio {
        file: path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned(),
        other,
        triangles: ours.1,
        median: median_of(&|p| p.1 / p.0),
        floor,
        ours_seconds: median_of(&|p| p.0),
        other_seconds: median_of(&|p| p.1),
    }
}

/// Loads with tobj, as its users call it: triangles, otherwise the defaults.
fn tobj_triangles(path: &Path) -> (f64, usize) {
    let options = tobj::LoadOptions {
        triangulate: true,
        ..tobj::LoadOptions::default()
    };
    let start = Instant::now();
    let (models, _) = tobj::load_obj(path, &options).expect("an OBJ file");
    let seconds = start.elapsed().as_secs_f64();
    (
        seconds,
        models.iter().map(|m| m.mesh.indices.len() / 3).sum(),
    )
}

struct PlyVertex([f32; 3]);
struct PlyFace(Vec<i32>);

impl ply::PropertyAccess for PlyVertex {
    fn new() -> Self {
        PlyVertex([0.0; 3])
    }

    fn set_property(&mut self, key: &str, property: ply::Property) -> ply::PropertyAccessResult {
        let axis = ["x", "y", "z"].iter().position(|name| *name == key);
        if let (Some(axis), ply::Property::Float(value)) = (axis, property) {
            self.0[axis] = value;
        }
        ply::PropertyAccessResult::Set
    }
}

impl ply::PropertyAccess for PlyFace {
    fn new() -> Self {
        PlyFace(Vec::new())
    }

    fn set_property(&mut self, _: &str, property: ply::Property) -> ply::PropertyAccessResult {
        if let ply::Property::ListInt(corners) = property {
            self.0 = corners;
        }
        ply::PropertyAccessResult::Set
    }
}

/// Loads directly into the caller's structures, this reader's fastest way, and from there into
/// columns.
fn ply_triangles(path: &Path) -> (f64, usize) {
    timed(|| {
        let file = File::open(path).expect("the file");
        let mut reader = parser::Reader::new(BufReader::new(file));
        let (vertices, faces) = (
            parser::Parser::<PlyVertex>::new(),
            parser::Parser::<PlyFace>::new(),
        );
        let header = vertices.read_header(&mut reader).expect("a header");
        let mut columns: [Vec<f32>; 3] = Default::default();
        let mut corners: Vec<[u32; 3]> = Vec::new();
        for element in header.elements.values() {
            if element.name == "vertex" {
                let rows = vertices
                    .read_payload_for_element(&mut reader, element, &header)
                    .expect("vertices");
                for (axis, column) in columns.iter_mut().enumerate() {
                    column.extend(rows.iter().map(|row| row.0[axis]));
                }
            } else {
                let rows = faces
                    .read_payload_for_element(&mut reader, element, &header)
                    .expect("faces");
                corners.extend(
                    rows.iter()
                        .map(|row| [row.0[0] as u32, row.0[1] as u32, row.0[2] as u32]),
                );
            }
        }
        std::hint::black_box(&columns);
        corners.len()
    })
}

/// A Python process that times trimesh by itself.
struct Python {
    child: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
}

/// Python script. `process=False` keeps trimesh from merging vertices, which is not required.
const SCRIPT: &str = "
import sys, time
try:
    import trimesh
except ImportError:
    print('no trimesh'); sys.exit()
print('ready', flush=True)
for line in sys.stdin:
    start = time.perf_counter()
    mesh = trimesh.load(line.strip(), process=False)
    faces = len(mesh.faces)
    print(time.perf_counter() - start, faces, flush=True)
";

impl Python {
    /// Starts Python. Returns `None`, with the reason on stderr, if there is no Python with
    /// trimesh.
    fn start() -> Option<Python> {
        let name = std::env::var("PHALANX_PYTHON").unwrap_or_else(|_| "python3".into());
        let child = Command::new(&name)
            .args(["-c", SCRIPT])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn();
        let mut child = child
            .inspect_err(|error| eprintln!("skipped: trimesh: {name}: {error}"))
            .ok()?;
        let (input, output) = (child.stdin.take()?, BufReader::new(child.stdout.take()?));
        let mut python = Python {
            child,
            input,
            output,
        };
        let ready = python.line();
        if ready.trim() != "ready" {
            eprintln!("skipped: trimesh: {name} has none");
            return None;
        }
        Some(python)
    }

    fn line(&mut self) -> String {
        let mut line = String::new();
        self.output.read_line(&mut line).expect("Python answers");
        line
    }

    fn triangles(&mut self, path: &Path) -> (f64, usize) {
        writeln!(self.input, "{}", path.display()).expect("Python listens");
        let line = self.line();
        let mut words = line.split_whitespace();
        let seconds = words.next().and_then(|w| w.parse().ok()).expect("seconds");
        (
            seconds,
            words
                .next()
                .and_then(|w| w.parse().ok())
                .expect("triangles"),
        )
    }
}

impl Drop for Python {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        let _ = self.output.read_to_string(&mut String::new());
    }
}
