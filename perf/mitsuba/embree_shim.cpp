// The 32 functions of Embree 3.13 that Mitsuba 3.9.1 imports, answered by phalanx.
//
// Built as libembree3.so, it takes the place of that library in Mitsuba's wheel. It does triangle
// meshes, one level of instances, filter functions of meshes, and rays one by one or in packets of
// 4, 8 and 16. Everything else is refused in words: the device's error function is called, and
// std::runtime_error thrown, which becomes an exception in Python. Embree never throws, but Mitsuba
// only logs its errors, and would render the scene without the shape. Ray functions are called from
// kernels compiled at run time, which nothing can be thrown through: they abort.

#include <phalanx.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

#define RTC_API __attribute__((visibility("default")))

// The wheel's Embree has its names in this namespace (EMBREE_API_NAMESPACE in rtcore_config.h).
namespace mitsuba {

// ------------------------------------------------------------------------------ declarations
// Those in use of rtcore_{common,device,geometry,ray,scene}.h of Embree 3.13.4 (Apache-2.0). Names
// of types are part of the names of functions.

enum RTCError : unsigned { RTC_ERROR_INVALID_OPERATION = 3 };
enum RTCFormat : unsigned { RTC_FORMAT_UINT3 = 0x5003, RTC_FORMAT_FLOAT3 = 0x9003,
                            RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR = 0x9244 };
enum RTCBuildQuality : unsigned { RTC_BUILD_QUALITY_LOW, RTC_BUILD_QUALITY_MEDIUM, RTC_BUILD_QUALITY_HIGH };
enum RTCBufferType : unsigned { RTC_BUFFER_TYPE_INDEX, RTC_BUFFER_TYPE_VERTEX };
enum RTCGeometryType : unsigned { RTC_GEOMETRY_TYPE_TRIANGLE, RTC_GEOMETRY_TYPE_INSTANCE = 121 };
enum RTCSceneFlags : unsigned { RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION = 1 << 3 };

typedef struct RTCDeviceTy *RTCDevice;
typedef struct RTCSceneTy *RTCScene;
typedef struct RTCGeometryTy *RTCGeometry;
typedef void (*RTCErrorFunction)(void *user, RTCError, const char *words);
typedef void (*RTCFilterFunctionN)(const struct RTCFilterFunctionNArguments *);
typedef void (*RTCBoundsFunction)(const struct RTCBoundsFunctionArguments *);
typedef void (*RTCIntersectFunctionN)(const struct RTCIntersectFunctionNArguments *);
typedef void (*RTCOccludedFunctionN)(const struct RTCOccludedFunctionNArguments *);

struct RTCIntersectContext { unsigned flags; RTCFilterFunctionN filter; unsigned instID[1]; };
struct RTCFilterFunctionNArguments {
    int *valid; void *geometryUserPtr; RTCIntersectContext *context; void *ray, *hit; unsigned N;
};

// RTCRay and RTCHit for N = 1, RTCRay4 and RTCHit4 for N = 4, and so on: each field is N words.
template <unsigned N> struct RayRows {
    float org[3][N], tnear[N], dir[3][N], time[N], tfar[N];
    unsigned mask[N], id[N], flags[N];
};
template <unsigned N> struct HitRows {
    float Ng[3][N], u[N], v[N];
    unsigned primID[N], geomID[N], instID[N];
};
template <unsigned N> struct RayHitRows { RayRows<N> ray; HitRows<N> hit; };
struct RTCRay : RayRows<1> {};
struct RTCRayHit : RayHitRows<1> {};

// ----------------------------------------------------------------------------------- objects

struct RTCDeviceTy {
    RTCErrorFunction on_error = nullptr;
    void *error_user = nullptr;
    unsigned threads = 0;
};

struct RTCGeometryTy {
    RTCDevice device;
    RTCGeometryType type;
    phx_mesh mesh{}; // Rows are the caller's, to be kept for as long as the geometry.
    RTCScene instanced = nullptr;
    double to_world[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    void *user = nullptr;
    RTCFilterFunctionN filter = nullptr, shadow_filter = nullptr;
    uint64_t edited = 0;
    std::atomic<unsigned> owners{1};

    RTCGeometryTy(RTCDevice device, RTCGeometryType type) : device(device), type(type) { mesh.size = sizeof mesh; }
    ~RTCGeometryTy();
    bool has_filter() const { return filter || shadow_filter; }
};

// A geometry of phalanx, in Embree's numbers.
struct Placed {
    RTCGeometry mesh;
    unsigned geomID, instID;
    uint32_t first_prim;
};

struct RTCSceneTy {
    RTCDevice device;
    phx_quality quality = PHX_QUALITY_MEDIUM;
    std::map<unsigned, RTCGeometry> attached;
    bool is_instanced = false;
    uint64_t edited = 0, committed = 0;
    std::atomic<unsigned> owners{1};
    // What the last commit made.
    std::mutex commit;
    phx_tree *tree = nullptr;
    std::vector<Placed> placed; // By geom_id, which is the order of adding.
    bool has_filters = false;

    explicit RTCSceneTy(RTCDevice device) : device(device) {}
    ~RTCSceneTy();
};

namespace {

// Numbers edits of all objects: a commit with no later ones keeps its tree.
std::atomic<uint64_t> edits{0};

[[noreturn]] void refuse(RTCDevice device, const std::string &words) {
    if (device->on_error)
        device->on_error(device->error_user, RTC_ERROR_INVALID_OPERATION, words.c_str());
    throw std::runtime_error("phalanx as Embree: " + words);
}

[[noreturn]] void stop(const char *words) {
    std::fprintf(stderr, "phalanx as Embree: rays: %s\n", words);
    std::abort();
}

template <class T> void release(T *object) {
    if (object && --object->owners == 0)
        delete object;
}

// ----------------------------------------------------------------------------------- commits

uint64_t last_edit(const RTCSceneTy &scene) {
    uint64_t last = scene.edited;
    for (const auto &[id, geometry] : scene.attached) {
        last = std::max(last, geometry->edited);
        if (geometry->instanced)
            last = std::max(last, last_edit(*geometry->instanced));
    }
    return last;
}

void build(RTCSceneTy &scene) {
    const auto failed = [&](std::string why) { refuse(scene.device, "rtcCommitScene: " + why); };
    const auto check = [&](phx_status status) { status == PHX_OK ? void() : failed(phx_error_message()); };
    phx_scene *world = nullptr;
    check(phx_scene_create(&world));
    const std::unique_ptr<phx_scene, phx_status (*)(phx_scene *)> owner(world, phx_scene_destroy);

    std::vector<Placed> placed;
    std::map<const RTCGeometryTy *, uint32_t> prototypes;
    bool has_filters = false;
    for (const auto &[id, geometry] : scene.attached) {
        if (geometry->type == RTC_GEOMETRY_TYPE_TRIANGLE) {
            has_filters |= geometry->has_filter();
            check(phx_scene_add_mesh(world, &geometry->mesh, nullptr));
            placed.push_back({geometry, id, PHX_NONE, 0});
            continue;
        }
        if (!geometry->instanced)
            failed("an instance without a scene");
        for (const auto &[mesh_id, mesh] : geometry->instanced->attached) {
            if (mesh->type != RTC_GEOMETRY_TYPE_TRIANGLE || mesh->has_filter())
                failed("instances and filter functions within instances are not done");
            if (mesh->mesh.triangle_count == 0)
                continue;
            const auto [entry, is_new] = prototypes.try_emplace(mesh);
            if (is_new)
                check(phx_scene_add_prototype(world, &mesh->mesh, &entry->second));
            check(phx_scene_add_instance(world, entry->second, geometry->to_world, nullptr));
            placed.push_back({mesh, mesh_id, id, 0});
        }
    }

    const phx_build_settings settings{sizeof settings, scene.quality, scene.device->threads};
    phx_tree *tree = nullptr;
    check(phx_tree_build(world, &settings, &tree));
    for (uint32_t geom = 0; geom < placed.size(); geom++)
        check(phx_tree_get_first_prim(tree, geom, &placed[geom].first_prim));
    phx_tree_destroy(scene.tree);
    scene.tree = tree;
    scene.placed = std::move(placed);
    scene.has_filters = has_filters;
}

// -------------------------------------------------------------------------------------- rays

template <unsigned N> void write(const RTCSceneTy &scene, const phx_hit &hit, HitRows<N> &hits, unsigned i) {
    const Placed &placed = scene.placed[hit.geom_id];
    hits.primID[i] = hit.prim_id - placed.first_prim;
    hits.geomID[i] = placed.geomID;
    hits.instID[i] = placed.instID;
    hits.u[i] = hit.u;
    hits.v[i] = hit.v;
    // (b - a) x (c - a), in the mesh's own space, as Embree has it.
    const auto row = [](phx_rows rows, size_t i) { return static_cast<const char *>(rows.data) + rows.stride * i; };
    const phx_mesh &mesh = placed.mesh->mesh;
    const auto *corners = reinterpret_cast<const uint32_t *>(row(mesh.triangles, hits.primID[i]));
    const auto corner = [&](int k) { return reinterpret_cast<const float *>(row(mesh.vertices, corners[k])); };
    const float *a = corner(0), *b = corner(1), *c = corner(2);
    for (int x = 0, y = 1, z = 2; x < 3; y = z, z = x, x++)
        hits.Ng[x][i] = (b[y] - a[y]) * (c[z] - a[z]) - (b[z] - a[z]) * (c[y] - a[y]);
}

// Lets the filter function of a hit's mesh decide, one ray at a time.
struct FilterCall {
    const RTCSceneTy &scene;
    RTCIntersectContext *context;
    bool is_shadow;
    RayRows<1> ray;

    static int accept(void *user, size_t, const phx_hit *hit) {
        FilterCall &call = *static_cast<FilterCall *>(user);
        const RTCGeometryTy &mesh = *call.scene.placed[hit->geom_id].mesh;
        const RTCFilterFunctionN filter = call.is_shadow ? mesh.shadow_filter : mesh.filter;
        if (!filter)
            return 1;
        HitRows<1> offered;
        write(call.scene, *hit, offered, 0);
        call.ray.tfar[0] = hit->t;
        int valid = -1;
        const RTCFilterFunctionNArguments arguments{&valid, mesh.user, call.context, &call.ray, &offered, 1};
        filter(&arguments);
        return valid != 0;
    }
};

// Asks for the closest hits, or without `hits` for any. A batch of 16 takes longer than 16 calls.
template <unsigned N>
void trace(const int *valid, RTCSceneTy &scene, RTCIntersectContext *context, RayRows<N> &rays, HitRows<N> *hits) {
    if (context && context->filter)
        stop("filter functions of contexts are not done");
    for (unsigned i = 0; i < N; i++) {
        if (valid && !valid[i])
            continue;
        phx_ray ray;
        for (int axis = 0; axis < 3; axis++) {
            ray.origin[axis] = rays.org[axis][i];
            ray.direction[axis] = rays.dir[axis][i];
        }
        // Embree counts a hit at tfar itself, phalanx only before it.
        ray.tmax = std::nextafter(rays.tfar[i], INFINITY);
        FilterCall call{scene, context, !hits, {}};
        phx_filter filter = PHX_FILTER;
        const bool filters = rays.tnear[i] != 0.0f || scene.has_filters;
        if (filters) {
            for (size_t word = 0; word < sizeof call.ray / 4; word++)
                std::memcpy(&call.ray.org[0][0] + word, &rays.org[0][0] + N * word + i, 4);
            filter.tnear = rays.tnear[i];
            filter.accept = scene.has_filters ? FilterCall::accept : nullptr;
            filter.user = &call;
        }
        phx_hit hit;
        int blocked = 0;
        const phx_filter *used = filters ? &filter : nullptr;
        if (hits ? phx_intersect(scene.tree, &ray, used, &hit) : phx_occluded(scene.tree, &ray, used, &blocked))
            stop(phx_error_message());
        if (hits && hit.prim_id != PHX_NONE) {
            rays.tfar[i] = hit.t;
            write(scene, hit, *hits, i);
        } else if (blocked) {
            rays.tfar[i] = -INFINITY;
        }
    }
}

} // namespace

RTCGeometryTy::~RTCGeometryTy() { release(instanced); }
RTCSceneTy::~RTCSceneTy() {
    for (const auto &[id, geometry] : attached)
        release(geometry);
    phx_tree_destroy(tree);
}

// -------------------------------------------------------------------------------- Embree's API

RTC_API RTCDevice rtcNewDevice(const char *config) {
    auto *device = new RTCDeviceTy;
    if (config)
        std::sscanf(config, "threads=%u", &device->threads);
    return device;
}
RTC_API void rtcSetDeviceErrorFunction(RTCDevice device, RTCErrorFunction error, void *user) {
    device->on_error = error;
    device->error_user = user;
}
RTC_API RTCScene rtcNewScene(RTCDevice device) { return new RTCSceneTy(device); }
RTC_API void rtcReleaseScene(RTCScene scene) { release(scene); }
RTC_API void rtcSetSceneFlags(RTCScene scene, RTCSceneFlags flags) {
    // All others are hints, or ROBUST, which phalanx is.
    if (flags & RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION)
        refuse(scene->device, "rtcSetSceneFlags: filters of contexts are not done");
}
RTC_API void rtcSetSceneBuildQuality(RTCScene scene, RTCBuildQuality quality) {
    const bool low = quality == RTC_BUILD_QUALITY_LOW, high = quality == RTC_BUILD_QUALITY_HIGH;
    scene->quality = low ? PHX_QUALITY_FAST : high ? PHX_QUALITY_BEST : PHX_QUALITY_MEDIUM;
}
RTC_API void rtcCommitScene(RTCScene scene) {
    const std::lock_guard<std::mutex> lock(scene->commit);
    const uint64_t last = last_edit(*scene);
    // An instanced scene becomes a part of those that show it, and has no tree of its own.
    if (scene->committed == last || scene->is_instanced)
        return;
    build(*scene);
    scene->committed = last;
}
// The first thread that joins builds, with phalanx's threads; the others wait.
RTC_API void rtcJoinCommitScene(RTCScene scene) { rtcCommitScene(scene); }
RTC_API unsigned rtcAttachGeometry(RTCScene scene, RTCGeometry geometry) {
    unsigned id = 0;
    while (scene->attached.count(id))
        id++;
    geometry->owners++;
    scene->attached[id] = geometry;
    scene->edited = ++edits;
    return id;
}
RTC_API void rtcDetachGeometry(RTCScene scene, unsigned id) {
    const auto entry = scene->attached.find(id);
    if (entry == scene->attached.end())
        refuse(scene->device, "rtcDetachGeometry: no such geometry");
    release(entry->second);
    scene->attached.erase(entry);
    scene->edited = ++edits;
}
RTC_API RTCGeometry rtcNewGeometry(RTCDevice device, RTCGeometryType type) {
    if (type != RTC_GEOMETRY_TYPE_TRIANGLE && type != RTC_GEOMETRY_TYPE_INSTANCE)
        refuse(device, "rtcNewGeometry: type " + std::to_string(type) + " is not done, "
               "only triangle meshes (0) and instances (121): no user geometry (120), no curves (15 to 59)");
    return new RTCGeometryTy(device, type);
}
RTC_API void rtcReleaseGeometry(RTCGeometry geometry) { release(geometry); }
RTC_API void rtcCommitGeometry(RTCGeometry geometry) { geometry->edited = ++edits; }
RTC_API void rtcSetGeometryUserData(RTCGeometry geometry, void *user) { geometry->user = user; }
RTC_API void rtcSetSharedGeometryBuffer(RTCGeometry geometry, RTCBufferType type, unsigned slot, RTCFormat format,
                                        const void *data, size_t offset, size_t stride, size_t count) {
    const bool vertices = type == RTC_BUFFER_TYPE_VERTEX && format == RTC_FORMAT_FLOAT3;
    if (slot != 0 || (!vertices && (type != RTC_BUFFER_TYPE_INDEX || format != RTC_FORMAT_UINT3)))
        refuse(geometry->device, "rtcSetSharedGeometryBuffer: only one FLOAT3 for vertices, UINT3 for indices");
    phx_mesh &mesh = geometry->mesh;
    (vertices ? mesh.vertices : mesh.triangles) = {static_cast<const char *>(data) + offset, stride};
    (vertices ? mesh.vertex_count : mesh.triangle_count) = count;
}
RTC_API void rtcSetGeometryIntersectFilterFunction(RTCGeometry mesh, RTCFilterFunctionN f) { mesh->filter = f; }
RTC_API void rtcSetGeometryOccludedFilterFunction(RTCGeometry mesh, RTCFilterFunctionN f) { mesh->shadow_filter = f; }
RTC_API void rtcSetGeometryInstancedScene(RTCGeometry geometry, RTCScene scene) {
    scene->owners++;
    scene->is_instanced = true;
    std::swap(geometry->instanced, scene);
    release(scene);
}
RTC_API void rtcSetGeometryTimeStepCount(RTCGeometry geometry, unsigned count) {
    if (count != 1)
        refuse(geometry->device, "rtcSetGeometryTimeStepCount: motion is not done");
}
RTC_API void rtcSetGeometryTransform(RTCGeometry geometry, unsigned step, RTCFormat format, const void *matrix) {
    if (step != 0 || format != RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR)
        refuse(geometry->device, "rtcSetGeometryTransform: only FLOAT4X4_COLUMN_MAJOR is done, and no motion");
    for (int k = 0; k < 12; k++)
        geometry->to_world[k] = static_cast<const float *>(matrix)[4 * (k % 4) + k / 4];
}

// rtcNewGeometry refuses user geometry already, but the client imports these by name.
#define USER_GEOMETRY(NAME, ...) \
    RTC_API void NAME(RTCGeometry geometry, __VA_ARGS__) { \
        refuse(geometry->device, #NAME ": user geometry is not done"); \
    }
USER_GEOMETRY(rtcSetGeometryUserPrimitiveCount, unsigned)
USER_GEOMETRY(rtcSetGeometryBoundsFunction, RTCBoundsFunction, void *)
USER_GEOMETRY(rtcSetGeometryIntersectFunction, RTCIntersectFunctionN)
USER_GEOMETRY(rtcSetGeometryOccludedFunction, RTCOccludedFunctionN)

RTC_API void rtcIntersect1(RTCScene scene, RTCIntersectContext *context, RTCRayHit *both) {
    trace<1>(nullptr, *scene, context, both->ray, &both->hit);
}
RTC_API void rtcOccluded1(RTCScene scene, RTCIntersectContext *context, RTCRay *rays) {
    trace<1>(nullptr, *scene, context, *rays, nullptr);
}
#define PACKETS(N) \
    struct RTCRay##N : RayRows<N> {}; \
    struct RTCRayHit##N : RayHitRows<N> {}; \
    RTC_API void rtcIntersect##N(const int *valid, RTCScene scene, RTCIntersectContext *with, RTCRayHit##N *both) { \
        trace<N>(valid, *scene, with, both->ray, &both->hit); \
    } \
    RTC_API void rtcOccluded##N(const int *valid, RTCScene scene, RTCIntersectContext *context, RTCRay##N *rays) { \
        trace<N>(valid, *scene, context, *rays, nullptr); \
    }
PACKETS(4)
PACKETS(8)
PACKETS(16)

} // namespace mitsuba
