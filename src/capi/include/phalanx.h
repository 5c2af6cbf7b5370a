/**
 * @file phalanx.h
 * @brief Casts rays at triangles and spheres: the closest hit, any hit, all hits, for one ray or for millions.
 *
 * What a call gets is copied before it returns; the library keeps no pointer of the caller's. Positions are in the scene's units,
 * which are the caller's own, distances in units of a ray's direction, angles do not occur. Answers are the same bits on every CPU,
 * for any number of threads, and for batches as for single calls.
 *
 * @code
 * #include <phalanx.h>
 * #include <stdio.h>
 *
 * int main(void) {
 *     const float corners[3][3] = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
 *     const uint32_t triangles[1][3] = {{0, 1, 2}};
 *     const phx_mesh wall = PHX_MESH(corners, 3, triangles, 1);
 *     phx_scene *scene;
 *     phx_tree *tree;
 *     phx_hit hit;
 *     if (phx_scene_create(&scene) || phx_scene_add_mesh(scene, &wall, NULL) || phx_tree_build(scene, NULL, &tree)) {
 *         puts(phx_error_message());
 *         return 1;
 *     }
 *     const phx_ray ray = {{1, 2, 5}, {0, 0, -1}, INFINITY};
 *     phx_intersect(tree, &ray, NULL, &hit);
 *     printf("t %g, u %g, v %g, triangle %u\n", hit.t, hit.u, hit.v, (unsigned)hit.prim_id);
 *     phx_tree_destroy(tree);
 *     phx_scene_destroy(scene);
 * }
 * @endcode
 *
 * Errors. Functions that can fail return a status, and one that is neither PHX_OK nor PHX_ERROR_INTERNAL has written nothing;
 * phx_error_message() says why. Null, NaN in geometry, misaligned pointers, numbers out of range, sizes that overflow and objects that
 * have been destroyed are errors. Rays that cannot hit anything (NaN, a zero direction, a tmax of 0 or less) are none: they miss. A
 * program that runs out of memory ends.
 *
 * Threads. Any number of threads may query a tree at once; queries of one ray take no locks. A scene may be edited by one thread while
 * its trees are queried by others; edits and builds from several threads wait for each other, and so do phx_refine() and what gets
 * something of a scene. Forbidden is to update or destroy a tree while another thread casts single rays at it, and to destroy anything
 * that another thread is about to use; beside builds, edits and batches they refuse. Update a clone, and exchange the two. What a call
 * reads must not be written meanwhile, but by its own outputs.
 *
 * Callbacks may cast rays. They must not throw, longjmp, change the tree that is queried, or edit or destroy a scene; nor look at a scene
 * that other threads edit.
 *
 * Numbers. A geometry's number, geom_id, is given when it is added and stays; prototypes are counted apart. A primitive's number,
 * prim_id, counts over the whole scene, what instances show behind all else. So that of an instance's triangle changes where geometry
 * is added: keep geom_id, and the row within it (phx_hits.local_prim_id).
 *
 * Ranges. Surfaces are made for sizes from 1e-6 to 1e6 units and directions for lengths from 1e-12 to 1e12; beyond, squares leave
 * the range of single precision, and rays may miss.
 *
 * Structures that begin with `size` grow with later versions. Begin with their macros (PHX_FILTER, PHX_BATCH, PHX_HITS, ...) and set
 * what is to be otherwise.
 */
#ifndef PHALANX_H
#define PHALANX_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Version of this header: 10000 · major + 100 · minor + patch. */
#define PHX_VERSION 100

/** A primitive, geometry or instance that is none. */
#define PHX_NONE UINT32_MAX

/** What a function returns. */
typedef enum phx_status {
    PHX_OK = 0,
    /** A pointer is null or misaligned, a number is out of range, or sizes do not fit. */
    PHX_ERROR_ARGUMENT = 1,
    /** A scene or tree that does not exist, or no longer. */
    PHX_ERROR_HANDLE = 2,
    /** Geometry that cannot be added or moved: not finite, an index without a vertex, a map without an inverse. */
    PHX_ERROR_GEOMETRY = 3,
    /** The tree is queried or updated by another thread. */
    PHX_ERROR_BUSY = 4,
    /** A file that cannot be read. */
    PHX_ERROR_FILE = 5,
    /** Header and library are of versions that do not fit, or the library is built for another CPU than this one. */
    PHX_ERROR_VERSION = 6,
    /** A fault in the library. Its objects may be used on, but for a tree whose update has failed. */
    PHX_ERROR_INTERNAL = 7,
    /** An edit that cannot be refitted, where nothing else is allowed. The tree is as it was. */
    PHX_ERROR_REFIT = 8
} phx_status;

/** Why the last call of this thread that failed did so: one line of UTF-8, valid until the next one fails. Empty before that. */
const char *phx_error_message(void);

/** Version of the library, as PHX_VERSION is that of the header. */
uint32_t phx_version(void);

/** The instruction set that the library was built for, such as "x86-64-v3" or "aarch64". */
const char *phx_instruction_set(void);

/**
 * Rows in memory: the first at `data`, each next one `stride` bytes further on, which is at least a row; for inputs, a stride of 0
 * repeats the first row for all. Addresses and strides are multiples of 4, but for columns of bytes. What rows hold is said where
 * they are used; three numbers each in a flat array of floats are {data, 12}.
 */
typedef struct phx_rows {
    const void *data;
    size_t stride;
} phx_rows;

/** Rows of `array`, a pointer whose elements are rows: to float[3], not to float, for three numbers a row. */
#ifdef __cplusplus
#define PHX_ROWS(array) (phx_rows{(array), sizeof *(array)})
#else
#define PHX_ROWS(array) ((phx_rows){(array), sizeof *(array)})
#endif

/** Rows of a field in an array of structures: PHX_FIELD(particles, position). */
#ifdef __cplusplus
#define PHX_FIELD(array, field) (phx_rows{&(array)->field, sizeof *(array)})
#else
#define PHX_FIELD(array, field) ((phx_rows){&(array)->field, sizeof *(array)})
#endif

/* ---------------------------------------------------------------------------------------------------------------- scenes */

/** Meshes, spheres, prototypes and their instances. */
typedef struct phx_scene phx_scene;

/** Use phx_scene_create(), which says the version of this header. */
phx_status phx_scene_create_for(uint32_t version, phx_scene **scene);

/** Creates an empty scene, to be destroyed by the caller. At most 65 536 scenes exist at a time, as many trees, and as many lists. */
static inline phx_status phx_scene_create(phx_scene **scene) {
    return phx_scene_create_for(PHX_VERSION, scene);
}

/** Destroys a scene. Its trees stay as they are. Null is none, and not an error; a scene that is built is PHX_ERROR_BUSY. */
phx_status phx_scene_destroy(phx_scene *scene);

/** Triangles: three numbers (float) a vertex, three rows of `vertices` (uint32_t) a triangle, counter-clockwise seen from outside. */
typedef struct phx_mesh {
    size_t size;
    phx_rows vertices;
    size_t vertex_count;
    phx_rows triangles;
    size_t triangle_count;
} phx_mesh;

/** A mesh of arrays of float[3] and of uint32_t[3]; the first may be of structures that begin with a position. */
#define PHX_MESH(vertices, vertex_count, triangles, triangle_count)                                                               \
    {sizeof(phx_mesh), PHX_ROWS(vertices), (size_t)(vertex_count), PHX_ROWS(triangles), (size_t)(triangle_count)}

/**
 * Adds a mesh, which is copied: one pass over vertices and triangles, 24 bytes a triangle and 12 a vertex. Rays hit both sides.
 * @param[out] geom_id number of the geometry, from 0 in the order of adding; may be null
 */
phx_status phx_scene_add_mesh(phx_scene *scene, const phx_mesh *mesh, uint32_t *geom_id);

/**
 * Adds spheres: three numbers (float) a centre, one (float, positive) a radius. They are one geometry, and do not move. A ray that
 * starts within one hits its far side.
 */
phx_status phx_scene_add_spheres(phx_scene *scene, phx_rows centers, phx_rows radii, size_t count, uint32_t *geom_id);

/** Adds a mesh that is seen through its instances alone, and stored once however many there are. At least one triangle. */
phx_status phx_scene_add_prototype(phx_scene *scene, const phx_mesh *mesh, uint32_t *prototype);

/**
 * Places a prototype in the world; the instance is a geometry of its own.
 * @param to_world three rows of four numbers: x′ = m[0]·x + m[1]·y + m[2]·z + m[3], and so on; invertible in single precision
 */
phx_status phx_scene_add_instance(phx_scene *scene, uint32_t prototype, const double to_world[12], uint32_t *geom_id);

/** Moves the vertices of a mesh: as many as it has. Trees follow by phx_tree_update(). */
phx_status phx_scene_set_vertices(phx_scene *scene, uint32_t geom_id, phx_rows vertices, size_t count);

/** Moves the vertices of a prototype. */
phx_status phx_scene_set_prototype_vertices(phx_scene *scene, uint32_t prototype, phx_rows vertices, size_t count);

/** Moves an instance. */
phx_status phx_scene_set_transform(phx_scene *scene, uint32_t geom_id, const double to_world[12]);

/** Sets the bits that a ray's mask must share to hit a geometry: all at first; 0 hides it, and takes it out of trees. */
phx_status phx_scene_set_mask(phx_scene *scene, uint32_t geom_id, uint32_t mask);

/**
 * Removes a geometry. All others keep their numbers and those of their primitives. A later geometry of this kind (mesh, spheres,
 * instance) that fits takes its number, its primitives' and its memory.
 */
phx_status phx_scene_remove(phx_scene *scene, uint32_t geom_id);

/** Removes a prototype that no instance shows; the next one that fits takes its number. */
phx_status phx_scene_remove_prototype(phx_scene *scene, uint32_t prototype);

/** Names a geometry, in UTF-8 that is copied, up to 1024 bytes, without spaces at its ends. */
phx_status phx_scene_set_name(phx_scene *scene, uint32_t geom_id, const char *name);

/**
 * The name of the object that a primitive belongs to: of what phx_scene_set_name() or a file has named.
 * @param[out] name up to `capacity` bytes, the last of them 0; what does not fit is cut off. May be null if `capacity` is 0
 * @param[out] length bytes of the whole name, without that 0; 0 if it has none. May be null
 */
phx_status phx_scene_get_name(const phx_scene *scene, uint32_t prim_id, char *name, size_t capacity, size_t *length);

/** A box around all that is visible, the lower corner first, rounded outward; that is beyond the upper one in an empty scene. */
phx_status phx_scene_get_bounds(const phx_scene *scene, float bounds[6]);

/* ----------------------------------------------------------------------------------------------------------------- trees */

/** A bounding volume hierarchy over the state that a scene had. It holds what it needs of it. */
typedef struct phx_tree phx_tree;

/** Build time against speed of rays. No hit depends on it. */
typedef enum phx_quality {
    PHX_QUALITY_MEDIUM = 0,
    /** Seven tenths of the build time of medium. */
    PHX_QUALITY_FAST = 1,
    /** Six to seven times the build time of medium. */
    PHX_QUALITY_BEST = 2
} phx_quality;

/** Settings of a build; {sizeof, PHX_QUALITY_MEDIUM, 0} are the usual ones. */
typedef struct phx_build_settings {
    size_t size;
    /** A phx_quality. */
    int32_t quality;
    /** 0: one per CPU. */
    uint32_t threads;
} phx_build_settings;

/** How far an update may go. */
typedef enum phx_update_mode {
    /** What has changed: see phx_tree_update(). */
    PHX_UPDATE_AUTO = 0,
    /** No tree is built over primitives: PHX_ERROR_REFIT if that takes one. Frames take about as long as each other. */
    PHX_UPDATE_REFIT_ONLY = 1,
    /** Everything is built. */
    PHX_UPDATE_REBUILD = 2
} phx_update_mode;

/** Settings of an update; {sizeof, PHX_UPDATE_AUTO} are the usual ones. */
typedef struct phx_update_settings {
    size_t size;
    /** A phx_update_mode. */
    int32_t mode;
} phx_update_settings;

/** Kind of work that an update did. */
typedef enum phx_update_work {
    /** The scene was as the tree was, but for masks. */
    PHX_UPDATE_NOTHING = 0,
    /** The tree has followed, in what is listed. */
    PHX_UPDATE_REFITTED = 1,
    /** Everything was built anew. */
    PHX_UPDATE_REBUILT = 2
} phx_update_work;

/** What an update did. The caller sets `size`, `geom_ids` and `capacity`. */
typedef struct phx_update_result {
    size_t size;
    /** Null, or room for the numbers of geometries: those refitted, and instances added, moved or shown; then those that got trees
     * of their own; then those that no ray hits any more. */
    uint32_t *geom_ids;
    /** How many numbers fit; the rest is left out. */
    size_t capacity;
    /** How many geometries there are of each sort; none where everything was built. */
    uint32_t refitted, built, removed;
    /** A phx_update_work. */
    int32_t work;
    /** How many times what it would cost if it were built anew the tree costs rays; PHX_UPDATE_AUTO builds everything at 1.5. */
    double cost_growth;
} phx_update_result;

/**
 * Builds a tree, to be destroyed by the caller. A million triangles take some 0.1 to 0.2 s on two cores.
 * @param settings may be null: medium quality, a thread per CPU
 */
phx_status phx_tree_build(const phx_scene *scene, const phx_build_settings *settings, phx_tree **tree);

/**
 * Lets a tree follow its scene after edits; answers are those of a fresh build, and the time is that of what has changed. Moved
 * vertices are refitted, what is added gets a tree of its own, what is removed or hidden leaves. A part that refits have made too
 * slow is built anew, and everything if the whole is. To build without stopping queries, build another tree of the scene on
 * another thread (edits wait meanwhile), or update a phx_tree_clone() with PHX_UPDATE_REBUILD.
 * @param settings may be null
 * @param[out] result may be null
 */
phx_status phx_tree_update(phx_tree *tree, const phx_scene *scene, const phx_update_settings *settings, phx_update_result *result);

/** Copies a tree: to be updated while the other is queried. */
phx_status phx_tree_clone(const phx_tree *tree, phx_tree **copy);

/** Destroys a tree. Null is none, and not an error; a tree that a batch uses is PHX_ERROR_BUSY. */
phx_status phx_tree_destroy(phx_tree *tree);

/** The prim_id of a geometry's first primitive: hit.prim_id less this is the row of the triangle or sphere in its geometry. */
phx_status phx_tree_get_first_prim(const phx_tree *tree, uint32_t geom_id, uint32_t *prim_id);

/* --------------------------------------------------------------------------------------------------------------- one ray */

/** A ray: hits at origin + t · direction count if 0 < t < tmax. */
typedef struct phx_ray {
    float origin[3];
    /** Of any length from 1e-12 to 1e12. */
    float direction[3];
    /** INFINITY for no end; 1 where `direction` leads to a light. */
    float tmax;
} phx_ray;

/** A hit. On a triangle, the point is (1 − u − v) · a + u · b + v · c. */
typedef struct phx_hit {
    /** Distance in units of the direction; INFINITY on a miss. */
    float t;
    /** Weights of a triangle's second and third vertex; 0 on a sphere. */
    float u, v;
    /** Primitive, counted over the whole scene; PHX_NONE on a miss. Among hits at one distance, the smallest counts. */
    uint32_t prim_id;
    /** Geometry, an instance being one; PHX_NONE on a miss, and for what a file has added. */
    uint32_t geom_id;
} phx_hit;

/**
 * Whether a hit counts: not 0 if it does. To be decided by the ray and the hit alone: hits are offered in any order, those of a sphere
 * twice, and many that are not the closest. `ray` is the number within a batch, 0 for one ray.
 */
typedef int (*phx_accept)(void *user, size_t ray, const phx_hit *hit);

/** Which hits count, beside a ray's tmax. PHX_FILTER accepts all; zeros would not. */
typedef struct phx_filter {
    size_t size;
    /** Hits count beyond this; none if it is NaN. */
    float tnear;
    /** Hits count on geometries whose mask shares a bit with this; 0 is an error. */
    uint32_t mask;
    /** A prim_id that does not count, such as that of the triangle that a ray leaves; PHX_NONE for none. */
    uint32_t ignore;
    uint32_t reserved;
    /** May be null. Called on the thread that traces. */
    phx_accept accept;
    void *user;
} phx_filter;

#define PHX_FILTER {sizeof(phx_filter), 0.0f, UINT32_MAX, PHX_NONE, 0, NULL, NULL}

/** The closest hit of a ray. @param filter may be null, and then costs nothing */
phx_status phx_intersect(const phx_tree *tree, const phx_ray *ray, const phx_filter *filter, phx_hit *hit);

/** Whether a ray hits anything: 1 or 0. @param filter may be null */
phx_status phx_occluded(const phx_tree *tree, const phx_ray *ray, const phx_filter *filter, int *blocked);

/**
 * All hits of a ray, nearest first.
 * @param filter may be null
 * @param[out] hits the nearest `capacity` of them; may be null if `capacity` is 0
 * @param[out] count how many there are in all
 */
phx_status phx_all_hits(const phx_tree *tree, const phx_ray *ray, const phx_filter *filter, phx_hit *hits, size_t capacity, size_t *count);

/** A hit in double precision. */
typedef struct phx_refined_hit {
    double t;
    double point[3];
    /** Of length 1, outward; of a triangle by its corners' order in the world, which a mirroring map turns. Zero where there is none. */
    double normal[3];
} phx_refined_hit;

/** Computes a hit again in double precision, from a ray and the primitive that it hits; about 50 ns. The scene is as at the hit. */
phx_status phx_refine(const phx_scene *scene, const double origin[3], const double direction[3], const phx_hit *hit, phx_refined_hit *refined);

/* -------------------------------------------------------------------------------------------------------------- many rays */

/** Rays of a batch. Neighbours should go about the same way, for speed alone. */
typedef struct phx_rays {
    size_t size;
    size_t count;
    /** Three numbers (float) a ray. */
    phx_rows origin;
    phx_rows direction;
    /** One number (float) a ray; null for no ends. */
    phx_rows tmax;
} phx_rays;

/** Rays whose origins and directions are rows: PHX_RAYS(count, PHX_FIELD(particles, position), PHX_FIELD(particles, velocity)). */
#define PHX_RAYS(count, origin, direction) {sizeof(phx_rays), (size_t)(count), origin, direction, {NULL, 0}}

/** Which hits of a batch count, and how many threads look for them. PHX_BATCH: all, with a thread per CPU. */
typedef struct phx_batch {
    size_t size;
    /** One number a ray (float; uint32_t; uint32_t) as in phx_filter; null for none. */
    phx_rows tnear, mask, ignore;
    /** May be null. Called by several threads at once, with the number of the ray. */
    phx_accept accept;
    void *user;
    /** 0: one per CPU. Batches of up to 2048 rays stay on the caller's. */
    uint32_t threads;
    uint32_t reserved;
} phx_batch;

#define PHX_BATCH {sizeof(phx_batch), {NULL, 0}, {NULL, 0}, {NULL, 0}, NULL, NULL, 0, 0}

/** What is written for a ray that misses. */
typedef enum phx_miss {
    /** As in phx_hit; a normal of zero. */
    PHX_MISS_DEFAULT = 0,
    /** Nothing: what was there stays. */
    PHX_MISS_UNCHANGED = 1,
    /** -1.0f in columns of float, UINT32_MAX in those of uint32_t, 255 in those of bytes. */
    PHX_MISS_MINUS_ONE = 2
} phx_miss;

/** An output: rows as in phx_rows, or null if it is not wanted. The stride is at least the size of a row. */
typedef struct phx_column {
    void *data;
    size_t stride;
    /** A phx_miss. */
    int32_t miss;
    uint32_t reserved;
} phx_column;

/** An output in a field of an array of structures: PHX_COLUMN(particles, distance, PHX_MISS_MINUS_ONE). */
#ifdef __cplusplus
#define PHX_COLUMN(array, field, miss) (phx_column{&(array)->field, sizeof *(array), (miss), 0})
#else
#define PHX_COLUMN(array, field, miss) ((phx_column){&(array)->field, sizeof *(array), (miss), 0})
#endif

/**
 * Where hits of a batch go: fields of the caller's own structures, or arrays. They may be written over what a batch reads, which is
 * copied first then (28 bytes a ray), but not over each other.
 */
typedef struct phx_hits {
    size_t size;
    /** As in phx_hit: one float a ray, or one uint32_t. */
    phx_column t, u, v, prim_id, geom_id;
    /** The primitive, counted from the first one of its geometry, or as prim_id where that is PHX_NONE (uint32_t). */
    phx_column local_prim_id;
    /** The instance (uint32_t): geom_id if that is one, else as for a miss. */
    phx_column inst_id;
    /** Three floats a ray: (b − a) × (c − a) of a triangle, in the world; of a sphere or another curved surface, outward, of length 1. */
    phx_column normal;
    /** For `inst_id` and `normal`: the scene, in the state that the tree was built or updated for. It waits for edits. */
    const phx_scene *scene;
} phx_hits;

/** No outputs: hits = PHX_HITS, then hits.t = PHX_COLUMN(...), and so on. */
#define PHX_NO_COLUMN {NULL, 0, 0, 0}
#define PHX_HITS                                                                                                                  \
    {sizeof(phx_hits), PHX_NO_COLUMN, PHX_NO_COLUMN, PHX_NO_COLUMN, PHX_NO_COLUMN, PHX_NO_COLUMN, PHX_NO_COLUMN, PHX_NO_COLUMN,    \
     PHX_NO_COLUMN, NULL}

/** The closest hit of every ray. @param batch may be null */
phx_status phx_intersect_batch(const phx_tree *tree, const phx_rays *rays, const phx_batch *batch, const phx_hits *hits);

/** Whether each ray hits anything: a byte, 1 or 0. @param batch may be null */
phx_status phx_occluded_batch(const phx_tree *tree, const phx_rays *rays, const phx_batch *batch, phx_column blocked);

/** How many primitives each ray hits (uint32_t). @param batch may be null */
phx_status phx_count_batch(const phx_tree *tree, const phx_rays *rays, const phx_batch *batch, phx_column counts);

/** All hits of rays: those of ray i, nearest first, are entries starts[i] to starts[i + 1] - 1 of columns as in phx_hit. */
typedef struct phx_hit_lists {
    size_t size;
    size_t ray_count;
    size_t hit_count;
    const size_t *starts;
    const float *t, *u, *v;
    const uint32_t *prim_id, *geom_id;
    void *memory;
} phx_hit_lists;

#define PHX_HIT_LISTS {sizeof(phx_hit_lists), 0, 0, NULL, NULL, NULL, NULL, NULL, NULL, NULL}

/** All hits of every ray, in memory of the library's: to be freed by phx_hit_lists_free(). @param batch may be null */
phx_status phx_all_hits_batch(const phx_tree *tree, const phx_rays *rays, const phx_batch *batch, phx_hit_lists *lists);

/** Frees lists and makes them empty. Null is none, and not an error. */
phx_status phx_hit_lists_free(phx_hit_lists *lists);

#ifdef __cplusplus
}
#endif

#endif
