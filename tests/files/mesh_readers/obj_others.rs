//! OBJ and MTL files as written by other programs: colours, names, paths, masks and mistakes.

use super::{FLAT, messages, triangles};
use glam::{Vec2, Vec3};
use phalanx::formats::{Loaded, Options, ReadOptions, load};
use phalanx::scene::{MapTarget, Material, NO_TEXTURE, Scene};
use std::path::Path;

const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
const PLACES: &str = "vt 0 0\nvt 1 0\nvt 0 1\n";

fn read(text: &str) -> Loaded {
    super::read("obj", text.as_bytes())
}

/// A picture of two adjacent pixels.
fn picture(color: png::ColorType, samples: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
    encoder.set_color(color);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(samples).unwrap();
    writer.finish().unwrap();
    bytes
}

fn rgb() -> Vec<u8> {
    picture(png::ColorType::Rgb, &[255, 0, 0, 0, 0, 255])
}

/// Reads `a.obj`, with the other files in the same folder.
fn beside(obj: &str, files: &[(&str, &[u8])]) -> Loaded {
    let scratch = tempfile::tempdir().unwrap();
    write_files(scratch.path(), files);
    read_in(scratch.path(), obj, Options::default())
}

fn write_files(folder: &Path, files: &[(&str, &[u8])]) {
    for (name, bytes) in files {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
}

fn read_in(folder: &Path, obj: &str, options: Options) -> Loaded {
    let path = folder.join("a.obj");
    std::fs::write(&path, obj).unwrap();
    load(&path, &options).unwrap_or_else(|e| panic!("{e}"))
}

/// The material of the first triangle.
fn first_material(scene: &Scene) -> Material {
    scene.materials.get(scene.triangles.material[0] as usize)
}

/// A triangle with a material of this text, and two pictures in the folder.
fn with_material(mtl: &str) -> Loaded {
    let obj = format!("mtllib a.mtl\n{CORNERS}{PLACES}usemtl m\nf 1/1 2/2 3/3\n");
    let leaf = picture(png::ColorType::Rgba, &[0, 99, 0, 0, 0, 99, 0, 255]);
    let mask = picture(png::ColorType::Grayscale, &[0, 204]);
    let files = [
        ("a.mtl", mtl.as_bytes()),
        ("leaf.png", &leaf),
        ("mask.png", &mask),
        ("tex.png", &rgb()),
    ];
    beside(&obj, &files)
}

fn near(a: Vec3, b: Vec3) -> bool {
    (a - b).abs().max_element() < 1e-5
}

#[test]
fn vertices_have_colours_of_their_own() {
    let grey = Vec3::splat(0.214_041);
    for (red, half) in [
        ("1 0 0", ".5 .5 .5"),
        ("1 0 0 1", ".5 .5 .5 1"),
        ("255 0 0", "127.5 127.5 127.5"),
    ] {
        let text = format!("v 0 0 0 {red}\nv 1 0 0 {half}\nv 0 1 0\nf 1 2 3\nf 3 2 1\n");
        let loaded = read(&text);
        let t = &loaded.scene.triangles;
        let colors = t.corner_colors(0).expect("colours");
        assert!(near(colors[0], Vec3::X) && near(colors[1], grey) && near(colors[2], Vec3::ONE));
        assert_eq!(
            t.corner_colors(1).unwrap()[2],
            colors[0],
            "it belongs to the vertex"
        );
        assert_eq!(t.vertex_opacity[..], [1.0; 3]);
        assert_eq!(triangles(&loaded.scene)[0], FLAT[0]);
        assert_eq!(
            first_material(&loaded.scene).kd,
            Vec3::ONE,
            "colours are not tinted"
        );
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    }
    let warning_of = |alpha: [&str; 3]| {
        let [a, b, c] = alpha;
        let text = format!("v 0 0 0 1 0 0 {a}\nv 1 0 0 1 0 0 {b}\nv 0 1 0 1 0 0 {c}\nf 1 2 3\n");
        messages(&read(&text).warnings)
    };
    assert!(warning_of(["1", "1.0", "255"]).is_empty());
    let one = "the opacity of this colour is not used";
    assert_eq!(warning_of(["1", "0.5", "1"]), [one]);
    assert_eq!(warning_of(["128", "255", "255"]), [one]);
    let three = "3 colours, this one first, have an opacity that is not used";
    assert_eq!(warning_of(["0"; 3]), [three]);
    let plain = read("v 0 0 0 1\nv 1 0 0 1\nv 0 1 0 1\nf 1 2 3\n").scene;
    assert!(plain.triangles.colors.is_empty() && plain.triangles.vertex_colors.is_empty());
    let bad = read("v 0 0 0 nan 0 0\nv 1 0 0 -1 0 0\nv 0 1 0 1.01 1 1\nf 1 2 3\n");
    let colors = bad.scene.triangles.corner_colors(0).unwrap();
    assert_eq!(
        colors,
        [Vec3::ONE, Vec3::ZERO, Vec3::ONE],
        "white, cut, and rounded"
    );
    assert!(messages(&bad.warnings)[0].contains("not finite: white"));
}

#[test]
fn zbrush_paints_in_comments() {
    let text = format!("{CORNERS}#MRGB ffff0000FF00ff00\n#MRGB ff0000ffZZ\nf 1 2 3\n# MRGB\n");
    let colors = read(&text).scene.triangles.corner_colors(0);
    assert_eq!(colors, Some([Vec3::X, Vec3::Y, Vec3::Z]));
    let own = text.replace("v 0 0 0", "v 0 0 0 0 0 0");
    let colors = read(&own).scene.triangles.corner_colors(0);
    assert_eq!(
        colors,
        Some([Vec3::ZERO, Vec3::ONE, Vec3::ONE]),
        "colours of vertices go first"
    );
}

#[test]
fn smoothing_groups_give_normals_to_those_without() {
    let roof = "v 0 0 0\nv 0 1 0\nv -1 0 -1\nv -1 1 -1\nv 1 0 -1\nv 1 1 -1\nvn 1 0 0\n";
    let normals = |group: &str, faces: &str| {
        let t = read(&format!("{roof}{group}\n{faces}\n")).scene.triangles;
        t.corner_normals(0).map(|n| n[0])
    };
    let faces = "f 1 2 4 3\nf 2 1 5 6";
    assert!(near(normals("s 1", faces).unwrap(), Vec3::Z));
    assert!(near(normals("S on # all", faces).unwrap(), Vec3::Z));
    for flat in ["", "s off", "s 0", "s", "s null", "s 1\ns off"] {
        assert_eq!(normals(flat, faces), None, "{flat}");
    }
    let apart = normals("s 2", "f 1 2 4 3\ns 3\nf 2 1 5 6").unwrap();
    assert!(apart.x < -0.7, "{apart}");
    assert_eq!(
        normals("s 1", "f 1//1 2//1 4//1 3//1\nf 2 1 5 6"),
        Some(Vec3::X)
    );
}

#[test]
fn opacity_is_coverage_unless_glass_refracts() {
    let material =
        |mtl: &str| first_material(&with_material(&format!("newmtl m\nKd 1 1 1\n{mtl}")).scene);
    let half = material("d .5\nillum 2\n");
    assert_eq!(
        (half.opacity, half.kd, half.kt),
        (0.5, Vec3::ONE, Vec3::ZERO)
    );
    let glass = material("d .5\nillum 7\nNi 1.5\n");
    assert_eq!(
        (glass.opacity, glass.kt, glass.thin),
        (1.0, Vec3::splat(0.5), false)
    );
    let sheet = material("d .5\nTf 1 0 0\n");
    assert_eq!(
        (sheet.opacity, sheet.kt, sheet.thin),
        (1.0, Vec3::X * 0.5, true)
    );
}

#[test]
fn a_mask_is_alpha_or_else_luminance() {
    let opacity = |mtl: &str| {
        let scene = with_material(&format!("newmtl m\n{mtl}")).scene;
        let row = first_material(&scene).opacity_texture;
        (row != NO_TEXTURE).then(|| scene.textures[row as usize].alpha.to_vec())
    };
    assert_eq!(
        opacity("map_Kd leaf.png\nmap_d leaf.png"),
        Some(vec![0, 255])
    );
    assert_eq!(
        opacity("map_Kd tex.png\nMAP_D mask.png"),
        Some(vec![0, 204])
    );
    assert_eq!(opacity("map_d mask.png"), Some(vec![0, 204]));
    assert_eq!(
        opacity("map_d -imfchan m mask.png"),
        None,
        "it has no alpha"
    );
    assert_eq!(
        opacity("map_Kd leaf.png"),
        None,
        "no map_d asks for its alpha"
    );
    assert_eq!(
        opacity("map_Kd tex.png\nmap_d ./tex.png"),
        None,
        "the same picture, all of it there"
    );
    assert_eq!(opacity("map_d none.png"), None);
}

#[test]
fn textures_are_scaled_and_moved() {
    let places = |options: &str| {
        let loaded = with_material(&format!("newmtl m\nmap_Kd {options} tex.png\n"));
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        loaded.scene.triangles.corner_uvs(0, 0).expect("places")
    };
    let plain = [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]].map(Vec2::from);
    assert_eq!(places(""), plain);
    assert_eq!(
        places("-s 2 2 1"),
        [[0.0, 1.0], [2.0, 1.0], [0.0, -1.0]].map(Vec2::from)
    );
    assert_eq!(
        places("-o 0.5 0.25 0"),
        [[0.5, 0.75], [1.5, 0.75], [0.5, -0.25]].map(Vec2::from)
    );
    let differing = with_material("newmtl m\nmap_Kd -s 2 2 tex.png\nmap_d mask.png\n");
    let warnings = messages(&differing.warnings);
    assert!(
        warnings[0].contains("a.mtl:3:7: `mask.png`") && warnings.len() == 1,
        "{warnings:?}"
    );
}

#[test]
fn what_a_material_leaves_out_is_named_once_where_it_stands() {
    let mtl = "# made by\nnewmtl m\nKs 1 1 1\nKe 1 1 1\nillum 3\nmap_Kd -mm 0 1 tex.png\nmap_Ka mask.png\n\
               map_Refl mask.png\n\tPs 1\nmap_Ke absent.png\nMap_Bump -bm 1 -cc on mask.png\nPcr 0.5\nNs -nan(ind)\n\
               newmtl unused\ndisp mask.png\nnewmtl n\nmap_bump mask.png\n";
    let obj =
        format!("mtllib a.mtl\n{CORNERS}{PLACES}usemtl m\nf 1/1 2/2 3/3\nusemtl n\nf 1 2 3\n");
    let mask = picture(png::ColorType::Grayscale, &[0, 204]);
    let loaded = beside(
        &obj,
        &[
            ("a.mtl", mtl.as_bytes()),
            ("tex.png", &rgb()),
            ("mask.png", &mask),
        ],
    );
    let warnings = messages(&loaded.warnings);
    let expected = [
        "a.mtl:6:8: `-mm`, `map_Refl`, `Ps`, `-cc`, `Pcr` are left out (not shown); \
         `Ns` is left out (a number that is not finite)",
        "a.mtl:7:8: `mask.png`: its picture is not shown: that of map_Kd colours the ambient light",
        "a.mtl:10:8: the texture `absent.png` is left out: No such file or directory (os error 2)",
    ];
    assert_eq!(warnings, expected);
    assert!(loaded.warnings.iter().all(|w| (w.line, w.column) == (1, 8)));
    let glow = first_material(&loaded.scene).ke;
    assert_eq!(glow, Vec3::ZERO, "without its texture");
    let same = with_material("newmtl m\nmap_Ka tex.png\nmap_Kd tex.png\n");
    assert!(same.warnings.is_empty(), "{:?}", same.warnings);
    let alone = with_material("newmtl m\nmap_Ka tex.png\n");
    assert!(first_material(&alone.scene).texture != NO_TEXTURE && alone.warnings.is_empty());
}

#[test]
fn comments_stand_behind_names() {
    let mtl = "newmtl red\t# e\nKd 1 0 0 # red\nmap_Kd my tex.png # of mine\nnewmtl red #2\nKd 0 1 0\n\
               newmtl # lone\nKd 0 0 1\n";
    let files: [(&str, &[u8]); 4] = [
        ("my #1.mtl", mtl.as_bytes()),
        ("the lib.mtl", mtl.as_bytes()),
        ("my tex.png", &rgb()),
        ("b.mtl", b""),
    ];
    for (library, name, kd) in [
        ("my #1.mtl", "red", Vec3::X),
        ("my #1.mtl # lib # b", "red  \t", Vec3::X),
        ("\"my #1.mtl\"", "red # the first", Vec3::X),
        ("my #1.mtl", "red # e", Vec3::X),
        ("b.mtl b.mtl # two\nmtllib my #1.mtl", "red #2", Vec3::Y),
        ("b.mtl none.mtl the lib.mtl # c", "red #2", Vec3::Y),
        ("b.mtl the\\ lib.mtl", "red", Vec3::X),
        (
            "b.mtl \\\nb.mtl\nMtlLib my #1.mtl\r",
            "red #2 # the second\r",
            Vec3::Y,
        ),
    ] {
        let obj = format!("mtllib {library}\n{CORNERS}{PLACES}usemtl {name}\nf 1/1 2/2 3/3 # f\n");
        let loaded = beside(&obj, &files);
        let texts = messages(&loaded.warnings);
        let missing = texts
            .iter()
            .all(|texts| texts.contains("`none.mtl` is left out"));
        assert!(missing, "{library}: {texts:?}");
        let material = first_material(&loaded.scene);
        assert_eq!(material.kd, kd, "{name}");
        assert_eq!(material.texture != NO_TEXTURE, kd == Vec3::X);
    }
    let obj = format!("mtllib none.mtl # x\n{CORNERS}usemtl nobody # y\nf 1 2 3\n");
    for (files, texts) in [
        (&[][..], "the material file `none.mtl` is left out"),
        (
            &[("none.mtl", &b""[..])][..],
            "there is no material `nobody`: ",
        ),
    ] {
        let warnings = messages(&beside(&obj, files).warnings);
        assert!(
            warnings.len() == 1 && warnings[0].starts_with(texts),
            "{warnings:?}"
        );
    }
}

#[test]
fn pictures_are_found_from_their_material_file() {
    let outer = tempfile::tempdir().unwrap();
    let scene = outer.path().join("scene");
    let png = rgb();
    let mtl = |name: &str| format!("newmtl m\nmap_Kd {name}\n").into_bytes();
    let obj = format!("mtllib materials/m.mtl\n{CORNERS}{PLACES}usemtl m\nf 1/1 2/2 3/3\n");
    write_files(
        outer.path(),
        &[("textures/bark.png", &png), ("secret.png", &png)],
    );
    let read = |name: &str, options: Options| {
        let files: [(&str, &[u8]); 3] = [
            ("materials/m.mtl", &mtl(name)),
            ("materials/images/a.png", &png),
            ("b.png", &png),
        ];
        write_files(&scene, &files);
        let loaded = read_in(&scene, &obj, options);
        (
            first_material(&loaded.scene).texture != NO_TEXTURE,
            messages(&loaded.warnings),
        )
    };
    for name in [
        "images/a.png",
        "images\\a.png ",
        "./images/a.png",
        "b.png",
        "../b.png",
        "C:\\Users\\bob\\b.png",
        "\"C:\\My Pictures\\b.png\"",
        "/home/bob/b.png",
        "\\\\server\\share\\b.png",
    ] {
        assert_eq!(read(name, Options::default()), (true, vec![]), "{name}");
    }
    for outside in ["../../textures/bark.png", "../../secret.png"] {
        let (textured, message) = read(outside, Options::default());
        assert!(
            !textured && message[0].contains("materials/m.mtl:2:8: "),
            "{message:?}"
        );
        assert!(message[0].contains("--allow-path"), "{message:?}");
    }
    let opened = Options {
        read: ReadOptions {
            allow_paths: vec![outer.path().join("textures")],
            ..ReadOptions::default()
        },
        ..Options::default()
    };
    assert_eq!(
        read("../../textures/bark.png", opened.clone()),
        (true, vec![])
    );
    assert_eq!(read("D:\\lib\\bark.png", opened.clone()), (true, vec![]));
    assert!(!read("../../secret.png", opened).0);
    let (textured, message) = read("img/b.png", Options::default());
    assert!(
        textured && message[0].contains("`b.png` is read instead"),
        "{message:?}"
    );
}

#[test]
fn numbers_out_of_range_cost_a_face_its_texture_or_normals() {
    let text = format!("{CORNERS}{PLACES}vn 0 0 1\n");
    for (face, places, normals, expected) in [
        (
            "f 1/0/1 2/0/1 3/0/1",
            false,
            true,
            "`0` is no texture coordinate: the file has 3; 3 corners",
        ),
        (
            "f 1/1/0 2/2/0 3/3/0",
            true,
            false,
            "`0` is no normal: the file has 1; 3 corners",
        ),
        (
            "f 1/1/1 2/2/1 3/4/1",
            false,
            true,
            "`4` is no texture coordinate",
        ),
        (
            "f 1/-1/-1 2/-2/-9 3/-3/-1",
            true,
            false,
            "`-9` is no normal",
        ),
        ("f 1//1 2 3//1", false, false, "at some corners only"),
        (
            "f 1/1 2/2 3/99999999999999999999",
            false,
            false,
            "is no texture coordinate",
        ),
    ] {
        let loaded = read(&format!("{text}{face}\nf 1/1/1 2/2/1 3/3/1\n"));
        let t = &loaded.scene.triangles;
        assert_eq!(
            (t.corner_uvs(0, 0).is_some(), t.corner_normals(0).is_some()),
            (places, normals),
            "{face}"
        );
        assert!(t.corner_uvs(1, 0).is_some() && t.corner_normals(1).is_some());
        let warnings = messages(&loaded.warnings);
        assert!(
            warnings.len() == 1 && warnings[0].contains(expected),
            "{face}: {warnings:?}"
        );
    }
}

#[test]
fn what_is_not_finite_matters_where_it_is_used() {
    for bad in [
        "nan",
        "-nan",
        "NaN",
        "-nan(ind)",
        "1.#QNAN",
        "-1.#IND00",
        "inf",
        "-Infinity",
        "1.#INF",
    ] {
        let text = format!("{CORNERS}v {bad} 0 0\nvn 0 {bad} 1\nvt {bad} 0\nf 1 2 3\n");
        let loaded = read(&text);
        assert_eq!(triangles(&loaded.scene), FLAT, "{bad}");
        assert_eq!(loaded.warnings.len(), 3, "{bad}: {:?}", loaded.warnings);
        let used = read(&format!("{text}f 1 2 4\n"));
        let warnings = messages(&used.warnings);
        assert!(
            warnings[0].contains("1 triangle is left out"),
            "{bad}: {warnings:?}"
        );
    }
    // A comment may stand at a number.
    assert_eq!(
        triangles(&read("v 0 0 0\nv 1. 0 0.#QUIT\nv 0 1 0#x\nf 1 2 3").scene),
        FLAT
    );
}

#[test]
fn operands_too_many_are_not_used() {
    let loaded =
        read("v 0 0 0 1 2\nv 1 0 0\nv 0 1 0\nvn 0 0 1 0\nvt 0 0 0 0\nf 1/1/1 2/1/1 3/1/1\n");
    assert_eq!(triangles(&loaded.scene), FLAT);
    let warnings = messages(&loaded.warnings);
    assert!(
        warnings.len() == 1 && warnings[0].starts_with("3 statements have operands too many"),
        "{warnings:?}"
    );
}

#[test]
fn textures_that_are_missing_are_one_warning() {
    let mtl = |k: u32| format!("newmtl m{k}\nmap_Kd t{k}.png\n");
    let face = |k: u32| format!("usemtl m{k}\nf 1/1 2/2 3/3\n");
    let repeated = |part: &dyn Fn(u32) -> String| (0..17).map(part).collect::<String>();
    let obj = format!("mtllib a.mtl\n{CORNERS}{PLACES}{}", repeated(&face));
    let warnings = messages(&beside(&obj, &[("a.mtl", repeated(&mtl).as_bytes())]).warnings);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(
        warnings[0].contains("17 textures are left out: "),
        "{warnings:?}"
    );
    assert!(
        warnings[0].ends_with("`t15.png`, `t16.png`"),
        "{warnings:?}"
    );
}

#[test]
fn a_texture_needs_places_and_may_have_options_behind_its_name() {
    let obj = format!("mtllib a.mtl\n{CORNERS}{PLACES}usemtl m\nf 1/1 2/2 3/3\nf 1 2 3\n");
    let mtl = b"newmtl m\nmap_Kd tex.png -bm 1\n";
    let loaded = beside(&obj, &[("a.mtl", mtl), ("tex.png", &rgb())]);
    assert_ne!(first_material(&loaded.scene).texture, NO_TEXTURE);
    let warnings = messages(&loaded.warnings);
    assert_eq!(
        warnings,
        ["a triangle has a texture and no texture coordinates: it is not shown there"]
    );
}

#[test]
fn maps_vary_what_their_statements_name() {
    let file = |name: &str| (name.to_owned(), rgb());
    let names = ["tex.png", "e.png", "s.png", "n.png", "r.png", "b.png"].map(file);
    let maps_of = |mtl: &str| {
        let obj = format!("mtllib a.mtl\n{CORNERS}{PLACES}usemtl m\nf 1/1 2/2 3/3\n");
        let mtl = format!("newmtl m\n{mtl}");
        let mut files: Vec<(&str, &[u8])> = vec![("a.mtl", mtl.as_bytes())];
        files.extend(names.iter().map(|(name, bytes)| (&name[..], &bytes[..])));
        let loaded = beside(&obj, &files);
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        let material = first_material(&loaded.scene);
        let maps = loaded.scene.maps.range(material.maps);
        let maps: Vec<_> = maps
            .map(|map| (map.target, map.channel, map.scale))
            .collect();
        (material, maps, loaded.scene)
    };
    let (plain, maps, scene) = maps_of(
        "Ks 1 1 1\nNs 50\nillum 3\nmap_Kd tex.png\nmap_Ke e.png\n\
        map_Ks s.png\nmap_Ns -imfchan g n.png\nbump -bm 2 b.png\n",
    );
    let expected = [
        (MapTarget::Emission, 0, 1.0),
        (MapTarget::Specular, 0, 1.0),
        (MapTarget::Shininess, 1, 1.0),
        (MapTarget::Normal, 0, 2.0),
    ];
    assert_eq!(maps, expected);
    assert_eq!(
        (plain.ke, plain.ks, plain.shininess),
        (Vec3::ONE, Vec3::ONE, 50.0)
    );
    // Heights become a texture of their own.
    assert_eq!(scene.textures.len(), 6);
    assert!(scene.triangles.corner_tangents(0).is_some());
    // A matt material shows no highlight, whatever its map.
    assert_eq!(
        maps_of("Ks 1 1 1\nmap_Ks s.png\nnorm n.png\nbump b.png\n").1,
        [(MapTarget::Normal, 0, 1.0),]
    );
    let (pbr, maps, _) =
        maps_of("Kd .5 .5 .5\nKs 1 1 1\nNs 50\nPm .5\nmap_Pr -imfchan b r.png\nmap_Ks s.png\n");
    assert_eq!(maps, [(MapTarget::Roughness, 2, 1.0)]);
    let lobes = pbr.metallic_roughness.expect("varied");
    assert_eq!((lobes.metallic, lobes.roughness), (0.5, 1.0));
    assert_eq!((pbr.kd, pbr.ks), (Vec3::splat(0.5), Vec3::splat(0.04)));
    // Without textures, they are converted once, as in glTF.
    let (even, maps, _) = maps_of("Kd .5 .5 .5\nPm 1\nPr 0\n");
    assert!(maps.is_empty() && even.metallic_roughness.is_none());
    assert_eq!((even.kd, even.ks), (Vec3::ZERO, Vec3::splat(0.5)));
}
