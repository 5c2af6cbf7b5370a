//! Pictures of environments: the same bits from every format, and what is refused.

use phalanx::film::{Aovs, Film};
use phalanx::formats::{EnvironmentSource, LoadError, Loaded, Options, load};
use phalanx::image::{Depth, Exposure, ImageFormat, PictureFile, PictureHeader, save_bands};
use phalanx::scene::{EnvironmentLight, EnvironmentMap, EnvironmentTexels, OutputEncoding, UpAxis};
use std::path::{Path, PathBuf};

const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// A folder with a mesh, and what becomes of an environment around it.
struct Surroundings(tempfile::TempDir);

impl Surroundings {
    fn new() -> Surroundings {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("a.obj"), CUBE).expect("a mesh");
        Surroundings(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, bytes).expect("a file");
        path
    }

    fn open_within(&self, file: &Path, max_memory: Option<u64>) -> Result<Loaded, LoadError> {
        let mut options = Options {
            environment: Some(EnvironmentSource::File(file.to_owned())),
            ..Options::default()
        };
        options.read.max_memory = max_memory;
        load(&self.path("a.obj"), &options)
    }

    fn open(&self, file: &Path) -> Result<Loaded, LoadError> {
        self.open_within(file, None)
    }
}

fn map(loaded: &Loaded) -> &EnvironmentMap {
    match &loaded.scene.environment.as_ref().expect("one").light {
        EnvironmentLight::Map(map) => map,
        EnvironmentLight::Gradient { .. } => panic!("not a map"),
    }
}

/// A PFM of these rows from the top.
fn pfm(width: usize, rows: &[[f32; 3]]) -> Vec<u8> {
    let mut bytes = format!("PF\n{width} {}\n-1.0\n", rows.len() / width).into_bytes();
    for row in rows.chunks(width).rev() {
        bytes.extend(row.iter().flatten().flat_map(|c| c.to_le_bytes()));
    }
    bytes
}

fn pictured(path: &Path, format: ImageFormat, depth: Depth, width: u32, rows: &[[f32; 3]]) {
    let height = rows.len() as u32 / width;
    let mut film = Film::new(width, height, false);
    for (k, rgb) in rows.iter().enumerate() {
        (0..3).for_each(|c| film.planes[c][k] = rgb[c]);
    }
    let file = PictureFile {
        width,
        height,
        crop: None,
        format,
        aovs: Aovs::NONE,
        origin: [0.0; 3],
        exposure: Exposure::from(OutputEncoding::LINEAR),
        depth,
        header: PictureHeader::NONE,
    };
    save_bands(path, &file, [Ok(film)]).expect("a picture");
}

/// Mantissas of eight bits below a common exponent, which halfs hold as well.
fn exact_rows(width: usize, height: usize) -> Vec<[f32; 3]> {
    let texel = |k: usize| {
        let scale = 2f32.powi((k % 19) as i32 - 12);
        [128 + k % 128, k * 7 % 256, k * 13 % 256].map(|m| m as f32 * scale)
    };
    (0..width * height).map(texel).collect()
}

#[test]
fn every_format_gives_the_same_radiance_in_the_least_room() {
    let room = Surroundings::new();
    let (width, height) = (70, 35);
    let rows = exact_rows(width, height);
    let files = [
        ("a.hdr", ImageFormat::Hdr, Depth::Standard, 4),
        ("a.exr", ImageFormat::Exr, Depth::Standard, 6),
        ("half.exr", ImageFormat::Exr, Depth::Sixteen, 6),
        ("a.pfm", ImageFormat::Pfm, Depth::Standard, 6),
    ];
    for (name, format, depth, texel) in files {
        let path = room.path(name);
        pictured(&path, format, depth, width as u32, &rows);
        let loaded = room.open(&path).expect(name);
        let map = map(&loaded);
        assert_eq!((map.width, map.height), (width as u32, height as u32));
        assert_eq!(map.texels.column().row_size(), texel, "{name}");
        for (k, rgb) in rows.iter().enumerate() {
            assert_eq!(map.texels.get(k).to_array(), *rgb, "{name} {k}");
        }
        assert!(!loaded.notes.iter().any(|note| note.contains("samples")));
        assert_eq!(loaded.files, [path]);
    }
}

#[test]
fn the_dimmest_texels_are_not_lost() {
    let room = Surroundings::new();
    // Down to the smallest normal numbers, below which no decoder is asked for more.
    for exponent in (3..=12).chain([0]) {
        let mut hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n".to_vec();
        hdr.extend([200, 128, 0, exponent]);
        let unit = if exponent > 0 { libm::exp2(f64::from(exponent) - 136.0) } else { 0.0 };
        let rgb = [200.0, 128.0, 0.0].map(|mantissa| (mantissa * unit) as f32);
        let pfm = room.write("a.pfm", pfm(1, &[rgb]));
        for path in [room.write("a.hdr", hdr), pfm] {
            let loaded = room.open(&path).expect("a map");
            let texel = map(&loaded).texels.get(0).to_array();
            assert_eq!(texel, rgb, "{} {exponent}", path.display());
        }
    }
}

#[test]
fn what_no_half_holds_is_kept_as_floats() {
    let room = Surroundings::new();
    let mut rows = exact_rows(64, 80);
    // In the last of several bands.
    rows[64 * 79] = [0.1, 1e9, 1e-9];
    let loaded = room
        .open(&room.write("a.pfm", pfm(64, &rows)))
        .expect("floats");
    let texels = &map(&loaded).texels;
    assert!(matches!(texels, EnvironmentTexels::Float(_)));
    for (k, rgb) in rows.iter().enumerate() {
        assert_eq!(texels.get(k).to_array(), *rgb, "{k}");
    }
}

#[test]
fn texels_that_are_no_radiance_are_changed_in_words() {
    let room = Surroundings::new();
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    let rows = [
        [nan, 1.0, -1.0],
        [inf, -inf, 1e38],
        [-0.0, 0.0, 0.5],
        [1.0; 3],
    ];
    let loaded = room.open(&room.write("a.pfm", pfm(4, &[rows, rows].concat())));
    let loaded = loaded.expect("a map");
    let texel = |k| map(&loaded).texels.get(k).to_array();
    assert_eq!(texel(0), [0.0, 1.0, 0.0]);
    assert_eq!(texel(1), [65504.0, 0.0, 65504.0]);
    assert_eq!(
        texel(2).map(f32::to_bits),
        [0.0f32, 0.0, 0.5].map(f32::to_bits)
    );
    let is_noted = loaded
        .notes
        .iter()
        .any(|note| note.starts_with("10 samples"));
    assert!(is_noted, "{:?}", loaded.notes);
}

#[test]
fn hostile_pictures_are_refused() {
    let room = Surroundings::new();
    let full = pfm(4, &[[1.0; 3]; 8]);
    let header = |size: &str| format!("PF\n{size}\n-1.0\n");
    let cases = [
        ("zero.pfm", header("0 0").into_bytes(), "out of range"),
        ("wide.pfm", header("100000 1").into_bytes(), "out of range"),
        (
            "long.hdr",
            b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 16385\n".to_vec(),
            "sides are 1 to 16384",
        ),
        (
            "cut.pfm",
            full[..full.len() - 1].to_vec(),
            "not a portable float map",
        ),
        (
            "huge.pfm",
            header("16384 16384").into_bytes(),
            "not a portable float map",
        ),
        ("empty.hdr", Vec::new(), "it is empty"),
        (
            "a.hdr",
            b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 9 +X 99999\n".to_vec(),
            "out of range",
        ),
        (
            "b.hdr",
            b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 9 +X 99\n".to_vec(),
            "not a Radiance",
        ),
        ("text.exr", b"hello".to_vec(), "by its first bytes"),
    ];
    for (name, bytes, reason) in cases {
        let error = room.open(&room.write(name, bytes)).expect_err(name);
        assert!(error.to_string().contains(reason), "{name}: {error}");
    }
    let png = room.path("a.png");
    pictured(&png, ImageFormat::Png, Depth::Standard, 2, &[[0.5; 3]; 2]);
    let error = room.open(&png).expect_err("not linear");
    assert!(error.to_string().contains("linear radiance"), "{error}");
    // Bits of integers are no floats.
    let exr = room.path("integers.exr");
    pictured(&exr, ImageFormat::Exr, Depth::Standard, 2, &[[0.5; 3]; 2]);
    let mut bytes = std::fs::read(&exr).expect("a picture");
    for name in *b"RGB" {
        let float = [name, 0, 2, 0, 0, 0];
        let place = bytes.windows(6).position(|six| six == float);
        bytes[place.expect("a channel") + 2] = 0;
    }
    let error = room.open(&room.write("integers.exr", bytes));
    let error = error.expect_err("integers").to_string();
    assert!(
        error.contains("no channels R, G and B of floats"),
        "{error}"
    );
    let error = room.open(&room.path("none.hdr")).expect_err("no file");
    assert!(matches!(error, LoadError::Io { .. }));
}

#[test]
fn memory_is_asked_for_before_it_is_used() {
    let room = Surroundings::new();
    let halfs = room.write("halfs.pfm", pfm(64, &exact_rows(64, 64)));
    let mut rows = exact_rows(64, 64);
    rows[64 * 64 - 1] = [0.1; 3];
    let floats = room.write("floats.pfm", pfm(64, &rows));
    // Six bytes a texel, and twelve more where they do not suffice; the mesh takes some, too.
    let texels = 64 * 64;
    for (path, needed) in [(&halfs, 6 * texels), (&floats, 18 * texels)] {
        assert!(room.open_within(path, Some(needed + 10_000)).is_ok());
        match room.open_within(path, Some(needed - 1)) {
            Err(LoadError::Memory {
                needed: claimed, ..
            }) => assert_eq!(claimed, needed),
            other => panic!("{other:?}"),
        }
    }
}

/// The largest are 3 GiB, which are counted once.
#[test]
fn a_map_is_in_memory_once() {
    let room = Surroundings::new();
    let path = room.write("a.pfm", pfm(64, &exact_rows(64, 64)));
    let light = EnvironmentSource::File(path).light(None).expect("a map").0;
    let mut options = Options::default();
    options.look.environment = Some(light);
    let loaded = load(&room.path("a.obj"), &options).expect("a scene");
    let again = loaded.scene.clone();
    let lights = [loaded.scene.environment, again.environment].map(|seen| seen.expect("one").light);
    let given = options.look.environment.expect("one");
    for light in lights {
        assert_eq!(light.texel_bytes().as_ptr(), given.texel_bytes().as_ptr());
    }
}

#[test]
fn the_zenith_is_the_scenes_up_axis() {
    let up_of = |ending: &str, text: &str| {
        let options = Options {
            environment: Some(EnvironmentSource::Sky),
            ..Options::default()
        };
        let read = phalanx::formats::read_bytes(ending, text.as_bytes(), &options);
        let scene = read.expect("a format").expect("a scene").scene;
        scene.environment.expect("a sky").placement().0
    };
    assert_eq!(up_of("obj", CUBE), UpAxis::Y);
    let stl = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
               vertex 0 1 0\nendloop\nendfacet\nendsolid\n";
    assert_eq!(up_of("stl", stl), UpAxis::Z);
    let test = |up: &str| format!("size 8 8\ncamera 5 5 5 0 0 0 {up} 45\nsphere 0 0 0 1\n");
    assert_eq!(up_of("test", &test("0.1 0.2 0.9")), UpAxis::Z);
    assert_eq!(up_of("test", &test("-1 0.2 0.9")), UpAxis::NegX);
}
