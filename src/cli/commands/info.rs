//! `phalanx info`.

use crate::cli::options::{OUTPUT, SceneArgs, SceneInput, TreeArgs, WantedPicture};
use crate::cli::output::{
    self, CameraReport, CliError, LightRow, MemoryStats, Output, PrimitiveCounts, TreeFigures,
    Verbosity, grouped, interrupt, lines, origin_row,
};
use clap::Args;
use phalanx::frame::{Engine, TreeStats};
use phalanx::report::plural;
use phalanx::scene::{LightShape, Scene};
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub struct InfoArgs {
    #[arg(
        help = "Scene file, cache (.phx), standard:NAME[:SIZE], or -",
        long_help = "Scene file, scene cache (.phx), standard scene (standard:NAME[:SIZE]), or - for stdin (see --format)"
    )]
    pub scene: PathBuf,
    #[command(flatten)]
    pub scene_args: SceneArgs,
    #[command(flatten)]
    pub tree: TreeArgs,
    /// Print the report as JSON
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,
}

#[derive(Debug, Serialize)]
struct InfoDocument {
    scene: String,
    image: ImageSize,
    max_depth: u32,
    primitives: PrimitiveCounts,
    instances: InstanceCounts,
    lights: LightCounts,
    /// The lights by power, for --json and --verbose.
    #[serde(skip_serializing_if = "Option::is_none")]
    lights_by_power: Option<Vec<LightRow>>,
    materials: usize,
    named_objects: NameList,
    named_materials: NameList,
    cameras: Vec<CameraRow>,
    camera: CameraReport,
    /// Bounds in the file's own coordinates; `None` for a scene without primitives.
    bounds: Option<FileBounds>,
    /// Origin of the scene's coordinates, in the file's; zero if they are the same.
    origin: [f64; 3],
    bvh: TreeFigures,
    memory: MemoryStats,
}

#[derive(Clone, Copy, Debug, Serialize)]
struct ImageSize {
    width: u32,
    height: u32,
}

/// Names of objects or materials from the file, the largest first, each with its number of visible
/// primitives.
#[derive(Debug, Serialize)]
struct NameList {
    count: usize,
    largest: Vec<(String, u64)>,
}

/// A camera of the file, which may have no name.
#[derive(Debug, Serialize)]
struct CameraRow {
    name: Option<String>,
    used: bool,
}

/// Most names in the report.
const MAX_NAMES: usize = 1000;
/// Most names in a row of the table, and most characters of each.
const MAX_SHOWN: usize = 8;
const NAME_CHARS: usize = 40;

impl NameList {
    fn of(sizes: &[(&str, u64)]) -> NameList {
        let largest = sizes.iter().take(MAX_NAMES);
        NameList {
            count: sizes.len(),
            largest: Vec::from_iter(largest.map(|&(name, size)| (name.to_owned(), size))),
        }
    }

    /// The largest in words; none if nothing has a name.
    fn words(&self) -> Option<String> {
        let word = |(name, size): &(String, u64)| format!("{} {}", short(name), grouped(*size));
        let words = first_words(self.largest.iter().map(word))?;
        let count = grouped(self.count as u64);
        Some(format!("{count} {}: {words}", plural(self.count, "name")))
    }
}

/// A name in the table.
fn short(name: &str) -> String {
    match name.char_indices().nth(NAME_CHARS) {
        Some((end, _)) => format!("`{}…`", &name[..end]),
        None => format!("`{name}`"),
    }
}

/// The first of some words; none if there are none.
fn first_words(words: impl Iterator<Item = String>) -> Option<String> {
    let mut first: Vec<String> = words.take(MAX_SHOWN + 1).collect();
    if let Some(more) = first.get_mut(MAX_SHOWN) {
        *more = "…".to_owned();
    }
    (!first.is_empty()).then(|| first.join(", "))
}

/// Cameras in words, by the numbers and names that --camera-name takes.
fn camera_words(cameras: &[CameraRow]) -> Option<String> {
    let word = |(row, camera): (usize, &CameraRow)| {
        let name = camera.name.as_deref().map(short);
        let used = camera.used.then(|| "(used)".to_owned());
        let parts = [Some(row.to_string()), name, used];
        Vec::from_iter(parts.into_iter().flatten()).join(" ")
    };
    first_words(cameras.iter().enumerate().map(word))
}

/// Numbers of meshes, instances and visible primitives.
#[derive(Debug, Serialize)]
struct InstanceCounts {
    meshes: usize,
    instances: usize,
    /// Primitives, counting those of a mesh once per instance.
    visible_primitives: u64,
}

#[derive(Debug, Default, Serialize)]
struct LightCounts {
    point: usize,
    directional: usize,
    sphere: usize,
    rectangle: usize,
}

impl LightCounts {
    fn of(scene: &Scene) -> LightCounts {
        let shapes = (0..scene.lights.len()).map(|i| scene.lights.shape(i));
        let mut count = LightCounts::default();
        for shape in shapes {
            match shape {
                LightShape::Point => count.point += 1,
                LightShape::Directional => count.directional += 1,
                LightShape::Sphere(_) => count.sphere += 1,
                LightShape::Rectangle(_) => count.rectangle += 1,
            }
        }
        count
    }

    /// The counts in words. Area lights are listed only if there are any.
    fn words(&self) -> String {
        let mut words = format!("{} point, {} directional", self.point, self.directional);
        for (count, name) in [(self.sphere, "sphere"), (self.rectangle, "rectangle")] {
            if count > 0 {
                words.push_str(&format!(", {count} {name}"));
            }
        }
        words
    }
}

#[derive(Debug, PartialEq, Serialize)]
struct FileBounds {
    lo: [f64; 3],
    hi: [f64; 3],
}

/// Prints the contents of a scene.
pub fn run(args: &InfoArgs) -> Result<(), CliError> {
    args.scene_args.no_picture()?;
    interrupt::listen()?;
    let mut scene_input =
        SceneInput::load(&args.scene, &args.scene_args, WantedPicture::default(), 0)?;
    let tree = scene_input.prepare(Engine::Simd, &args.tree, 0)?;
    let (scene, mapped) = (&scene_input.scene, scene_input.mapped_bytes);
    let mut document = InfoDocument::new(&args.scene, scene, tree.tree_stats(), mapped);
    let listed = args.json || output::verbosity() == Verbosity::Verbose;
    document.lights_by_power = listed.then(|| LightRow::all(scene));
    output::print_output(&document, args.json)
}

impl InfoDocument {
    fn new(path: &Path, scene: &Scene, tree: TreeStats, mapped_bytes: u64) -> InfoDocument {
        let [named_objects, named_materials] = scene.name_sizes().map(|sizes| NameList::of(&sizes));
        let used = scene.used_camera();
        let cameras = (scene.cameras.iter().enumerate()).map(|(row, camera)| CameraRow {
            name: scene.names.get(camera.name).map(str::to_owned),
            used: used == Some(row),
        });
        let cameras = cameras.collect();
        InfoDocument {
            scene: path.to_string_lossy().into_owned(),
            image: ImageSize {
                width: scene.width,
                height: scene.height,
            },
            max_depth: scene.max_depth,
            primitives: PrimitiveCounts::of(scene),
            instances: InstanceCounts {
                meshes: scene.meshes.len(),
                instances: scene.instances.len(),
                visible_primitives: scene.visible_count(),
            },
            lights: LightCounts::of(scene),
            lights_by_power: None,
            materials: scene.materials.len(),
            named_objects,
            named_materials,
            cameras,
            camera: CameraReport::of(scene, (scene.width, scene.height)),
            bounds: bounds(scene),
            origin: scene.origin,
            bvh: tree.into(),
            memory: MemoryStats::of(scene, &tree, 0, mapped_bytes),
        }
    }
}

impl Output for InfoDocument {
    fn table(&self) -> String {
        let corner = |c: [f64; 3]| format!("({}, {}, {})", c[0], c[1], c[2]);
        let bounds = match &self.bounds {
            Some(b) => format!("{} to {}", corner(b.lo), corner(b.hi)),
            None => "empty".to_owned(),
        };
        let ImageSize { width, height } = self.image;
        let image = format!("{width}x{height}, max depth {}", self.max_depth);
        let tree = format!("{}, cost {:.2}", self.bvh.words(), self.bvh.sah);
        let materials = grouped(self.materials as u64);
        let materials = [Some(materials), self.named_materials.words()];
        let materials = Vec::from_iter(materials.into_iter().flatten()).join(", ");
        let placed = &self.instances;
        let placed = (placed.meshes > 0).then(|| {
            format!(
                "{} of {} meshes: {} visible primitives",
                grouped(placed.instances as u64),
                grouped(placed.meshes as u64),
                grouped(placed.visible_primitives)
            )
        });
        let rows = [
            Some(("scene", self.scene.clone())),
            Some(("image", image)),
            camera_words(&self.cameras).map(|words| ("cameras", words)),
            Some(self.camera.row()),
            Some(("primitives", self.primitives.words())),
            placed.map(|words| ("instances", words)),
            self.named_objects.words().map(|words| ("objects", words)),
            Some(("lights", self.lights.words())),
            Some(("materials", materials)),
            Some(("bounds", bounds)),
            origin_row(self.origin),
            Some(("tree", tree)),
        ];
        let mut rows = Vec::from_iter(rows.into_iter().flatten());
        rows.extend(self.memory.rows());
        lines(&rows) + &LightRow::table(self.lights_by_power.as_deref().unwrap_or_default())
    }
}

/// Bounds in the file's own coordinates.
fn bounds(scene: &Scene) -> Option<FileBounds> {
    let bounds = scene.bounds();
    (!bounds.is_empty()).then(|| FileBounds {
        lo: scene.short_position(bounds.lo).to_array(),
        hi: scene.short_position(bounds.hi).to_array(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn scene() -> Scene {
        let mut scene = Scene::default();
        scene.add_sphere(Vec3::new(1.0, 2.0, 3.0), 0.5, 0);
        scene.add_triangle([Vec3::ZERO, Vec3::X, Vec3::Y], None, 0);
        scene.add_ellipsoid(glam::Affine3A::IDENTITY, glam::Affine3A::IDENTITY, 0);
        scene.lights.add_point(Vec3::ONE, Vec3::ONE, Vec3::X);
        scene.lights.add_point(Vec3::ONE, Vec3::ONE, Vec3::X);
        scene.lights.add_directional(Vec3::Y, Vec3::ONE);
        let (corner, edges) = (Vec3::ZERO, [Vec3::X, Vec3::Z]);
        (scene.lights).add_rectangle(corner, edges, Vec3::ONE, Vec3::X);
        scene
    }

    const TREE: TreeStats = TreeStats {
        nodes: 5,
        depth: 3,
        sah: 7.25,
        node_bytes: 160,
        prim_bytes: 96,
        wide_bytes: 32,
    };

    #[test]
    fn the_document_has_the_promised_keys() {
        let json = serde_json::to_value(InfoDocument::new(Path::new("a.test"), &scene(), TREE, 0))
            .unwrap();
        assert_eq!(
            json["primitives"],
            serde_json::json!({"spheres": 2, "triangles": 1, "cones": 0})
        );
        assert_eq!(
            json["lights"],
            serde_json::json!({"point": 2, "directional": 1, "sphere": 0, "rectangle": 1})
        );
        let words = "2 point, 1 directional, 1 rectangle";
        assert_eq!(LightCounts::of(&scene()).words(), words);
        assert_eq!(json["materials"], 0);
        assert_eq!(
            json["bounds"],
            serde_json::json!({"lo": [-1.0, -1.0, -1.0], "hi": [1.5, 2.5, 3.5]})
        );
        assert_eq!(
            json["bvh"],
            serde_json::json!({"nodes": 5, "depth": 3, "sah": 7.25})
        );
        let memory = &json["memory"];
        assert_eq!(memory["bvh_node_bytes"], 160);
        let scene_bytes = memory["scene_bytes"].as_u64().unwrap();
        assert_eq!(memory["total_bytes"], scene_bytes + 288);
    }

    #[test]
    fn what_instances_show_is_counted_and_bounded() {
        let mut scene = scene();
        let mesh = scene.begin_mesh();
        scene.add_sphere(Vec3::ZERO, 1.0, 0);
        scene.add_sphere(Vec3::X, 1.0, 0);
        scene.end_mesh(mesh);
        let document = InfoDocument::new(Path::new("a.test"), &scene, TREE, 0);
        assert_eq!(document.instances.visible_primitives, 3);
        assert_eq!(bounds(&scene), bounds(&self::scene()), "not placed");
        for x in [10.0, 20.0] {
            let position = glam::DVec3::new(x, 0.0, 0.0);
            let map = glam::DAffine3::from_translation(position);
            scene.add_instance(mesh, map).unwrap();
        }
        let document = InfoDocument::new(Path::new("a.test"), &scene, TREE, 0);
        assert_eq!(document.instances.visible_primitives, 7);
        assert!(
            document
                .table()
                .contains("2 of 1 meshes: 7 visible primitives")
        );
        let hi = bounds(&scene).unwrap().hi[0];
        assert!((22.0..22.01).contains(&hi), "{hi}");
    }

    #[test]
    fn bounds_are_those_of_the_file() {
        let mut scene = scene();
        scene.scale = 0.25;
        assert_eq!(bounds(&scene).unwrap().hi, [6.0, 10.0, 14.0]);
        assert_eq!(bounds(&Scene::default()), None);
    }
}
