//! Scenes: what is added to them, named and moved.

use crate::rows::{PhxRows, WrittenRows, read, structure};
use crate::status::{ApiError, PhxStatus, answer, answer_if_wanted, first_answer, guarded};
use crate::table::{HandleTable, Opaque};
use phalanx::glam::{DAffine3, DVec3};
use phalanx::{GeometryError, Scene, isa};
use std::ffi::{CStr, CString, c_char};
use std::mem;
use std::sync::{OnceLock, PoisonError, RwLock, RwLockReadGuard, TryLockError};

pub static SCENES: HandleTable<RwLock<Scene>> = HandleTable::new(0x53, "scene");

/// `phx_mesh`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PhxMesh {
    pub size: usize,
    pub vertices: PhxRows,
    pub vertex_count: usize,
    pub triangles: PhxRows,
    pub triangle_count: usize,
}

/// A scene to look at; edits wait.
pub fn reading<'s>(scene: *const Opaque) -> Result<RwLockReadGuard<'s, Scene>, ApiError> {
    let scene = SCENES.get(scene)?.read();
    Ok(scene.unwrap_or_else(PoisonError::into_inner))
}

/// An edit, and the number that it returns.
fn edit<T: Copy + Default>(
    scene: *mut Opaque,
    (name, number): (&str, *mut T),
    edit: impl FnOnce(&mut Scene) -> Result<T, ApiError>,
) -> PhxStatus {
    // SAFETY: null or the caller's, as every function says.
    unsafe {
        answer_if_wanted(name, number, || {
            let scene = SCENES.get(scene)?.write();
            edit(&mut scene.unwrap_or_else(PoisonError::into_inner))
        })
    }
}

/// Where no number is returned.
const NOTHING: (&str, *mut ()) = ("", std::ptr::null_mut());

/// Refuses headers that are newer, or of another ABI.
pub fn check_version(version: u32) -> Result<(), ApiError> {
    if version / 10_000 == VERSION / 10_000 && version <= VERSION {
        return Ok(());
    }
    let words = format!("phalanx.h is of version {version}, and the library of {VERSION}");
    Err(ApiError(PhxStatus::Version, words))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_scene_create_for(version: u32, scene: *mut *mut Opaque) -> PhxStatus {
    // SAFETY: the caller's.
    unsafe {
        first_answer("scene", scene, || {
            check_version(version)?;
            SCENES.insert(RwLock::default())
        })
    }
}

/// 10000 · major + 100 · minor + patch.
const VERSION: u32 = {
    const fn number(digits: &str) -> u32 {
        match u32::from_str_radix(digits, 10) {
            Ok(number) => number,
            Err(_) => panic!("a version is three numbers"),
        }
    }
    let major = number(env!("CARGO_PKG_VERSION_MAJOR"));
    let minor = number(env!("CARGO_PKG_VERSION_MINOR"));
    10_000 * major + 100 * minor + number(env!("CARGO_PKG_VERSION_PATCH"))
};

#[unsafe(no_mangle)]
pub extern "C" fn phx_version() -> u32 {
    VERSION
}

#[unsafe(no_mangle)]
pub extern "C" fn phx_instruction_set() -> *const c_char {
    static NAME: OnceLock<CString> = OnceLock::new();
    let name = || CString::new(isa::compiled_level()).unwrap_or_default();
    NAME.get_or_init(name).as_ptr()
}

#[unsafe(no_mangle)]
pub extern "C" fn phx_scene_destroy(scene: *mut Opaque) -> PhxStatus {
    guarded(|| {
        if scene.is_null() {
            return Ok(());
        }
        // It stays taken, so that nobody begins to use it.
        mem::forget(match SCENES.get(scene)?.try_write() {
            Err(TryLockError::WouldBlock) => {
                let words = "the scene is built, edited or looked at";
                return Err(ApiError(PhxStatus::Busy, words.into()));
            }
            taken => taken,
        });
        SCENES.remove(scene)
    })
}

/// Adds a mesh in one of the scene's ways.
///
/// # Safety
/// As the header says of `phx_mesh`.
unsafe fn add(
    scene: *mut Opaque,
    number: (&str, *mut u32),
    mesh: *const PhxMesh,
    add: impl FnOnce(&mut Scene, &[[f32; 3]], &[[u32; 3]]) -> Result<u32, GeometryError>,
) -> PhxStatus {
    edit(scene, number, |scene| {
        // SAFETY: the caller's.
        let PhxMesh {
            vertices,
            vertex_count,
            triangles,
            triangle_count,
            ..
        } = unsafe { structure(mesh) }?;
        // SAFETY: the caller's.
        let vertices = unsafe { vertices.all("vertices", vertex_count, WrittenRows::NONE) }?;
        // SAFETY: the caller's.
        let triangles = unsafe { triangles.all("triangles", triangle_count, WrittenRows::NONE) }?;
        Ok(add(scene, &vertices, &triangles)?)
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_scene_add_mesh(
    scene: *mut Opaque,
    mesh: *const PhxMesh,
    geom_id: *mut u32,
) -> PhxStatus {
    // SAFETY: the caller's.
    unsafe { add(scene, ("geom_id", geom_id), mesh, Scene::add_mesh) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_scene_add_prototype(
    scene: *mut Opaque,
    mesh: *const PhxMesh,
    prototype: *mut u32,
) -> PhxStatus {
    // SAFETY: the caller's.
    unsafe { add(scene, ("prototype", prototype), mesh, Scene::add_prototype) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_scene_add_spheres(
    scene: *mut Opaque,
    centers: PhxRows,
    radii: PhxRows,
    count: usize,
    geom_id: *mut u32,
) -> PhxStatus {
    edit(scene, ("geom_id", geom_id), |scene| {
        // SAFETY: the caller's.
        let centers = unsafe { centers.all("centers", count, WrittenRows::NONE) }?;
        // SAFETY: the caller's.
        let radii = unsafe { radii.all("radii", count, WrittenRows::NONE) }?;
        Ok(scene.add_spheres(&centers, &radii)?)
    })
}

/// A map of three rows of four numbers.
///
/// # Safety
/// Null, or twelve numbers.
unsafe fn map(rows: *const [[f64; 4]; 3]) -> Result<DAffine3, ApiError> {
    // SAFETY: the caller's.
    let [x, y, z] = unsafe { read("to_world", rows) }?;
    let column = |k: usize| DVec3::new(x[k], y[k], z[k]);
    let [x, y, z, offset] = [0, 1, 2, 3].map(column);
    Ok(DAffine3::from_cols(x, y, z, offset))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_scene_add_instance(
    scene: *mut Opaque,
    prototype: u32,
    to_world: *const [[f64; 4]; 3],
    geom_id: *mut u32,
) -> PhxStatus {
    // SAFETY: the caller's.
    edit(scene, ("geom_id", geom_id), |scene| {
        Ok(scene.add_instance(prototype, unsafe { map(to_world) }?)?)
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_scene_set_transform(
    scene: *mut Opaque,
    geom_id: u32,
    to_world: *const [[f64; 4]; 3],
) -> PhxStatus {
    // SAFETY: the caller's.
    edit(scene, NOTHING, |scene| {
        Ok(scene.set_transform(geom_id, unsafe { map(to_world) }?)?)
    })
}

/// Moves the vertices of a mesh or a prototype.
///
/// # Safety
/// As the header says.
unsafe fn move_vertices(
    scene: *mut Opaque,
    (vertices, count): (PhxRows, usize),
    set: impl FnOnce(&mut Scene, &[[f32; 3]]) -> Result<(), GeometryError>,
) -> PhxStatus {
    edit(scene, NOTHING, |scene| {
        // SAFETY: the caller's.
        let vertices = unsafe { vertices.all("vertices", count, WrittenRows::NONE) }?;
        Ok(set(scene, &vertices)?)
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_scene_set_vertices(
    scene: *mut Opaque,
    geom_id: u32,
    vertices: PhxRows,
    count: usize,
) -> PhxStatus {
    let set = |scene: &mut Scene, all: &[[f32; 3]]| scene.set_vertices(geom_id, all);
    // SAFETY: the caller's.
    unsafe { move_vertices(scene, (vertices, count), set) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_scene_set_prototype_vertices(
    scene: *mut Opaque,
    prototype: u32,
    vertices: PhxRows,
    count: usize,
) -> PhxStatus {
    let set = |scene: &mut Scene, all: &[[f32; 3]]| scene.set_prototype_vertices(prototype, all);
    // SAFETY: the caller's.
    unsafe { move_vertices(scene, (vertices, count), set) }
}

#[unsafe(no_mangle)]
pub extern "C" fn phx_scene_set_mask(scene: *mut Opaque, geom_id: u32, mask: u32) -> PhxStatus {
    edit(scene, NOTHING, |scene| Ok(scene.set_mask(geom_id, mask)?))
}

#[unsafe(no_mangle)]
pub extern "C" fn phx_scene_remove(scene: *mut Opaque, geom_id: u32) -> PhxStatus {
    edit(scene, NOTHING, |scene| Ok(scene.remove(geom_id)?))
}

#[unsafe(no_mangle)]
pub extern "C" fn phx_scene_remove_prototype(scene: *mut Opaque, prototype: u32) -> PhxStatus {
    edit(scene, NOTHING, |scene| {
        Ok(scene.remove_prototype(prototype)?)
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_scene_set_name(
    scene: *mut Opaque,
    geom_id: u32,
    name: *const c_char,
) -> PhxStatus {
    edit(scene, NOTHING, |scene| {
        // SAFETY: the caller's.
        let name = unsafe { text("name", name) }?;
        Ok(scene.set_name(geom_id, name)?)
    })
}

/// Text in UTF-8.
///
/// # Safety
/// Null, or text that ends with a 0.
pub unsafe fn text<'t>(what: &str, text: *const c_char) -> Result<&'t str, ApiError> {
    if text.is_null() {
        return Err(ApiError::argument(format!("{what} is null")));
    }
    // SAFETY: the caller's.
    let text = unsafe { CStr::from_ptr(text) }.to_str();
    text.map_err(|error| ApiError::argument(format!("{what} is not UTF-8: {error}")))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_scene_get_name(
    scene: *const Opaque,
    prim_id: u32,
    name: *mut c_char,
    capacity: usize,
    length: *mut usize,
) -> PhxStatus {
    // SAFETY: the caller's, `name` for `capacity` bytes.
    unsafe {
        answer_if_wanted("length", length, || {
            if name.is_null() && capacity > 0 {
                return Err(ApiError::argument("name is null, and capacity is not 0"));
            }
            let scene = reading(scene)?;
            let known = scene.prim_names(prim_id)[0].unwrap_or("");
            if capacity > 0 {
                let mut ends = (0..=known.len().min(capacity - 1)).rev();
                let end = ends.find(|&end| known.is_char_boundary(end)).unwrap_or(0);
                name.cast::<u8>().copy_from(known.as_ptr(), end);
                name.add(end).write(0);
            }
            Ok(known.len())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_scene_get_bounds(
    scene: *const Opaque,
    bounds: *mut [f32; 6],
) -> PhxStatus {
    // SAFETY: the caller's.
    unsafe {
        answer("bounds", bounds, || {
            let bounds = reading(scene)?.bounds();
            let ([a, b, c], [d, e, f]) = (bounds.lo.into(), bounds.hi.into());
            Ok([a, b, c, d, e, f])
        })
    }
}
