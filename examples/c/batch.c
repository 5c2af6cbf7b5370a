/* A million rays in structures of one's own, read and written in place: as examples/million_rays.rs, whose hits it counts. */

#include <phalanx.h>
#include <stdio.h>
#include <stdlib.h>

enum { RINGS = 400, SIDE = 1024 };

/* What a renderer or a simulation might keep of a ray. */
struct particle {
    float origin[3], distance, direction[3], energy, normal[3];
    uint32_t triangle;
};

static void check(phx_status status) {
    if (status != PHX_OK) {
        fprintf(stderr, "%s\n", phx_error_message());
        exit(1);
    }
}

/* A wavy sphere. */
static void add_sphere(phx_scene *scene) {
    const size_t vertex_count = (size_t)(RINGS + 1) * RINGS, triangle_count = 2 * (size_t)RINGS * RINGS;
    float(*vertices)[3] = (float(*)[3])malloc(vertex_count * sizeof *vertices);
    uint32_t(*triangles)[3] = (uint32_t(*)[3])malloc(triangle_count * sizeof *triangles);
    const float pi = 3.14159265f;
    for (uint32_t i = 0; i < vertex_count; ++i) {
        const float down = (float)(i / RINGS) / RINGS * pi, turn = (float)(i % RINGS) / RINGS * 2 * pi;
        const float radius = 1 + 0.05f * sinf(9 * turn) * sinf(12 * cosf(down));
        vertices[i][0] = radius * (sinf(down) * cosf(turn));
        vertices[i][1] = radius * cosf(down);
        vertices[i][2] = radius * (sinf(down) * sinf(turn));
    }
    for (uint32_t row = 0, k = 0; row < RINGS; ++row) {
        for (uint32_t column = 0; column < RINGS; ++column, k += 2) {
            const uint32_t a = row * RINGS + column, b = row * RINGS + (column + 1) % RINGS;
            const uint32_t two[2][3] = {{a, b, a + RINGS}, {b, b + RINGS, a + RINGS}};
            for (int corner = 0; corner < 3; ++corner) {
                triangles[k][corner] = two[0][corner];
                triangles[k + 1][corner] = two[1][corner];
            }
        }
    }
    const phx_mesh mesh = PHX_MESH(vertices, vertex_count, triangles, triangle_count);
    check(phx_scene_add_mesh(scene, &mesh, NULL));
    free(vertices);
    free(triangles);
}

static void cross(const float a[3], const float b[3], float product[3]) {
    for (int x = 0; x < 3; ++x) {
        const int y = (x + 1) % 3, z = (x + 2) % 3;
        product[x] = a[y] * b[z] - b[y] * a[z];
    }
}

static float length(const float v[3]) {
    return sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static void normalize(float v[3]) {
    const float scale = 1 / length(v);
    for (int axis = 0; axis < 3; ++axis) {
        v[axis] *= scale;
    }
}

/* Rays from above and in front, toward the centre; neighbours in the array go about the same way. */
static void aim(const phx_scene *scene, struct particle *particles, size_t count) {
    const float from[3] = {0.3f, 0.4f, 1}, vertical[3] = {0, 1, 0};
    float box[6], size[3], eye[3], ahead[3], right[3], up[3];
    check(phx_scene_get_bounds(scene, box));
    for (int axis = 0; axis < 3; ++axis) {
        size[axis] = box[axis + 3] - box[axis];
    }
    for (int axis = 0; axis < 3; ++axis) {
        const float center = (box[axis] + box[axis + 3]) / 2;
        eye[axis] = center + 0.7f * length(size) * from[axis];
        ahead[axis] = center - eye[axis];
    }
    normalize(ahead);
    cross(ahead, vertical, right);
    normalize(right);
    cross(right, ahead, up);
    for (size_t k = 0; k < count; ++k) {
        const float u = ((float)(k % SIDE) + 0.5f) / SIDE - 0.5f, v = ((float)(k / SIDE) + 0.5f) / SIDE - 0.5f;
        for (int axis = 0; axis < 3; ++axis) {
            particles[k].origin[axis] = eye[axis];
            particles[k].direction[axis] = ahead[axis] + u * right[axis] - v * up[axis];
        }
    }
}

int main(void) {
    phx_scene *scene;
    phx_tree *tree;
    check(phx_scene_create(&scene));
    add_sphere(scene);
    check(phx_tree_build(scene, NULL, &tree));

    const size_t count = (size_t)SIDE * SIDE;
    struct particle *particles = (struct particle *)calloc(count, sizeof *particles);
    aim(scene, particles, count);
    const phx_rays rays = PHX_RAYS(count, PHX_FIELD(particles, origin), PHX_FIELD(particles, direction));
    phx_hits hits = PHX_HITS;
    hits.t = PHX_COLUMN(particles, distance, PHX_MISS_MINUS_ONE);
    hits.prim_id = PHX_COLUMN(particles, triangle, PHX_MISS_DEFAULT);
    hits.normal = PHX_COLUMN(particles, normal, PHX_MISS_UNCHANGED);
    hits.scene = scene;
    check(phx_intersect_batch(tree, &rays, NULL, &hits));

    size_t met = 0;
    double sum = 0;
    for (size_t k = 0; k < count; ++k) {
        met += particles[k].triangle != PHX_NONE;
        sum += particles[k].distance > 0 ? particles[k].distance : 0;
    }
    printf("%zu of %zu rays hit\n", met, count);
    printf("at a mean distance of %.4f\n", sum / (double)met);
    free(particles);
    check(phx_tree_destroy(tree));
    check(phx_scene_destroy(scene));
}
