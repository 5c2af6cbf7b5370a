//! The scene: structure-of-arrays columns, one per attribute. Nothing here depends on how the
//! columns are traced.
//!
//! A [`Scene`] is built by a reader in `formats` (or by hand) and checked once with
//! [`Scene::validate`]; after that nothing downstream can fail. Primitives are numbered in file
//! order: `prim_id` indexes [`Scene::prims`], which gives the column that holds the primitive.
//! Units are the scene's own, angles degrees, colours linear RGB.
//!
//! A mesh is a run of primitives that is visible only through its instances. The primitives of an
//! instance have numbers of their own beyond the stored ones, so that one `prim_id` always
//! identifies the hit primitive: see [`Scene::resolve`].

mod bounds;
pub mod camera;
mod camera_matrices;
mod camera_path;
mod cameras;
mod column;
mod columns;
mod coverage;
mod defaulted_parts;
mod edits;
mod encoding;
mod environment;
pub mod film;
mod fork_safe_once;
mod geometries;
mod geometry;
#[allow(unsafe_code, reason = "the system takes advice by address alone")]
#[doc(hidden)]
pub mod huge_pages;
mod instances;
mod integrator_settings;
pub mod lighting;
mod lights;
mod materials;
mod mattes;
mod memory;
mod metallic_roughness;
mod moving;
mod names;
mod naming;
mod origin;
mod prim_places;
mod prims;
mod ray_counts;
mod removing;
mod rescale;
pub mod sampling;
mod scene;
mod tangents;
mod terminator;
mod texture_maps;
mod textures;
mod threads;
mod up_axis;
mod validate;
mod vectors;
mod view;
mod visible_vertices;
#[doc(hidden)]
pub mod workers;

pub use bounds::{
    Bounds, DOUBLE_ROUNDING, MAX_OFFSET_PER_DISTANCE, OFFSET_PER_COORDINATE, OFFSET_PER_EDGE, PAD,
    PLANE_ROUNDING,
};
pub use camera_matrices::CameraMatrices;
pub use camera_path::{CameraKey, CameraPath};
pub use cameras::SceneCamera;
pub use column::{AnyColumn, Column};
pub use coverage::{MAX_PASSES, MIN_SURFACE_SHARE, SurfaceHit};
pub use defaulted_parts::{DefaultedParts, OrthoHeight};
pub use edits::{Edits, PartChange, SceneChanges};
pub use encoding::{OutputEncoding, Quantize, Transfer};
pub use environment::{
    Environment, EnvironmentLight, EnvironmentMap, EnvironmentTexels, MAX_ENVIRONMENT_SIDE,
};
#[doc(hidden)]
pub use fork_safe_once::ForkSafeOnce;
pub use geometries::{GeomId, Geometries, Geometry, NO_GEOM};
pub use geometry::GeometryError;
pub use instances::{Instances, Meshes};
pub use integrator_settings::IntegratorSettings;
pub use lights::{LightShape, Lights, SHADOWLESS};
pub use materials::{METALLIC_ROUGHNESS, Material, MaterialTable, Materials, SINGLE_SIDED, THIN};
pub use mattes::{MatteIds, material_names, matte_id, object_names};
pub use metallic_roughness::{LobeWeights, MetallicRoughness};
pub use names::{NO_NAME, NameTable};
pub use origin::FileView;
pub use prim_places::PrimPlace;
pub use prims::*;
pub use ray_counts::RayCounts;
pub use scene::{ResolvedPrim, Scene};
pub use terminator::{OwnFacets, SMOOTH_SLOPE};
pub use texture_maps::{MapTarget, TextureMap, TextureMaps};
pub use textures::{MAX_TEXTURE_SIDE, NO_TEXTURE, Texture, Wrap};
#[doc(hidden)]
pub use threads::{map_on_pool, on_pool, set_pool_threads, thread_count};
pub use up_axis::UpAxis;
pub use validate::{MAX_DEPTH_LIMIT, MAX_SIDE, SceneError, check_image_size};
pub use vectors::{Vec2s, Vec3s};
pub use view::{Basis, View, ViewError};
#[doc(hidden)]
pub use visible_vertices::{VisibleVertices, blocks_of_prims};
