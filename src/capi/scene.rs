//! Scenes: what is added to them, named and moved.

use crate::rows::{OutPointer, PhxRows, SizedStruct, read, structure};
use crate::status::{ApiError, PhxStatus, guarded};
use crate::table::{HandleTable, Opaque};
use phalanx::glam::DAffine3;
use phalanx::{GeometryError, Scene, isa};
use std::ffi::{CStr, CString, c_char};
use std::slice;
use std::sync::{OnceLock, PoisonError, RwLock, RwLockReadGuard};

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

// SAFETY: numbers and rows.
unsafe impl SizedStruct for PhxMesh {
    const NAME: &'static str = "phx_mesh";
}

/// A scene to look at; edits wait.
pub fn reading<'s>(scene: *const Opaque) -> Result<RwLockReadGuard<'s, Scene>, ApiError> {
    Ok(SCENES
        .get(scene)?
        .read()
        .unwrap_or_else(PoisonError::into_inner))
}

/// An edit, and the number that it returns.
fn edit<T>(
    scene: *mut Opaque,
    number: *mut T,
    edit: impl FnOnce(&mut Scene) -> Result<T, ApiError>,
) -> PhxStatus {
    guarded(|| {
        let number = OutPointer::optional("the place for a number", number)?;
        let mut scene = SCENES
            .get(scene)?
            .write()
            .unwrap_or_else(PoisonError::into_inner);
        let answer = edit(&mut scene)?;
        // SAFETY: null or the caller's, as every function says.
        unsafe { number.write(answer) };
        Ok(())
    })
}

/// Where no number is returned.
const NOTHING: *mut () = std::ptr::null_mut();

/// Refuses headers of other versions, and CPUs that the library is not built for.
pub fn check_build(version: u32) -> Result<(), ApiError> {
    if version / 100 != VERSION / 100 || version > VERSION {
        let words = format!("phalanx.h is of version {version}, and the library of {VERSION}");
        return Err(ApiError(PhxStatus::Version, words));
    }
    if let Some(lacking) = (isa::extensions().iter()).find(|e| e.compiled && !e.present) {
        let (level, name) = (isa::compiled_level(), lacking.name);
        let words = format!("the library is built for {level}: this CPU lacks {name}");
        return Err(ApiError(PhxStatus::Version, words));
    }
    Ok(())
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_scene_create_for(version: u32, scene: *mut *mut Opaque) -> PhxStatus {
    guarded(|| {
        let place = OutPointer::of("scene", scene)?;
        check_build(version)?;
        let scene = SCENES.insert(RwLock::new(Scene::new()))?;
        // SAFETY: the caller's.
        unsafe { place.write(scene) };
        Ok(())
    })
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
    guarded(|| if scene.is_null() { Ok(()) } else { SCENES.remove(scene) })
}

/// Passes on the vertices and triangles of a mesh.
///
/// # Safety
/// As the header says of `phx_mesh`.
unsafe fn with_mesh<T>(
    mesh: *const PhxMesh,
    take: impl FnOnce(&[[f32; 3]], &[[u32; 3]]) -> Result<T, GeometryError>,
) -> Result<T, ApiError> {
    // SAFETY: the caller's.
    unsafe {
        let mesh = structure(mesh)?;
        mesh.vertices
            .with("vertices", mesh.vertex_count, |vertices| {
                let triangles = mesh.triangles;
                triangles.with("triangles", mesh.triangle_count, |triangles| {
                    Ok(take(vertices, triangles)?)
                })
            })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_scene_add_mesh(
    scene: *mut Opaque,
    mesh: *const PhxMesh,
    geom_id: *mut u32,
) -> PhxStatus {
    // SAFETY: the caller's.
    edit(scene, geom_id, |scene| unsafe {
        with_mesh(mesh, |vertices, triangles| {
            scene.add_mesh(vertices, triangles)
        })
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_scene_add_prototype(
    scene: *mut Opaque,
    mesh: *const PhxMesh,
    prototype: *mut u32,
) -> PhxStatus {
    // SAFETY: the caller's.
    edit(scene, prototype, |scene| unsafe {
        with_mesh(mesh, |vertices, triangles| {
            scene.add_prototype(vertices, triangles)
        })
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_scene_add_spheres(
    scene: *mut Opaque,
    centers: PhxRows,
    radii: PhxRows,
    count: usize,
    geom_id: *mut u32,
) -> PhxStatus {
    // SAFETY: the caller's.
    edit(scene, geom_id, |scene| unsafe {
        centers.with("centers", count, |centers| {
            radii.with("radii", count, |radii| {
                Ok(scene.add_spheres(centers, radii)?)
            })
        })
    })
}

/// A map of three rows of four numbers.
///
/// # Safety
/// Null, or twelve numbers.
unsafe fn map(rows: *const [[f64; 4]; 3]) -> Result<DAffine3, ApiError> {
    // SAFETY: the caller's.
    let [x, y, z] = unsafe { read("to_world", rows) }?;
    let column = |k: usize| [x[k], y[k], z[k]].into();
    Ok(DAffine3::from_cols(
        column(0),
        column(1),
        column(2),
        column(3),
    ))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_scene_add_instance(
    scene: *mut Opaque,
    prototype: u32,
    to_world: *const [[f64; 4]; 3],
    geom_id: *mut u32,
) -> PhxStatus {
    // SAFETY: the caller's.
    edit(scene, geom_id, |scene| {
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

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_scene_set_vertices(
    scene: *mut Opaque,
    geom_id: u32,
    vertices: PhxRows,
    count: usize,
) -> PhxStatus {
    // SAFETY: the caller's.
    edit(scene, NOTHING, |scene| unsafe {
        vertices.with("vertices", count, |all| {
            Ok(scene.set_vertices(geom_id, all)?)
        })
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_scene_set_prototype_vertices(
    scene: *mut Opaque,
    prototype: u32,
    vertices: PhxRows,
    count: usize,
) -> PhxStatus {
    // SAFETY: the caller's.
    edit(scene, NOTHING, |scene| unsafe {
        vertices.with("vertices", count, |all| {
            Ok(scene.set_prototype_vertices(prototype, all)?)
        })
    })
}

#[unsafe(no_mangle)]
pub extern "C" fn phx_scene_set_mask(scene: *mut Opaque, geom_id: u32, mask: u32) -> PhxStatus {
    edit(scene, NOTHING, |scene| Ok(scene.set_mask(geom_id, mask)?))
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
    guarded(|| {
        let length = OutPointer::optional("length", length)?;
        if name.is_null() && capacity > 0 {
            return Err(ApiError::argument("name is null, and capacity is not 0"));
        }
        let scene = reading(scene)?;
        let known = scene.prim_names(prim_id)[0].unwrap_or("");
        if capacity > 0 {
            let mut end = known.len().min(capacity - 1);
            while !known.is_char_boundary(end) {
                end -= 1;
            }
            // SAFETY: the caller's: `capacity` bytes.
            let name = unsafe { slice::from_raw_parts_mut(name.cast::<u8>(), end + 1) };
            name[..end].copy_from_slice(&known.as_bytes()[..end]);
            name[end] = 0;
        }
        // SAFETY: null or the caller's.
        unsafe { length.write(known.len()) };
        Ok(())
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn phx_scene_get_bounds(
    scene: *const Opaque,
    lower: *mut [f32; 3],
    upper: *mut [f32; 3],
) -> PhxStatus {
    guarded(|| {
        let (lower, upper) = (
            OutPointer::of("lower", lower)?,
            OutPointer::of("upper", upper)?,
        );
        let bounds = reading(scene)?.bounds();
        // SAFETY: the caller's.
        unsafe {
            lower.write(bounds.lo.into());
            upper.write(bounds.hi.into());
        }
        Ok(())
    })
}
