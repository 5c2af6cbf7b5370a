//! Materials and textures of OBJ with MTL, glTF and PLY.

use super::loaded;
use crate::folders::folder;
use glam::Vec3;
use phalanx::bvh::Bvh;
use phalanx::cache;
use phalanx::formats::{Loaded, Options, load};
use phalanx::scene::{MapTarget, Material, NO_TEXTURE, Scene};

fn material_of(scene: &Scene, triangle: usize) -> Material {
    scene
        .materials
        .get(scene.triangles.material[triangle] as usize)
}

/// A square with a material of this text, beside the white, red and blue pictures of the awkward
/// files and a normal map.
fn square_of(mtl: &str) -> Loaded {
    let scratch = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(scratch.path().join(name), bytes);
    for picture in [
        "awkward/white.png",
        "awkward/red.png",
        "regressions/atlas.png",
    ] {
        let path = folder("tests/files").join(picture);
        let name = path.file_name().unwrap().to_str().unwrap();
        write(name, &std::fs::read(&path).unwrap()).unwrap();
    }
    let obj = folder("tests/files/regressions").join("atlas.obj");
    write("atlas.obj", &std::fs::read(obj).unwrap()).unwrap();
    write("atlas.mtl", format!("newmtl m\n{mtl}").as_bytes()).unwrap();
    let path = scratch.path().join("atlas.obj");
    load(&path, &Options::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn assert_near(actual: Vec3, expected: Vec3) {
    let apart = (actual - expected).abs().max_element();
    assert!(apart < 1e-6, "{actual} instead of {expected}");
}

/// CesiumGS/obj2gltf#69: Blender's `Ka 1 1 1`, `Ks 0.5` and `illum 2`.
#[test]
fn one_material_in_obj_and_gltf_looks_the_same() {
    let [obj, gltf] = ["regressions/box.obj", "regressions/box.gltf"]
        .map(|name| material_of(&loaded(name).scene, 0));
    assert_near(obj.kd, Vec3::new(0.4, 0.05, 0.02));
    assert_near(obj.ka, gltf.ka);
    assert_near(obj.kd, gltf.kd);
    assert_near(obj.ks, gltf.ks);
    assert_near(obj.highlight, gltf.highlight);
    let exponents = obj.shininess / gltf.shininess;
    assert!((exponents - 1.0).abs() < 1e-5, "{exponents}");
}

/// Assimp and old exporters write `Ns -5`.
#[test]
fn negative_numbers_of_materials_are_zero() {
    let matt = material_of(&loaded("awkward/negative.obj").scene, 0);
    assert_eq!(matt.kd, Vec3::new(0.0, 0.2, 0.1));
    assert_eq!((matt.ks, matt.shininess), (Vec3::ZERO, 0.0));
    assert_eq!(matt.highlight.y, 0.0);
    let zero = square_of("Ns 0\nKd 0 .2 .1\nKs .5 0 .5\nillum 2\n");
    assert_eq!(material_of(&zero.scene, 0), matt);
    let all =
        "Ka -1 1 1\nKd -1 1 1\nKs -1 1 1\nKe -1 1 1\nTf -1 1 1\nd .5\nNs -0.5\nmap_Ns white.png\n";
    for illum in ["illum 2", "illum 3", "illum 7\nNi 1.5"] {
        let all = square_of(&format!("{all}{illum}\n"));
        let row = material_of(&all.scene, 0);
        for color in [row.ka, row.ke, row.kd, row.ks, row.kt, row.highlight] {
            assert!(color.min_element() >= 0.0, "{illum}: {row:?}");
        }
        assert_eq!(row.kt.x, 0.0);
        let warnings = all
            .warnings
            .iter()
            .filter(|w| w.message.contains("negative"));
        assert_eq!(warnings.count(), 1, "one word");
    }
}

/// mrdoob/three.js#22541: exports whose slider of alpha was at 0.
#[test]
fn a_file_whose_materials_are_all_hidden_is_opaque() {
    let scene = loaded("awkward/hidden.obj").scene;
    let [wall, side] = [0, 9].map(|k| material_of(&scene, k));
    assert_eq!((wall.opacity, side.opacity), (1.0, 1.0));
    assert_eq!(
        (wall.kd, side.kd),
        (Vec3::splat(0.8), Vec3::new(0.8, 0.1, 0.1))
    );
    // As Blender 2.79 writes it for a sphere of alpha 0: neither glass nor a mirror.
    let ball = square_of("Ks .5 .5 .5\nNs 86\nNi 1.45\nd 0\nillum 9\n");
    let row = material_of(&ball.scene, 0);
    assert_eq!((row.opacity, row.kt, row.ks), (1.0, Vec3::ZERO, Vec3::ZERO));
    // One other material shows that `d 0` means what it says, and so does a coloured `Tf`.
    let mixed = square_of("d 0\nnewmtl other\nKd 1 0 0\n");
    assert_eq!(material_of(&mixed.scene, 0).opacity, 0.0);
    let glass = material_of(&square_of("d 0\nTf 1 .5 0\n").scene, 0);
    assert_eq!((glass.kt, glass.thin), (Vec3::new(1.0, 0.5, 0.0), true));
}

/// KhronosGroup/glTF-Sample-Viewer#385: pixel art.
#[test]
fn the_filter_of_magnification_decides_about_texels() {
    let file = std::fs::read_to_string(folder("tests/files/regressions/nearest.gltf")).unwrap();
    let nearest = |filters: &str| {
        let scratch = tempfile::tempdir().unwrap();
        let picture = folder("tests/files/regressions/texels.png");
        std::fs::copy(picture, scratch.path().join("texels.png")).unwrap();
        let given = "\"magFilter\": 9728, \"minFilter\": 9728, ";
        assert!(file.contains(given));
        let path = scratch.path().join("a.gltf");
        std::fs::write(&path, file.replace(given, filters)).unwrap();
        let loaded = load(&path, &Options::default()).unwrap_or_else(|error| panic!("{error}"));
        loaded.scene.textures[0].nearest
    };
    assert!(nearest("\"magFilter\": 9728, \"minFilter\": 9728, "));
    assert!(nearest("\"magFilter\": 9728, \"minFilter\": 9987, "));
    assert!(!nearest("\"magFilter\": 9729, \"minFilter\": 9728, "));
    assert!(!nearest("\"minFilter\": 9728, ") && !nearest(""));
}

/// A cache or a checkpoint of one must not stand for the other.
#[test]
fn filters_and_highlights_are_part_of_the_fingerprint() {
    let scene = loaded("regressions/nearest.gltf").scene;
    let mut linear = scene.clone();
    linear.textures[0].nearest = false;
    let mut shiny = scene.clone();
    shiny.materials.highlight.x.make_mut()[0] = 0.5;
    let prints = [&scene, &linear, &shiny].map(cache::fingerprint);
    assert!(
        prints[0] != prints[1] && prints[0] != prints[2],
        "{prints:?}"
    );
    let mut bytes = Vec::new();
    cache::write(&mut bytes, &shiny, &Bvh::build(&shiny)).unwrap();
    let back = cache::open_bytes("a.phx".as_ref(), &bytes).unwrap().scene;
    assert_eq!(cache::fingerprint(&back), prints[2]);
    assert!(back.textures[0].nearest);
}

/// CesiumGS/obj2gltf#146: the unused part of a baked normal map is black.
#[test]
fn normal_maps_in_atlases_are_no_heights() {
    let atlas = loaded("regressions/atlas.obj");
    // Heights would become a texture of their own.
    assert_eq!(atlas.scene.textures.len(), 1);
    let is_noted =
        |loaded: &Loaded, text: &str| loaded.notes.iter().any(|note| note.contains(text));
    assert!(
        is_noted(&atlas, "`atlas.png` is taken as a normal map"),
        "{:?}",
        atlas.notes
    );
    let heights = square_of("map_Bump white.png\nmap_Kd white.png\n");
    assert_eq!(heights.scene.textures.len(), 2);
    assert!(
        is_noted(&heights, "`white.png` is taken as heights"),
        "{:?}",
        heights.notes
    );
}

/// assimp/assimp#1121, ufbx/ufbx#55.
#[test]
fn normal_maps_have_several_keywords() {
    for keyword in ["norm", "map_Kn", "map_kn", "map_norm", "map_Normal"] {
        let bumped = square_of(&format!("Kd 1 1 1\n{keyword} red.png\n"));
        assert!(
            bumped.warnings.is_empty(),
            "{keyword}: {:?}",
            bumped.warnings
        );
        let maps = material_of(&bumped.scene, 0).maps;
        let targets: Vec<MapTarget> = bumped
            .scene
            .maps
            .range(maps)
            .map(|map| map.target)
            .collect();
        assert_eq!(targets, [MapTarget::Normal], "{keyword}");
    }
}

/// ufbx/ufbx#55: `Pm 0` and `Pr 0` beneath their textures.
#[test]
fn nothing_beneath_a_texture_of_metal_or_roughness_is_one() {
    let lobes = |mtl: &str| {
        let row = material_of(&square_of(mtl).scene, 0);
        row.metallic_roughness
            .map(|lobes| [lobes.metallic, lobes.roughness])
    };
    assert_eq!(lobes("Pm 0\nPr 0\nmap_Pm white.png\n"), Some([1.0, 0.0]));
    assert_eq!(lobes("Pm 0\nPr 0\nmap_Pr white.png\n"), Some([0.0, 1.0]));
    assert_eq!(
        lobes("Pm .5\nPr .25\nmap_Pm white.png\nmap_Pr red.png\n"),
        Some([0.5, 0.25])
    );
    assert_eq!(lobes("Pm 0\nPr 0\n"), None);
}

/// A texture of exponents is told where there is none that it could vary, and nowhere else.
#[test]
fn exponents_vary_where_there_are_some() {
    let warnings_of = |mtl: &str| {
        let warnings = square_of(&format!("Ks 1 1 1\n{mtl}\nmap_Ns white.png\n")).warnings;
        warnings.iter().any(|w| w.message.contains("has no effect"))
    };
    assert!(
        warnings_of("illum 2")
            && warnings_of("Ns 1\nillum 2")
            && warnings_of("Ns -5")
            && warnings_of("Ns 0\nillum 3")
    );
    assert!(
        !warnings_of("Ns 50\nillum 2") && !warnings_of("illum 3") && !warnings_of("Ns 50\nillum 3")
    );
    assert!(warnings_of("Ns 50\nillum 1") && warnings_of("Ns 50\nPr .5\nillum 2"));
}

/// assimp/assimp#4939: a face's `texnumber` beyond the pictures.
#[test]
fn a_picture_that_is_not_there_is_told_and_not_shown() {
    let loaded = loaded("awkward/texnumber.ply");
    let textures = [0, 1].map(|k| material_of(&loaded.scene, k).texture);
    assert_eq!(textures, [0, NO_TEXTURE]);
    assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
}
