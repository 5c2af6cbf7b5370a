//! The part of Embree's C interface that is used here. This is the only file of the `peers` module
//! with foreign signatures.
//!
//! Versions 3 and 4 share the layout of rays and hits, the numbers of their enumerations and most
//! signatures. They differ in how they describe a query. Version 4 passes optional
//! `RTCIntersectArguments` (or `RTCOccludedArguments`, which have the same layout) after the rays.
//! Version 3 passes an `RTCIntersectContext` before them.

use super::layout::{QueryArguments, RayHit, Valid};
use phalanx_trace::bvh::Quality;
use std::ffi::{CString, c_char, c_int, c_uint, c_void};
use std::marker::PhantomData;
use std::mem::ManuallyDrop;
use std::ptr::{NonNull, null_mut};
use std::sync::Arc;

const TRIANGLES: c_int = 0;
const SPHERES: c_int = 50;
const INSTANCE: c_int = 121;
const INDEX_BUFFER: c_int = 0;
const VERTEX_BUFFER: c_int = 1;
const UINT3: c_int = 0x5003;
const FLOAT3: c_int = 0x9003;
const FLOAT4: c_int = 0x9004;
const FLOAT3X4_COLUMN_MAJOR: c_int = 0x9234;
const ROBUST: c_int = 1 << 2;
const VERSION_PARTS: [c_int; 3] = [1, 2, 3];
const NATIVE_RAY16_SUPPORTED: c_int = 34;

type Handle = *mut c_void;
type Single = unsafe extern "C" fn(Handle, *mut c_void, *mut c_void);
type Packet = unsafe extern "C" fn(*const i32, Handle, *mut c_void, *mut c_void);

/// The functions of one query, for one, eight and sixteen rays.
struct QueryFns {
    one: Single,
    eight: Packet,
    sixteen: Packet,
}

/// The functions of one library. It stays loaded for the rest of the process: threads that it
/// started may sleep in its code forever.
pub(super) struct Api {
    new_device: unsafe extern "C" fn(*const c_char) -> Handle,
    release_device: unsafe extern "C" fn(Handle),
    device_error: unsafe extern "C" fn(Handle) -> c_int,
    device_property: unsafe extern "C" fn(Handle, c_int) -> isize,
    new_scene: unsafe extern "C" fn(Handle) -> Handle,
    release_scene: unsafe extern "C" fn(Handle),
    set_quality: unsafe extern "C" fn(Handle, c_int),
    set_flags: unsafe extern "C" fn(Handle, c_int),
    attach: unsafe extern "C" fn(Handle, Handle, c_uint),
    commit_scene: unsafe extern "C" fn(Handle),
    new_geometry: unsafe extern "C" fn(Handle, c_int) -> Handle,
    release_geometry: unsafe extern "C" fn(Handle),
    commit_geometry: unsafe extern "C" fn(Handle),
    new_buffer: unsafe extern "C" fn(Handle, c_int, c_uint, c_int, usize, usize) -> *mut c_void,
    set_instanced: unsafe extern "C" fn(Handle, Handle),
    set_transform: unsafe extern "C" fn(Handle, c_uint, c_int, *const c_void),
    intersect: QueryFns,
    occluded: QueryFns,
    _library: ManuallyDrop<libloading::Library>,
}

impl Api {
    /// Loads a library as Embree.
    ///
    /// # Errors
    /// The loader's message: no such library, or a symbol that it lacks.
    pub(super) fn load(name: &std::ffi::OsStr) -> Result<Api, libloading::Error> {
        // SAFETY: the caller who names a library (the user, or the lists of `find`) means Embree,
        // whose initialisers do no more than register algorithms; floating-point modes they might
        // change are restored by the caller.
        let library = ManuallyDrop::new(unsafe { libloading::Library::new(name) }?);
        // SAFETY: every symbol has the type of the field that it is loaded into, by the headers of
        // versions 3 and 4. The symbols that differ between them differ in the order of pointers,
        // which is decided where they are called.
        unsafe {
            Ok(Api {
                new_device: symbol(&library, "rtcNewDevice")?,
                release_device: symbol(&library, "rtcReleaseDevice")?,
                device_error: symbol(&library, "rtcGetDeviceError")?,
                device_property: symbol(&library, "rtcGetDeviceProperty")?,
                new_scene: symbol(&library, "rtcNewScene")?,
                release_scene: symbol(&library, "rtcReleaseScene")?,
                set_quality: symbol(&library, "rtcSetSceneBuildQuality")?,
                set_flags: symbol(&library, "rtcSetSceneFlags")?,
                attach: symbol(&library, "rtcAttachGeometryByID")?,
                commit_scene: symbol(&library, "rtcCommitScene")?,
                new_geometry: symbol(&library, "rtcNewGeometry")?,
                release_geometry: symbol(&library, "rtcReleaseGeometry")?,
                commit_geometry: symbol(&library, "rtcCommitGeometry")?,
                new_buffer: symbol(&library, "rtcSetNewGeometryBuffer")?,
                set_instanced: symbol(&library, "rtcSetGeometryInstancedScene")?,
                set_transform: symbol(&library, "rtcSetGeometryTransform")?,
                intersect: QueryFns {
                    one: symbol(&library, "rtcIntersect1")?,
                    eight: symbol(&library, "rtcIntersect8")?,
                    sixteen: symbol(&library, "rtcIntersect16")?,
                },
                occluded: QueryFns {
                    one: symbol(&library, "rtcOccluded1")?,
                    eight: symbol(&library, "rtcOccluded8")?,
                    sixteen: symbol(&library, "rtcOccluded16")?,
                },
                _library: library,
            })
        }
    }
}

/// A function of the library.
///
/// # Safety
/// `F` must be the type of a function pointer, and the type of that function.
unsafe fn symbol<F: Copy>(
    library: &libloading::Library,
    name: &str,
) -> Result<F, libloading::Error> {
    // SAFETY: as the caller promises. The copy may outlive the borrow, because the library is never
    // unloaded.
    unsafe { library.get::<F>(name) }.map(|symbol| *symbol)
}

/// An error that Embree reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", self.text())]
pub struct EmbreeFault(c_int);

impl EmbreeFault {
    fn text(self) -> &'static str {
        match self.0 {
            2 => "invalid argument",
            3 => "invalid operation",
            4 => "out of memory",
            5 => "this CPU is not supported",
            6 => "cancelled",
            _ => "unknown error",
        }
    }
}

/// A reference to an object of the library, which is returned when this is dropped.
struct Owned {
    api: Arc<Api>,
    handle: NonNull<c_void>,
    release: unsafe extern "C" fn(Handle),
}

impl Owned {
    /// The object that the library made; where it made none, the error of the device, or of the
    /// thread for a null device.
    fn new(
        api: &Arc<Api>,
        handle: Handle,
        release: unsafe extern "C" fn(Handle),
        device: Handle,
    ) -> Result<Owned, EmbreeFault> {
        // SAFETY: the device exists or is null.
        let fault = || EmbreeFault(unsafe { (api.device_error)(device) });
        Ok(Owned {
            api: Arc::clone(api),
            handle: NonNull::new(handle).ok_or_else(fault)?,
            release,
        })
    }

    fn get(&self) -> Handle {
        self.handle.as_ptr()
    }
}

impl Drop for Owned {
    fn drop(&mut self) {
        // SAFETY: the function is that of the object's kind, and the one reference that its maker
        // was given is returned; objects that depend on it hold references of their own.
        unsafe { (self.release)(self.handle.as_ptr()) }
    }
}

/// An Embree device, which creates scenes.
pub(super) struct Device {
    owned: Owned,
    /// Major, minor and patch version.
    pub(super) version: [u32; 3],
    /// True if one call with sixteen rays does more than two calls with eight.
    pub(super) sixteen: bool,
}

// SAFETY: Embree's devices are reference counted atomically, and may be used from any thread; the
// handle is only asked for properties and for new objects, which Embree allows at the same time.
unsafe impl Send for Device {}
// SAFETY: as above.
unsafe impl Sync for Device {}

impl Device {
    /// Creates a device that builds with the given number of threads; 0 means one per CPU.
    pub(super) fn new(api: &Arc<Api>, threads: usize) -> Result<Device, EmbreeFault> {
        let config = CString::new(format!("threads={threads},verbose=0")).unwrap_or_default();
        // SAFETY: the string ends with a zero and outlives the call.
        let handle = unsafe { (api.new_device)(config.as_ptr()) };
        let owned = Owned::new(api, handle, api.release_device, null_mut())?;
        // SAFETY: the device exists, the properties are known to both versions.
        let property = |p: c_int| unsafe { (api.device_property)(handle, p) };
        Ok(Device {
            version: VERSION_PARTS.map(|part| property(part) as u32),
            sixteen: property(NATIVE_RAY16_SUPPORTED) != 0,
            owned,
        })
    }

    fn api(&self) -> &Arc<Api> {
        &self.owned.api
    }

    /// Returns the error since the last call of this function, if there is one.
    fn check(&self) -> Result<(), EmbreeFault> {
        // SAFETY: the device exists.
        match unsafe { (self.api().device_error)(self.owned.get()) } {
            0 => Ok(()),
            code => Err(EmbreeFault(code)),
        }
    }
}

/// How a scene's trees are built and queried.
#[derive(Clone, Copy)]
pub(super) struct SceneOptions {
    pub(super) quality: Quality,
    /// True if no ray may be lost at an edge.
    pub(super) robust: bool,
}

impl SceneOptions {
    /// Embree's number of the quality.
    fn quality(self) -> c_int {
        match self.quality {
            Quality::Fast => 0,
            Quality::Medium => 1,
            Quality::Best => 2,
        }
    }
}

/// A scene under construction.
pub(super) struct EmbreeSceneDraft {
    device: Arc<Device>,
    scene: Owned,
}

impl EmbreeSceneDraft {
    /// Creates an empty scene.
    pub(super) fn new(
        device: &Arc<Device>,
        options: SceneOptions,
    ) -> Result<EmbreeSceneDraft, EmbreeFault> {
        let api = device.api();
        // SAFETY: the device exists.
        let handle = unsafe { (api.new_scene)(device.owned.get()) };
        let scene = Owned::new(api, handle, api.release_scene, device.owned.get())?;
        // SAFETY: the scene exists and is not committed yet.
        unsafe {
            (api.set_quality)(handle, options.quality());
            (api.set_flags)(handle, if options.robust { ROBUST } else { 0 });
        }
        Ok(EmbreeSceneDraft {
            device: Arc::clone(device),
            scene,
        })
    }

    /// Adds triangles as the geometry with that id. Triangles whose vertices do not exist are
    /// omitted.
    pub(super) fn triangles(
        &mut self,
        id: u32,
        vertices: &[[f32; 3]],
        corners: &[[u32; 3]],
    ) -> Result<(), EmbreeFault> {
        let geometry = self.geometry(TRIANGLES)?;
        self.fill(&geometry, VERTEX_BUFFER, FLOAT3, vertices)?;
        self.fill(&geometry, INDEX_BUFFER, UINT3, corners)?;
        self.attach(geometry, id)
    }

    /// Adds spheres, (x, y, z, radius) each, as the geometry with that id.
    pub(super) fn spheres(&mut self, id: u32, spheres: &[[f32; 4]]) -> Result<(), EmbreeFault> {
        let geometry = self.geometry(SPHERES)?;
        self.fill(&geometry, VERTEX_BUFFER, FLOAT4, spheres)?;
        self.attach(geometry, id)
    }

    /// Adds another scene of the same device as an instance, positioned by the columns of an affine
    /// map.
    pub(super) fn instance(
        &mut self,
        id: u32,
        prototype: &CommittedScene,
        columns: &[[f32; 3]; 4],
    ) -> Result<(), EmbreeFault> {
        let geometry = self.geometry(INSTANCE)?;
        let api = self.device.api();
        // SAFETY: geometry and scene exist, and Embree keeps a reference of its own to the scene.
        // The map is twelve floats, column by column, as the format demands, and is copied.
        unsafe {
            (api.set_instanced)(geometry.get(), prototype.0.scene.get());
            let map = columns.as_ptr().cast();
            (api.set_transform)(geometry.get(), 0, FLOAT3X4_COLUMN_MAJOR, map);
        }
        self.attach(geometry, id)
    }

    fn geometry(&self, kind: c_int) -> Result<Owned, EmbreeFault> {
        let (api, device) = (self.device.api(), self.device.owned.get());
        // SAFETY: the device exists.
        let handle = unsafe { (api.new_geometry)(device, kind) };
        Owned::new(api, handle, api.release_geometry, device)
    }

    /// Copies rows into a new buffer of a geometry, which Embree pads as it needs.
    fn fill<const W: usize, T: Copy>(
        &self,
        geometry: &Owned,
        buffer: c_int,
        format: c_int,
        rows: &[[T; W]],
    ) -> Result<(), EmbreeFault> {
        let (width, count) = (size_of::<[T; W]>(), rows.len());
        let new_buffer = self.device.api().new_buffer;
        // SAFETY: the geometry exists and has no such buffer yet.
        let room = unsafe { new_buffer(geometry.get(), buffer, 0, format, width, count) };
        self.device.check()?;
        let room = NonNull::new(room).ok_or(EmbreeFault(4))?;
        // SAFETY: Embree allocated `count` rows of `width` bytes, aligned to 16 bytes at least, and
        // that memory is not ours.
        unsafe { std::ptr::copy_nonoverlapping(rows.as_ptr(), room.as_ptr().cast(), count) };
        Ok(())
    }

    fn attach(&mut self, geometry: Owned, id: u32) -> Result<(), EmbreeFault> {
        let api = self.device.api();
        // SAFETY: both exist; the scene takes a reference of its own, so that ours ends here.
        unsafe {
            (api.commit_geometry)(geometry.get());
            (api.attach)(self.scene.get(), geometry.get(), id);
        }
        self.device.check()
    }

    /// Builds the trees.
    pub(super) fn build(self) -> Result<CommittedScene, EmbreeFault> {
        // SAFETY: the scene exists, and no other thread has it.
        unsafe { (self.device.api().commit_scene)(self.scene.get()) };
        self.device.check()?;
        Ok(CommittedScene(self))
    }
}

/// A finished scene with built trees.
pub(super) struct CommittedScene(EmbreeSceneDraft);

// SAFETY: Embree's queries of a committed scene may run on any number of threads, and no other call
// takes a `&CommittedScene` but being instanced, which counts an atomic reference.
unsafe impl Send for CommittedScene {}
// SAFETY: as above.
unsafe impl Sync for CommittedScene {}

/// One thread's access to a scene for queries of one ray, eight or sixteen. All data for a call is
/// adjacent here, because the number of address look-ups matters for single rays.
pub(super) struct QueryCaller<'a, const N: usize> {
    scene: Handle,
    intersect: EntryPoints,
    occluded: EntryPoints,
    /// True if the library is of version 4, where the query comes last.
    query_last: bool,
    query: QueryArguments,
    built: PhantomData<&'a CommittedScene>,
}

/// Functions of a query for single rays, and for packets of the caller's width.
#[derive(Clone, Copy)]
struct EntryPoints {
    one: Single,
    many: Packet,
}

impl CommittedScene {
    /// Creates a caller for queries, optimised for coherent rays or for any.
    pub(super) fn caller<const N: usize>(&self, coherent: bool) -> QueryCaller<'_, N> {
        const { assert!(N == 1 || N == 8 || N == 16, "Embree's packets") };
        let device = &self.0.device;
        let entry = |query: &QueryFns| EntryPoints {
            one: query.one,
            many: if N == 16 { query.sixteen } else { query.eight },
        };
        QueryCaller {
            scene: self.0.scene.get(),
            intersect: entry(&device.api().intersect),
            occluded: entry(&device.api().occluded),
            query_last: device.version[0] >= 4,
            query: QueryArguments::new(coherent),
            built: PhantomData,
        }
    }
}

impl<const N: usize> QueryCaller<'_, N> {
    /// Finds the closest hits. A single ray is always valid.
    #[inline(always)]
    pub(super) fn intersect(&mut self, valid: &Valid<N>, rays: &mut RayHit<N>) {
        self.call(self.intersect, valid, rays);
    }

    /// Tests for any hit. A single ray is always valid.
    #[inline(always)]
    pub(super) fn occluded(&mut self, valid: &Valid<N>, rays: &mut RayHit<N>) {
        self.call(self.occluded, valid, rays);
    }

    #[inline(always)]
    fn call(&mut self, entry: EntryPoints, valid: &Valid<N>, rays: &mut RayHit<N>) {
        let rays: *mut c_void = std::ptr::from_mut(rays).cast();
        let (first, second) = if self.query_last {
            (rays, std::ptr::from_mut(&mut self.query.arguments).cast())
        } else {
            (std::ptr::from_mut(&mut self.query.context).cast(), rays)
        };
        // SAFETY: the scene is committed, and borrowed for the life of this caller. Rays, mask and
        // query have the layout, the alignment and the width that the function takes, in the order
        // of the library's version, and are borrowed for the call.
        unsafe {
            if N == 1 {
                (entry.one)(self.scene, first, second);
            } else {
                (entry.many)(valid.0.as_ptr(), self.scene, first, second);
            }
        }
    }
}
