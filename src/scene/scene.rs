//! The scene itself: columns, the numbers of primitives, bounds.

use crate::bounds::Bounds;
use crate::cameras::SceneCamera;
use crate::column::Column;
use crate::defaulted_parts::DefaultedParts;
use crate::edits::Edits;
use crate::encoding::OutputEncoding;
use crate::environment::Environment;
use crate::geometries::{Geometries, Geometry};
use crate::instances::{Instances, Meshes};
use crate::lights::Lights;
use crate::materials::Materials;
use crate::names::NameTable;
use crate::prims::{
    Cone, Cones, Ellipsoids, Mesh, Prim, PrimColumns, PrimKind, Spheres, Triangles,
};
use crate::texture_maps::TextureMaps;
use crate::textures::Texture;
use crate::threads::{BLOCK_ROWS, map_on_pool};
use crate::view::View;
use glam::Vec3;
use std::ops::Range;

/// Everything that a picture depends on: primitives, materials, lights, camera.
///
/// [`Scene::add_mesh`] and [`Scene::add_spheres`] check what they are given, and rays need no more.
/// The columns are public, so that generators and readers can fill them directly;
/// [`Scene::validate`] then checks all of them before anything is traced.
///
/// ```
/// # extern crate phalanx_scene as phalanx;
/// use phalanx::Scene;
///
/// let mut scene = Scene::new();
/// scene.add_spheres(&[[0.0, 0.0, -3.0]], &[1.0])?;
/// assert!(scene.validate().is_ok());
/// assert_eq!(scene.bounds().lo.to_array(), [-1.0, -1.0, -4.0]);
/// # Ok::<(), phalanx::GeometryError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scene {
    /// Image width in pixels, 1 to [`MAX_SIDE`](crate::MAX_SIDE).
    pub width: u32,
    /// Image height in pixels, 1 to [`MAX_SIDE`](crate::MAX_SIDE).
    pub height: u32,
    /// Bounces after the primary ray, 0 to [`MAX_DEPTH_LIMIT`](crate::MAX_DEPTH_LIMIT).
    pub max_depth: u32,
    /// Output name that the file requests, as it stands there. It may name a folder anywhere: write
    /// only to one that `phalanx_io::formats::is_bare_name` takes.
    pub output: Option<String>,
    /// Radiance of a ray that misses everything.
    pub background: Vec3,
    /// Surroundings, which mirrored and refracted rays that miss everything see in place of the
    /// background, and camera rays if [`Environment::is_background`].
    pub environment: Option<Environment>,
    /// True if shadow rays leave triangles from the smooth surface that their vertex normals
    /// describe, so that the shadow terminator of a model of few triangles has no steps.
    pub smooth_shadows: bool,
    /// Encoding that the format prescribes for its pictures.
    pub encoding: OutputEncoding,
    /// Camera.
    pub view: View,
    /// Cameras of the file, in its order; empty for formats that have but one.
    pub cameras: Vec<SceneCamera>,
    /// Parts that are made for each picture anew.
    pub defaulted: DefaultedParts,
    /// Kind and column index of each stored primitive, in file order.
    pub prims: Column<Prim>,
    /// Spheres under a similarity transform.
    pub spheres: Spheres,
    /// Spheres under any other affine transform.
    pub ellipsoids: Ellipsoids,
    /// Triangles with face or vertex normals.
    pub triangles: Triangles,
    /// Truncated cones and cylinders.
    pub cones: Cones,
    /// Runs of primitives that are visible only through instances.
    pub meshes: Meshes,
    /// Meshes placed in the world.
    pub instances: Instances,
    /// Primitives that were added together: see [`Scene::add_mesh`].
    pub geometries: Geometries,
    /// Names of objects, materials and cameras.
    pub names: NameTable,
    /// Surface parameters, shared between primitives.
    pub materials: Materials,
    /// Textures that vary materials over their surfaces.
    pub maps: TextureMaps,
    /// Pictures that materials refer to.
    pub textures: Vec<Texture>,
    /// Lights in file order; their sum follows that order.
    pub lights: Lights,
    /// Factor from a file's lux, candela and nits to the light of the scene; positive, and 1 where
    /// nothing was scaled. Emission is multiplied by it (see [`Scene::set_light_scale`]), and so is
    /// everything that is given in such units: see [`lighting`](crate::lighting).
    pub light_scale: f32,
    /// True if surfaces that emit light (Ke) are lights, as in formats where Ke is a radiance.
    /// Otherwise Ke is only seen: `.test` and standard scenes have point lights inside their lamps.
    pub emission_lights: bool,
    /// Scene units per file unit: a power of two, 1 unless the file's extent left the safe range of
    /// f32.
    pub scale: f32,
    /// Origin of the scene's coordinates, in those of the file: a file position p is `(p − origin)
    /// · scale` here (see [`Scene::scene_position`]). Zero unless a reader moved the scene; nothing
    /// that is added to a scene moves it.
    pub origin: [f64; 3],
    /// Stamps of the latest edits, for trees that follow: see [`Scene::set_vertices`].
    pub edits: Edits,
}

impl Default for Scene {
    fn default() -> Self {
        Scene {
            width: 640,
            height: 480,
            max_depth: 5,
            output: None,
            background: Vec3::ZERO,
            environment: None,
            smooth_shadows: false,
            encoding: OutputEncoding::LINEAR,
            view: View {
                eye: Vec3::new(0.0, 0.0, 1.0),
                center: Vec3::ZERO,
                up: Vec3::Y,
                fovy: 45.0,
                ortho: None,
            },
            cameras: Vec::new(),
            defaulted: DefaultedParts::default(),
            prims: Column::new(),
            spheres: Spheres::default(),
            ellipsoids: Ellipsoids::default(),
            triangles: Triangles::default(),
            cones: Cones::default(),
            meshes: Meshes::default(),
            instances: Instances::default(),
            geometries: Geometries::default(),
            names: NameTable::default(),
            materials: Materials::default(),
            maps: TextureMaps::default(),
            textures: Vec::new(),
            lights: Lights::default(),
            light_scale: 1.0,
            emission_lights: false,
            scale: 1.0,
            origin: [0.0; 3],
            edits: Edits::default(),
        }
    }
}

/// The stored primitive and the instance that a `prim_id` stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResolvedPrim {
    /// The stored primitive: an index into [`Scene::prims`].
    pub prim: u32,
    /// The instance that shows it; `None` for a primitive in the world itself.
    pub instance: Option<u32>,
}

impl Scene {
    /// Takes the view and the picture's shape of a camera of the file.
    pub fn use_camera(&mut self, camera: SceneCamera) {
        self.view = camera.view;
        self.width = camera.width;
        self.defaulted.view = false;
        self.defaulted.ortho_size = camera.ortho_size;
    }

    /// Index of the camera that gives the view. The height of its parallel rays may be another,
    /// which depends on the picture.
    pub fn used_camera(&self) -> Option<usize> {
        let placed = |view: View| View {
            ortho: None,
            ..view
        };
        let mut cameras = self.cameras.iter();
        cameras.position(|camera| placed(camera.view) == placed(self.view))
    }

    /// Number of stored primitives of all kinds, those of meshes among them.
    #[inline]
    pub fn prim_count(&self) -> usize {
        self.prims.len()
    }

    /// The columns of a kind of primitive.
    pub fn columns_of(&self, kind: PrimKind) -> &dyn PrimColumns {
        match kind {
            PrimKind::Sphere => &self.spheres,
            PrimKind::Ellipsoid => &self.ellipsoids,
            PrimKind::Triangle => &self.triangles,
            PrimKind::Cone => &self.cones,
        }
    }

    /// The columns of a kind of primitive, to be changed.
    pub fn columns_of_mut(&mut self, kind: PrimKind) -> &mut dyn PrimColumns {
        match kind {
            PrimKind::Sphere => &mut self.spheres,
            PrimKind::Ellipsoid => &mut self.ellipsoids,
            PrimKind::Triangle => &mut self.triangles,
            PrimKind::Cone => &mut self.cones,
        }
    }

    /// Number of stored primitives of a kind, which is the number of rows of its columns.
    #[inline]
    pub fn count(&self, kind: PrimKind) -> usize {
        self.columns_of(kind).material().len()
    }

    /// [`Scene::count`] of every kind, in the order of their numbers.
    #[inline]
    pub fn counts(&self) -> [usize; PrimKind::COUNT] {
        PrimKind::ALL.map(|kind| self.count(kind))
    }

    /// Returns true if a ray's result involves random choices: a position on a light, or a
    /// direction in a glossy reflection.
    #[inline]
    pub fn is_stochastic(&self) -> bool {
        let mut lights = 0..self.lights.len();
        lights.any(|light| self.lights.is_area(light))
            || self.materials.gloss.iter().any(|&gloss| gloss > 0.0)
    }

    /// Number of visible primitives: those of a mesh count once for each of its instances, and not
    /// for themselves.
    #[inline]
    pub fn visible_count(&self) -> u64 {
        let stored = self.world_runs().into_iter().map(|run| run.len() as u64);
        let shown = self.visible_instances().map(|k| {
            let mesh = self.instances.mesh[k] as usize;
            u64::from(self.meshes.count[mesh])
        });
        stored.sum::<u64>() + shown.sum::<u64>()
    }

    /// Number of all `prim_id`s, with those that are free again: see [`Scene::resolve`].
    #[inline]
    pub fn id_count(&self) -> u64 {
        self.prim_count() as u64 + self.instanced_count()
    }

    /// Number of the numbers of primitives that instances show, with those that are free again.
    pub(crate) fn instanced_count(&self) -> u64 {
        let last = self.instances.first.last().zip(self.instances.mesh.last());
        last.map_or(0, |(&first, &mesh)| {
            u64::from(first) + u64::from(self.meshes.count[mesh as usize])
        })
    }

    /// The stored primitives that are visible in the world itself, without those of meshes, of
    /// hidden geometries and of removed ones, as runs in file order.
    pub fn world_runs(&self) -> Vec<Range<u32>> {
        let unseen = |unseen: Geometry| match unseen {
            Geometry::Prims { first, count } => Some(first..first + count),
            Geometry::Instance(_) => None,
        };
        let mesh = |mesh: usize| {
            let place = self.geometries.prim_place(self.meshes.first[mesh]);
            place.map_or(self.meshes.prims(mesh), |place| place.all_prims())
        };
        let mut others: Vec<Range<u32>> = (0..self.meshes.len())
            .map(mesh)
            .chain(self.geometries.unseen().filter_map(unseen))
            .collect();
        others.sort_unstable_by_key(|run| run.start);
        runs_between(0..self.prim_count() as u32, others)
    }

    /// The objects of the world, as runs: those of [`Scene::world_runs`], then those of
    /// [`Scene::instance_runs`].
    pub fn world_objects(&self) -> Vec<Range<u32>> {
        let mut runs = self.world_runs();
        runs.extend(self.instance_runs());
        runs
    }

    /// The visible instances as objects, which are numbered from [`Scene::prim_count`] on, as runs.
    pub fn instance_runs(&self) -> Vec<Range<u32>> {
        let first = self.prim_count() as u32;
        let mut unseen: Vec<u32> = (self.geometries.unseen())
            .filter_map(|unseen| match unseen {
                Geometry::Instance(k) => Some(first + k),
                Geometry::Prims { .. } => None,
            })
            .collect();
        unseen.sort_unstable();
        let unseen = unseen.into_iter().map(|object| object..object + 1);
        runs_between(first..first + self.instances.len() as u32, unseen)
    }

    /// Numbers of the visible instances.
    pub fn visible_instances(&self) -> impl Iterator<Item = usize> {
        let first = self.prim_count();
        let objects = self.instance_runs().into_iter().flatten();
        objects.map(move |object| object as usize - first)
    }

    /// The stored primitive and the instance of a `prim_id`. Numbers below [`Scene::prim_count`]
    /// are stored primitives. Those from there on number the primitives of the first instance, then
    /// those of the second, and so on.
    #[inline]
    pub fn resolve(&self, prim_id: u32) -> ResolvedPrim {
        let stored = self.prims.len() as u32;
        if prim_id < stored {
            return ResolvedPrim {
                prim: prim_id,
                instance: None,
            };
        }
        let offset = prim_id - stored;
        let instance = self.instances.first.partition_point(|&f| f <= offset) - 1;
        let mesh = self.instances.mesh[instance] as usize;
        ResolvedPrim {
            prim: self.meshes.first[mesh] + (offset - self.instances.first[instance]),
            instance: Some(instance as u32),
        }
    }

    /// The `prim_id` of the first primitive of an instance.
    #[inline]
    pub fn instance_first_id(&self, instance: usize) -> u32 {
        self.prims.len() as u32 + self.instances.first[instance]
    }

    /// Adds a sphere and returns its `prim_id`.
    #[inline]
    pub fn add_sphere(&mut self, center: Vec3, radius: f32, material: u32) -> u32 {
        let index = self.spheres.len();
        self.spheres.push(center, radius, material);
        self.add_prim(PrimKind::Sphere, index)
    }

    /// Adds the unit sphere under an affine map given both ways; returns its `prim_id`.
    ///
    /// `to_world` maps object space (where the sphere has radius 1 about the origin) to the world,
    /// `to_object` maps back.
    pub fn add_ellipsoid(
        &mut self,
        to_world: glam::Affine3A,
        to_object: glam::Affine3A,
        material: u32,
    ) -> u32 {
        let index = self.ellipsoids.len();
        self.ellipsoids.push(to_world, to_object, material);
        self.add_prim(PrimKind::Ellipsoid, index)
    }

    /// Adds a truncated cone or cylinder and returns its `prim_id`.
    #[inline]
    pub fn add_cone(&mut self, cone: Cone, material: u32) -> u32 {
        let index = self.cones.len();
        self.cones.push(cone, material);
        self.add_prim(PrimKind::Cone, index)
    }

    /// Adds a triangle with counter-clockwise vertices; `normals` are its vertex normals, if it has
    /// any. Returns its `prim_id`.
    pub fn add_triangle(
        &mut self,
        corners: [Vec3; 3],
        normals: Option<[Vec3; 3]>,
        material: u32,
    ) -> u32 {
        let index = self.triangles.len();
        self.triangles.push(corners, normals, material);
        self.add_prim(PrimKind::Triangle, index)
    }

    /// Adds triangles in one piece; into a scene without any, their columns are moved. Returns the
    /// first `prim_id`. Nothing is checked: [`Scene::validate`] does that for the whole scene.
    #[inline]
    pub fn append_mesh(&mut self, mesh: Mesh) -> u32 {
        let first_id = self.prims.len() as u32;
        let (first, count) = (self.triangles.len(), mesh.corners.len());
        self.triangles.append(mesh);
        let prim = |index| Prim::new(PrimKind::Triangle, index as u32);
        self.prims.extend((first..first + count).map(prim));
        first_id
    }

    fn add_prim(&mut self, kind: PrimKind, index: usize) -> u32 {
        let id = self.prims.len() as u32;
        self.prims.push(Prim::new(kind, index as u32));
        id
    }

    /// Begins a mesh: the primitives added until [`Scene::end_mesh`] are visible only through
    /// instances. Meshes do not nest.
    #[inline]
    pub fn begin_mesh(&mut self) -> u32 {
        self.meshes.first.push(self.prims.len() as u32);
        self.meshes.count.push(0);
        self.meshes.len() as u32 - 1
    }

    /// Ends the mesh that was begun last.
    #[inline]
    pub fn end_mesh(&mut self, mesh: u32) {
        let mesh = mesh as usize;
        self.meshes.count[mesh] = self.prims.len() as u32 - self.meshes.first[mesh];
    }

    /// Exact bounds of one stored primitive, unpadded, in the space where it is stored.
    #[inline]
    pub fn prim_bounds(&self, prim: u32) -> Bounds {
        let prim = self.prims[prim as usize];
        let i = prim.index();
        match prim.kind() {
            PrimKind::Sphere => self.spheres.bounds(i),
            PrimKind::Ellipsoid => self.ellipsoids.bounds(i),
            PrimKind::Triangle => self.triangles.bounds(i),
            PrimKind::Cone => self.cones.bounds(i),
        }
    }

    /// Bounds of a mesh's padded primitives, in the space where they are stored.
    pub fn mesh_bounds(&self, mesh: usize) -> Bounds {
        self.padded_bounds(self.meshes.prims(mesh))
    }

    /// Bounds of stored primitives, padded, in the space where they are stored.
    pub fn padded_bounds(&self, prims: Range<u32>) -> Bounds {
        self.bounds_of_run(prims, Bounds::padded)
    }

    /// [`Scene::mesh_bounds`] of every mesh.
    pub fn bounds_of_meshes(&self) -> Vec<Bounds> {
        map_on_pool(0..self.meshes.len(), |mesh| self.mesh_bounds(mesh))
    }

    /// Bounds of the boxes that `change` makes of those of a run of primitives.
    fn bounds_of_run(&self, run: Range<u32>, change: impl Fn(Bounds) -> Bounds + Sync) -> Bounds {
        let of_triangle = self.triangles.boxes();
        let of_block = |prims: &[Prim]| {
            prims.iter().fold(Bounds::EMPTY, |all, prim| {
                let own = match prim.kind() {
                    PrimKind::Triangle => of_triangle(prim.index()),
                    other => self.columns_of(other).bounds(prim.index()),
                };
                all.union(change(own))
            })
        };
        let prims = &self.prims[run.start as usize..run.end as usize];
        let blocks = map_on_pool(prims.chunks(BLOCK_ROWS), of_block).into_iter();
        blocks.fold(Bounds::EMPTY, Bounds::union)
    }

    /// Bounds of all visible primitives; empty for a scene without primitives.
    pub fn bounds(&self) -> Bounds {
        let world = self.world_runs().into_iter();
        let world = world.map(|run| self.bounds_of_run(run, |own| own));
        let direct = world.fold(Bounds::EMPTY, Bounds::union);
        let meshes = self.bounds_of_meshes();
        self.visible_instances().fold(direct, |all, k| {
            let mesh = self.instances.mesh[k] as usize;
            all.union(self.instances.bounds(k, meshes[mesh]))
        })
    }

    /// Material of a stored primitive.
    #[inline]
    pub fn prim_material(&self, prim: u32) -> u32 {
        let prim = self.prims[prim as usize];
        match prim.kind() {
            PrimKind::Sphere => self.spheres.material[prim.index()],
            PrimKind::Ellipsoid => self.ellipsoids.material[prim.index()],
            PrimKind::Triangle => self.triangles.material[prim.index()],
            PrimKind::Cone => self.cones.material[prim.index()],
        }
    }
}

/// The runs of `all` that none of `others` holds, which are ascending and do not overlap; they may
/// be empty.
fn runs_between(all: Range<u32>, others: impl IntoIterator<Item = Range<u32>>) -> Vec<Range<u32>> {
    let mut runs = Vec::new();
    let mut from = all.start;
    for other in others.into_iter().chain(std::iter::once(all.end..all.end)) {
        if from < other.start {
            runs.push(from..other.start);
        }
        from = from.max(other.end);
    }
    runs
}
